//! Stribeck curves near a record, for starts: of the law's curve where it slides only the Stribeck speed is not linear.
//!
//! For v_s on a grid the three others follow from linear least squares over the samples that slide (variable projection, Golub and
//! Pereyra 1973):
//!
//! ```text
//! s y = mu_c + (mu_s - mu_c) exp(-(v / v_s)^2) + sigma2 |v|
//! ```

use nalgebra::{Matrix3, Vector3};

/// Stribeck speeds that are tried, as shares of the top speed.
const SHARES: [f64; 9] = [0.01, 0.02, 0.035, 0.06, 0.1, 0.17, 0.3, 0.5, 0.8];
/// Curves that are kept.
const KEPT: usize = 2;
/// Fewest samples that say anything of a curve, and the share of the top speed that their speeds must span.
const FEWEST: usize = 20;
const SPAN: f64 = 0.1;
/// Largest rise towards rest, in levels: more is a column that hardly any sample shows.
const MOST_RISE: f64 = 3.0;

/// A Stribeck curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlidingCurve {
    /// Level at speed without the viscous part, mu (N, N m).
    pub mu_c: f64,
    /// Level at rest.
    pub mu_s: f64,
    /// Stribeck speed, m/s (rad/s).
    pub v_s: f64,
    /// Viscous slope, s/m.
    pub sigma2: f64,
}

/// The curves that lie nearest to speeds and resistances, with a level at rest above that at speed and no slope below zero.
pub(crate) fn sliding_curves(slid: &[(f64, f64)], top_speed: f64) -> Vec<SlidingCurve> {
    let speeds = || slid.iter().map(|(speed, _)| *speed);
    let span = speeds().fold(0.0, f64::max) - speeds().fold(f64::INFINITY, f64::min);
    if slid.len() < FEWEST || !(span > SPAN * top_speed) {
        return Vec::new();
    }
    let mut curves: Vec<(f64, SlidingCurve)> = SHARES
        .iter()
        .filter_map(|share| curve(slid, share * top_speed))
        .collect();
    curves.sort_by(|a, b| a.0.total_cmp(&b.0));
    curves.truncate(KEPT);
    curves.into_iter().map(|(_, curve)| curve).collect()
}

/// The curve of one Stribeck speed and its sum of squares.
fn curve(slid: &[(f64, f64)], v_s: f64) -> Option<(f64, SlidingCurve)> {
    let row = |speed: f64| Vector3::new(1.0, (-(speed / v_s).powi(2)).exp(), speed);
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for &(speed, resistance) in slid {
        let row = row(speed);
        normal += row * row.transpose();
        right += row * resistance;
    }
    let all = normal.cholesky().map(|factor| factor.solve(&right));
    let levels = || {
        // No slope below zero: without one.
        let factor = normal.fixed_view::<2, 2>(0, 0).into_owned().cholesky()?;
        let two = factor.solve(&right.fixed_rows::<2>(0).into_owned());
        Some(Vector3::new(two[0], two[1], 0.0))
    };
    let [level, rise, sigma2] = all.filter(|c| c[2] >= 0.0).or_else(levels)?.into();
    let found = SlidingCurve {
        mu_c: level,
        mu_s: level + rise,
        v_s,
        sigma2,
    };
    let squares: f64 = slid
        .iter()
        .map(|&(speed, y)| (y - row(speed).dot(&Vector3::new(level, rise, sigma2))).powi(2))
        .sum();
    (level > 0.0 && (0.0..MOST_RISE * level).contains(&rise) && squares.is_finite())
        .then_some((squares, found))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A record that slides at many speeds, the lowest near the Stribeck speed.
    fn record(curve: &SlidingCurve) -> Vec<(f64, f64)> {
        let speeds = (1..=200).map(|i| 2e-4 * f64::from(i));
        speeds
            .map(|v| {
                let rise = (curve.mu_s - curve.mu_c) * (-(v / curve.v_s).powi(2)).exp();
                (v, curve.mu_c + rise + curve.sigma2 * v)
            })
            .collect()
    }

    #[test]
    fn the_curve_on_the_grid_is_found_exactly_and_the_one_beside_it_nearly() {
        let truth = SlidingCurve {
            mu_c: 0.48,
            mu_s: 0.71,
            v_s: 0.06 * 0.04,
            sigma2: 2.0,
        };
        let found = sliding_curves(&record(&truth), 0.04);
        assert_eq!(found.len(), KEPT);
        assert!((found[0].mu_c - truth.mu_c).abs() < 1e-9, "{found:?}");
        assert!((found[0].mu_s - truth.mu_s).abs() < 1e-9, "{found:?}");
        assert!((found[0].sigma2 - truth.sigma2).abs() < 1e-7, "{found:?}");
        let between = SlidingCurve {
            v_s: 0.077 * 0.04,
            ..truth
        };
        let found = sliding_curves(&record(&between), 0.04);
        assert!((found[0].mu_c - truth.mu_c).abs() < 0.02, "{found:?}");
    }

    #[test]
    fn a_record_of_one_speed_says_nothing_of_a_curve() {
        assert!(sliding_curves(&vec![(0.01, 0.4); 50], 0.01).is_empty());
        assert!(sliding_curves(&[], 0.01).is_empty());
    }
}
