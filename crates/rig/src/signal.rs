//! What channels do to a sampled signal: slopes, first-order lag, delay. Generic over the scalar, linear in samples.

use friction::Scalar;

/// Slope of a sampled signal at its samples: the parabola through three neighbours, one-sided at the ends.
pub fn slope<D: Scalar>(time_s: &[f64], signal: &[D]) -> Vec<D> {
    let n = signal.len();
    if n < 2 {
        return vec![D::constant(0.0); n];
    }
    let chord = |i: usize| (signal[i + 1] - signal[i]) / (time_s[i + 1] - time_s[i]);
    let mut slopes = Vec::with_capacity(n);
    slopes.push(chord(0));
    for i in 1..n - 1 {
        let (before, after) = (time_s[i] - time_s[i - 1], time_s[i + 1] - time_s[i]);
        let weight = before / (before + after);
        slopes.push(chord(i) * weight + chord(i - 1) * (1.0 - weight));
    }
    slopes.push(chord(n - 2));
    slopes
}

/// First-order lag, y' = (x - y)/tau, of a signal that is linear between its samples; y starts at x.
///
/// Exact for that signal: with r = dt/tau, y1 = x1 - s tau (1 - e^-r) + (y0 - x0) e^-r, s the slope of x. At tau <= 0
/// the output is the input.
pub fn lag<D: Scalar>(time_s: &[f64], signal: &mut [D], tau: D) {
    let Some(&first) = signal.first() else { return };
    let (mut before, mut y) = (first, first);
    for i in 1..signal.len() {
        let dt = time_s[i] - time_s[i - 1];
        let x = signal[i];
        y = lag_step(before, x, y, dt, tau);
        before = x;
        signal[i] = y;
    }
}

/// One step of the lag over `dt` from output `y` at input `x0` to the output at input `x1`. `tau` and `dt` may be a
/// time, or a distance where memory is a length.
pub fn lag_step<D: Scalar>(x0: D, x1: D, y: D, dt: f64, tau: D) -> D {
    if dt <= 0.0 {
        return y;
    }
    let (fade, behind) = if tau.value() * 700.0 < dt {
        // so short that what was before is forgotten: y follows x by tau times its slope
        (D::constant(0.0), tau)
    } else {
        let fade = (-(tau.recip() * dt)).exp();
        (fade, tau * (-fade + 1.0))
    };
    x1 - (x1 - x0) / dt * behind + (y - x0) * fade
}

/// The input of a first-order lag, tau y' = x - y, from its output at samples.
///
/// The inverse of [`lag`], exact for an input that is linear between samples: with r = dt/tau and b = (1 - e^-r)/r,
/// x1 = (y1 - y0 e^-r - x0 (b - e^-r))/(1 - b), x starts at y. Its rounding errors alternate and fade slowly where a sample is short
/// beside tau; there x = y + tau y' with the slopes of [`slope`] is good, and the two are blended by 1/(1 + (tau/2dt)^4).
pub fn unlag<D: Scalar>(time_s: &[f64], output: &[f64], tau: D) -> Vec<D> {
    let slopes = slope(time_s, output);
    let mut exact = D::constant(output.first().copied().unwrap_or(0.0));
    let mut input = vec![exact; output.len()];
    for i in 1..output.len() {
        let dt = time_s[i] - time_s[i - 1];
        if dt <= 0.0 {
            input[i] = input[i - 1];
            continue;
        }
        let fade = if tau.value() * 700.0 < dt {
            D::constant(0.0)
        } else {
            (-(tau.recip() * dt)).exp()
        };
        let b = tau * (-fade + 1.0) / dt;
        exact = (-(fade * output[i - 1]) + output[i] - exact * (b - fade)) / (-b + 1.0);
        let square = (tau / (2.0 * dt)) * (tau / (2.0 * dt));
        let weight = (square * square + 1.0).recip();
        let smooth = tau * slopes[i] + output[i];
        input[i] = smooth + (exact - smooth) * weight;
    }
    input
}

/// The signal as it was `delay` seconds ago (ahead, if negative): a cubic through each pair of samples with their
/// slopes; before the first and after the last sample the signal stands still (at no delay,
/// the derivative is the one towards a late signal).
pub fn delay<D: Scalar>(time_s: &[f64], signal: &mut [D], delay: D) {
    let n = signal.len();
    if n < 2 {
        return;
    }
    let slopes = slope(time_s, signal);
    let source = signal.to_vec();
    let mut k = 0;
    for i in 0..n {
        let at = -delay + time_s[i];
        if at.value() <= time_s[0] {
            signal[i] = source[0];
            continue;
        }
        if at.value() >= time_s[n - 1] {
            // at no delay the derivative is that towards a late signal
            let end = at.value() == time_s[n - 1];
            signal[i] = if end {
                source[n - 1] + (at - time_s[n - 1]) * slopes[n - 1]
            } else {
                source[n - 1]
            };
            continue;
        }
        while k + 2 < n && time_s[k + 1] <= at.value() {
            k += 1;
        }
        while k > 0 && time_s[k] > at.value() {
            k -= 1;
        }
        let h = time_s[k + 1] - time_s[k];
        let s = (at - time_s[k]) / h;
        let (s2, s3) = (s * s, s * s * s);
        let rise = s2 * 3.0 - s3 * 2.0;
        signal[i] = source[k] * (-rise + 1.0)
            + source[k + 1] * rise
            + slopes[k] * (s - s2 * 2.0 + s3) * h
            + slopes[k + 1] * (s3 - s2) * h;
    }
}

/// Value of a sampled signal between its samples by straight lines, `t` inside the record.
pub fn between<D: Scalar>(time_s: &[f64], signal: &[D], i: usize, t: f64) -> D {
    let share = (t - time_s[i]) / (time_s[i + 1] - time_s[i]);
    signal[i] + (signal[i + 1] - signal[i]) * share
}

#[cfg(test)]
mod tests {
    use super::{lag, unlag};

    /// What a lag did to a motion with kinks at its samples is undone: to a share of the slope formula's error while the lag is
    /// shorter than a sample, and to that formula's own error where it is longer.
    #[test]
    fn the_inverse_of_a_lag_finds_its_input() {
        let time: Vec<f64> = (0..60).map(|i| f64::from(i) / 60.0).collect();
        let truth: Vec<f64> = time
            .iter()
            .map(|t| {
                if *t < 0.3 {
                    0.1 * t
                } else {
                    0.03 - 0.2 * (t - 0.3)
                }
            })
            .collect();
        // (tau in samples, largest error over tau times the change of slope)
        for (tau, worst) in [(0.1, 1e-5), (0.5, 3e-3), (1.0, 0.03), (10.0, 0.5)] {
            let tau: f64 = tau / 60.0;
            let mut recorded = truth.clone();
            lag(&time, &mut recorded, tau);
            let found = unlag(&time, &recorded, tau);
            let error = found
                .iter()
                .zip(&truth)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            assert!(error < worst * tau * 0.3, "{tau}: {}", error / (tau * 0.3));
        }
        assert_eq!(unlag(&time, &truth, 0.0), truth);
    }
}
