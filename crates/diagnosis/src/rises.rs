//! How force rises after reversals: a sentence for a reader whose record no cause explains.
//!
//! After a reversal force runs from the level of one direction to that of the other. What slides on bristles bends ever more slowly
//! towards its level (an exponential of the distance, whose last part takes four and more times as long as its first); a spring in
//! series with dry friction pulls along a straight line and ends at a corner. With s_p the distance slid since the reversal at which the
//! share p of the swing is reached,
//!
//! ```text
//! straightness = (s_0.3 - s_0.1) / (s_0.9 - s_0.7)      (a straight line 1, an exponential 0.23)
//! stiffness    = 0.4 swing / (s_0.7 - s_0.3)             N/m (rotary: N m/rad)
//! ```

use campaign::Axis;
use rig::RunMotion;

use crate::whole::Whole;

/// Speeds below this share of a run's largest have no direction.
const STANDING: f64 = 0.05;
/// Samples of a way between reversals, at least, and ways that say something.
const SAMPLES: usize = 10;
const WAYS: usize = 4;
/// A rise is straight from this straightness on, and if it is so many times that of the law's own prediction.
const STRAIGHT: f64 = 0.6;
const STRAIGHTER: f64 = 1.3;

/// One way from a reversal to the next.
struct Rise {
    straightness: f64,
    stiffness: f64,
}

/// What the rises of the record show that those of the law do not, in words; `None` where they are no straighter.
pub(crate) fn straighter_than_the_law(whole: &Whole<'_>) -> Option<String> {
    let experiment = &whole.bench.experiment;
    let all = |force: &[f64]| -> Vec<Rise> {
        let runs = experiment.runs.iter();
        runs.flat_map(|run| rises(run, &force[run.samples.clone()]))
            .collect()
    };
    let recorded = all(&experiment.measured_n);
    let of_the_law = all(&whole.law.prediction);
    let straightness = quartiles(recorded.iter().map(|r| r.straightness))?[1];
    let predicted = quartiles(of_the_law.iter().map(|r| r.straightness)).map_or(0.0, |q| q[1]);
    if recorded.len() < WAYS || straightness < STRAIGHT.max(STRAIGHTER * predicted) {
        return None;
    }
    let [low, middle, high] = quartiles(recorded.iter().map(|r| r.stiffness))?;
    let unit = match experiment.axis {
        Axis::Linear => "N/m",
        Axis::Rotary => "N m/rad",
    };
    Some(format!(
        "after {} reversals force rises along a straight line of {middle:.3e} {unit} (half of them within {low:.3e} and {high:.3e}) and ends at a corner, \
         as with a spring in series with dry friction: the last fifth of a rise takes {:.1} times as long as the first, with the law {:.1} times",
        recorded.len(),
        1.0 / straightness,
        1.0 / predicted.max(1e-3)
    ))
}

/// The rises of one run.
fn rises(run: &RunMotion, force: &[f64]) -> Vec<Rise> {
    let ways = ways(&run.velocity_m_s);
    // Before the first reversal nobody knows from where force comes.
    let between = ways.iter().skip(1);
    between
        .filter(|way| way.samples.len() >= SAMPLES)
        .filter_map(|way| {
            let slid = &run.distance_m[way.samples.clone()];
            let slid: Vec<f64> = slid.iter().map(|s| s - slid[0]).collect();
            let along = force[way.samples.clone()].iter().map(|f| way.sign * f);
            rise(&slid, &along.collect::<Vec<_>>())
        })
        .collect()
}

/// Samples that are slid in one direction.
struct Way {
    samples: std::ops::Range<usize>,
    sign: f64,
}

/// The ways of a run from its first motion on; a stand belongs to the way before it.
fn ways(velocity: &[f64]) -> Vec<Way> {
    let standing = STANDING * velocity.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let mut ways: Vec<Way> = Vec::new();
    for (i, v) in velocity.iter().enumerate() {
        let moves = v.abs() > standing;
        match ways.last_mut() {
            Some(way) if !moves || way.sign == v.signum() => way.samples.end = i + 1,
            _ if moves => ways.push(Way {
                samples: i..i + 1,
                sign: v.signum(),
            }),
            _ => {}
        }
    }
    ways
}

/// The rise of a force in the direction of sliding, from what it is at the reversal to its level over the second half of the way.
fn rise(slid: &[f64], force: &[f64]) -> Option<Rise> {
    let whole = *slid.last()?;
    let late = slid.iter().zip(force).filter(|(s, _)| **s > 0.5 * whole);
    let level = quartiles(late.map(|(_, f)| *f))?[1];
    let start = force[0];
    let swing = level - start;
    // Force that does not come from the other side has not turned.
    if !(start < -0.3 * level) {
        return None;
    }
    let at = |share: f64| -> Option<f64> {
        let goal = start + share * swing;
        let k = force.iter().position(|f| *f >= goal).filter(|k| *k > 0)?;
        let part = (goal - force[k - 1]) / (force[k] - force[k - 1]);
        Some(slid[k - 1] + part * (slid[k] - slid[k - 1]))
    };
    let (first, middle, last) = (
        at(0.3)? - at(0.1)?,
        at(0.7)? - at(0.3)?,
        at(0.9)? - at(0.7)?,
    );
    (first > 0.0 && middle > 0.0 && last > 0.0).then(|| Rise {
        straightness: first / last,
        stiffness: 0.4 * swing / middle,
    })
}

/// Quartiles of a series; `None` of an empty one.
fn quartiles(values: impl Iterator<Item = f64>) -> Option<[f64; 3]> {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    let at = |quarter: usize| sorted.get(quarter * sorted.len() / 4).copied();
    Some([at(1)?, at(2)?, at(3)?])
}

#[cfg(test)]
mod tests {
    use super::{rise, ways};

    const WAY: usize = 200;

    fn slid() -> Vec<f64> {
        (0..WAY).map(|i| 1e-3 * i as f64 / WAY as f64).collect()
    }

    #[test]
    fn a_spring_in_series_is_straight_and_has_its_stiffness() {
        let force: Vec<f64> = slid()
            .iter()
            .map(|s| (4e4 * s - 2.0_f64).min(2.0))
            .collect();
        let found = rise(&slid(), &force).expect("a rise");
        assert!(
            (found.straightness - 1.0).abs() < 1e-6,
            "{}",
            found.straightness
        );
        assert!((found.stiffness - 4e4).abs() < 1.0, "{}", found.stiffness);
    }

    /// F = 2 - 4 exp(-s/d): ln(9/7) / ln 3.
    #[test]
    fn bristles_bend_ever_more_slowly() {
        let force: Vec<f64> = slid()
            .iter()
            .map(|s| 2.0 - 4.0 * (-s / 5e-5).exp())
            .collect();
        let found = rise(&slid(), &force).expect("a rise");
        let expected = (9.0_f64 / 7.0).ln() / 3.0_f64.ln();
        assert!(
            (found.straightness - expected).abs() < 0.02,
            "{}",
            found.straightness
        );
    }

    #[test]
    fn force_that_does_not_turn_does_not_rise() {
        let force: Vec<f64> = slid().iter().map(|s| 1.0 + 1e3 * s).collect();
        assert!(rise(&slid(), &force).is_none());
    }

    #[test]
    fn a_stand_belongs_to_the_way_before_it() {
        let velocity = [0.0, 1.0, 1.0, 0.0, 0.0, -1.0, -1.0, 0.01, 1.0];
        let found: Vec<_> = ways(&velocity)
            .iter()
            .map(|w| (w.samples.clone(), w.sign))
            .collect();
        assert_eq!(found, [(1..5, 1.0), (5..8, -1.0), (8..9, 1.0)]);
    }
}
