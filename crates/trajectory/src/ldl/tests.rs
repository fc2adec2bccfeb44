//! The factors against Clarabel's QDLDL, which works column by column.

use super::{Ldl, order};
use crate::pattern::Pattern;
use clarabel::algebra::CscMatrix;
use clarabel::qdldl::{QDLDLFactorisation, QDLDLSettingsBuilder};
use proptest::prelude::*;

/// A symmetric quasidefinite matrix: `n` rows, some entries above the diagonal, diagonals that dominate with either sign.
fn matrix() -> impl Strategy<Value = (Pattern, Vec<f64>)> {
    (1..60usize).prop_flat_map(|n| {
        let entry = (0..n, 0..n, -1.0..1.0f64);
        let entries = prop::collection::vec(entry, 0..4 * n);
        (entries, prop::collection::vec(any::<bool>(), n)).prop_map(move |(entries, signs)| {
            let upper = entries.iter().map(|&(i, j, _)| (i.min(j), i.max(j)));
            let pattern =
                Pattern::from_entries(n, n, upper.chain((0..n).map(|k| (k, k))).collect());
            let mut values = vec![0.0; pattern.len()];
            let mut sums = vec![1.0; n];
            for &(i, j, value) in entries.iter().filter(|(i, j, _)| i != j) {
                values[pattern.slot(i.min(j), i.max(j))] += value;
                sums[i] += value.abs();
                sums[j] += value.abs();
            }
            for k in 0..n {
                values[pattern.slot(k, k)] = if signs[k] { sums[k] } else { -sums[k] };
            }
            (pattern, values)
        })
    })
}

fn laid_out(pattern: &Pattern) -> Ldl {
    let order = order(pattern).expect("an order");
    Ldl::new(pattern, &order).expect("a layout")
}

fn qdldl(pattern: &Pattern, values: &[f64]) -> QDLDLFactorisation<f64> {
    let (n, starts, row_of) = (
        pattern.columns,
        pattern.starts.clone(),
        pattern.row_of.clone(),
    );
    let matrix = CscMatrix::new(n, n, starts, row_of, values.to_vec());
    let settings = QDLDLSettingsBuilder::default()
        .regularize_enable(false)
        .build();
    QDLDLFactorisation::new(&matrix, settings.ok()).expect("factors")
}

proptest! {
    #[test]
    fn inertia_and_solutions_are_those_of_qdldl((pattern, values) in matrix(), seed in -1.0..1.0f64) {
        let mut ldl = laid_out(&pattern);
        let mut other = qdldl(&pattern, &values);
        prop_assert_eq!(ldl.factorise(&values), Some(other.positive_inertia()));
        let b: Vec<f64> = (0..pattern.columns).map(|k| (seed + k as f64).sin()).collect();
        let (mut x, mut y) = (b.clone(), b);
        ldl.solve(&mut x);
        other.solve(&mut y);
        for (x, y) in x.iter().zip(&y) {
            prop_assert!((x - y).abs() < 1e-12, "{} {}", x, y);
        }
    }
}

#[test]
fn a_second_matrix_of_the_same_pattern_forgets_the_first() {
    let pattern = Pattern::from_entries(2, 2, vec![(0, 0), (0, 1), (1, 1)]);
    let mut ldl = laid_out(&pattern);
    assert_eq!(ldl.factorise(&[1.0, 5.0, 1.0]), Some(1));
    assert_eq!(ldl.factorise(&[2.0, 1.0, 3.0]), Some(2));
    let mut x = [5.0, 10.0];
    ldl.solve(&mut x);
    assert!((x[0] - 1.0).abs() < 1e-15 && (x[1] - 3.0).abs() < 1e-15);
}

#[test]
fn a_vanishing_pivot_is_told() {
    let pattern = Pattern::from_entries(2, 2, vec![(0, 0), (0, 1), (1, 1)]);
    let mut ldl = laid_out(&pattern);
    assert_eq!(ldl.factorise(&[1.0, 1.0, 1.0]), None);
    assert_eq!(ldl.factorise(&[f64::NAN, 1.0, 1.0]), None);
}
