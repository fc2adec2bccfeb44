//! Which other causes could have made the same data: rivals by their signatures, the law's own directions taken out.

use nalgebra::DVector;
use planting::effect::Effect;
use planting::species::CAUSES;
use planting::{Base, Case, Planted};

use super::{Oracle, THRESHOLD, changes_the_speeds, is_periodic};

/// Distance below which two explanations count as the same.
const INSEPARABLE: f64 = 4.7;
/// Size at which a cause's signature is taken.
const SIGNATURE_SIZE: f64 = 0.2;
/// A signature is a straight line: rivals that leave less than this share of the distance are looked at again at their best size.
const IMITATES: f64 = 0.95;

/// What a protocol makes of an effect of a given size.
#[derive(Clone, Debug, PartialEq)]
pub struct Sight {
    /// Distance from the law alone, scatter and its estimation allowed for.
    pub distance: f64,
    /// Causes that could have produced the same data, the planted one included.
    pub forced: Vec<String>,
}

impl Oracle {
    /// What the protocol makes of these effects: distance, and the causes that could have made the same data.
    ///
    /// # Errors
    /// If a planted id is unknown.
    pub fn look(&self, planted: &[Planted], rivals: &Rivals) -> Result<Sight, String> {
        let change = self.change(planted)?;
        let own: Vec<&str> = planted.iter().map(|planted| planted.id.as_str()).collect();
        let mut forced: Vec<String> = own.iter().map(|id| (*id).to_string()).collect();
        let whole = self.distance(&change);
        if planted.len() == 1 && !self.shows_in_positions(planted)? {
            for (cause, signatures) in &rivals.signatures {
                if own.contains(&cause.as_str()) {
                    continue;
                }
                let nearest = signatures
                    .iter()
                    .map(|line| (self.distance(&(&change - line.best(&change))), line))
                    .min_by(|a, b| a.0.total_cmp(&b.0));
                let Some((mut nearest, line)) = nearest else {
                    continue;
                };
                if nearest > INSEPARABLE && nearest < IMITATES * whole && signatures.len() == 1 {
                    nearest = nearest.min(self.bent(cause, line, &change)?);
                }
                if nearest < INSEPARABLE {
                    forced.push(cause.clone());
                }
            }
        }
        forced.sort();
        Ok(Sight {
            distance: whole,
            forced,
        })
    }

    /// Whether speeds and positions are recorded that go together in a way that only the effects explain: a stage goes the mean of its
    /// speeds times the time between them.
    fn shows_in_positions(&self, planted: &[Planted]) -> Result<bool, String> {
        let Some(step_m) = self.plan.position_step_m() else {
            return Ok(false);
        };
        let effects = self.effects(planted)?;
        if !changes_the_speeds(&effects) {
            return Ok(false);
        }
        let mut squares = 0.0;
        for (changed, plain) in self.day(&effects).iter().zip(&self.day(&[])) {
            let ways = changed
                .velocity_m_s
                .windows(2)
                .zip(plain.velocity_m_s.windows(2));
            let ways = ways.map(|(with, without)| {
                (with[0] + with[1] - without[0] - without[1]) / (2.0 * self.plan.sample_rate_hz)
            });
            squares += ways.map(|way| way * way).sum::<f64>();
        }
        // Either end of a way is written to the nearest step.
        Ok(squares > (THRESHOLD * step_m).powi(2) / 6.0)
    }

    /// Distance of a change from a rival at its best size, the rival's own bend allowed for: a delay of a corner is no multiple of a
    /// longer one.
    fn bent(&self, cause: &str, line: &Line, change: &DVector<f64>) -> Result<f64, String> {
        const ROUNDS: usize = 4;
        let mut size = SIGNATURE_SIZE * line.direction.dot(change) / line.length;
        let mut nearest = f64::INFINITY;
        for _ in 0..ROUNDS {
            if size == 0.0 || size < 0.0 && !has_both_signs(cause) {
                break;
            }
            let planted = Planted {
                id: cause.into(),
                size,
                second_shape: false,
            };
            let rival = self.change(&[planted])?;
            nearest = nearest.min(self.distance(&(change - &rival)));
            size *= rival.dot(change) / rival.norm_squared().max(f64::MIN_POSITIVE);
        }
        Ok(nearest)
    }

    /// Signatures of every cause for several of its periods and time constants.
    ///
    /// # Errors
    /// Never for the known causes.
    pub fn rivals(&self) -> Result<Rivals, String> {
        let mut signatures = Vec::new();
        for cause in CAUSES {
            // Clipping and rounding are looked for directly; periods are free, so a rival's meets no other by chance.
            if matches!(cause, "force-saturation" | "force-resolution") || is_periodic(cause) {
                continue;
            }
            // A mass on a cord under a law without an inner state sticks by chattering: minutes for one signature.
            let stateless = matches!(self.case.base, Base::Stribeck | Base::CoulombViscous);
            if cause == "cord-compliance" && stateless {
                continue;
            }
            let mut shapes = Vec::new();
            for effect in self.variants(cause)? {
                let change = self.project(&self.difference(&[effect]));
                let raw = self.whitener.whiten(&self.difference(&[effect])).norm();
                // What the law absorbs is no explanation of its own.
                if change.norm() > 1e-3 * raw && raw > 0.0 {
                    shapes.push(Line {
                        length: change.norm(),
                        direction: change.normalize(),
                    });
                }
            }
            signatures.push((cause.to_string(), shapes));
        }
        Ok(Rivals { signatures })
    }

    /// A cause at small size, over the range of its shape parameters.
    fn variants(&self, cause: &str) -> Result<Vec<Effect>, String> {
        let planted = vec![Planted {
            id: cause.into(),
            size: SIGNATURE_SIZE,
            second_shape: false,
        }];
        let effect = Case {
            planted,
            ..self.case.clone()
        }
        .key()?
        .effects[0];
        let spread = [0.2, 0.5, 1.0, 2.0, 5.0];
        Ok(match effect {
            Effect::Wear {
                amplitude,
                distance_m,
                course,
            } => spread
                .iter()
                .map(|factor| Effect::Wear {
                    amplitude,
                    distance_m: distance_m * factor,
                    course,
                })
                .collect(),
            Effect::ThermalSoftening {
                strength_per_j,
                time_constant_s,
                levels_off,
            } => spread
                .iter()
                .map(|factor| Effect::ThermalSoftening {
                    strength_per_j,
                    time_constant_s: time_constant_s * factor,
                    levels_off,
                })
                .collect(),
            Effect::BristleSet {
                angle_rad,
                settling,
                ..
            } => [0.3, 1.0, 2.0, 4.0]
                .iter()
                .map(|runs| Effect::BristleSet {
                    angle_rad,
                    runs: *runs,
                    settling,
                })
                .collect(),
            Effect::CordCompliance {
                compliance_m_n,
                damping_n_s_m,
                ..
            } => [0.3, 1.0, 3.0]
                .iter()
                .map(|factor| Effect::CordCompliance {
                    compliance_m_n: compliance_m_n * factor,
                    damping_n_s_m,
                    hardening_m: None,
                })
                .collect(),
            other => vec![other],
        })
    }
}

/// Unit signatures of the causes, law projected out.
pub struct Rivals {
    signatures: Vec<(String, Vec<Line>)>,
}

/// What a cause changes at [`SIGNATURE_SIZE`], law projected out.
struct Line {
    direction: DVector<f64>,
    length: f64,
}

impl Line {
    /// The multiple of the line that is nearest to a change.
    fn best(&self, change: &DVector<f64>) -> DVector<f64> {
        &self.direction * self.direction.dot(change)
    }
}

/// Whether a cause may have either sign where what it changes bends with its size.
fn has_both_signs(cause: &str) -> bool {
    matches!(
        cause,
        "clock-offset" | "direction-asymmetry" | "bristle-set" | "stribeck-shape"
    )
}

#[cfg(test)]
mod tests {
    use super::super::viewpoint;
    use super::*;

    /// A short lag is a delay of the same length but for its corners; a long one is none. A delay's signature at one size tells
    /// neither: it is no multiple of a shorter delay's.
    #[test]
    fn a_short_lag_is_taken_for_a_delay_and_a_long_one_is_not() -> Result<(), String> {
        let oracle = Oracle::new(&viewpoint(planting::Protocol::Rich, 0))?;
        let rivals = oracle.rivals()?;
        let threshold = oracle.threshold("sensor-lag", false, 1.0)?;
        let threshold = threshold.ok_or("the lag is seen")?;
        let is_delay = |ratio: f64| -> Result<bool, String> {
            let planted = Planted {
                id: "sensor-lag".into(),
                size: ratio * threshold,
                second_shape: false,
            };
            let sight = oracle.look(&[planted], &rivals)?;
            println!("{ratio} {} {:?}", sight.distance, sight.forced);
            Ok(sight.forced.iter().any(|cause| cause == "clock-offset"))
        };
        assert!(is_delay(5.0)?);
        assert!(!is_delay(40.0)?);
        Ok(())
    }
}
