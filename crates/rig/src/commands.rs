//! Runs of one command.
//!
//! A stage that is told the same goes the same way, forward or in reverse, and what an encoder records of it differs by the encoder's noise
//! alone. Runs of one command have one motion: the mean of M of them has 1/M of the noise's variance, and what a prediction makes of what is
//! left of it is the same in all of them.

use campaign::{Campaign, InitialState, Run};

use crate::whittaker::{Course, HELD, cornered, likeliest};

/// Standard deviations of a difference of two records at one sample, of its sum of squares, and of that of its sums over blocks, within which it is
/// noise.
const NOISE: f64 = 5.0;
/// Samples of a block: what two motions differ by lasts longer.
const BLOCK: usize = 8;
/// Standard deviations of its mean within which the first sample of a run with relaxed bristles is at rest.
const AT_REST: f64 = 4.0;
/// Share of the time between samples within which two runs are sampled at the same times.
const SAME_TIME: f64 = 1e-6;

/// Runs whose stage was told the same.
pub(crate) struct Command<'a> {
    /// Index in the campaign, the run, and the sign that turns its velocities into those of the first one.
    runs: Vec<(usize, &'a Run, f64)>,
    /// Standard deviation of the noise of each record.
    sd_m_s: f64,
}

impl<'a> Command<'a> {
    /// The commands of these runs of a campaign whose velocities have noise of this standard deviation.
    pub(crate) fn all(
        campaign: &'a Campaign,
        asked: impl Fn(&Run) -> bool,
        sd_m_s: f64,
    ) -> Vec<Self> {
        let mut commands: Vec<Self> = Vec::new();
        for (index, run) in campaign.runs.iter().enumerate().filter(|(_, r)| asked(r)) {
            let told = commands.iter_mut().find_map(|command| {
                let sign = command.sign_of(run)?;
                Some((command, sign))
            });
            match told {
                Some((command, sign)) => command.runs.push((index, run, sign)),
                None => commands.push(Self {
                    runs: vec![(index, run, 1.0)],
                    sd_m_s,
                }),
            }
        }
        commands
    }

    /// The sign under which another run records the motion of the first one; `None` where it goes another way.
    fn sign_of(&self, other: &Run) -> Option<f64> {
        let first = self.runs[0].1;
        let goes = |sign: f64| same_motion(first, other, sign, self.sd_m_s);
        (same_times(first, other)).then(|| [1.0, -1.0].into_iter().find(|&sign| goes(sign)))?
    }

    /// The mean of all records.
    fn mean_m_s(&self) -> Vec<f64> {
        let count = self.runs.len() as f64;
        let mut mean = vec![0.0; self.runs[0].1.velocity_m_s.len()];
        for (_, run, sign) in &self.runs {
            for (mean, v) in mean.iter_mut().zip(&run.velocity_m_s) {
                *mean += sign * v / count;
            }
        }
        mean
    }

    /// Where the stage stands: exact zeros, and the first sample of runs from rest.
    fn stands(&self, mean_m_s: &[f64]) -> Vec<bool> {
        let first = self.runs[0].1;
        let within = AT_REST * self.sd_m_s / (self.runs.len() as f64).sqrt();
        let from_rest =
            |(_, run, _): &(usize, &Run, f64)| run.initial_state == InitialState::Relaxed;
        let mut stands: Vec<bool> = first.velocity_m_s.iter().map(|v| *v == 0.0).collect();
        stands[0] |= mean_m_s[0].abs() <= within && self.runs.iter().all(from_rest);
        stands
    }

    /// The velocity along the one course of all records, by the index of each run.
    pub(crate) fn along(&self) -> impl Iterator<Item = (usize, Vec<f64>)> {
        let z = self.course_m_s();
        let told = |z: &[f64], sign: f64| z.iter().map(|z| sign * z).collect();
        self.runs
            .iter()
            .map(move |(index, _, sign)| (*index, told(&z, *sign)))
    }

    /// The course of the mean, which weighs as much as it has records; zero where the stage stands.
    fn course_m_s(&self) -> Vec<f64> {
        let mut mean = self.mean_m_s();
        let stands = self.stands(&mean);
        let count = self.runs.len() as f64;
        let mut weights = vec![count; mean.len()];
        for i in (0..mean.len()).filter(|&i| stands[i]) {
            (mean[i], weights[i]) = (0.0, HELD);
        }
        let course = |lambda: f64| cornered(&mean, &weights, lambda);
        let lambda = likeliest(|lambda| self.left_of(&course(lambda), &stands));
        let mut z = course(lambda).z;
        for i in (0..z.len()).filter(|&i| stands[i]) {
            z[i] = 0.0;
        }
        z
    }

    /// What the records leave beside a course while they move: sum of squares and degrees of freedom. Rest counts once, and is taken once.
    fn left_of(&self, course: &Course, stands: &[bool]) -> (f64, f64) {
        let of_runs = self.runs.iter().map(|(_, run, sign)| {
            let both = run.velocity_m_s.iter().zip(&course.z).zip(stands);
            let moving = both.filter(|(_, stands)| !**stands);
            moving
                .map(|((v, z), _)| (sign * v - z).powi(2))
                .sum::<f64>()
        });
        let standing = stands.iter().filter(|stands| **stands).count();
        let samples = self.runs.len() * (stands.len() - standing) + standing;
        (of_runs.sum(), samples as f64 - course.taken)
    }
}

/// Whether two runs are sampled at the same times after their first sample.
fn same_times(one: &Run, other: &Run) -> bool {
    let (first, second) = (one.time_s[0], other.time_s[0]);
    let allowed = SAME_TIME * (one.time_s[1] - first);
    let same = |(a, b): (&f64, &f64)| ((a - first) - (b - second)).abs() <= allowed;
    one.time_s.len() == other.time_s.len() && one.time_s.iter().zip(&other.time_s).all(same)
}

/// Whether `sign` times the velocity of `other` differs from that of `one` by white noise of both records at most, and both stand together.
fn same_motion(one: &Run, other: &Run, sign: f64, sd_m_s: f64) -> bool {
    let sd = sd_m_s * 2.0_f64.sqrt();
    let pairs = || one.velocity_m_s.iter().zip(&other.velocity_m_s);
    let near =
        |(a, b): (&f64, &f64)| (*a == 0.0) == (*b == 0.0) && (a - sign * b).abs() <= NOISE * sd;
    if !pairs().all(near) {
        return false;
    }
    let moving = pairs().filter(|(a, _)| **a != 0.0);
    let apart: Vec<f64> = moving.map(|(a, b)| (a - sign * b) / sd).collect();
    let blocks: Vec<f64> = (apart.chunks_exact(BLOCK))
        .map(|block| block.iter().sum::<f64>() / (BLOCK as f64).sqrt())
        .collect();
    is_chance(&apart) && is_chance(&blocks)
}

/// Whether the sum of squares of these numbers is one that unit noise may have.
fn is_chance(numbers: &[f64]) -> bool {
    let count = numbers.len() as f64;
    numbers.iter().map(|d| d * d).sum::<f64>() <= count + NOISE * (2.0 * count).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load_noise::tests::campaign;
    use crate::whittaker::tests::{miss, noise};

    const SD_M_S: f64 = 1e-4;

    /// A stage that starts after fifty samples and then goes at 50 mm/s beside a swing of this amplitude.
    fn motion(swing_m_s: f64) -> Vec<f64> {
        let steady = |i: usize| 0.05 + swing_m_s * (i as f64 / 20.0).sin();
        (0..600)
            .map(|i| if i < 50 { 0.0 } else { steady(i) })
            .collect()
    }

    /// Four runs of this motion times a sign each, with noise of their own.
    fn recorded(sign: [f64; 4], swing_m_s: [f64; 4]) -> Campaign {
        let load = |_: usize| vec![5.0; 600];
        let mut campaign = campaign(load, load);
        for (k, run) in campaign.runs.iter_mut().enumerate() {
            let both = motion(swing_m_s[k]).into_iter().zip(noise(k as u64, 600));
            let read = |(v, e): (f64, f64)| if v == 0.0 { 0.0 } else { v + SD_M_S * e };
            run.velocity_m_s = both.map(|both| sign[k] * read(both)).collect();
        }
        campaign
    }

    fn commands(campaign: &Campaign) -> Vec<Command<'_>> {
        Command::all(campaign, |_| true, SD_M_S)
    }

    #[test]
    fn runs_of_one_command_share_their_course_in_either_direction() {
        let campaign = recorded([1.0, -1.0, 1.0, -1.0], [0.0; 4]);
        let of_all = commands(&campaign);
        assert_eq!(of_all.len(), 1);
        let along: Vec<(usize, Vec<f64>)> = of_all[0].along().collect();
        assert_eq!(along[0].1, along[2].1);
        assert!(along[0].1.iter().zip(&along[1].1).all(|(a, b)| *a == -*b));
        let alone = Command {
            runs: vec![(0, &campaign.runs[0], 1.0)],
            sd_m_s: SD_M_S,
        };
        let missed = |command: &Command<'_>| miss(&command.course_m_s(), &motion(0.0));
        assert!(missed(&of_all[0]) < 0.7 * missed(&alone));
    }

    /// What one run does beside the others is no noise, however slow: a swing that reaches one standard deviation of the noise is seen.
    #[test]
    fn runs_that_go_another_way_keep_their_own() {
        let swings = recorded([1.0; 4], [0.0, 0.0, SD_M_S, SD_M_S]);
        let told = |campaign: &Campaign| -> Vec<usize> {
            let of_all = commands(campaign);
            of_all.iter().map(|command| command.runs.len()).collect()
        };
        assert_eq!(told(&swings), [2, 2]);
        let mut late = recorded([1.0; 4], [0.0; 4]);
        for t in &mut late.runs[3].time_s {
            *t *= 1.01;
        }
        late.runs[1].velocity_m_s[50] = 0.0;
        assert_eq!(told(&late), [2, 1, 1]);
    }
}
