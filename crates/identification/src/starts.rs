//! Where a fit begins: from the data alone.
//!
//! Levels, the stretch before sliding and the slope at speed give each law's parameters up to what only a fit can tell
//! (Stribeck speed, damping): over those the starts are spread. No published value and no recipe takes part.

use crate::features::Features;
use crate::sliding::SlidingCurve;
use friction::LawKind;

/// How much stiffer than the record shows a state may be: on a rig without a stretch before sliding what is read off is the way between
/// two samples, and from there the slope says nothing of a state stiffer still.
const JUMPS: f64 = 1e4;

/// Starts for the parameters of a law, in the order of [`LawKind::parameters`].
///
/// `height_m` is the gap of the bristle laws; `lean` their theta0 where it is held fixed.
pub fn starts(
    law: LawKind,
    features: &Features,
    height_m: Option<f64>,
    lean: Option<f64>,
) -> Vec<Vec<f64>> {
    let rise = features.slow_over_fast.clamp(1.02, 3.0);
    match law {
        LawKind::CoulombViscous => vec![vec![features.level(), features.viscous_slope]],
        LawKind::Stribeck => {
            let spread = [0.03, 0.1, 0.3].map(|share| {
                vec![
                    features.level(),
                    rise * features.level(),
                    share * features.top_speed,
                    features.viscous_slope,
                ]
            });
            let near = features.sliding.iter();
            let near = near.map(|curve| vec![curve.mu_c, curve.mu_s, curve.v_s, curve.sigma2]);
            spread.into_iter().chain(near).collect()
        }
        LawKind::Dahl => [0.5, 1.0, 2.0, JUMPS]
            .iter()
            .map(|factor| vec![features.level(), factor * features.stiffness()])
            .collect(),
        LawKind::Lugre | LawKind::LugreTyre => {
            let stiffness = features.stiffness();
            let damped = |damping: f64| damping * stiffness * time_scale(features);
            let spread = spread(&[0.01, 0.05, 0.2, 0.6]).map(|[share, damping]| {
                vec![
                    features.level(),
                    rise * features.level(),
                    share * features.top_speed,
                    stiffness,
                    damped(damping),
                    0.5 * features.viscous_slope,
                ]
            });
            let near = features.sliding.iter().flat_map(|curve| {
                let SlidingCurve {
                    mu_c,
                    mu_s,
                    v_s,
                    sigma2,
                } = *curve;
                [1.0, JUMPS]
                    .map(|stiffer| vec![mu_c, mu_s, v_s, stiffer * stiffness, damped(0.1), sigma2])
            });
            spread.chain(near).collect()
        }
        LawKind::SymmetricBristle => bristle_starts(features, height_m, Some(0.0))
            .into_iter()
            .map(|mut start| {
                start.truncate(6);
                start
            })
            .collect(),
        LawKind::AsymmetricBristle => bristle_starts(features, height_m, lean),
    }
}

/// Shares of the top speed with small and large damping.
fn spread(shares: &[f64]) -> impl Iterator<Item = [f64; 2]> {
    shares
        .iter()
        .flat_map(|&share| [[share, 0.03], [share, 0.3]])
        .collect::<Vec<_>>()
        .into_iter()
}

/// Time that the state takes to bend, s.
fn time_scale(features: &Features) -> f64 {
    if features.half_way_speed > 0.0 {
        features.half_way / features.half_way_speed
    } else {
        0.0
    }
}

/// Deflection, stiffness and lean of a bristle from the two levels and the slope at the start:
///
/// ```text
/// mu_f = sigma0 T cos^2(T + theta0),  mu_r = sigma0 T cos^2(T - theta0),  k = sigma0 cos^4(theta0) / h
/// ```
///
/// With q = (1 - sqrt(mu_f/mu_r)) / (1 + sqrt(mu_f/mu_r)) the first two give tan T tan theta0 = q; theta0 is scanned
/// (or fixed), and the scan keeps the leans whose slope k comes nearest.
fn bristle_starts(features: &Features, height_m: Option<f64>, lean: Option<f64>) -> Vec<Vec<f64>> {
    let height = height_m.unwrap_or(features.half_way);
    let slope = features.stiffness();
    let forward = features.forward.unwrap_or_else(|| features.level());
    let reverse = features.reverse.unwrap_or(forward);
    let ratio = (forward / reverse).max(1e-6).sqrt();
    let q = (1.0 - ratio) / (1.0 + ratio);

    let leans: Vec<f64> = match lean {
        Some(fixed) => vec![fixed],
        None => (1..=12)
            .flat_map(|i| [-0.1 * f64::from(i), 0.1 * f64::from(i)])
            .collect(),
    };
    let mut guesses: Vec<(f64, [f64; 3])> = leans
        .iter()
        .filter_map(|&theta0| {
            let upright = theta0.abs() < 1e-6 || lean.is_some();
            let bent = if upright {
                // theta0 does not tell the deflection: mu = sigma0 T cos^2 T with sigma0 from the slope.
                let stiffness = slope * height / theta0.cos().powi(4);
                (1..=13).map(|i| 0.1 * f64::from(i)).min_by(|a, b| {
                    let miss = |t: f64| {
                        (stiffness * t * (t + theta0).cos().powi(2) / forward)
                            .ln()
                            .abs()
                    };
                    miss(*a).total_cmp(&miss(*b))
                })?
            } else {
                (q / theta0.tan()).atan()
            };
            if !(0.02..1.4).contains(&bent) || (bent + theta0).cos().powi(2) < 1e-3 {
                return None;
            }
            let stiffness = forward / (bent * (bent + theta0).cos().powi(2));
            let miss = (stiffness * theta0.cos().powi(4) / height / slope)
                .ln()
                .abs();
            Some((miss, [bent, stiffness, theta0]))
        })
        .collect();
    guesses.sort_by(|a, b| a.0.total_cmp(&b.0));
    guesses.truncate(3);
    if guesses.is_empty() {
        let bent = 0.4;
        guesses.push((0.0, [bent, forward / bent, lean.unwrap_or(0.0)]));
    }
    let rise = features.slow_over_fast.clamp(1.05, 2.0);
    guesses
        .iter()
        .flat_map(|(_, [bent, stiffness, theta0])| {
            let top_rate = features.top_speed / height * (bent + theta0).cos().powi(2);
            [0.1, 0.4].into_iter().flat_map(move |share| {
                [0.01, 0.1].into_iter().map(move |damping| {
                    vec![
                        *bent,
                        (rise * bent).min(1.5),
                        *stiffness,
                        damping * stiffness * time_scale(features),
                        0.01 * forward / top_rate,
                        share * top_rate,
                        *theta0,
                    ]
                })
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp_features() -> Features {
        Features {
            top_speed: 0.06,
            forward: Some(0.8),
            reverse: Some(0.4),
            slow_over_fast: 1.1,
            viscous_slope: 0.2,
            half_way: 2e-3,
            half_way_speed: 0.01,
            sliding: vec![SlidingCurve {
                mu_c: 0.5,
                mu_s: 0.6,
                v_s: 4e-3,
                sigma2: 0.2,
            }],
        }
    }

    #[test]
    fn every_law_gets_starts_inside_its_bounds() {
        for law in LawKind::ALL {
            let found = starts(law, &ramp_features(), Some(7e-3), None);
            assert!(!found.is_empty());
            for start in found {
                law.check(&start).unwrap();
            }
        }
    }

    /// The closed form behind the bristle's starts, run backwards: the levels that a start implies are those given.
    #[test]
    fn bristle_starts_reproduce_both_levels() {
        let features = ramp_features();
        for p in starts(LawKind::AsymmetricBristle, &features, Some(7e-3), None) {
            let level = |sign: f64| p[2] * p[0] * (sign * p[0] + p[6]).cos().powi(2);
            assert!((level(1.0) - 0.8).abs() < 1e-9);
            assert!((level(-1.0) - 0.4).abs() < 1e-9, "{}", level(-1.0));
        }
    }

    #[test]
    fn a_fixed_lean_stays_fixed() {
        for start in starts(
            LawKind::AsymmetricBristle,
            &ramp_features(),
            Some(7e-3),
            Some(-0.2),
        ) {
            assert_eq!(start[6], -0.2);
        }
    }
}
