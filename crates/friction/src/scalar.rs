//! The scalar over which every law is generic: `f64`, or a dual number that carries derivatives along.

use nalgebra::{ArrayStorage, SVector};
use num_dual::{Derivative, DualNum, DualSVec64, DualStruct};

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

    /// Sine and cosine, by the same few operations on every processor.
    #[inline(always)]
    fn sine_and_cosine(&self) -> (Self, Self) {
        let (sine, cosine) = libm::sincos(self.value());
        (
            Self::along(sine, [(self, cosine)].into_iter()),
            Self::along(cosine, [(self, -sine)].into_iter()),
        )
    }

    /// Whether it carries derivatives.
    fn varies(&self) -> bool;

    /// A value whose derivatives are the sum of those of its arguments, each times the slope by it. A function whose slopes are
    /// known costs one such sum, where its formula in dual numbers costs one or two for every operation.
    fn along<'a>(value: f64, arguments: impl Iterator<Item = (&'a Self, f64)>) -> Self
    where
        Self: 'a;
}

impl Scalar for f64 {
    #[inline(always)]
    fn varies(&self) -> bool {
        false
    }

    #[inline(always)]
    fn along<'a>(value: f64, _arguments: impl Iterator<Item = (&'a Self, f64)>) -> Self {
        value
    }
}

impl<const N: usize> Scalar for DualSVec64<N> {
    #[inline(always)]
    fn varies(&self) -> bool {
        self.eps.0.is_some()
    }

    #[inline(always)]
    fn along<'a>(value: f64, arguments: impl Iterator<Item = (&'a Self, f64)>) -> Self {
        let mut sum = [0.0; N];
        let mut varies = false;
        arguments.for_each(|(argument, slope)| {
            if let Some(theirs) = &argument.eps.0 {
                varies = true;
                let [theirs] = &theirs.data.0;
                for k in 0..N {
                    sum[k] += theirs[k] * slope;
                }
            }
        });
        let eps = varies.then(|| SVector::from_array_storage(ArrayStorage([sum])));
        Self::new(value, Derivative::new(eps))
    }
}
