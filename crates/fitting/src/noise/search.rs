//! A small quasi-Newton search for the sizes of the noise, in their logarithms, with differences for the gradient.
//!
//! Where the standard deviations of all parts grow by e^t, V grows by e^(2t), and of C of (N3) with n - p degrees of freedom it is known
//! without an evaluation that
//!
//! ```text
//! C(t) = C(0) + 2 (n - p) t + (e^(-2t) - 1) r' P r                                                             (N11)
//! ```
//!
//! So every point is moved to where this is least, t = log(r' P r / (n - p)) / 2, and one slope of those of the standard deviations follows from
//! the others: all together they are 2 (n - p) - 2 r' P r. It is that of the part with the most curvature that is not asked for, as the others'
//! errors add up in it.
//!
//! The restricted likelihood costs milliseconds and is smooth to about 1e-6, so that steps of 0.0005 in a logarithm give its slope to
//! some 4e-3. Longer steps do harm: a difference to one side is off by half a step times that coordinate's own curvature, and along
//! a ridge (length against size and smoothing) a small error of the slope is a long way. With steps of 0.02 searches ended up to a quarter
//! short in length.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::quadratic::Quadratic;

/// Step of the differences.
const STEP: f64 = 0.0005;
/// How far a search goes: a step that promises to lower -2 log likelihood by less than this is not worth taking.
pub(super) const TO_THE_END: f64 = 0.02;
/// The same where another search follows, or where what is compared must differ by tens.
pub(super) const NEAR: f64 = 0.3;

/// Curvature before any is met.
const FIRST: f64 = 10.0;

/// Shares of a step that was too long, least and most, which are tried next.
const SHORTER: (f64, f64) = (0.1, 0.5);
/// Longest step in a coordinate.
const LONGEST: f64 = 1.5;
/// Damping below which there is none.
const UNDAMPED: f64 = 0.01;

/// Where a search ended.
#[derive(Clone)]
pub(super) struct Minimum {
    pub(super) point: Vec<f64>,
    /// Estimate of the Hessian there.
    pub(super) hessian: DMatrix<f64>,
    pub(super) value: f64,
    pub(super) evaluations: usize,
    pub(super) converged: bool,
}

/// -2 log likelihood at a point.
#[derive(Clone, Copy)]
pub(super) struct Level {
    /// C of (N3).
    pub(super) value: f64,
    /// r' P r there.
    pub(super) squares: f64,
}

impl Level {
    /// Where there is no likelihood.
    pub(super) const NONE: Self = Self {
        value: f64::INFINITY,
        squares: 0.0,
    };
}

/// What is searched for, and how it depends on its coordinates.
pub(super) struct Problem<'a> {
    pub(super) level: &'a (dyn Fn(&[f64]) -> Level + Sync),
    pub(super) bounds: &'a [(f64, f64)],
    /// Coordinates that are logarithms of standard deviations of all parts of the noise.
    pub(super) parts: &'a [usize],
    /// A coordinate on which nothing depends.
    pub(super) idle: Option<usize>,
    /// n - p of (N11).
    pub(super) degrees_of_freedom: f64,
}

/// A point and its level.
struct Reached {
    point: DVector<f64>,
    level: Level,
}

impl Problem<'_> {
    fn clamp(&self, x: &DVector<f64>) -> DVector<f64> {
        let within = x.iter().zip(self.bounds);
        DVector::from_iterator(x.len(), within.map(|(v, (lo, hi))| v.clamp(*lo, *hi)))
    }

    /// The likeliest of the points that have the standard deviations of `point` times a common factor, as far as bounds allow, (N11).
    fn reach(&self, mut point: DVector<f64>) -> Reached {
        let Level { value, squares } = (self.level)(point.as_slice());
        let parts = || self.parts.iter().map(|&k| (point[k], self.bounds[k]));
        let least = parts().map(|(x, (lo, _))| lo - x).fold(f64::MIN, f64::max);
        let most = parts().map(|(x, (_, hi))| hi - x).fold(f64::MAX, f64::min);
        let t = 0.5 * (squares / self.degrees_of_freedom).ln();
        if self.parts.is_empty() || !t.is_finite() || least > most {
            let level = Level { value, squares };
            return Reached { point, level };
        }
        let t = t.clamp(least, most);
        self.parts.iter().for_each(|&k| point[k] += t);
        let level = Level {
            value: value + 2.0 * self.degrees_of_freedom * t + (-2.0 * t).exp_m1() * squares,
            squares: squares * (-2.0 * t).exp(),
        };
        Reached { point, level }
    }

    /// Slopes by forward differences, evaluated side by side (the order of the results is fixed), but for that of `inferred`, which
    /// follows from the others'.
    fn slopes(
        &self,
        at: &Reached,
        inferred: Option<usize>,
        evaluations: &mut usize,
    ) -> DVector<f64> {
        let n = at.point.len();
        let asked: Vec<usize> = (0..n)
            .filter(|&k| inferred != Some(k) && self.idle != Some(k))
            .collect();
        *evaluations += asked.len();
        let of = |&k: &usize| {
            let mut beside = at.point.clone();
            beside[k] += STEP;
            ((self.level)(beside.as_slice()).value - at.level.value) / STEP
        };
        let known: Vec<f64> = asked.par_iter().map(of).collect();
        let mut slopes = DVector::zeros(n);
        asked.iter().zip(known).for_each(|(&k, s)| slopes[k] = s);
        if let Some(inferred) = inferred {
            let others: f64 = self.parts.iter().map(|&k| slopes[k]).sum();
            slopes[inferred] = 2.0 * (self.degrees_of_freedom - at.level.squares) - others;
        }
        slopes
    }

    /// The part whose logarithm has the most curvature.
    fn most_curved(&self, curvature: &DMatrix<f64>) -> Option<usize> {
        let parts = self.parts.iter().copied();
        parts.max_by(|&a, &b| curvature[(a, a)].total_cmp(&curvature[(b, b)]))
    }
}

/// How far a search has come.
struct Walk<'a> {
    problem: &'a Problem<'a>,
    at: Reached,
    slope: DVector<f64>,
    model: Quadratic,
    damping: f64,
    /// The coordinate whose slope follows from the others'.
    inferred: Option<usize>,
    evaluations: usize,
}

impl<'a> Walk<'a> {
    /// `inferred`: the coordinate whose slope follows from the others'.
    fn from(
        problem: &'a Problem<'a>,
        start: &[f64],
        inferred: Option<usize>,
        model: Quadratic,
    ) -> Self {
        let at = problem.reach(problem.clamp(&DVector::from_column_slice(start)));
        let mut evaluations = 1;
        Self {
            slope: problem.slopes(&at, inferred, &mut evaluations),
            problem,
            at,
            model,
            damping: 0.0,
            inferred,
            evaluations,
        }
    }

    fn step(&self, damping: f64) -> DVector<f64> {
        let bounds = self.problem.bounds;
        let mut step = (self.model).step(&self.at.point, &self.slope, bounds, damping);
        let longest = step.amax();
        if longest > LONGEST {
            step *= LONGEST / longest;
        }
        step
    }

    /// Where a step leads, damped until it lowers the value; `None` where none does.
    fn trial(&mut self, undamped: DVector<f64>) -> Option<Reached> {
        const MOST_TRIALS: usize = 8;
        let mut step = undamped;
        for _ in 0..MOST_TRIALS {
            if self.damping > 0.0 {
                step = self.step(self.damping);
            }
            let next = (self.problem).reach(self.problem.clamp(&(&self.at.point + &step)));
            self.evaluations += 1;
            let beyond = next.level.value - self.at.level.value;
            let along = step.dot(&self.slope);
            if beyond < 1e-4 * along {
                let share = beyond / self.model.change(&step, &self.slope);
                self.damping = match share {
                    s if s > 0.75 => 0.1 * self.damping,
                    s if s < 0.25 => 4.0 * (self.damping + 0.25),
                    _ => self.damping,
                };
                if self.damping < UNDAMPED {
                    self.damping = 0.0;
                }
                return Some(next);
            }
            // Where the parabola through both values with the slope here is least.
            let least = (-0.5 * along / (beyond - along)).clamp(SHORTER.0, SHORTER.1);
            self.damping = (1.0 + self.damping) / least - 1.0;
        }
        None
    }

    /// Goes there, and learns from the slope there.
    fn go(&mut self, next: Reached) {
        let slope = (self.problem).slopes(&next, self.inferred, &mut self.evaluations);
        let step = &next.point - &self.at.point;
        self.model.update(&step, &(&slope - &self.slope));
        (self.at, self.slope) = (next, slope);
    }

    fn end(self, converged: bool) -> Minimum {
        Minimum {
            point: self.at.point.as_slice().to_vec(),
            hessian: self.model.hessian,
            value: self.at.level.value,
            evaluations: self.evaluations,
            converged,
        }
    }
}

/// Minimises within the bounds from `start`, as far as `worthwhile` steps lead, with the curvature that may be expected there (positive definite,
/// `None`: nothing is expected) and an estimate of the Hessian where one is known better.
pub(super) fn minimise(
    problem: &Problem<'_>,
    start: &[f64],
    expected: Option<DMatrix<f64>>,
    hessian: Option<DMatrix<f64>>,
    worthwhile: f64,
) -> Minimum {
    const MOST_ITERATIONS: usize = 25;
    let n = start.len();
    let expected = expected.unwrap_or_else(|| DMatrix::identity(n, n) * FIRST);
    let inferred = problem.most_curved(&expected);
    let mut walk = Walk::from(problem, start, inferred, Quadratic::new(expected, hessian));
    let mut promised_before = None;
    for _ in 0..MOST_ITERATIONS {
        let step = walk.step(0.0);
        let promised = step.dot(&walk.slope);
        if promised.abs() < worthwhile {
            return walk.end(true);
        }
        let Some(next) = walk.trial(step) else {
            return walk.end(promised.abs() < 0.5);
        };
        // The promises of whole steps fall by a factor. Where the next one, fallen as much, would not be worth taking, no slope is needed.
        let whole = walk.damping == 0.0;
        let fallen = promised_before.map_or(1.0, |before: f64| promised / before);
        if whole && promised.abs() * fallen < worthwhile {
            walk.at = next;
            return walk.end(true);
        }
        promised_before = whole.then_some(promised);
        walk.go(next);
    }
    walk.end(false)
}

/// Standard deviations of the coordinates from the curvature of `f` = -2 log likelihood; infinite where it is flat.
pub(super) fn standard_deviations(f: &(dyn Fn(&[f64]) -> f64 + Sync), x: &[f64]) -> Vec<f64> {
    let n = x.len();
    let h = 0.1;
    let points: Vec<(usize, usize)> = (0..n).flat_map(|i| (i..n).map(move |j| (i, j))).collect();
    let second: Vec<f64> = points
        .par_iter()
        .map(|&(i, j)| {
            let at = |a: f64, b: f64| {
                let mut p = x.to_vec();
                p[i] += a;
                p[j] += b;
                f(&p)
            };
            if i == j {
                (at(h, 0.0) - 2.0 * f(x) + at(-h, 0.0)) / (h * h)
            } else {
                (at(h, h) - at(h, -h) - at(-h, h) + at(-h, -h)) / (4.0 * h * h)
            }
        })
        .collect();
    let mut hessian = DMatrix::zeros(n, n);
    for (&(i, j), v) in points.iter().zip(&second) {
        hessian[(i, j)] = *v;
        hessian[(j, i)] = *v;
    }
    // f = -2 log L, so the covariance is the inverse of half its Hessian.
    match (hessian * 0.5).try_inverse() {
        Some(covariance) => (0..n)
            .map(|i| {
                let v = covariance[(i, i)];
                if v > 0.0 { v.sqrt() } else { f64::INFINITY }
            })
            .collect(),
        None => vec![f64::INFINITY; n],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(value: f64) -> Level {
        Level {
            value,
            ..Level::NONE
        }
    }

    fn without_parts<'a>(
        level: &'a (dyn Fn(&[f64]) -> Level + Sync),
        bounds: &'a [(f64, f64)],
    ) -> Problem<'a> {
        Problem {
            level,
            bounds,
            parts: &[],
            idle: None,
            degrees_of_freedom: 1.0,
        }
    }

    /// Thirty samples of a noise e^a with mean square 1, and fifty of e^a beside e^b with mean square 3: (a, b) = (0, log(2) / 2).
    fn two_parts(x: &[f64]) -> Level {
        let alone = (2.0 * x[0]).exp();
        let both = alone + (2.0 * x[1]).exp();
        let squares = 30.0 / alone + 150.0 / both;
        Level {
            value: 30.0 * alone.ln() + 50.0 * both.ln() + squares,
            squares,
        }
    }

    /// What is known of a common factor is what the level says at the point that was moved by it, and the slope that follows from the others' is
    /// the one that would be found. The minimum is the known one, for fewer evaluations.
    #[test]
    fn a_common_factor_is_known_without_an_evaluation() {
        let bounds = [(-6.0, 6.0); 2];
        let plain = without_parts(&two_parts, &bounds);
        let problem = Problem {
            parts: &[0, 1],
            degrees_of_freedom: 80.0,
            ..without_parts(&two_parts, &bounds)
        };
        let at = problem.reach(DVector::from_vec(vec![1.3, -0.4]));
        assert!((at.point[0] - at.point[1] - 1.7).abs() < 1e-12);
        let there = two_parts(at.point.as_slice());
        assert!((at.level.value - there.value).abs() < 1e-10);
        assert!(
            (at.level.squares - there.squares).abs() < 1e-10
                && (there.squares - 80.0).abs() < 1e-10
        );

        let off = Reached {
            point: DVector::from_vec(vec![1.3, -0.4]),
            level: two_parts(&[1.3, -0.4]),
        };
        let (mut fewer, mut all) = (0, 0);
        let inferred = problem.slopes(&off, Some(0), &mut fewer);
        let asked = plain.slopes(&off, None, &mut all);
        assert_eq!((fewer, all), (1, 2));
        // forward differences of both: half a step times the curvature, which is some hundreds
        assert!((inferred - asked).amax() < 0.5);

        let [known, blind] =
            [&problem, &plain].map(|of| minimise(of, &[1.3, -0.4], None, None, TO_THE_END));
        for found in [&known, &blind] {
            assert!(found.converged);
            assert!(
                found.point[0].abs() < 0.02 && (found.point[1] - 0.5 * 2.0_f64.ln()).abs() < 0.02
            );
        }
        assert!(
            known.evaluations < blind.evaluations,
            "{} {}",
            known.evaluations,
            blind.evaluations
        );
    }

    /// Where every coordinate presses on its bound the search has come to its end.
    #[test]
    fn a_corner_is_an_end() {
        let plane = |x: &[f64]| plain(10.0 * x[0] - 20.0 * x[1]);
        let problem = without_parts(&plane, &[(0.0, 1.0), (0.0, 1.0)]);
        let found = minimise(&problem, &[0.0, 1.0], None, None, TO_THE_END);
        assert!(found.converged);
        assert_eq!((found.point, found.evaluations), (vec![0.0, 1.0], 3));
    }

    /// A narrow valley that a bound cuts: along it the second coordinate presses on its bound, and the first has its minimum beside it where
    /// the slope there says. With the curvature known one step leads there, however far the first one might go with the second free.
    #[test]
    fn beside_a_coordinate_on_its_bound_a_step_is_no_longer_than_the_valley_is_wide() {
        let hessian = DMatrix::from_row_slice(2, 2, &[200.0, 199.9, 199.9, 200.0]);
        let middle = DVector::from_vec(vec![-3.0, 3.0]);
        let valley = |x: &[f64]| {
            let off = DVector::from_column_slice(x) - &middle;
            plain(0.5 * off.dot(&(&hessian * &off)))
        };
        let problem = without_parts(&valley, &[(-10.0, 10.0), (-10.0, 0.0)]);
        // d/dx at y = 0: 200 (x + 3) - 199.9 * 3 = 0
        let there = 3.0 * 199.9 / 200.0 - 3.0;
        // The second coordinate presses on its bound at the first start, is drawn away from it by its slope at the next, and comes to it from
        // the last.
        for (first, second) in [(-0.05, 0.0), (0.05, 0.0), (0.2, -0.1)] {
            let expected = Some(hessian.clone());
            let found = minimise(&problem, &[first, second], expected, None, TO_THE_END);
            assert!(found.converged);
            let off = (found.point[0] - there).abs();
            assert!(off < 2.0 * STEP, "{first}: {:?}", found.point);
            assert_eq!(found.point[1], 0.0);
            // the start, its slope, the step, and at most one slope and step more
            assert!(found.evaluations <= 8, "{first}: {}", found.evaluations);
        }
    }
}
