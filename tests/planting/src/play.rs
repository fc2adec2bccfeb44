//! A play opens where the joint carries no force: bristles that are bent hold it closed for a while after a turn.

use crate::law::{Law, Surroundings};
use crate::motion::{Motion, Play};

/// Step of the integration, s: a stage of some millimetres a second goes micrometres in it.
const STEP_S: f64 = 1e-4;

/// Distances (m) that the stage goes after each of its turns until the contact behind a play of width `gap_m` pulls no more. The
/// contact starts unbent; a turn before the play has opened takes no entry.
pub(crate) fn held_after_turns(law: &Law, motion: &Motion, gap_m: f64) -> Vec<f64> {
    let mut held = Vec::new();
    for turn_s in motion.turns() {
        // From this turn on the play stays closed.
        let closed = [held.as_slice(), &[f64::INFINITY]].concat();
        let behind = motion.behind_play(gap_m, &closed, &mut Play::default());
        // Unless it turns again before that.
        if let Some(at_s) = released_at(law, &behind, turn_s) {
            held.push((motion.position(at_s) - motion.position(turn_s)).abs());
        }
    }
    held
}

/// The first time after a turn at which the contact has no force, if the motion does not turn again before.
fn released_at(law: &Law, motion: &Motion, turn_s: f64) -> Option<f64> {
    let mut z = 0.0;
    let mut pulled: Option<f64> = None;
    let steps = (motion.duration_s() / STEP_S).ceil() as usize;
    for k in 0..steps {
        let middle_s = (k as f64 + 0.5) * STEP_S;
        let v = motion.speed(middle_s);
        let rate = |z: f64| law.evaluate(z, v, &Surroundings::PLAIN).0;
        z += STEP_S * rate(z + 0.5 * STEP_S * rate(z));
        let force = law.evaluate(z, v, &Surroundings::PLAIN).1;
        match pulled {
            // Before the turn it pulls the way that it goes.
            None if middle_s < turn_s => {}
            None => pulled = Some(-v.signum()),
            Some(sign) if v * sign > 0.0 => return None,
            Some(_) => {}
        }
        if let Some(sign) = pulled
            && force * sign <= 0.0
        {
            return Some(middle_s);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::Deflection;

    /// Bristles of a Dahl law bent to F_c/s0 are straight again after F_c/s0 ln 2: z' = v (1 - s0 z sgn(v)/F_c).
    #[test]
    fn bent_bristles_hold_until_they_are_straight() {
        let (stiffness, coulomb) = (1000.0, 0.5);
        let law = Law::Dahl(Deflection {
            stiffness,
            coulomb,
            breakaway: coulomb,
            damping: 0.0,
            viscous: 0.0,
            stribeck_speed: 1.0,
        });
        let motion = Motion::through(&[
            (0.0, 0.0),
            (0.1, 0.02),
            (1.0, 0.02),
            (1.2, -0.02),
            (2.0, -0.02),
        ]);
        let held = held_after_turns(&law, &motion, 1e-3);
        let expected = coulomb / stiffness * 2.0_f64.ln();
        assert_eq!(held.len(), 1);
        assert!(
            (held[0] / expected - 1.0).abs() < 0.01,
            "{held:?} {expected}"
        );
    }
}
