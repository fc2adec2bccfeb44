//! The elementary functions of a recorded number, each with its first and
//! second derivative, so that it can stand where a dual number stands.

use super::Var;
use num_dual::{DualNum, DualStruct, Mappable};
use num_traits::One;

impl DualStruct for Var {
    type Real = f64;
    type Inner = f64;

    fn re(&self) -> f64 {
        self.value
    }

    fn from_inner(inner: &f64) -> Self {
        Self::constant(*inner)
    }
}

impl Mappable<Var> for Var {
    type Output<O> = O;

    fn map_dual<M: Fn(Var) -> O, O>(self, f: M) -> O {
        f(self)
    }
}

impl DualNum for Var {
    type Primitive = f64;
    const NDERIV: usize = 2;
    type InnerDual = f64;

    fn from_re(re: f64) -> Self {
        Self::constant(re)
    }

    fn scale(self, factor: &f64) -> Self {
        self * *factor
    }

    fn recip(&self) -> Self {
        let r = 1.0 / self.value;
        self.unary(r, -r * r, 2.0 * r * r * r)
    }

    fn powi(&self, n: i32) -> Self {
        match n {
            0 => Self::one(),
            1 => *self,
            _ => {
                let (x, e) = (self.value, f64::from(n));
                self.unary(x.powi(n), e * x.powi(n - 1), e * (e - 1.0) * x.powi(n - 2))
            }
        }
    }

    fn powf(&self, n: f64) -> Self {
        if n == 0.0 {
            Self::one()
        } else if n == 1.0 {
            *self
        } else if n == 2.0 {
            self.powi(2)
        } else {
            let x = self.value;
            self.unary(
                x.powf(n),
                n * x.powf(n - 1.0),
                n * (n - 1.0) * x.powf(n - 2.0),
            )
        }
    }

    fn sqrt(&self) -> Self {
        let root = self.value.sqrt();
        let d = 0.5 / root;
        self.unary(root, d, -0.5 * d / self.value)
    }

    fn cbrt(&self) -> Self {
        let root = self.value.cbrt();
        let d = root / (3.0 * self.value);
        self.unary(root, d, -2.0 / 3.0 * d / self.value)
    }

    fn exp(&self) -> Self {
        let e = self.value.exp();
        self.unary(e, e, e)
    }

    fn exp2(&self) -> Self {
        let (e, ln2) = (self.value.exp2(), std::f64::consts::LN_2);
        self.unary(e, ln2 * e, ln2 * ln2 * e)
    }

    fn exp_m1(&self) -> Self {
        let e = self.value.exp();
        self.unary(self.value.exp_m1(), e, e)
    }

    fn ln(&self) -> Self {
        let r = 1.0 / self.value;
        self.unary(self.value.ln(), r, -r * r)
    }

    fn log(&self, base: f64) -> Self {
        let (r, scale) = (1.0 / self.value, 1.0 / base.ln());
        self.unary(self.value.log(base), scale * r, -scale * r * r)
    }

    fn log2(&self) -> Self {
        let (r, scale) = (1.0 / self.value, std::f64::consts::LOG2_E);
        self.unary(self.value.log2(), scale * r, -scale * r * r)
    }

    fn log10(&self) -> Self {
        let (r, scale) = (1.0 / self.value, std::f64::consts::LOG10_E);
        self.unary(self.value.log10(), scale * r, -scale * r * r)
    }

    fn ln_1p(&self) -> Self {
        let r = 1.0 / (1.0 + self.value);
        self.unary(self.value.ln_1p(), r, -r * r)
    }

    fn sin(&self) -> Self {
        let (s, c) = self.value.sin_cos();
        self.unary(s, c, -s)
    }

    fn cos(&self) -> Self {
        let (s, c) = self.value.sin_cos();
        self.unary(c, -s, -c)
    }

    fn tan(&self) -> Self {
        let t = self.value.tan();
        let d = 1.0 + t * t;
        self.unary(t, d, 2.0 * t * d)
    }

    fn sin_cos(&self) -> (Self, Self) {
        let (s, c) = self.value.sin_cos();
        (self.unary(s, c, -s), self.unary(c, -s, -c))
    }

    fn asin(&self) -> Self {
        let x = self.value;
        let r = 1.0 / (1.0 - x * x);
        self.unary(x.asin(), r.sqrt(), x * r.sqrt() * r)
    }

    fn acos(&self) -> Self {
        let x = self.value;
        let r = 1.0 / (1.0 - x * x);
        self.unary(x.acos(), -r.sqrt(), -x * r.sqrt() * r)
    }

    fn atan(&self) -> Self {
        let x = self.value;
        let r = 1.0 / (1.0 + x * x);
        self.unary(x.atan(), r, -2.0 * x * r * r)
    }

    fn atan2(&self, other: Self) -> Self {
        // θ = atan2(y, x), r² = x² + y²: ∇θ = (x, −y)/r², Hessian [−2xy, y²−x², 2xy]/r⁴.
        let (y, x) = (self.value, other.value);
        let r = 1.0 / (x * x + y * y);
        let cross = 2.0 * x * y * r * r;
        self.binary(
            other,
            y.atan2(x),
            [x * r, -y * r],
            [-cross, (y * y - x * x) * r * r, cross],
        )
    }

    fn sinh(&self) -> Self {
        let (s, c) = (self.value.sinh(), self.value.cosh());
        self.unary(s, c, s)
    }

    fn cosh(&self) -> Self {
        let (s, c) = (self.value.sinh(), self.value.cosh());
        self.unary(c, s, c)
    }

    fn tanh(&self) -> Self {
        let t = self.value.tanh();
        let d = 1.0 - t * t;
        self.unary(t, d, -2.0 * t * d)
    }

    fn asinh(&self) -> Self {
        let x = self.value;
        let r = 1.0 / (1.0 + x * x);
        self.unary(x.asinh(), r.sqrt(), -x * r.sqrt() * r)
    }

    fn acosh(&self) -> Self {
        let x = self.value;
        let r = 1.0 / (x * x - 1.0);
        self.unary(x.acosh(), r.sqrt(), -x * r.sqrt() * r)
    }

    fn atanh(&self) -> Self {
        let x = self.value;
        let r = 1.0 / (1.0 - x * x);
        self.unary(x.atanh(), r, 2.0 * x * r * r)
    }

    fn sph_j0(&self) -> Self {
        if self.value.abs() < f64::EPSILON {
            Self::one() - *self * *self / 6.0
        } else {
            self.sin() / *self
        }
    }

    fn sph_j1(&self) -> Self {
        if self.value.abs() < f64::EPSILON {
            return *self / 3.0;
        }
        let (s, c) = self.sin_cos();
        (s - *self * c) / (*self * *self)
    }

    fn sph_j2(&self) -> Self {
        if self.value.abs() < f64::EPSILON {
            return *self * *self / 15.0;
        }
        let (s, c) = self.sin_cos();
        let square = *self * *self;
        ((s - *self * c) * 3.0 - square * s) / (square * *self)
    }
}
