//! What stands between the force that makes the noise and its record: a filter of the channel, and on a cord a resonance.
//!
//! Both are taken out of a record before it is whitened, z = L2 L1 m with L1 of (N6) and L2 of (N5). The white noise e of the sensor
//! has passed neither; after they are taken out it is coloured,
//!
//! ```text
//! n_i = sum_j c_j e_{i-j} - sum_j m_j n_{i-j}                                                               (N8)
//! ```
//!
//! which the filter along the runs carries as states. At the first sample of a run everything has rested before: n = e.

use std::ops::Range;

use super::lag::Lag;
use super::ring::Ring;

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
    /// Whether the record is the force itself.
    pub(super) fn is_empty(&self) -> bool {
        self.lag.is_empty() && self.rings.is_empty()
    }

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
        if self.is_empty() {
            return out;
        }
        for run in runs {
            let ring = self.rings.iter().find(|(of, _)| of == run);
            let (over, back) = ring.map_or(([1.0, 0.0, 0.0], [0.0; 2]), |(_, r)| r.coefficients());
            let back = [back[0], back[1], 0.0];
            let mut before = 1.0;
            for i in run.clone() {
                let (b, h) = self.lag.noise(i);
                if i == run.start {
                    out.push(Colour {
                        own: 1.0,
                        ..Colour::default()
                    });
                    continue;
                }
                // (over_0 + over_1 B + over_2 B^2)(b + h B)
                let c = [
                    over[0] * b,
                    over[0] * h + over[1] * b,
                    over[1] * h + over[2] * b,
                    over[2] * h,
                ];
                let feed = if i == run.start + 1 {
                    // the first e stands for all before it
                    let rest = |j: usize| (j..MOST_STATES).map(|k| c[k + 1] - back[k]).sum();
                    std::array::from_fn(rest)
                } else {
                    std::array::from_fn(|j| c[j + 1] - back[j] * before)
                };
                before = c[0];
                out.push(Colour {
                    own: c[0],
                    keep: 1.0,
                    feed,
                    back,
                });
            }
        }
        out
    }

    /// log |det| of the map from the record to z.
    pub(super) fn log_det(&self) -> f64 {
        let rings = self.rings.iter().map(|(run, ring)| ring.log_det(run.len()));
        self.lag.log_det() + rings.sum::<f64>()
    }

    /// z from the record.
    pub(super) fn take_out(&self, record: &mut [f64]) {
        self.lag.take_out(record);
        for (run, ring) in &self.rings {
            ring.take_out(&mut record[run.clone()]);
        }
    }

    /// The transposed map.
    pub(super) fn take_out_transposed(&self, record: &mut [f64]) {
        for (run, ring) in &self.rings {
            ring.take_out_transposed(&mut record[run.clone()]);
        }
        self.lag.take_out_transposed(record);
    }
}
