//! Adaptive Dormand-Prince integration of orders 5(4) with event-free, sample-exact output.
//!
//! Solves y' = f(t, y) from one output time to the next; steps end exactly on output times and on the breakpoints of
//! the motion, so that the method never integrates across a kink that is known beforehand.
//! Source: Dormand, Prince, "A family of embedded Runge-Kutta formulae", J. Comp. Appl. Math. 6 (1980) 19-26.

/// Stage times of the method.
const C: [f64; 7] = [0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];

/// Stage weights; the last row is the fifth-order solution.
const A: [[f64; 6]; 7] = [
    [0.0; 6],
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [
        19372.0 / 6561.0,
        -25360.0 / 2187.0,
        64448.0 / 6561.0,
        -212.0 / 729.0,
        0.0,
        0.0,
    ],
    [
        9017.0 / 3168.0,
        -355.0 / 33.0,
        46732.0 / 5247.0,
        49.0 / 176.0,
        -5103.0 / 18656.0,
        0.0,
    ],
    [
        35.0 / 384.0,
        0.0,
        500.0 / 1113.0,
        125.0 / 192.0,
        -2187.0 / 6784.0,
        11.0 / 84.0,
    ],
];

/// Difference between the fifth-order and the embedded fourth-order weights.
const E: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// Right-hand side of y' = f(t, y), written into the last argument.
pub trait Dynamics {
    /// Writes the rate of `state` at `time_s` into `rate`.
    fn rate(&self, time_s: f64, state: &[f64], rate: &mut [f64]);
}

/// An integration in progress: remembers the step size from interval to interval.
#[derive(Clone, Debug)]
pub struct Integrator {
    /// Relative tolerance of a step.
    pub relative: f64,
    /// Absolute tolerance of a step, one for each component of the state.
    pub absolute: Vec<f64>,
    /// Longest step, s.
    pub longest_s: f64,
    step_s: f64,
    stages: Vec<Vec<f64>>,
    trial: Vec<f64>,
}

impl Integrator {
    /// An integrator for states of the size of `absolute`.
    pub fn new(relative: f64, absolute: Vec<f64>, longest_s: f64) -> Self {
        let size = absolute.len();
        Self {
            relative,
            absolute,
            longest_s,
            step_s: longest_s,
            stages: vec![vec![0.0; size]; 7],
            trial: vec![0.0; size],
        }
    }

    /// Advances `state` from `from_s` to `to_s`.
    ///
    /// # Panics
    /// If the step size collapses: the dynamics given are then not a function that can be integrated.
    pub fn advance(&mut self, dynamics: &impl Dynamics, state: &mut [f64], from_s: f64, to_s: f64) {
        let mut time = from_s;
        while time < to_s {
            let rest = to_s - time;
            let clipped = self.step_s.min(self.longest_s) >= rest;
            let step = if clipped {
                rest
            } else {
                self.step_s.min(self.longest_s)
            };
            let error = self.attempt(dynamics, state, time, step);
            // Step control of an order-4 error estimate: h_new = h * 0.9 * error^(-1/5).
            let growth = if error > 0.0 {
                (0.9 * error.powf(-0.2)).clamp(0.2, 5.0)
            } else {
                5.0
            };
            if error <= 1.0 {
                state.copy_from_slice(&self.trial);
                time = if clipped { to_s } else { time + step };
                // A clipped step says little about the longest step that would have been accepted.
                self.step_s = if clipped {
                    self.step_s.max(step * growth)
                } else {
                    step * growth
                };
            } else {
                self.step_s = step * growth.min(1.0);
                assert!(self.step_s > 1e-13, "step size collapsed at t = {time} s");
            }
        }
    }

    /// One step into `self.trial`; returns its scaled error (accepted when at most 1).
    fn attempt(&mut self, dynamics: &impl Dynamics, state: &[f64], time: f64, step: f64) -> f64 {
        let size = state.len();
        for stage in 0..7 {
            for (i, value) in state.iter().enumerate() {
                let mut sum = 0.0;
                for (previous, weight) in A[stage].iter().enumerate().take(stage) {
                    sum += weight * self.stages[previous][i];
                }
                self.trial[i] = value + step * sum;
            }
            dynamics.rate(time + C[stage] * step, &self.trial, &mut self.stages[stage]);
        }
        // The seventh stage was evaluated at the fifth-order solution, which `trial` still holds.
        let mut sum = 0.0;
        for (i, value) in state.iter().enumerate() {
            let error: f64 = step
                * E.iter()
                    .enumerate()
                    .map(|(s, e)| e * self.stages[s][i])
                    .sum::<f64>();
            let scale = self.absolute[i] + self.relative * value.abs().max(self.trial[i].abs());
            sum += (error / scale).powi(2);
        }
        (sum / size as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Oscillator;
    impl Dynamics for Oscillator {
        fn rate(&self, _time_s: f64, y: &[f64], rate: &mut [f64]) {
            rate[0] = y[1];
            rate[1] = -25.0 * y[0];
        }
    }

    /// y = cos 5t after two periods, to the tolerance asked for.
    #[test]
    fn oscillator_returns_after_whole_periods() {
        let mut state = [1.0, 0.0];
        let mut integrator = Integrator::new(1e-10, vec![1e-12; 2], 1.0);
        integrator.advance(
            &Oscillator,
            &mut state,
            0.0,
            4.0 * std::f64::consts::PI / 5.0,
        );
        assert!(
            (state[0] - 1.0).abs() < 1e-7 && state[1].abs() < 1e-6,
            "{state:?}"
        );
    }

    /// The global error falls with the tolerance: the step control acts on the true error.
    #[test]
    fn error_falls_with_tolerance() {
        let error = |tolerance: f64| {
            let mut state = [1.0, 0.0];
            Integrator::new(tolerance, vec![tolerance; 2], 1.0).advance(
                &Oscillator,
                &mut state,
                0.0,
                3.0,
            );
            (state[0] - 15.0_f64.cos()).abs()
        };
        assert!(error(1e-9) < 0.05 * error(1e-6));
    }
}
