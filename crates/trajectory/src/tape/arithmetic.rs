//! The operators of a recorded number, with itself and with real numbers.

use super::Var;
use num_traits::{FromPrimitive, Inv, Num, One, Signed, Zero};
use std::fmt;
use std::iter::{Product, Sum};
use std::ops::{
    Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Rem, RemAssign, Sub, SubAssign,
};

fn add(x: Var, y: Var) -> Var {
    x.binary(y, x.value + y.value, [1.0, 1.0], [0.0; 3])
}

fn sub(x: Var, y: Var) -> Var {
    x.binary(y, x.value - y.value, [1.0, -1.0], [0.0; 3])
}

fn mul(x: Var, y: Var) -> Var {
    x.binary(y, x.value * y.value, [y.value, x.value], [0.0, 1.0, 0.0])
}

fn div(x: Var, y: Var) -> Var {
    let inverse = 1.0 / y.value;
    let quotient = x.value * inverse;
    let square = inverse * inverse;
    x.binary(
        y,
        quotient,
        [inverse, -quotient * inverse],
        [0.0, -square, 2.0 * quotient * square],
    )
}

/// x − y ⌊x/y⌋ towards zero: linear where it is smooth.
fn rem(x: Var, y: Var) -> Var {
    let whole = (x.value / y.value).trunc();
    x.binary(y, x.value % y.value, [1.0, -whole], [0.0; 3])
}

macro_rules! operator {
    ($trait:ident, $method:ident, $assign:ident, $assign_method:ident) => {
        impl $trait for Var {
            type Output = Var;
            #[inline]
            fn $method(self, other: Var) -> Var {
                $method(self, other)
            }
        }
        impl $trait<&Var> for Var {
            type Output = Var;
            #[inline]
            fn $method(self, other: &Var) -> Var {
                $method(self, *other)
            }
        }
        impl $trait<Var> for &Var {
            type Output = Var;
            #[inline]
            fn $method(self, other: Var) -> Var {
                $method(*self, other)
            }
        }
        impl $trait<&Var> for &Var {
            type Output = Var;
            #[inline]
            fn $method(self, other: &Var) -> Var {
                $method(*self, *other)
            }
        }
        impl $trait<f64> for Var {
            type Output = Var;
            #[inline]
            fn $method(self, other: f64) -> Var {
                $method(self, Var::constant(other))
            }
        }
        impl $assign for Var {
            #[inline]
            fn $assign_method(&mut self, other: Var) {
                *self = $method(*self, other);
            }
        }
        impl $assign<f64> for Var {
            #[inline]
            fn $assign_method(&mut self, other: f64) {
                *self = $method(*self, Var::constant(other));
            }
        }
    };
}

operator!(Add, add, AddAssign, add_assign);
operator!(Sub, sub, SubAssign, sub_assign);
operator!(Mul, mul, MulAssign, mul_assign);
operator!(Div, div, DivAssign, div_assign);
operator!(Rem, rem, RemAssign, rem_assign);

impl Neg for Var {
    type Output = Var;
    #[inline]
    fn neg(self) -> Var {
        self.unary(-self.value, -1.0, 0.0)
    }
}

impl Neg for &Var {
    type Output = Var;
    #[inline]
    fn neg(self) -> Var {
        -*self
    }
}

impl Zero for Var {
    fn zero() -> Self {
        Self::constant(0.0)
    }

    fn is_zero(&self) -> bool {
        self.value == 0.0
    }
}

impl One for Var {
    fn one() -> Self {
        Self::constant(1.0)
    }
}

impl Inv for Var {
    type Output = Var;
    fn inv(self) -> Var {
        Self::one() / self
    }
}

impl Sum for Var {
    fn sum<I: Iterator<Item = Self>>(iter: I) -> Self {
        iter.fold(Self::zero(), |sum, x| sum + x)
    }
}

impl<'a> Sum<&'a Var> for Var {
    fn sum<I: Iterator<Item = &'a Self>>(iter: I) -> Self {
        iter.fold(Self::zero(), |sum, x| sum + x)
    }
}

impl Product for Var {
    fn product<I: Iterator<Item = Self>>(iter: I) -> Self {
        iter.fold(Self::one(), |product, x| product * x)
    }
}

impl<'a> Product<&'a Var> for Var {
    fn product<I: Iterator<Item = &'a Self>>(iter: I) -> Self {
        iter.fold(Self::one(), |product, x| product * x)
    }
}

impl From<f64> for Var {
    fn from(value: f64) -> Self {
        Self::constant(value)
    }
}

impl FromPrimitive for Var {
    fn from_i64(n: i64) -> Option<Self> {
        f64::from_i64(n).map(Self::constant)
    }

    fn from_u64(n: u64) -> Option<Self> {
        f64::from_u64(n).map(Self::constant)
    }

    fn from_f64(n: f64) -> Option<Self> {
        Some(Self::constant(n))
    }
}

impl PartialEq for Var {
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

impl PartialOrd for Var {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        self.value.partial_cmp(&other.value)
    }
}

impl PartialEq<f64> for Var {
    fn eq(&self, other: &f64) -> bool {
        self.value == *other
    }
}

impl PartialOrd<f64> for Var {
    fn partial_cmp(&self, other: &f64) -> Option<std::cmp::Ordering> {
        self.value.partial_cmp(other)
    }
}

impl fmt::Display for Var {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.value)
    }
}

impl Num for Var {
    type FromStrRadixErr = <f64 as Num>::FromStrRadixErr;

    fn from_str_radix(text: &str, radix: u32) -> Result<Self, Self::FromStrRadixErr> {
        f64::from_str_radix(text, radix).map(Self::constant)
    }
}

impl Signed for Var {
    fn abs(&self) -> Self {
        if self.value < 0.0 { -*self } else { *self }
    }

    fn abs_sub(&self, other: &Self) -> Self {
        if self.value > other.value {
            *self - *other
        } else {
            Self::zero()
        }
    }

    fn signum(&self) -> Self {
        Self::constant(self.value.signum())
    }

    fn is_positive(&self) -> bool {
        self.value > 0.0
    }

    fn is_negative(&self) -> bool {
        self.value < 0.0
    }
}
