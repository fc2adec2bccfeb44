//! How far a planted effect takes the data from everything that the law alone, or the law with another cause, could
//! have produced: computed with the planting simulator and the true noise, independently of the diagnosis.
//!
//! With W'W = V^-1 for the true noise without scatter, J the derivatives of the record with respect to the law, H one
//! gain column a run, D the change that the effect makes:
//!
//! ```text
//! d_w^2 = min |W (D - J a - H b)|^2                       within runs: no scatter can imitate it
//! d_k^2 = min |W (D - J a - H b)|^2 + |b|^2 / scatter^2    scatter known
//! ```
//!
//! What lives between runs, d_k^2 - d_w^2, is judged with a scatter that is itself estimated from the runs: it counts as
//! the normal deviate with the tail probability of Student's t with the degrees of freedom that the runs leave.
//! A size has ratio 1 where the total reaches the distance that a test at 1 % over 27 causes finds in 90 % of cases.

mod rivals;

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use planting::effect::Effect;
use planting::machine::{Recording, Rig, run_day};
use planting::motion::Motion;
use planting::plan::{Noise, Plan};
use planting::{Case, NoiseKind, Planted};
use statrs::distribution::{Continuous, ContinuousCDF, Normal, StudentsT};

use fitting::noise::{Context, Sizes, Whitener};

pub use rivals::{Rivals, Sight};

/// Distance at which the test that knows the cause has 90 % power at 1 % over 27 causes.
pub const THRESHOLD: f64 = 4.8;
/// The same where a period has to be searched for.
pub const THRESHOLD_PERIODIC: f64 = 6.1;
/// Whether a cause has a period that must be searched for.
pub fn is_periodic(cause: &str) -> bool {
    matches!(
        cause,
        "stage-ripple" | "surface-texture" | "load-oscillation"
    )
}

/// The point of view of one specimen on one protocol.
pub struct Oracle {
    case: Case,
    law_rig: Rig,
    plan: Plan,
    whitener: Whitener,
    /// With the scatter between runs.
    whole_whitener: Whitener,
    scatter: f64,
    clean: Vec<f64>,
    /// Orthonormal basis of the whitened derivatives.
    basis: DMatrix<f64>,
    /// Whitened gain columns, law projected out, orthonormal directions times their lengths.
    gains: DMatrix<f64>,
    gain_lengths: Vec<f64>,
    freedom: f64,
}

fn stack(recordings: &[Recording]) -> Vec<f64> {
    recordings
        .iter()
        .flat_map(|run| run.force_n.iter().copied())
        .collect()
}

/// Orthonormal basis of the columns whose part outside the previous ones is not negligible.
fn orthonormal(columns: &DMatrix<f64>) -> DMatrix<f64> {
    let mut kept: Vec<DVector<f64>> = Vec::new();
    for column in columns.column_iter() {
        let length = column.norm();
        let mut free = column.into_owned();
        // Twice is enough (Kahan, Parlett).
        for _ in 0..2 {
            for other in &kept {
                let share = other.dot(&free);
                free.axpy(-share, other, 1.0);
            }
        }
        if length > 0.0 && free.norm() > 1e-6 * length {
            kept.push(free.normalize());
        }
    }
    if kept.is_empty() {
        DMatrix::zeros(columns.nrows(), 0)
    } else {
        DMatrix::from_columns(&kept)
    }
}

/// Whether the recorded speeds are others than those of the stage.
fn changes_the_speeds(effects: &[Effect]) -> bool {
    let mut effects = effects.iter();
    effects.any(|effect| matches!(effect, Effect::VelocityLag { .. }))
}

impl Oracle {
    /// Looks at the specimen, protocol, law and noise of `case` with nothing planted.
    ///
    /// # Errors
    /// If the case cannot be set up.
    pub fn new(case: &Case) -> Result<Self, String> {
        let healthy = Case {
            planted: Vec::new(),
            ..case.clone()
        };
        let (rig, plan, noise) = healthy.set_up()?;
        let recordings = run_day(&rig, &plan, &Noise::NONE, 0);
        let clean = stack(&recordings);
        let context = context(&plan, &recordings);
        let sizes = Sizes {
            sensor: noise.sensor_n,
            wander: noise.wander_n,
            wander_time_s: noise.wander_s,
            private: noise.roughness * (1.0 - noise.plate_share).sqrt(),
            plate: noise.roughness * noise.plate_share.sqrt(),
            length: noise.correlation_m,
            ..Sizes::NONE
        };
        let whitener = Whitener::new(&context, &sizes);
        let scatter = noise.scatter;
        let whole_whitener = Whitener::new(&context, &Sizes { scatter, ..sizes });
        let derivatives = whitener.whiten_columns(&law_derivatives(&rig, &plan, &clean));
        let basis = orthonormal(&derivatives);
        let mut gains = DMatrix::zeros(clean.len(), context.runs.len());
        for (k, run) in context.runs.iter().enumerate() {
            for i in run.clone() {
                gains[(i, k)] = context.scale[i];
            }
        }
        let gains = whitener.whiten_columns(&gains);
        let free = &gains - &basis * basis.tr_mul(&gains);
        let decomposition = free.svd(true, false);
        let left = decomposition.u.ok_or("no singular vectors")?;
        let largest = decomposition.singular_values.max();
        let keep: Vec<usize> = (0..left.ncols())
            .filter(|k| decomposition.singular_values[*k] > 1e-3 * largest)
            .collect();
        let gain_lengths = keep
            .iter()
            .map(|k| decomposition.singular_values[*k])
            .collect::<Vec<f64>>();
        let freedom = (keep.len() as f64 - 1.0).max(1.0);
        Ok(Self {
            case: healthy,
            law_rig: rig,
            plan,
            whitener,
            whole_whitener,
            scatter,
            clean,
            basis,
            gains: left.select_columns(&keep),
            gain_lengths,
            freedom,
        })
    }

    /// The change that these effects make, whitened, law projected out; relative to what the finder would predict from
    /// the recorded velocity.
    fn change(&self, planted: &[Planted]) -> Result<DVector<f64>, String> {
        Ok(self.project(&self.difference(&self.effects(planted)?)))
    }

    /// What is planted, at this specimen's scales.
    fn effects(&self, planted: &[Planted]) -> Result<Vec<Effect>, String> {
        let case = Case {
            planted: planted.to_vec(),
            ..self.case.clone()
        };
        Ok(case.key()?.effects)
    }

    /// The day with these effects and without noise.
    fn day(&self, effects: &[Effect]) -> Vec<Recording> {
        let rig = Rig {
            effects: effects.to_vec(),
            ..self.law_rig.clone()
        };
        run_day(&rig, &self.plan, &Noise::NONE, 0)
    }

    fn difference(&self, effects: &[Effect]) -> DVector<f64> {
        let recordings = self.day(effects);
        let force = stack(&recordings);
        let reference = if changes_the_speeds(effects) {
            self.predicted_from(&recordings)
        } else {
            self.clean.clone()
        };
        DVector::from_iterator(
            force.len(),
            force.iter().zip(&reference).map(|(a, b)| a - b),
        )
    }

    /// What the law alone gives for the motions in the velocity channels.
    fn predicted_from(&self, recordings: &[Recording]) -> Vec<f64> {
        let mut plan = self.plan.clone();
        for (run, recording) in plan.runs.iter_mut().zip(recordings) {
            let points: Vec<(f64, f64)> = recording
                .time_s
                .iter()
                .copied()
                .zip(recording.velocity_m_s.iter().copied())
                .collect();
            run.motion = Motion::through(&points);
        }
        stack(&run_day(&self.law_rig, &plan, &Noise::NONE, 0))
    }

    fn project(&self, change: &DVector<f64>) -> DVector<f64> {
        let whitened = self.whitener.whiten(change);
        &whitened - &self.basis * self.basis.tr_mul(&whitened)
    }

    /// The share of the law's squared error against the noise-free truth that the extension removes, errors whitened by the
    /// true noise: 1 - |W (extended - truth)|^2 / |W (law - truth)|^2.
    pub fn true_gain(&self, truth: &[f64], law: &[f64], extended: &[f64]) -> f64 {
        let error = |curve: &[f64]| {
            let apart = curve.iter().zip(truth).map(|(a, t)| a - t);
            let apart = DVector::from_iterator(truth.len(), apart);
            self.whole_whitener.whiten(&apart).norm_squared()
        };
        1.0 - error(extended) / error(law).max(f64::MIN_POSITIVE)
    }

    /// A record's deviation, whitened, what gains of runs and the law can take out of it taken out.
    pub fn whiten_free(&self, deviation: &DVector<f64>) -> DVector<f64> {
        let free = self.project(deviation);
        &free - &self.gains * self.gains.tr_mul(&free)
    }

    /// Distance of a projected change, see the head of this file.
    fn distance(&self, free: &DVector<f64>) -> f64 {
        let along = self.gains.tr_mul(free);
        let within = (free.norm_squared() - along.norm_squared()).max(0.0);
        // Along a gain direction of length l the noise has variance 1 + (scatter l)^2.
        let between: f64 = along
            .iter()
            .zip(&self.gain_lengths)
            .map(|(a, l)| a * a / (1.0 + (self.scatter * l).powi(2)))
            .sum();
        (within + deviate(between.sqrt(), self.freedom).powi(2)).sqrt()
    }

    /// (within, between) parts of a projected change: what scatter cannot imitate, and what it can, scatter known.
    pub fn parts(&self, planted: &[Planted]) -> Result<(f64, f64), String> {
        let free = self.change(planted)?;
        let along = self.gains.tr_mul(&free);
        let within = (free.norm_squared() - along.norm_squared()).max(0.0).sqrt();
        let between: f64 = along
            .iter()
            .zip(&self.gain_lengths)
            .map(|(a, l)| a * a / (1.0 + (self.scatter * l).powi(2)))
            .sum();
        Ok((within, between.sqrt()))
    }

    /// Distance of the effects from the law alone, in standard deviations.
    ///
    /// # Errors
    /// If a planted id is unknown.
    pub fn distance_of(&self, planted: &[Planted]) -> Result<f64, String> {
        Ok(self.distance(&self.change(planted)?))
    }

    /// The size at which the test that knows the cause finds the effect in 90 % of cases, `None` if the law absorbs
    /// every size up to `largest`.
    ///
    /// # Errors
    /// If the id is unknown.
    pub fn threshold(
        &self,
        id: &str,
        second_shape: bool,
        largest: f64,
    ) -> Result<Option<f64>, String> {
        let goal = if is_periodic(id) {
            THRESHOLD_PERIODIC
        } else {
            THRESHOLD
        };
        let at = |size: f64| {
            self.distance_of(&[Planted {
                id: id.into(),
                size,
                second_shape,
            }])
        };
        let (mut low, mut high) = (0.0, f64::INFINITY);
        let mut size = 0.1;
        // Distances grow nearly in proportion to sizes: a secant through the origin, kept between the best bounds.
        for _ in 0..14 {
            let distance = at(size)?;
            if (distance / goal - 1.0).abs() < 0.01 {
                return Ok(Some(size));
            }
            if distance < goal {
                low = size
            } else {
                high = size
            }
            let proportional = size * (goal / distance.max(1e-9)).clamp(0.05, 20.0);
            size = if proportional > low && proportional < high {
                proportional
            } else if high.is_finite() {
                0.5 * (low + high)
            } else {
                2.0 * low
            };
            if size > largest {
                return Ok(None);
            }
        }
        Ok(Some(size))
    }
}

/// The normal deviate with the two-sided tail of Student's t at `t` with `freedom` degrees.
fn deviate(t: f64, freedom: f64) -> f64 {
    let (Ok(student), Ok(normal)) = (StudentsT::new(0.0, 1.0, freedom), Normal::new(0.0, 1.0))
    else {
        return t;
    };
    // No distance, or one that is no number, shows nothing.
    if t.is_nan() || t <= 0.0 {
        return 0.0;
    }
    let tail = 1.0 - student.cdf(t);
    // Far out the tail is t pdf(t)/freedom, and the normal deviate sqrt(-2 log tail) to a few per cent.
    if tail < 1e-14 {
        let log_tail = student.ln_pdf(t) + (t / freedom).ln();
        return t.min((-2.0 * log_tail).sqrt());
    }
    normal.inverse_cdf(1.0 - tail).max(0.0)
}

/// Central differences of the record with respect to the law's free parameters.
fn law_derivatives(rig: &Rig, plan: &Plan, clean: &[f64]) -> DMatrix<f64> {
    let free = rig.law.free_parameters();
    let mut derivatives = DMatrix::zeros(clean.len(), free.len());
    for (column, value) in free.iter().enumerate() {
        // Step of the cube root of the integration error times the size: error of the slope about 1e-5 of it.
        let step = 2e-3 * value.abs();
        let at = |shift: f64| {
            let mut moved = free.clone();
            moved[column] += shift;
            let rig = Rig {
                law: rig.law.with_free_parameters(&moved),
                ..rig.clone()
            };
            stack(&run_day(&rig, plan, &Noise::NONE, 0))
        };
        let (up, down) = (at(step), at(-step));
        for (i, (u, d)) in up.iter().zip(&down).enumerate() {
            derivatives[(i, column)] = (u - d) / (2.0 * step);
        }
    }
    derivatives
}

/// Sliding, place and friction of every sample, as the noise sees them.
fn context(plan: &Plan, recordings: &[Recording]) -> Context {
    let (mut runs, mut steps_s, mut sliding) = (Vec::new(), Vec::new(), Vec::new());
    let (mut place, mut scale) = (Vec::new(), Vec::new());
    for recording in recordings {
        let first = sliding.len();
        let mut slid = 0.0;
        for i in 0..recording.time_s.len() {
            if i > 0 {
                slid += (recording.position_m[i] - recording.position_m[i - 1]).abs();
            }
            let before = i.saturating_sub(1);
            steps_s.push(recording.time_s[i] - recording.time_s[before]);
            sliding.push(slid);
            place.push(recording.position_m[i]);
            let inertia = plan.moving_mass_kg.unwrap_or(0.0) * slope(recording, i);
            scale.push(recording.force_n[i] - inertia);
        }
        runs.push(first..sliding.len());
    }
    Context {
        conditions: Vec::new(),
        steps_s,
        channel: Arc::default(),
        rows: Vec::new(),
        runs,
        sliding,
        place,
        scale,
    }
}

/// dv/dt by differences over the neighbours.
fn slope(recording: &Recording, i: usize) -> f64 {
    let (low, high) = (i.saturating_sub(1), (i + 1).min(recording.time_s.len() - 1));
    (recording.velocity_m_s[high] - recording.velocity_m_s[low])
        / (recording.time_s[high] - recording.time_s[low])
}

/// A case of the usual noise, as the point of view of an oracle.
pub fn viewpoint(protocol: planting::Protocol, specimen: u64) -> Case {
    Case::nothing(protocol, NoiseKind::Usual, specimen)
}
