//! Direct collocation and sequential quadratic programming on Clarabel: functions and sparsity, not robots.
