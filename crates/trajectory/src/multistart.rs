//! Many starts, and the minima they end in, named.
//!
//! Starts run in parallel but are collected in their order, and minima are
//! sorted out one after the other, so the answer does not depend on the number
//! of threads. Two certified points are the same minimum when their scaled
//! trajectories are closer than a tolerance; equal costs prove nothing.

use crate::{Options, Programme, ProgrammeError, Solution, Start, solve};
use rayon::prelude::*;

/// A minimum and the starts that found it.
#[derive(Clone, Debug, PartialEq)]
pub struct Minimum {
    /// A, B, C … by rising cost.
    pub name: String,
    /// The solution of the first start that found it.
    pub solution: Solution,
    /// Places of the starts that found it.
    pub starts: Vec<usize>,
}

/// The outcome of many starts.
#[derive(Clone, Debug, PartialEq)]
pub struct MultiStart {
    /// Certified minima by rising cost; each certificate carries its count of starts.
    pub minima: Vec<Minimum>,
    /// How every start ended, in the order of the starts.
    pub solutions: Vec<Solution>,
}

impl MultiStart {
    /// The best certified minimum.
    pub fn best(&self) -> Option<&Minimum> {
        self.minima.first()
    }
}

/// Largest distance of two points in units of the variables' scales.
pub fn scaled_distance<P: Programme>(programme: &P, a: &[f64], b: &[f64]) -> f64 {
    let variables = programme.variables();
    let terms = a
        .iter()
        .zip(b)
        .zip(&variables)
        .map(|((a, b), v)| ((a - b) / v.scale).abs());
    terms.fold(0.0, f64::max)
}

/// Solves from every start and sorts the certified points into minima.
///
/// `same` is the scaled distance within which two points are one minimum.
///
/// **Errors**: as [`solve`], from the first start that is refused.
pub fn multistart<P: Programme>(
    programme: &P,
    starts: &[Start],
    options: &Options,
    same: f64,
) -> Result<MultiStart, ProgrammeError> {
    let solutions: Vec<Solution> = starts
        .par_iter()
        .map(|start| solve(programme, start, options))
        .collect::<Result<_, _>>()?;
    Ok(sort_into_minima(programme, solutions, same))
}

/// Sorts solutions, one per start, into named minima.
pub fn sort_into_minima<P: Programme>(
    programme: &P,
    solutions: Vec<Solution>,
    same: f64,
) -> MultiStart {
    let mut minima: Vec<Minimum> = Vec::new();
    for (k, solution) in solutions
        .iter()
        .enumerate()
        .filter(|(_, s)| s.status.is_solved())
    {
        match minima
            .iter_mut()
            .find(|m| scaled_distance(programme, &m.solution.x, &solution.x) <= same)
        {
            Some(minimum) => minimum.starts.push(k),
            None => {
                minima.push(Minimum {
                    name: String::new(),
                    solution: solution.clone(),
                    starts: vec![k],
                });
            }
        }
    }
    minima.sort_by(|a, b| {
        a.solution
            .cost
            .total_cmp(&b.solution.cost)
            .then(a.starts.cmp(&b.starts))
    });
    for (place, minimum) in minima.iter_mut().enumerate() {
        minimum.name = name(place);
        minimum.solution.certificate.starts = Some((minimum.starts.len(), solutions.len()));
    }
    MultiStart { minima, solutions }
}

/// A, B, … Z, A1, B1, …
fn name(place: usize) -> String {
    let letter = char::from(b'A' + (place % 26) as u8);
    if place < 26 {
        letter.to_string()
    } else {
        format!("{letter}{}", place / 26)
    }
}
