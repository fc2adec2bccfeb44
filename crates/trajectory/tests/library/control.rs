//! Optimal control problems with known answers.

use trajectory::collocation::{
    Coordinate, End, EndPoint, Guess, Linkage, OptimalControl, Phase, Point, PointRows, State,
    Transcription,
};
use trajectory::{Row, Scalar, Variable};

pub fn coordinate(name: &str, q: Variable, v: Variable, a: Variable) -> Coordinate {
    let named = |v: Variable, suffix: &str| Variable {
        name: format!("{name}{suffix}"),
        ..v
    };
    Coordinate {
        position: named(q, ""),
        velocity: named(v, " velocity"),
        acceleration: named(a, " acceleration"),
    }
}

pub fn free(scale: f64) -> Variable {
    Variable::free("", scale)
}

/// A unit mass moved over a distance in minimum time with |acceleration| ≤ 1.
///
/// Answer: T = 2 √distance, full thrust forward to the middle, then backward
/// (Bryson and Ho, Applied Optimal Control, section 3.9).
pub struct DoubleIntegrator {
    pub distance: f64,
    pub intervals: usize,
}

impl DoubleIntegrator {
    pub fn shortest_time(&self) -> f64 {
        2.0 * self.distance.sqrt()
    }

    pub fn start<P: OptimalControl>(t: &Transcription<'_, P>, distance: f64) -> Vec<f64> {
        t.start(&[], &[3.0], |_, share| Guess {
            q: vec![distance * share],
            v: vec![distance / 3.0],
            a: vec![0.0],
            ..Guess::default()
        })
    }
}

impl OptimalControl for DoubleIntegrator {
    fn phases(&self) -> Vec<Phase> {
        vec![Phase {
            name: "move".into(),
            coordinates: vec![coordinate(
                "x",
                free(1.0),
                free(1.0),
                Variable::new("", -1.0, 1.0, 1.0),
            )],
            states: vec![],
            controls: vec![],
            duration: Variable::new("T", 0.1, 100.0, 1.0),
            intervals: self.intervals,
            rows: vec![],
        }]
    }

    fn linkages(&self) -> Vec<Linkage> {
        vec![Linkage {
            name: "rest to rest".into(),
            ends: vec![End::Start(0), End::Finish(0)],
            rows: vec![Row::equal(1.0); 4],
        }]
    }

    fn point<D: Scalar>(&self, _: usize, _: &Point<'_, D>, _: PointRows<'_, D>) {}

    fn link<D: Scalar>(
        &self,
        _: usize,
        ends: &[EndPoint<'_, D>],
        _: &[D],
        cost: &mut D,
        rows: &mut [D],
    ) {
        *cost = ends[0].duration;
        rows[0] = ends[0].q[0];
        rows[1] = ends[0].v[0];
        rows[2] = ends[1].q[0] - self.distance;
        rows[3] = ends[1].v[0];
    }
}

/// The brachistochrone: fastest slide from the origin to (x, y), y downward.
///
/// Answer: the cycloid x = r (φ − sin φ), y = r (1 − cos φ), T = φ √(r/g)
/// (Bernoulli, Acta Eruditorum, 1697).
pub struct Brachistochrone {
    pub x: f64,
    pub y: f64,
    pub g: f64,
    pub intervals: usize,
}

impl Brachistochrone {
    pub fn shortest_time(&self) -> f64 {
        // (φ − sin φ)/(1 − cos φ) = x/y rises with φ: bisect.
        let ratio = |phi: f64| (phi - phi.sin()) / (1.0 - phi.cos());
        let (mut low, mut high) = (1e-6, 2.0 * std::f64::consts::PI - 1e-6);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if ratio(middle) < self.x / self.y {
                low = middle
            } else {
                high = middle
            }
        }
        let phi: f64 = 0.5 * (low + high);
        let r = self.y / (1.0 - phi.cos());
        phi * (r / self.g).sqrt()
    }

    pub fn start<P: OptimalControl>(&self, t: &Transcription<'_, P>) -> Vec<f64> {
        t.start(&[], &[2.0], |_, share| Guess {
            s: vec![self.x * share, self.y * share, 8.0 * share],
            rate: vec![self.x / 2.0, self.y / 2.0, 4.0],
            u: vec![0.2 + 1.3 * share],
            ..Guess::default()
        })
    }
}

impl OptimalControl for Brachistochrone {
    fn phases(&self) -> Vec<Phase> {
        let state = |name: &str, scale: f64| State {
            value: Variable::free(name, scale),
            rate: Variable::free(format!("{name} rate"), scale),
        };
        vec![Phase {
            name: "slide".into(),
            coordinates: vec![],
            states: vec![state("x", self.x), state("y", self.y), state("speed", 10.0)],
            controls: vec![Variable::new("angle", 0.0, std::f64::consts::PI, 1.0)],
            duration: Variable::new("T", 0.1, 100.0, 1.0),
            intervals: self.intervals,
            rows: vec![Row::equal(10.0); 3],
        }]
    }

    fn linkages(&self) -> Vec<Linkage> {
        vec![Linkage {
            name: "from the origin to the target".into(),
            ends: vec![End::Start(0), End::Finish(0)],
            rows: vec![Row::equal(1.0); 5],
        }]
    }

    fn point<D: Scalar>(&self, _: usize, at: &Point<'_, D>, out: PointRows<'_, D>) {
        let (sin, cos) = at.u[0].sin_cos();
        out.rows[0] = at.rate[0] - at.s[2] * sin;
        out.rows[1] = at.rate[1] - at.s[2] * cos;
        out.rows[2] = at.rate[2] - cos * self.g;
    }

    fn link<D: Scalar>(
        &self,
        _: usize,
        ends: &[EndPoint<'_, D>],
        _: &[D],
        cost: &mut D,
        rows: &mut [D],
    ) {
        *cost = ends[0].duration;
        rows[0] = ends[0].s[0];
        rows[1] = ends[0].s[1];
        rows[2] = ends[0].s[2];
        rows[3] = ends[1].s[0] - self.x;
        rows[4] = ends[1].s[1] - self.y;
    }
}

/// Swing-up of a pole on a cart with the least ∫u² dt.
///
/// Kelly, An introduction to trajectory optimization, SIAM Review 59 (2017),
/// section 6 and table 1: cart 1 kg, pole 0.3 kg at 0.5 m, 1 m in 2 s, |u| ≤ 20 N.
pub struct CartPole {
    pub intervals: usize,
}

impl CartPole {
    pub const CART_KG: f64 = 1.0;
    pub const POLE_KG: f64 = 0.3;
    pub const LENGTH_M: f64 = 0.5;
    pub const G: f64 = 9.81;
    pub const DISTANCE_M: f64 = 1.0;
    pub const DURATION_S: f64 = 2.0;
    pub const FORCE_N: f64 = 20.0;

    pub fn start<P: OptimalControl>(t: &Transcription<'_, P>) -> Vec<f64> {
        use std::f64::consts::PI;
        t.start(&[], &[Self::DURATION_S], |_, share| Guess {
            q: vec![Self::DISTANCE_M * share, PI * share],
            v: vec![Self::DISTANCE_M / Self::DURATION_S, PI / Self::DURATION_S],
            a: vec![0.0, 0.0],
            u: vec![0.0],
            ..Guess::default()
        })
    }

    /// (ẍ, θ̈) for a force; θ = 0 hangs down.
    pub fn accelerations(q: [f64; 2], v: [f64; 2], force_n: f64) -> [f64; 2] {
        let (m1, m2, l, g) = (Self::CART_KG, Self::POLE_KG, Self::LENGTH_M, Self::G);
        let (sin, cos) = q[1].sin_cos();
        let x = (l * m2 * sin * v[1] * v[1] + force_n + m2 * g * cos * sin) / (m1 + m2 * sin * sin);
        [x, -(cos * x + g * sin) / l]
    }
}

impl OptimalControl for CartPole {
    fn phases(&self) -> Vec<Phase> {
        vec![Phase {
            name: "swing-up".into(),
            coordinates: vec![
                coordinate(
                    "cart",
                    Variable::new("", -2.0, 2.0, 1.0),
                    free(3.0),
                    free(10.0),
                ),
                coordinate("pole", free(3.0), free(6.0), free(30.0)),
            ],
            states: vec![],
            controls: vec![Variable::new("force", -Self::FORCE_N, Self::FORCE_N, 10.0)],
            duration: Variable::new("T", Self::DURATION_S, Self::DURATION_S, 1.0),
            intervals: self.intervals,
            rows: vec![Row::equal(10.0), Row::equal(10.0)],
        }]
    }

    fn linkages(&self) -> Vec<Linkage> {
        vec![Linkage {
            name: "hanging at rest to standing at rest".into(),
            ends: vec![End::Start(0), End::Finish(0)],
            rows: vec![Row::equal(1.0); 8],
        }]
    }

    fn cost_scale(&self) -> f64 {
        10.0
    }

    fn point<D: Scalar>(&self, _: usize, at: &Point<'_, D>, out: PointRows<'_, D>) {
        let (m1, m2, l, g) = (Self::CART_KG, Self::POLE_KG, Self::LENGTH_M, Self::G);
        let (sin, cos) = at.q[1].sin_cos();
        *out.cost = at.u[0] * at.u[0];
        out.rows[0] = at.a[0] * (m1 + m2) + cos * at.a[1] * (m2 * l)
            - sin * at.v[1] * at.v[1] * (m2 * l)
            - at.u[0];
        out.rows[1] = at.a[1] * l + cos * at.a[0] + sin * g;
    }

    fn link<D: Scalar>(
        &self,
        _: usize,
        ends: &[EndPoint<'_, D>],
        _: &[D],
        _: &mut D,
        rows: &mut [D],
    ) {
        rows[..2].copy_from_slice(ends[0].q);
        rows[2..4].copy_from_slice(ends[0].v);
        rows[6..].copy_from_slice(ends[1].v);
        rows[4] = ends[1].q[0] - Self::DISTANCE_M;
        rows[5] = ends[1].q[1] - std::f64::consts::PI;
    }
}
