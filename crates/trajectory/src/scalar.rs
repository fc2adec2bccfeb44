//! The scalar that every user function is written over.

use num_dual::DualNum;

/// A real or dual number: `f64` for values, dual numbers for exact derivatives.
///
/// User functions are written once, generic over this trait. They must be
/// twice continuously differentiable where the solver evaluates them; a kink
/// makes the second derivatives meaningless and the certificate with them.
pub trait Scalar: DualNum<Primitive = f64> + Copy {}

impl<D: DualNum<Primitive = f64> + Copy> Scalar for D {}
