//! Solving strides.
