//! The scalar over which every law is generic: `f64`, or a dual number that carries derivatives along.

use num_dual::{DualNum, DualStruct};

/// A real number or a dual number over `f64`.
///
/// `D::from(x)` makes a constant, [`Scalar::value`] reads the real part. Branches (sign of a speed, size of a step)
/// look at the real part only, so value and derivative always take the same path.
pub trait Scalar: DualNum<Primitive = f64> + Copy + Send + Sync {
    /// Real part.
    #[inline]
    fn value(&self) -> f64 {
        DualStruct::re(self)
    }

    /// A constant: no derivatives.
    #[inline]
    fn constant(value: f64) -> Self {
        Self::from(value)
    }

    /// Magnitude; at zero the sign counts as positive.
    #[inline]
    fn magnitude(&self) -> Self {
        if self.value() < 0.0 { -*self } else { *self }
    }
}

impl<T> Scalar for T where T: DualNum<Primitive = f64> + Copy + Send + Sync {}
