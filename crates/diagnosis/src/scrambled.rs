//! The placebo of a gain: the fitted effect with its course along each run scrambled, fitted and judged in the same folds.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::bench::{Bench, Fitted};
use crate::fold::reference;
use crate::ground::orthonormal;
use crate::selection::Selected;

/// Scrambled extensions that a gain must beat.
const PLACEBOS: usize = 19;

/// The fitted effects with their course along each run shifted round and their sign drawn, from fixed seeds.
pub(crate) fn scrambled(bench: &Bench<'_>, selected: &Selected, shifted: bool) -> Vec<Vec<f64>> {
    if selected.names_nothing() {
        return Vec::new();
    }
    let effect: Vec<f64> = selected
        .stand
        .fitted
        .prediction
        .iter()
        .zip(&reference(bench, &selected.baseline.fitted, shifted).prediction)
        .map(|(a, b)| a - b)
        .collect();
    (0..PLACEBOS)
        .map(|p| {
            let mut rng = ChaCha8Rng::seed_from_u64(0x0b1a_5eed + p as u64);
            let mut out = effect.clone();
            for run in &bench.samples.runs {
                let n = run.len();
                let shift = rng.random_range(n / 10..n.max(n / 10 + 1));
                let sign = if rng.random::<f64>() < 0.5 { -1.0 } else { 1.0 };
                for (place, i) in run.clone().enumerate() {
                    out[i] = sign * effect[run.start + (place + shift) % n];
                }
            }
            out
        })
        .collect()
}

/// Predictions with each scrambled effect, fitted by least squares together with the law's own directions (or, where the law stands as it
/// is stated, alone).
pub(crate) fn placebos(
    bench: &Bench<'_>,
    own: &Selected,
    reference: &Fitted,
    effects: &[Vec<f64>],
    shifted: bool,
) -> Vec<Vec<f64>> {
    let (base, subset) = (&own.baseline, &own.subset);
    let whitened = |column: &[f64]| -> DVector<f64> {
        let raw = DMatrix::from_column_slice(column.len(), 1, column);
        base.whiten(subset, &raw).column(0).into_owned()
    };
    let (basis, back, residual) = if shifted {
        let measured = bench.experiment.measured_n.iter();
        let residual: Vec<f64> = (measured.zip(&reference.prediction))
            .map(|(y, f)| y - f)
            .collect();
        let (rows, parameters) = base.white_jacobian.shape();
        let (none, back) = (DMatrix::zeros(rows, 0), DMatrix::zeros(parameters, 0));
        (none, back, whitened(&residual))
    } else {
        let (basis, back) = orthonormal(&base.white_jacobian, 1e-9);
        (basis, back, base.ground.y.clone())
    };
    let scrambled = effects.iter();
    let beside = scrambled.map(|effect| {
        let white = whitened(effect);
        let along = basis.tr_mul(&white);
        let free = &white - &basis * &along;
        let power = free.norm_squared().max(1e-300);
        let size = free.dot(&residual) / power;
        let shift = &base.jacobian * (&back * along);
        let law = reference.prediction.iter();
        law.zip(effect)
            .zip(shift.iter())
            .map(|((p, e), j)| p + size * (e - j))
            .collect()
    });
    beside.collect()
}
