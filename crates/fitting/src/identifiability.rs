//! What the data determine at all.
//!
//! The sensitivities S = J diag(scale) say by how many standard deviations of noise the record moves when a parameter moves by
//! its own size. A zero singular value is a direction in which nothing measurable changes, whatever the noise
//! (structural); a small one is a direction that this noise hides (practical).

use crate::triangular::reduce;
use nalgebra::{DMatrix, DVector};

/// What can be said of one parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// Determined: its standard deviation is below its own size.
    Identifiable,
    /// The noise hides it: its standard deviation is at least its own size.
    PracticallyNonIdentifiable,
    /// It takes part in a combination of which nothing measurable depends.
    StructurallyNonIdentifiable,
}

impl Verdict {
    /// Name as it stands in documents.
    pub fn id(self) -> &'static str {
        match self {
            Verdict::Identifiable => "identifiable",
            Verdict::PracticallyNonIdentifiable => "practically-non-identifiable",
            Verdict::StructurallyNonIdentifiable => "structurally-non-identifiable",
        }
    }
}

/// Rank, spectrum and null directions of scaled sensitivities.
#[derive(Clone, Debug)]
pub struct Identifiability {
    /// Singular values of S, largest first.
    pub singular_values: Vec<f64>,
    /// How many exceed `RANK_TOLERANCE` times the largest.
    pub rank: usize,
    /// Largest over smallest singular value (infinite without full rank).
    pub condition: f64,
    /// Unit vectors, in units of the scales, along which nothing measurable changes; n - rank of them.
    pub null_directions: Vec<DVector<f64>>,
    /// Standard deviation of each parameter over its scale, from the directions that are determined.
    pub relative_deviation: Vec<f64>,
    /// One verdict per parameter.
    pub verdicts: Vec<Verdict>,
}

/// Singular values below this fraction of the largest count as zero: exact derivatives of a few thousand samples carry
/// rounding of about 1e-13, and noise that hides a direction by a factor of 1e10 need not be told from a structural zero.
pub const RANK_TOLERANCE: f64 = 1e-10;
/// A parameter takes part in a null direction when its component exceeds this.
const TAKES_PART: f64 = 1e-5;

/// Analyses a whitened Jacobian; `scales` are the sizes of the parameters (all above zero).
///
/// **Shape:** `jacobian` m x n, `scales` n.
///
/// # Panics
/// When `scales` has not one entry per column.
pub fn identifiability(jacobian: &DMatrix<f64>, scales: &[f64]) -> Identifiability {
    let n = jacobian.ncols();
    assert_eq!(n, scales.len(), "one scale per parameter");
    let mut scaled = jacobian.clone();
    for (mut column, scale) in scaled.column_iter_mut().zip(scales) {
        column *= *scale;
        // A derivative that is no number says nothing about its parameter; it must not spoil what the others say.
        if column.iter().any(|entry| !entry.is_finite()) {
            column.fill(0.0);
        }
    }
    // A sensitivity that is no number says nothing: it counts as none.
    scaled.apply(|x| {
        if !x.is_finite() {
            *x = 0.0;
        }
    });
    let r = reduce(scaled, &DVector::zeros(jacobian.nrows())).r;
    // A wide or square-short system still has n right singular vectors: pad R with rows of zeros.
    let padded = r.clone().resize(n.max(r.nrows()), n, 0.0);
    let svd = padded.svd(false, true);
    let v_t = svd.v_t.unwrap_or_else(|| DMatrix::identity(n, n));
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| svd.singular_values[b].total_cmp(&svd.singular_values[a]));
    let singular_values: Vec<f64> = order.iter().map(|&k| svd.singular_values[k]).collect();
    let directions: Vec<DVector<f64>> = order.iter().map(|&k| v_t.row(k).transpose()).collect();
    let floor = RANK_TOLERANCE * singular_values.first().copied().unwrap_or(0.0);
    let rank = singular_values.iter().filter(|&&s| s > floor).count();
    let null_directions: Vec<DVector<f64>> = directions[rank..].to_vec();

    let mut relative_deviation = Vec::with_capacity(n);
    let mut verdicts = Vec::with_capacity(n);
    for j in 0..n {
        let variance: f64 = (0..rank)
            .map(|k| (directions[k][j] / singular_values[k]).powi(2))
            .sum();
        let structural = null_directions.iter().any(|d| d[j].abs() > TAKES_PART);
        relative_deviation.push(if structural {
            f64::INFINITY
        } else {
            variance.sqrt()
        });
        verdicts.push(if structural {
            Verdict::StructurallyNonIdentifiable
        } else if variance.sqrt() >= 1.0 {
            Verdict::PracticallyNonIdentifiable
        } else {
            Verdict::Identifiable
        });
    }
    Identifiability {
        condition: match (singular_values.first(), singular_values.last()) {
            (Some(&first), Some(&last)) if rank == n => first / last,
            _ => f64::INFINITY,
        },
        singular_values,
        rank,
        null_directions,
        relative_deviation,
        verdicts,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// r = a exp(-b t) * c: only a c counts, so (1, 0, -1)/sqrt(2) in relative units is null and b is identifiable.
    #[test]
    fn a_product_of_two_parameters_is_one_too_many() {
        let (a, b, c) = (2.0_f64, 0.7_f64, 3.0_f64);
        let jacobian = DMatrix::from_fn(50, 3, |i, j| {
            let t = 0.1 * i as f64;
            let e = (-b * t).exp();
            100.0
                * match j {
                    0 => c * e,
                    1 => -t * a * c * e,
                    _ => a * e,
                }
        });
        let found = identifiability(&jacobian, &[a, b, c]);
        assert_eq!(found.rank, 2);
        let null = &found.null_directions[0];
        assert!((null[0] + null[2]).abs() < 1e-10 && null[1].abs() < 1e-10);
        assert!((null[0].abs() - 0.5_f64.sqrt()).abs() < 1e-10);
        assert_eq!(
            found.verdicts,
            vec![
                Verdict::StructurallyNonIdentifiable,
                Verdict::Identifiable,
                Verdict::StructurallyNonIdentifiable
            ]
        );
    }

    #[test]
    fn what_the_noise_hides_is_practical_and_keeps_full_rank() {
        let jacobian = DMatrix::from_row_slice(3, 2, &[10.0, 0.0, 0.0, 0.01, 0.0, 0.0]);
        let found = identifiability(&jacobian, &[1.0, 1.0]);
        assert_eq!(found.rank, 2);
        assert_eq!(found.verdicts[0], Verdict::Identifiable);
        assert_eq!(found.verdicts[1], Verdict::PracticallyNonIdentifiable);
        assert!((found.relative_deviation[1] - 100.0).abs() < 1e-9);
    }

    #[test]
    fn fewer_samples_than_parameters_leave_null_directions() {
        let jacobian = DMatrix::from_row_slice(1, 2, &[1.0, 1.0]);
        let found = identifiability(&jacobian, &[1.0, 1.0]);
        assert_eq!(found.rank, 1);
        assert_eq!(found.null_directions.len(), 1);
    }
}
