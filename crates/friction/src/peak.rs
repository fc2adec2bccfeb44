//! Steps that meet the peak of the Stribeck curve.
//!
//! A step's three stages could all lie where the curve is flat or nothing moves, and neither the state nor the error estimate would know
//! that there is a peak between them.

use crate::Law;

/// The Stribeck curve is flat, as far as stages can see, from so many of its speed scales on: exp(-16) for p = 2.
const BEYOND: f64 = 4.0;
/// Speed scales that a step may go over below these: at rest the state does not change whatever the curve says, so that of a step to a stop
/// the second stage, some third of the way before its end, is the last one to meet the peak.
const MET: f64 = 2.0;

impl Law<f64> {
    /// The share, up to 1, of a step on which the speed goes in a straight line from `from` to `to` (m/s; of any sign) that no peak of the
    /// curve escapes: from above the curve's speeds a step ends where they begin, among them it goes over a few scales only.
    #[inline]
    pub fn share_to_the_peak(&self, z: f64, from: f64, to: f64) -> f64 {
        let Some(scale) = self.curve.speed else {
            return 1.0;
        };
        // no lean gears higher than the height alone
        if (to - from).abs() * self.highest_gear() <= MET * scale {
            return 1.0;
        }
        let gear = self.gear(z) / scale;
        let change = (to - from).abs() * gear;
        let above = from.abs() * gear - BEYOND;
        let rises = (to - from) * from >= 0.0;
        let most = match rises {
            true if above >= 0.0 => return 1.0,
            true => MET,
            false => above.max(MET),
        };
        (most / change).min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use crate::LawKind;

    #[test]
    fn a_step_ends_where_the_curve_begins_and_goes_over_few_scales_of_it() {
        let law = LawKind::Lugre
            .build(&[0.1, 0.2, 0.01, 300.0, 0.3, 0.1], None)
            .expect("a law");
        let share = |from: f64, to: f64| law.share_to_the_peak(0.0, 0.01 * from, 0.01 * to);
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        // In units of the curve's speed: down to 4, from there by 2, over zero too; up by 2 as long as below 4.
        close(share(10.0, 0.0), 0.6);
        close(share(-10.0, 10.0), 0.3);
        close(share(4.0, 0.0), 0.5);
        close(share(1.0, -7.0), 0.25);
        close(share(0.0, 8.0), 0.25);
        close(share(5.0, 50.0), 1.0);
        close(share(1.0, -1.0), 1.0);
    }
}
