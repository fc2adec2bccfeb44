//! A velocity that bends between its samples.
//!
//! A stage that is set going smoothly is recorded at few instants, and the chord between two of them cuts off way,
//!
//! ```text
//! x_chord - x = c h^3 / 12,   c = v''                                                                    (M1)
//! ```
//!
//! which before full sliding is friction. Where the samples themselves show a bend it is followed: c of an interval is the mean of the
//! second differences at its two ends (right in the middle of a cubic), at most twice the smaller of them, and zero where they differ in
//! sign, so that a corner of the motion stays a corner (the limiter of van Leer 1977). A recorded position has the last word: it may say
//! that the stage went along the chords.

/// Neighbouring intervals that must bend the same way: a corner between two samples bends at most two.
const TOGETHER: usize = 3;

/// c of (M1) in each interval, m/s^3; zero where the velocity is as good as straight. `bulge_m_s`: the largest distance between
/// chord and velocity, |c| h^2 / 8, that a bend must reach to count.
pub(crate) fn bends(time_s: &[f64], velocity_m_s: &[f64], bulge_m_s: f64) -> Vec<f64> {
    let intervals = time_s.len().saturating_sub(1);
    let chord = |i: usize| (velocity_m_s[i + 1] - velocity_m_s[i]) / (time_s[i + 1] - time_s[i]);
    let second = |i: usize| 2.0 * (chord(i) - chord(i - 1)) / (time_s[i + 1] - time_s[i - 1]);
    let mut bends: Vec<f64> = (0..intervals)
        .map(|i| {
            let before = (i > 0).then(|| second(i));
            let after = (i + 1 < intervals).then(|| second(i + 1));
            match (before, after) {
                (Some(a), Some(b)) if a * b > 0.0 => {
                    let least = a.abs().min(b.abs());
                    a.signum() * (0.5 * (a + b).abs()).min(2.0 * least)
                }
                (Some(c), None) | (None, Some(c)) => c,
                _ => 0.0,
            }
        })
        .collect();
    let bulge = |i: usize, c: f64| c.abs() * (time_s[i + 1] - time_s[i]).powi(2) / 8.0;
    let mut from = 0;
    while from < intervals {
        let same = bends[from..]
            .iter()
            .take_while(|c| **c * bends[from] > 0.0)
            .count();
        let to = from + same.max(1);
        let counts = (from..to).any(|i| bulge(i, bends[i]) > bulge_m_s);
        if same < TOGETHER || !counts {
            bends[from..to].fill(0.0);
        }
        from = to;
    }
    bends
}

/// Whether a recorded position (in m, either sense) says that the stage went along the chords and not along these bends: of the way of
/// the bends less than half is there, by two standard deviations.
pub(crate) fn went_straight(
    position_m: &[f64],
    time_s: &[f64],
    velocity_m_s: &[f64],
    bends: &[f64],
) -> bool {
    let ways: Vec<(f64, f64, f64)> = (0..bends.len())
        .filter(|&i| bends[i] != 0.0)
        .map(|i| {
            let h = time_s[i + 1] - time_s[i];
            let chord = 0.5 * (velocity_m_s[i] + velocity_m_s[i + 1]) * h;
            let bend = -bends[i] * h.powi(3) / 12.0;
            (position_m[i + 1] - position_m[i], chord, bend)
        })
        .collect();
    let sum = |term: &dyn Fn(&(f64, f64, f64)) -> f64| ways.iter().map(term).sum::<f64>();
    let sense = sum(&|(way, chord, _)| way * chord).signum();
    let squares = sum(&|(_, _, bend)| bend * bend);
    let share = sum(&|(way, chord, bend)| (sense * way - chord) * bend) / squares;
    let rest = sum(&|(way, chord, bend)| (sense * way - chord - share * bend).powi(2));
    let sd = (rest / squares / ways.len().saturating_sub(1).max(1) as f64).sqrt();
    share + 2.0 * sd < 0.5
}

/// Takes a velocity at `parts` steps from each sample to the next from its chords to the bends. The steps' own chords then cover the
/// way of the bend: v - c x (h - x) / 2 times 1 / (1 - 1 / parts^2).
pub(crate) fn bend(velocity: &mut [f64], time_s: &[f64], bends: &[f64], parts: usize) {
    let whole = 1.0 / (1.0 - 1.0 / (parts * parts) as f64);
    for (i, &c) in bends.iter().enumerate() {
        let (start, end) = (time_s[i * parts], time_s[(i + 1) * parts]);
        for k in i * parts + 1..(i + 1) * parts {
            velocity[k] -= 0.5 * whole * c * (time_s[k] - start) * (end - time_s[k]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::refined::between;

    /// Smooth start to speed 1 within `rise`, then steady.
    fn start(t: f64, rise: f64) -> f64 {
        let s = (t / rise).min(1.0);
        s * s * (3.0 - 2.0 * s)
    }

    fn way(time: &[f64], v: &[f64]) -> f64 {
        let steps = time.windows(2).zip(v.windows(2));
        steps
            .map(|(t, v)| 0.5 * (v[0] + v[1]) * (t[1] - t[0]))
            .sum()
    }

    #[test]
    fn the_way_of_a_smooth_start_is_followed() {
        let time: Vec<f64> = (0..40).map(|i| 0.05 * f64::from(i)).collect();
        let v: Vec<f64> = time.iter().map(|&t| start(t, 0.8)).collect();
        let c = bends(&time, &v, 2e-4);
        // Up to the third sample: s^3 - s^4 / 2 over the rise.
        let exact = 0.8 * ((0.15_f64 / 0.8).powi(3) - 0.5 * (0.15_f64 / 0.8).powi(4));
        let chords = way(&time[..4], &v[..4]);
        for parts in [2, 4] {
            let (fine_time, mut fine) = (between(&time, parts), between(&v, parts));
            bend(&mut fine, &fine_time, &c, parts);
            let followed = way(&fine_time[..=3 * parts], &fine[..=3 * parts]);
            assert!((chords - exact).abs() > 8.0 * (followed - exact).abs());
        }
        assert!(c[20..].iter().all(|c| *c == 0.0), "steady is steady");
    }

    /// In the middle of an interval a smooth start, a cubic of time, is met up to rounding; about its turning point, where the second
    /// differences change their sign, nearly.
    #[test]
    fn a_cubic_is_followed_between_its_samples() {
        let rise = 0.83;
        let time: Vec<f64> = (0..40).map(|i| 0.05 * f64::from(i)).collect();
        let v: Vec<f64> = time.iter().map(|&t| start(t, rise)).collect();
        let c = bends(&time, &v, 2e-4);
        for i in 1..15 {
            let t = 0.5 * (time[i] + time[i + 1]);
            let followed = 0.5 * (v[i] + v[i + 1]) - c[i] * 0.05_f64.powi(2) / 8.0;
            let miss = followed - start(t, rise);
            let turns = (t - 0.5 * rise).abs() < 0.1;
            assert!(miss.abs() < if turns { 1e-4 } else { 1e-12 }, "{i}: {miss}");
        }
    }

    #[test]
    fn a_corner_stays_a_corner() {
        let time: Vec<f64> = (0..40).map(|i| 0.05 * f64::from(i)).collect();
        for corner in [1.0, 1.02] {
            let v: Vec<f64> = time.iter().map(|&t| f64::min(t, corner)).collect();
            assert!(bends(&time, &v, 2e-4).iter().all(|c| *c == 0.0));
        }
    }

    /// A stage that is set going by half a sine, its position to a tenth of a micrometre: along the sine, along its chords, and to a
    /// millimetre only, which says nothing.
    #[test]
    fn a_recorded_position_tells_bends_from_chords() {
        let time: Vec<f64> = (0..60).map(|i| f64::from(i) / 60.0).collect();
        let turn = std::f64::consts::PI;
        let v: Vec<f64> = time
            .iter()
            .map(|t| 0.01 * (1.0 - (turn * t).cos()))
            .collect();
        let c = bends(&time, &v, 1e-6);
        assert!(c.iter().any(|c| *c != 0.0));
        let written = |x: f64, step: f64| (x / step).round() * step;
        let smooth = |step| -> Vec<f64> {
            let exact = |t: &f64| 0.01 * (t - (turn * t).sin() / turn);
            time.iter().map(|t| written(exact(t), step)).collect()
        };
        let chords = |step| -> Vec<f64> {
            let mut way = vec![0.0];
            for i in 1..60 {
                way.push(way[i - 1] + 0.5 * (v[i - 1] + v[i]) / 60.0);
            }
            way.iter().map(|x| written(0.3 - x, step)).collect()
        };
        assert!(!went_straight(&smooth(1e-7), &time, &v, &c));
        assert!(went_straight(&chords(1e-7), &time, &v, &c));
        assert!(!went_straight(&chords(1e-3), &time, &v, &c));
    }

    #[test]
    fn short_series_have_no_bends() {
        assert!(bends(&[], &[], 1.0).is_empty());
        assert_eq!(bends(&[0.0, 1.0], &[0.0, 1.0], 1.0), [0.0]);
    }
}
