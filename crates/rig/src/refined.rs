//! A run on a finer grid than it was recorded on: where the true speed ripples faster than the samples follow, the contact
//! must be carried through the ripple and not along chords from sample to sample.

use friction::Scalar;

use crate::RunMotion;
use crate::bends::bend;
use crate::signal::slope;

/// `parts` equal steps from each value to the next, linear between them; the last value ends the series.
pub(crate) fn between<D: Scalar>(series: &[D], parts: usize) -> Vec<D> {
    let mut fine = Vec::with_capacity((series.len().max(1) - 1) * parts + 1);
    for pair in series.windows(2) {
        let steps = (0..parts).map(|k| pair[0] + (pair[1] - pair[0]) * k as f64 / parts as f64);
        fine.extend(steps);
    }
    fine.extend(series.last());
    fine
}

impl RunMotion {
    /// Longest way between two samples, m.
    pub fn widest_step_m(&self) -> f64 {
        let ways = self.time_s.windows(2).zip(self.velocity_m_s.windows(2));
        ways.map(|(t, v)| (t[1] - t[0]) * v[0].abs().max(v[1].abs()))
            .fold(0.0, f64::max)
    }

    /// The same motion with each interval cut into `parts`: sample `i` stands at `parts * i`. Recorded series are linear in
    /// between, as everywhere in the chain, the velocity where it does not bend (M1).
    pub(crate) fn refined(&self, parts: usize) -> Self {
        let fine = |series: &[f64]| between(series, parts);
        let time_s = fine(&self.time_s);
        let mut velocity_m_s = fine(&self.velocity_m_s);
        bend(&mut velocity_m_s, &time_s, &self.bends_m_s3, parts);
        let every_sample: Vec<usize> = (0..time_s.len()).collect();
        Self {
            acceleration_m_s2: slope(&time_s, &velocity_m_s),
            position_m: fine(&self.position_m),
            distance_m: fine(&self.distance_m),
            load_n: fine(&self.load_n),
            temperature_c: self.temperature_c.as_deref().map(fine),
            steps_a_sample: parts,
            bends_m_s3: Vec::new(),
            halved: None,
            knots: every_sample.clone(),
            every_sample,
            time_s,
            velocity_m_s,
            ..self.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::between;

    #[test]
    fn the_recorded_values_stand_at_every_so_many_steps() {
        assert_eq!(between(&[0.0, 2.0, 1.0], 2), [0.0, 1.0, 2.0, 1.5, 1.0]);
        assert_eq!(between(&[3.0], 4), [3.0]);
    }
}
