//! The spread of identified parameters as one stage leaves it for another.

use fitting::noise::Sizes;
use identification::Spread;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

/// [`Spread`] in plain numbers, matrices by rows.
#[derive(Serialize, Deserialize)]
pub(crate) struct Kept {
    covariance: Vec<Vec<f64>>,
    moved_by_gains: Vec<Vec<f64>>,
    sensor: f64,
    private: f64,
    plate: f64,
    length: f64,
    smoothing: f64,
    plate_ratio: f64,
    plate_smoothing: f64,
    scatter: f64,
    scatters: Vec<(f64, f64)>,
}

impl From<&Spread> for Kept {
    fn from(spread: &Spread) -> Self {
        let rows = |matrix: &DMatrix<f64>| {
            matrix
                .row_iter()
                .map(|row| row.iter().copied().collect())
                .collect()
        };
        let sizes = &spread.sizes;
        Self {
            covariance: rows(&spread.covariance),
            moved_by_gains: rows(&spread.moved_by_gains),
            sensor: sizes.sensor,
            private: sizes.private,
            plate: sizes.plate,
            length: sizes.length,
            smoothing: sizes.smoothing,
            plate_ratio: sizes.plate_ratio,
            plate_smoothing: sizes.plate_smoothing,
            scatter: sizes.scatter,
            scatters: spread.scatters.clone(),
        }
    }
}

impl From<Kept> for Spread {
    fn from(kept: Kept) -> Self {
        let matrix = |rows: &[Vec<f64>]| {
            let columns = rows.first().map_or(0, Vec::len);
            DMatrix::from_row_iterator(rows.len(), columns, rows.iter().flatten().copied())
        };
        Self {
            covariance: matrix(&kept.covariance),
            moved_by_gains: matrix(&kept.moved_by_gains),
            sizes: Sizes {
                sensor: kept.sensor,
                private: kept.private,
                plate: kept.plate,
                length: kept.length,
                smoothing: kept.smoothing,
                plate_ratio: kept.plate_ratio,
                plate_smoothing: kept.plate_smoothing,
                scatter: kept.scatter,
                ..Sizes::NONE
            },
            scatters: kept.scatters,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spread_comes_back_as_it_was() {
        let spread = Spread {
            covariance: DMatrix::from_row_slice(2, 2, &[1.0, 0.25, 0.25, 3.0]),
            moved_by_gains: DMatrix::from_row_slice(2, 3, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]),
            sizes: Sizes {
                sensor: 1e-3,
                private: 2e-3,
                plate: 3e-3,
                length: 4e-3,
                scatter: 5e-3,
                ..Sizes::NONE
            },
            scatters: vec![(0.0, 0.25), (0.1, 0.75)],
        };
        let text = serde_json::to_string(&Kept::from(&spread)).unwrap();
        let kept: Kept = serde_json::from_str(&text).unwrap();
        assert_eq!(Spread::from(kept), spread);
    }
}
