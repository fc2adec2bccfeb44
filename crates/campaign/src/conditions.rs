//! Repeats: runs of one condition, told by what was done and never by a number that somebody wrote beside them.
//!
//! Two runs repeat each other where direction, protocol, load and orientation of the rig are equal and the commanded
//! velocities agree within 1 % of their maximum at equal times. Sample times need not coincide and rows may be missing,
//! so one record is compared with the range that the other one covers around the same time.

use crate::record::{Campaign, Run};

/// Commanded velocities within this share of their maximum are equal (contract).
const VELOCITY_SHARE: f64 = 0.01;
/// Nominal loads within this share are equal: they are written as decimals.
const LOAD_SHARE: f64 = 1e-6;
/// Two runs overlap for at least this share of the longer one: missing rows at an end are no other protocol.
const LEAST_OVERLAP: f64 = 0.9;

impl Campaign {
    /// Conditions of the campaign: for each, the indices of its runs (its repeats), in canonical order.
    #[must_use]
    pub fn conditions(&self) -> Vec<Vec<usize>> {
        let mut conditions: Vec<Vec<usize>> = Vec::new();
        for (index, run) in self.runs.iter().enumerate() {
            match conditions
                .iter_mut()
                .find(|known| repeats(&self.runs[known[0]], run))
            {
                Some(condition) => condition.push(index),
                None => conditions.push(vec![index]),
            }
        }
        conditions
    }
}

/// Whether two runs are repeats of one condition.
fn repeats(one: &Run, other: &Run) -> bool {
    one.direction == other.direction
        && one.protocol == other.protocol
        && one.stage_turned == other.stage_turned
        && one.specimen_turned == other.specimen_turned
        && equal_load(one, other)
        && equal_velocity(one, other)
}

fn equal_load(one: &Run, other: &Run) -> bool {
    match (one.normal_load_n, other.normal_load_n) {
        (Some(a), Some(b)) => (a - b).abs() <= LOAD_SHARE * a.abs().max(b.abs()),
        (None, None) => true,
        _ => false,
    }
}

/// Commanded velocities on the runs' own clocks, or on clocks that start with the first sample.
fn equal_velocity(one: &Run, other: &Run) -> bool {
    let shift = other.time_s[0] - one.time_s[0];
    agrees(one, other, 0.0) || (shift != 0.0 && agrees(one, other, shift))
}

/// Whether the velocities agree where `other` runs `shift` seconds late.
fn agrees(one: &Run, other: &Run, shift: f64) -> bool {
    let span = |run: &Run| (run.time_s[0], run.time_s[run.time_s.len() - 1]);
    let ((start, end), (other_start, other_end)) = (span(one), span(other));
    let overlap = end.min(other_end - shift) - start.max(other_start - shift);
    let longer = (end - start).max(other_end - other_start);
    if overlap < LEAST_OVERLAP * longer {
        return false;
    }
    let fastest = |run: &Run| {
        run.velocity_m_s
            .iter()
            .fold(0.0_f64, |v, next| v.max(next.abs()))
    };
    let allowed = VELOCITY_SHARE * fastest(one).max(fastest(other));
    within(one, other, shift, allowed) && within(other, one, -shift, allowed)
}

/// Whether every sample of `one` lies within `allowed` of the range that `other` covers around the same time: between
/// the samples before and after it, and one further on either side, since a step may fall between two samples.
fn within(one: &Run, other: &Run, shift: f64, allowed: f64) -> bool {
    let last = other.time_s.len() - 1;
    let mut after = 0;
    one.time_s
        .iter()
        .zip(&one.velocity_m_s)
        .all(|(time, velocity)| {
            let time = time + shift;
            while after <= last && other.time_s[after] < time {
                after += 1;
            }
            if time < other.time_s[0] || time > other.time_s[last] {
                return true;
            }
            let around = &other.velocity_m_s[after.saturating_sub(2)..=(after + 1).min(last)];
            let low = around.iter().copied().fold(f64::INFINITY, f64::min);
            let high = around.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            low - allowed <= *velocity && *velocity <= high + allowed
        })
}
