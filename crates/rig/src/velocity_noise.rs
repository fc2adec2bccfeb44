//! The noise of a recorded velocity.
//!
//! An encoder's noise is in the velocity as recorded and not in the motion: a prediction from it carries the noise by the viscous part of
//! friction and by its starts, and whatever smooths it or moves it in time fits better and is no cause. A velocity with noise is taken along its
//! smooth course with corners (M2, M4), which all runs of one command share. A motion without noise, however bent, is left as recorded: about
//! its course it does not alternate from sample to sample as noise does. So is one whose shaking friction follows (M3), and a stage that stands stands.

use campaign::noise::{of_third_differences, spread};
use campaign::{Campaign, Run};

use crate::commands::Command;
use crate::followed::Followed;
use crate::whittaker::SHORTEST;

/// Noise below this share of the largest speed is none.
const NONE: f64 = 1e-5;
/// Share of neighbours on different sides of the course from which they alternate as noise does (one half, and more beside a course that
/// follows it).
const ALTERNATES: f64 = 0.45;

/// Velocities of all runs along their courses, and the standard deviation of what was taken, m/s; `None` where they have no noise, or what they
/// show is true.
pub(crate) fn without_noise(campaign: &Campaign) -> Option<(Vec<Vec<f64>>, f64)> {
    let speeds = campaign.runs.iter().flat_map(|run| &run.velocity_m_s);
    let least = NONE * speeds.fold(0.0_f64, |a, v| a.max(v.abs()));
    let asked: Vec<&Run> = campaign.runs.iter().filter(|run| is_long(run)).collect();
    let sd_m_s = while_moving(&asked);
    if sd_m_s <= least {
        return None;
    }
    let commands = Command::all(campaign, is_long, sd_m_s);
    let recorded = campaign.runs.iter().map(|run| run.velocity_m_s.clone());
    let mut taken: Vec<Vec<f64>> = recorded.collect();
    for (index, course) in commands.iter().flat_map(Command::along) {
        taken[index] = course;
    }
    let beside: Vec<Vec<f64>> = campaign.runs.iter().zip(&taken).map(moving).collect();
    let sd_m_s = spread(&beside.concat());
    (sd_m_s > least && alternates(&beside) && !is_followed(campaign, &taken))
        .then_some((taken, sd_m_s))
}

fn is_long(run: &Run) -> bool {
    run.velocity_m_s.len() >= SHORTEST
}

/// Standard deviation of the noise of these runs while they move.
fn while_moving(runs: &[&Run]) -> f64 {
    let fours =
        (runs.iter()).flat_map(|run| run.time_s.windows(4).zip(run.velocity_m_s.windows(4)));
    of_third_differences(fours.filter(|(_, v)| v.iter().all(|v| *v != 0.0)))
}

/// What is recorded beside the course while the stage moves.
fn moving((run, z): (&Run, &Vec<f64>)) -> Vec<f64> {
    let both = run.velocity_m_s.iter().zip(z);
    let moving = both.filter(|(v, _)| **v != 0.0);
    moving.map(|(v, z)| v - z).collect()
}

fn alternates(beside: &[Vec<f64>]) -> bool {
    let pairs = || beside.iter().flat_map(|run| run.windows(2));
    let sides = pairs().filter(|r| r[0] * r[1] < 0.0).count();
    sides as f64 >= ALTERNATES * pairs().count() as f64
}

/// Whether friction follows what the velocities show beside their courses.
fn is_followed(campaign: &Campaign, taken: &[Vec<f64>]) -> bool {
    let mut followed = Followed::default();
    for (run, z) in campaign.runs.iter().zip(taken) {
        let shown: Vec<f64> = run.velocity_m_s.iter().zip(z).map(|(v, z)| v - z).collect();
        followed.add(&shown, &run.force_n);
    }
    followed.share() > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load_noise::tests::campaign;
    use crate::whittaker::tests::{miss, noise};

    /// Rest, a smooth start, steady speed, a step, a ramp down, m/s.
    fn motion() -> Vec<f64> {
        let speed = |i: usize| match i {
            0..50 => 0.0,
            50..150 => {
                let s = (i - 50) as f64 / 100.0;
                0.02 * s * s * (3.0 - 2.0 * s)
            }
            150..300 => 0.02,
            300..450 => 0.05,
            _ => 0.05 - 2e-4 * (i - 450) as f64,
        };
        (0..600).map(speed).collect()
    }

    /// Four runs that record these velocities, k the run.
    fn moved(velocity: impl Fn(u64) -> Vec<f64>) -> Campaign {
        let load = |_: usize| vec![5.0; 600];
        let mut campaign = campaign(load, load);
        for (k, run) in (0_u64..).zip(&mut campaign.runs) {
            run.velocity_m_s = velocity(k);
        }
        campaign
    }

    fn recorded(k: u64) -> Vec<f64> {
        let rests = |(v, e): (f64, f64)| if v == 0.0 { 0.0 } else { v + 1e-4 * e };
        motion()
            .into_iter()
            .zip(noise(k + 1, 600))
            .map(rests)
            .collect()
    }

    #[test]
    fn noise_goes_and_corners_stay() {
        let (taken, sd) = without_noise(&moved(recorded)).expect("there is noise");
        assert!((sd / 1e-4 - 1.0).abs() < 0.2, "{sd}");
        for (k, v) in (0_u64..).zip(&taken) {
            assert!(v[..50].iter().all(|v| *v == 0.0), "rest stays rest");
            assert!((v[300] - v[299] - 0.03).abs() < 3e-4, "a step stays a step");
            assert!(miss(v, &motion()) < 0.4 * miss(&recorded(k), &motion()));
        }
    }

    /// Viscous friction of 20 N s/m on a stage that truly shakes by 0.1 mm/s, beside a sensor's noise of 1 mN.
    #[test]
    fn what_friction_follows_stays() {
        let mut campaign = moved(recorded);
        for run in &mut campaign.runs {
            let sensor = noise(7, 600).into_iter().zip(&run.velocity_m_s);
            run.force_n = sensor.map(|(e, v)| 1.5 + 20.0 * v + 1e-3 * e).collect();
        }
        assert!(without_noise(&campaign).is_none());
    }

    #[test]
    fn a_motion_without_noise_is_left_as_recorded() {
        let written = |_| motion().iter().map(|v| (v * 1e7).round() / 1e7).collect();
        assert!(without_noise(&moved(written)).is_none());
        for samples_a_turn in [6.0, 9.3, 24.0, 80.0] {
            let wave = |i: usize| 0.05 * (std::f64::consts::TAU * i as f64 / samples_a_turn).sin();
            let waves = |_| (0..600).map(wave).collect();
            assert!(without_noise(&moved(waves)).is_none(), "{samples_a_turn}");
        }
        assert!(without_noise(&moved(|_| vec![0.0; 600])).is_none());
        assert!(without_noise(&moved(|_| vec![0.01; 8])).is_none());
    }
}
