//! What a least-squares problem offers.

use nalgebra::{DMatrix, DVector};

/// A vector of whitened residuals r(p) with its exact derivative; the cost is 1/2 |r|^2.
///
/// **Shape:** n parameters, m residuals, m the same at every p. **Sign:** r = predicted - measured or the reverse; only
/// squares count. A point at which the model has no value answers with residuals that are not finite: the solver then
/// takes a shorter step.
pub trait Residuals: Sync {
    /// r(p), length m.
    fn residuals(&self, parameters: &[f64]) -> DVector<f64>;

    /// r(p) and J = dr/dp, m rows and n columns.
    fn jacobian(&self, parameters: &[f64]) -> (DVector<f64>, DMatrix<f64>);

    /// r(p) and the named columns of J in the given order. Override it where leaving columns out saves work.
    fn jacobian_columns(
        &self,
        parameters: &[f64],
        columns: &[usize],
    ) -> (DVector<f64>, DMatrix<f64>) {
        let (residuals, jacobian) = self.jacobian(parameters);
        if columns.len() == jacobian.ncols() && columns.iter().enumerate().all(|(k, &c)| k == c) {
            return (residuals, jacobian);
        }
        (residuals, jacobian.select_columns(columns))
    }
}
