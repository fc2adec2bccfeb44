//! The penalty of the merit function.
//!
//! ```text
//! ρ ≥ (gᵀd + ½ dᵀHd) / ((1 − σ)(v − v_lin))       (Nocedal and Wright, 18.36)
//! ```
//!
//! With it the quadratic model of φ falls by at least a share σ of what the
//! step takes off the violation, so the step is a descent direction of φ.

/// Share of the violation's fall that the model's fall must reach.
const SHARE: f64 = 0.3;

/// Below this share of the present penalty the needed one lets it fall.
const EXCESSIVE: f64 = 0.1;

/// The penalty ρ ≥ 1. It rises at once to what a step asks for and falls by half where a step asks for far less: one
/// subproblem with huge multipliers must not hold the rest of the solve to the curved rows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Penalty(pub f64);

impl Penalty {
    /// Sets ρ so that the step is a descent direction.
    ///
    /// `model` is gᵀd + ½ max(0, dᵀHd); `relief` is v − v_lin ≥ 0. Without relief nothing is asked: the step descends
    /// whatever ρ is, and ρ at the size of the largest multiplier, though an exact penalty, would hold the search to
    /// steps as short as the rows are curved.
    pub(crate) fn update(&mut self, model: f64, relief: f64) {
        if relief > 1e-14 {
            let needed = model / ((1.0 - SHARE) * relief);
            if needed > self.0 {
                self.0 = 1.5 * needed;
            } else if needed < EXCESSIVE * self.0 {
                self.0 = (0.5 * self.0).max(1.0);
            }
        }
    }
}
