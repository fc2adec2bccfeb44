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

/// A penalty that never falls during one solve, save for one reset when the
/// violation has vanished and ρ is out of all proportion to the multipliers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Penalty(pub f64);

impl Penalty {
    /// Raises ρ so that the step is a descent direction.
    ///
    /// `model` is gᵀd + ½ max(0, dᵀHd); `relief` is v − v_lin ≥ 0; `multiplier`
    /// the largest row multiplier of the step.
    pub(crate) fn update(&mut self, model: f64, relief: f64, multiplier: f64) {
        if relief > 1e-14 {
            let needed = model / ((1.0 - SHARE) * relief);
            if needed > self.0 {
                self.0 = 1.5 * needed;
            }
        } else if multiplier > self.0 {
            // On the feasible manifold the rule above says nothing; an exact
            // penalty must exceed the largest multiplier.
            self.0 = 1.5 * multiplier;
        }
    }
}
