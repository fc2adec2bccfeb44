//! What stands between the force that makes the noise and its record: a filter of the channel, and on a cord a resonance.
//!
//! Both are taken out of a record before it is whitened, z = L2 L1 m with L1 of (N6) and L2 of (N5). The white noise e of the sensor
//! has passed neither; after they are taken out it is coloured,
//!
//! ```text
//! n_i = sum_j c_j e_{i-j} - sum_j m_j n_{i-j}                                                               (N8)
//! ```
//!
//! which the filter along the runs carries as states. At the first sample of a run everything has rested before.

use std::ops::Range;

use super::lag::{self, Lag, UndoneLag};
use super::ring::{Coefficients, Ring};

/// The way from the force to the record, of all runs.
#[derive(Clone, Debug, Default)]
pub struct Channel {
    /// The filter of the force channel.
    pub lag: Lag,
    /// The resonance through which each run's roughness reaches the record, with the run's samples; empty where there is none.
    pub rings: Vec<(Range<usize>, Ring)>,
}

/// States of coloured noise: those that a resonance behind a filter needs.
pub(super) const MOST_STATES: usize = 3;

/// The recursion of (N8) from one sample to the next: s_j = keep s_{j+1} - m_j s_1 + feed_j e, then n = s_1 + own e.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Colour {
    /// c_0.
    pub(super) own: f64,
    /// Zero at the first sample of a run, else one.
    pub(super) keep: f64,
    /// What the last sample's e adds to each state.
    pub(super) feed: [f64; MOST_STATES],
    /// m_j.
    pub(super) back: [f64; MOST_STATES],
}

impl Channel {
    /// The channel as it is undone where samples lie at these distances slid and the roughness has this length.
    pub(super) fn undone(&self, sliding: &[f64], length: f64) -> Undone {
        let rings = self.rings.iter().map(|(run, ring)| {
            let further = |i: usize| (sliding[i] - sliding[i.max(run.start + 1) - 1]) / length;
            let second = (run.start + 1).min(run.end - 1);
            UndoneRing {
                poles: ring.poles(),
                // what was before the first sample, the second says best
                at: (run.clone().map(|i| ring.at(further(i.max(second))))).collect(),
                run: run.clone(),
            }
        });
        Undone {
            rings: rings.collect(),
            lag: self.lag.undone(sliding, length),
        }
    }
}

/// A channel as it is undone, sample by sample.
#[derive(Clone, Debug, Default)]
pub(super) struct Undone {
    /// The filter; empty where there is none.
    lag: Vec<UndoneLag>,
    rings: Vec<UndoneRing>,
}

/// The resonance of one run as it is undone.
#[derive(Clone, Debug)]
struct UndoneRing {
    run: Range<usize>,
    /// D without its leading one.
    poles: [f64; 2],
    /// L at each sample of the run.
    at: Vec<Coefficients>,
}

impl UndoneRing {
    /// z over y at rest, before the run.
    fn at_rest(&self) -> f64 {
        let Coefficients { lead, zeros } = self.at[0];
        lead * (1.0 + self.poles[0] + self.poles[1]) / (1.0 + zeros[0] + zeros[1])
    }

    /// z_i = lead y_i + s_1,  s_1 = lead d_1 y_{i-1} - m_1 z_{i-1} + s_2,  s_2 = lead d_2 y_{i-1} - m_2 z_{i-1}.
    fn take_out(&self, run: &mut [f64]) {
        let Some(first) = run.first_mut() else { return };
        let (mut y, mut z) = (*first, self.at_rest() * *first);
        *first = z;
        let mut second = self.second(0, y, z);
        for (i, x) in run.iter_mut().enumerate().skip(1) {
            let Coefficients { lead, zeros } = self.at[i];
            let state = lead * self.poles[0] * y - zeros[0] * z + second;
            second = self.second(i, y, z);
            y = *x;
            z = lead * y + state;
            *x = z;
        }
    }

    /// s_2 at a sample, from the one before.
    fn second(&self, i: usize, y: f64, z: f64) -> f64 {
        self.at[i].lead * self.poles[1] * y - self.at[i].zeros[1] * z
    }

    /// The transposed map: the same recursion backwards on the adjoints.
    fn take_out_transposed(&self, run: &mut [f64]) {
        // adjoints of the states that sample i + 1 leaves, and of s_2 that sample i left
        let (mut of_y, mut of_z, mut second) = (0.0, 0.0, 0.0);
        for i in (1..run.len()).rev() {
            let Coefficients { lead, zeros } = self.at[i];
            let z = run[i] + of_z;
            let y = of_y + lead * z;
            run[i] = y;
            let state = z;
            of_y = lead * self.poles[0] * state + lead * self.poles[1] * second;
            of_z = -zeros[0] * state - zeros[1] * second;
            second = state;
        }
        let at_rest = self.at_rest();
        if let Some(first) = run.first_mut() {
            let Coefficients { lead, zeros } = self.at[0];
            of_y += lead * self.poles[1] * second;
            of_z -= zeros[1] * second;
            *first = of_y + at_rest * (*first + of_z);
        }
    }

    /// log |det L|.
    fn log_det(&self) -> f64 {
        let later: f64 = self.at.iter().skip(1).map(|of| of.lead.ln()).sum();
        self.at_rest().ln() + later
    }
}

impl Undone {
    /// States that the white noise needs once the channel is taken out.
    pub(super) fn states(&self) -> usize {
        if !self.rings.is_empty() {
            MOST_STATES
        } else {
            usize::from(!self.lag.is_empty())
        }
    }

    /// The colour of the white noise, sample by sample; empty where it stays white.
    pub(super) fn colours(&self, runs: &[Range<usize>]) -> Vec<Colour> {
        let mut out = Vec::new();
        if self.states() == 0 {
            return out;
        }
        for run in runs {
            let ring = self.rings.iter().find(|ring| ring.run == *run);
            let filter = |i: usize| self.lag.get(i).copied().unwrap_or(UndoneLag::NONE);
            let mut before = ring.map_or(1.0, UndoneRing::at_rest) * filter(run.start).lead;
            for i in run.clone() {
                if i == run.start {
                    out.push(Colour {
                        own: before,
                        ..Colour::default()
                    });
                    continue;
                }
                let (over, under) = ring.map_or(([1.0, 0.0, 0.0], [0.0; 2]), |ring| {
                    let Coefficients { lead, zeros } = ring.at[i - run.start];
                    let [first, second] = ring.poles;
                    ([lead, lead * first, lead * second], zeros)
                });
                let UndoneLag { lead, fade, zero } = filter(i);
                // (1 + under_0 B + under_1 B^2)(1 + zero B) and (over_0 + over_1 B + over_2 B^2)(b + h B)
                let back = [under[0] + zero, under[1] + under[0] * zero, under[1] * zero];
                let (b, h) = (lead, -lead * fade);
                let c = [
                    over[0] * b,
                    over[0] * h + over[1] * b,
                    over[1] * h + over[2] * b,
                    over[2] * h,
                ];
                let fed = |j: usize| c[j + 1] - back[j] * before;
                // the first e stands for all before it
                let last = if i == run.start + 1 { MOST_STATES } else { 0 };
                let feed = |j: usize| (j..last.max(j + 1)).map(fed).sum();
                out.push(Colour {
                    own: c[0],
                    keep: 1.0,
                    feed: std::array::from_fn(feed),
                    back,
                });
                before = c[0];
            }
        }
        out
    }

    /// log |det| of the map from the record to z.
    pub(super) fn log_det(&self) -> f64 {
        lag::log_det(&self.lag) + self.rings.iter().map(UndoneRing::log_det).sum::<f64>()
    }

    /// z from the record.
    pub(super) fn take_out(&self, record: &mut [f64]) {
        lag::take_out(&self.lag, record);
        for ring in &self.rings {
            ring.take_out(&mut record[ring.run.clone()]);
        }
    }

    /// The transposed map.
    pub(super) fn take_out_transposed(&self, record: &mut [f64]) {
        for ring in &self.rings {
            ring.take_out_transposed(&mut record[ring.run.clone()]);
        }
        lag::take_out_transposed(&self.lag, record);
    }
}
