//! A channel of second order: y + tau y' + b tau^2 y'' = x, with x what comes in and y what is recorded.
//!
//! tau, s, is by how much y is late of a ramp; b says how it sets in: at 0 the channel is of first order, at 1/4 it is two equal stages,
//! at 1/2 its pass band is the flattest; its damping ratio is 1/(2 sqrt(b)). Generic over the scalar, linear in samples.

use friction::Scalar;

use crate::signal::unlag;

/// b below which a channel is told from one of first order by its derivative only.
const LEAST: f64 = 1e-6;

/// The record of a signal that is linear between its samples; it starts settled, y = x and y' = 0. Exact for that signal. At tau <= 0
/// the output is the input.
pub fn lag_second_order<D: Scalar>(time_s: &[f64], signal: &mut [D], tau: D, b: D) {
    let Some(&first) = signal.first() else { return };
    let short = LEAST - b.value();
    let b = if short > 0.0 { b + short } else { b };
    let (mut before, mut y, mut rate) = (first, first, D::constant(0.0));
    let mut known = (0.0, Transition::forgotten());
    for i in 1..signal.len() {
        let dt = time_s[i] - time_s[i - 1];
        if dt <= 0.0 {
            signal[i] = y;
            continue;
        }
        if known.0 != dt {
            known = (dt, Transition::over(dt, tau, b));
        }
        let x = signal[i];
        let slope = (x - before) / dt;
        // What differs from y = x - tau x' fades.
        let (off, off_rate) = known.1.apply(y - before + slope * tau, rate - slope);
        y = x - slope * tau + off;
        rate = slope + off_rate;
        before = x;
        signal[i] = y;
    }
}

/// What a step makes of (z, z') where z + tau z' + b tau^2 z'' = 0.
struct Transition<D> {
    by_value: [D; 2],
    by_rate: [D; 2],
}

impl<D: Scalar> Transition<D> {
    fn forgotten() -> Self {
        let nothing = [D::constant(0.0); 2];
        Self {
            by_value: nothing,
            by_rate: nothing,
        }
    }

    /// With a = 1/(2 b tau), w^2 = 1/(b tau^2), r^2 = a^2 - w^2, c = e^(-a dt) cosh(r dt) and s = e^(-a dt) sinh(r dt)/r:
    /// z1 = (c + a s) z0 + s z0',  z1' = -w^2 s z0 + (c - a s) z0'.
    fn over(dt: f64, tau: D, b: D) -> Self {
        if tau.value() * 700.0 < dt {
            return Self::forgotten();
        }
        let a = (b * tau * 2.0).recip();
        let square = (b * tau * tau).recip();
        let (c, s) = fading(dt, a, square);
        Self {
            by_value: [c + a * s, -(square * s)],
            by_rate: [s, c - a * s],
        }
    }

    fn apply(&self, value: D, rate: D) -> (D, D) {
        let row = |k: usize| self.by_value[k] * value + self.by_rate[k] * rate;
        (row(0), row(1))
    }
}

/// e^(-a t) cosh(r t) and e^(-a t) sinh(r t)/r with r^2 = a^2 - w^2 of either sign; near r = 0 by their series.
fn fading<D: Scalar>(t: f64, a: D, square: D) -> (D, D) {
    let r_square = a * a - square;
    let x = r_square * (t * t);
    let fade = |rate: D| (-(rate * t)).exp();
    if x.value() >= 0.5 {
        let r = r_square.sqrt();
        let (slow, fast) = (fade(square / (a + r)), fade(a + r));
        ((slow + fast) * 0.5, (slow - fast) * 0.5 / r)
    } else if x.value() <= -0.5 {
        let r = (-r_square).sqrt();
        let (sine, cosine) = (r * t).sine_and_cosine();
        (fade(a) * cosine, fade(a) * sine / r)
    } else {
        let (mut c, mut s) = (D::constant(1.0), D::constant(1.0));
        // Horner's scheme: cosh = sum x^k/(2k)!, sinh = sum x^k/(2k+1)!
        for k in (1..=8).rev() {
            let k = f64::from(k);
            c = c * x / (2.0 * k * (2.0 * k - 1.0)) + 1.0;
            s = s * x / (2.0 * k * (2.0 * k + 1.0)) + 1.0;
        }
        (fade(a) * c, fade(a) * s * t)
    }
}

/// What came in, from the record at samples: that of first order with b tau^2 y'' beside it, y the cubic spline through the record.
pub fn unlag_second_order<D: Scalar>(time_s: &[f64], output: &[f64], tau: D, b: D) -> Vec<D> {
    let mut input = unlag(time_s, output, tau);
    let weight = b * tau * tau;
    for (x, bend) in input.iter_mut().zip(curvatures(time_s, output)) {
        *x += weight * bend;
    }
    input
}

/// Second derivatives at the samples of the natural cubic spline:
/// h0 m0 + 2 (h0 + h1) m1 + h1 m2 = 6 (s1 - s0), h the steps and s the chords.
fn curvatures(time_s: &[f64], signal: &[f64]) -> Vec<f64> {
    let n = signal.len();
    let mut curvature = vec![0.0; n];
    if n < 3 {
        return curvature;
    }
    let step = |i: usize| (time_s[i + 1] - time_s[i]).max(f64::MIN_POSITIVE);
    let chord = |i: usize| (signal[i + 1] - signal[i]) / step(i);
    // Elimination from the first row on, then back.
    let mut above = vec![0.0; n];
    for i in 1..n - 1 {
        let pivot = 2.0 * (step(i - 1) + step(i)) - step(i - 1) * above[i - 1];
        above[i] = step(i) / pivot;
        curvature[i] = (6.0 * (chord(i) - chord(i - 1)) - step(i - 1) * curvature[i - 1]) / pivot;
    }
    for i in (1..n - 1).rev() {
        curvature[i] -= above[i] * curvature[i + 1];
    }
    curvature
}

#[cfg(test)]
mod tests {
    use super::{curvatures, lag_second_order, unlag_second_order};
    use crate::signal::lag;

    fn kinked(time_s: &[f64]) -> Vec<f64> {
        let at = |t: f64| {
            if t < 0.3 {
                0.1 * t
            } else {
                0.03 - 0.2 * (t - 0.3)
            }
        };
        time_s.iter().map(|&t| at(t)).collect()
    }

    fn worst(a: &[f64], b: &[f64]) -> f64 {
        a.iter()
            .zip(b)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max)
    }

    /// Steps as fine as one likes give the same record, over all kinds of damping; two equal stages are two lags one after the other.
    #[test]
    fn a_step_is_exact() {
        let (fine, coarse): (Vec<f64>, Vec<f64>) = (
            (0..=6400).map(|i| f64::from(i) / 6400.0).collect(),
            (0..=64).map(|i| f64::from(i) / 64.0).collect(),
        );
        // The kink lies on a sample of both.
        let at = |t: f64| {
            if t < 0.25 {
                0.1 * t
            } else {
                0.025 - 0.2 * (t - 0.25)
            }
        };
        let record = |time_s: &[f64], tau: f64, b: f64| {
            let mut y: Vec<f64> = time_s.iter().map(|&t| at(t)).collect();
            lag_second_order(time_s, &mut y, tau, b);
            y
        };
        for tau in [1e-5, 2e-3, 0.05, 0.4] {
            for b in [0.0, 1e-3, 0.2, 0.25, 0.26, 0.5, 1.0] {
                let every: Vec<f64> = record(&fine, tau, b).into_iter().step_by(100).collect();
                let off = worst(&every, &record(&coarse, tau, b));
                assert!(off < 1e-12, "{tau} {b}: {off:e}");
            }
        }
        let mut stages: Vec<f64> = fine.iter().map(|&t| at(t)).collect();
        let of_second_order = record(&fine, 0.05, 0.25);
        for _ in 0..2 {
            lag(&fine, &mut stages, 0.025);
        }
        assert!(worst(&stages, &of_second_order) < 1e-6);
        let mut first: Vec<f64> = coarse.iter().map(|&t| at(t)).collect();
        lag(&coarse, &mut first, 0.05);
        assert!(worst(&first, &record(&coarse, 0.05, 0.0)) < 1e-7);
    }

    /// The input comes back, to a share of what the channel did to it.
    #[test]
    fn the_inverse_finds_its_input() {
        let fine: Vec<f64> = (0..=6000).map(|i| f64::from(i) / 6000.0).collect();
        let time: Vec<f64> = fine.iter().copied().step_by(100).collect();
        let truth = kinked(&time);
        for (tau, most) in [(0.2, 0.35), (0.5, 0.35), (1.0, 0.3), (3.0, 0.3)] {
            let tau: f64 = tau / 60.0;
            let mut recorded = kinked(&fine);
            lag_second_order(&fine, &mut recorded, tau, 0.25);
            let recorded: Vec<f64> = recorded.into_iter().step_by(100).collect();
            let found = unlag_second_order(&time, &recorded, tau, 0.25);
            let share = worst(&found, &truth) / worst(&recorded, &truth);
            println!("{tau}: {share}");
            assert!(share < most, "{tau}: {share}");
        }
    }

    /// sin(pi t) over half a period is bent by nothing at its ends, as a natural spline is.
    #[test]
    fn a_spline_is_bent_as_its_signal() {
        let pi = std::f64::consts::PI;
        let time: Vec<f64> = (0..=64).map(|i| f64::from(i) / 64.0).collect();
        let signal: Vec<f64> = time.iter().map(|t| (pi * t).sin()).collect();
        let bent: Vec<f64> = signal.iter().map(|s| -pi * pi * s).collect();
        assert!(worst(&curvatures(&time, &signal), &bent) < pi.powi(4) / 64.0_f64.powi(2) / 11.0);
    }
}
