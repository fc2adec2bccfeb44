//! Least squares, noise models and identifiability: knows residuals and parameters, not friction.
