//! Profile likelihood: how much the fit suffers when one parameter is held and all others follow.
//!
//! ```text
//! D(x) = |r(x, p(x))|^2 - |r(p_hat)|^2,   p(x) = argmin over the other parameters
//! ```
//!
//! An interval is {x : D(x) <= threshold}; with whitened residuals and a noise level that was itself estimated with nu degrees of
//! freedom the threshold is the squared t quantile ([`crate::criteria::t_quantile`]). The ends are found by
//! root finding on sqrt(D), which is a straight line where the model is linear, with every fit started from its
//! neighbour (Venzon and Moolgavkar 1988; Raue et al. 2009).

use crate::bounds::{Bounds, BoundsError, Side};
use crate::levenberg_marquardt::Options;
use crate::minimise::{Fit, Status, minimise};
use crate::residuals::Residuals;

/// How a profile is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileOptions {
    /// Interval: all x with D(x) <= threshold.
    pub threshold: f64,
    /// Relative resolution of an end, as a fraction of the half width.
    pub resolution: f64,
    /// Size of the first step where the covariance gives none.
    pub fallback_step: f64,
    /// Doublings of the distance before a side counts as open.
    pub doublings: u32,
    /// Options of the inner fits.
    pub inner: Options,
}

impl ProfileOptions {
    /// Usual options with a threshold and a first step for parameters without a standard deviation.
    pub fn new(threshold: f64, fallback_step: f64) -> Self {
        Self {
            threshold,
            resolution: 1e-3,
            fallback_step,
            doublings: 12,
            // The ends are wanted to a thousandth of the half width: D must be right to a hundredth, not to rounding.
            inner: Options {
                reduction_tolerance: 1e-8,
                ..Options::warm()
            },
        }
    }
}

/// One point of a profile.
#[derive(Clone, Debug)]
pub struct ProfilePoint {
    /// Value at which the parameter was held.
    pub value: f64,
    /// D there; infinite where the inner fit found no finite residuals.
    pub deviance: f64,
    /// All parameters there.
    pub parameters: Vec<f64>,
    /// Other parameters that met a bound there.
    pub at_bound: Vec<(usize, Side)>,
    /// How the inner fit ended.
    pub status: Status,
}

/// One end of an interval.
#[derive(Clone, Debug, PartialEq)]
pub enum Limit {
    /// The threshold is crossed here; `at_bound` names other parameters that lie on a bound there.
    Crossed {
        /// The end.
        value: f64,
        /// Other parameters that met a bound.
        at_bound: Vec<(usize, Side)>,
    },
    /// The parameter's own bound comes first: the interval is one-sided.
    OwnBound {
        /// The bound.
        value: f64,
    },
    /// The threshold is not reached as far as was looked: the data do not limit the parameter on this side.
    Open {
        /// How far was looked.
        reached: f64,
        /// Largest D met on the way.
        deviance: f64,
    },
}

impl Limit {
    /// The end as a number: the crossing, the bound, or an infinity of the sign of `side`.
    pub fn value(&self, side: Side) -> f64 {
        match self {
            Limit::Crossed { value, .. } | Limit::OwnBound { value } => *value,
            Limit::Open { .. } => match side {
                Side::Lower => f64::NEG_INFINITY,
                Side::Upper => f64::INFINITY,
            },
        }
    }
}

/// Interval and the points that were computed on the way to it.
#[derive(Clone, Debug)]
pub struct Profile {
    /// Which parameter.
    pub index: usize,
    /// Value of the best fit.
    pub best: f64,
    /// Lower end.
    pub lower: Limit,
    /// Upper end.
    pub upper: Limit,
    /// Points in order of value, the best fit among them.
    pub points: Vec<ProfilePoint>,
    /// A point with a lower cost than the fit that was handed in: that fit was no minimum, and the interval is void.
    pub better: Option<Vec<f64>>,
}

impl Profile {
    /// True when D stays below the threshold on both sides as far as was looked.
    pub fn is_flat(&self) -> bool {
        matches!(
            (&self.lower, &self.upper),
            (
                Limit::Open { .. } | Limit::OwnBound { .. },
                Limit::Open { .. } | Limit::OwnBound { .. }
            )
        )
    }
}

struct Profiler<'a, R: ?Sized> {
    problem: &'a R,
    fit: &'a Fit,
    index: usize,
    bounds: &'a Bounds,
    options: ProfileOptions,
    points: Vec<ProfilePoint>,
    work: u64,
}

impl<R: Residuals + ?Sized> Profiler<'_, R> {
    /// Inner fit at `value`, started from the two nearest points on the way (a secant), or from the covariance.
    fn at(&mut self, value: f64) -> Result<ProfilePoint, BoundsError> {
        let start = self.predict(value);
        let held = self.bounds.with_fixed(self.index, value);
        let inner = minimise(self.problem, &start, &held, &self.options.inner)?;
        self.work += inner.evaluations + inner.jacobians;
        let deviance = 2.0 * (inner.cost - self.fit.cost);
        let point = ProfilePoint {
            value,
            deviance: if deviance.is_finite() {
                deviance
            } else {
                f64::INFINITY
            },
            parameters: inner.parameters,
            at_bound: inner.at_bound,
            status: inner.status,
        };
        self.points.push(point.clone());
        Ok(point)
    }

    /// Where the others should be when this one is at `value`.
    fn predict(&self, value: f64) -> Vec<f64> {
        let mut near: Vec<&ProfilePoint> = self
            .points
            .iter()
            .filter(|p| p.status.converged())
            .collect();
        near.sort_by(|a, b| (a.value - value).abs().total_cmp(&(b.value - value).abs()));
        let mut start = match near.as_slice() {
            [a, b, ..] if a.value != b.value => {
                let t = (value - a.value) / (b.value - a.value);
                a.parameters
                    .iter()
                    .zip(&b.parameters)
                    .map(|(pa, pb)| pa + t * (pb - pa))
                    .collect()
            }
            _ => self.tangent(value),
        };
        start[self.index] = value;
        self.bounds.clamp(&start)
    }

    /// p_hat + C_:i / C_ii (value - p_hat_i): the direction in which the others follow in a linear model.
    fn tangent(&self, value: f64) -> Vec<f64> {
        let i = self.index;
        let best = &self.fit.parameters;
        match &self.fit.covariance {
            Some(c) if c[(i, i)] > 0.0 => best
                .iter()
                .enumerate()
                .map(|(j, p)| p + c[(j, i)] / c[(i, i)] * (value - best[i]))
                .collect(),
            _ => best.clone(),
        }
    }

    /// One end: widen until the threshold is bracketed, then Illinois false position on sqrt(D).
    fn end(&mut self, side: Side) -> Result<Limit, BoundsError> {
        let best = self.fit.parameters[self.index];
        let (sign, own_bound) = match side {
            Side::Lower => (-1.0, self.bounds.lower()[self.index]),
            Side::Upper => (1.0, self.bounds.upper()[self.index]),
        };
        let room = sign * (own_bound - best);
        if room <= 0.0 {
            return Ok(Limit::OwnBound { value: own_bound });
        }
        let target = self.options.threshold.sqrt();
        let first = match self.fit.standard_deviation(self.index) {
            Some(sd) if sd > 0.0 => sd * target,
            _ => self.options.fallback_step,
        };
        let mut distance = first.min(room);
        // Distances with sqrt(D) - target: `inside` is negative, `outside` positive.
        let mut inside = (0.0, -target);
        let mut highest = 0.0_f64;
        for _ in 0..=self.options.doublings {
            let point = self.at(self.place(best, sign, distance, room, own_bound))?;
            highest = highest.max(point.deviance);
            let excess = point.deviance.max(0.0).sqrt() - target;
            if excess >= 0.0 {
                return self.close_in(best, sign, inside, (distance, excess));
            }
            if distance >= room {
                return Ok(Limit::OwnBound { value: own_bound });
            }
            inside = (distance, excess);
            // sqrt(D) grows about linearly: aim a little beyond where it would cross, at most doubling.
            let slope = (excess + target) / distance;
            let aim = if slope > 0.0 {
                1.05 * target / slope
            } else {
                2.0 * distance
            };
            distance = aim.clamp(1.02 * distance, 2.0 * distance).min(room);
        }
        Ok(Limit::Open {
            reached: best + sign * inside.0,
            deviance: highest,
        })
    }

    fn place(&self, best: f64, sign: f64, distance: f64, room: f64, own_bound: f64) -> f64 {
        if distance >= room {
            own_bound
        } else {
            best + sign * distance
        }
    }

    /// Root of sqrt(D) - target between two distances.
    fn close_in(
        &mut self,
        best: f64,
        sign: f64,
        mut inside: (f64, f64),
        mut outside: (f64, f64),
    ) -> Result<Limit, BoundsError> {
        let target = self.options.threshold.sqrt();
        let tolerance = self.options.resolution * target;
        if outside.1 <= tolerance {
            return Ok(self.crossed(best + sign * outside.0));
        }
        for _ in 0..60 {
            let weight = if outside.1.is_finite() {
                inside.1 / (inside.1 - outside.1)
            } else {
                0.5
            };
            let distance = inside.0 + weight.clamp(0.01, 0.99) * (outside.0 - inside.0);
            let point = self.at(best + sign * distance)?;
            let excess = point.deviance.max(0.0).sqrt() - target;
            if excess.abs() <= tolerance
                || (outside.0 - inside.0) <= self.options.resolution * outside.0
            {
                return Ok(self.crossed(best + sign * distance));
            }
            // Illinois: halve the weight of the end that stays.
            if excess < 0.0 {
                inside = (distance, excess);
                outside.1 *= 0.5;
            } else {
                outside = (distance, excess);
                inside.1 *= 0.5;
            }
        }
        Ok(self.crossed(best + sign * outside.0))
    }

    fn crossed(&self, value: f64) -> Limit {
        let at_bound = self
            .points
            .iter()
            .find(|p| p.value == value)
            .map(|p| p.at_bound.clone())
            .unwrap_or_default();
        Limit::Crossed { value, at_bound }
    }

    fn finish(mut self, lower: Limit, upper: Limit) -> Profile {
        self.points.sort_by(|a, b| a.value.total_cmp(&b.value));
        // A fit is improved upon when D falls below what its own tolerance explains.
        let slack = 1e-6 * (1.0 + self.options.threshold);
        let better = self
            .points
            .iter()
            .filter(|p| p.deviance < -slack)
            .min_by(|a, b| a.deviance.total_cmp(&b.deviance))
            .map(|p| p.parameters.clone());
        Profile {
            index: self.index,
            best: self.fit.parameters[self.index],
            lower,
            upper,
            points: self.points,
            better,
        }
    }
}

fn profiler<'a, R: Residuals + ?Sized>(
    problem: &'a R,
    fit: &'a Fit,
    index: usize,
    bounds: &'a Bounds,
    options: &ProfileOptions,
) -> Profiler<'a, R> {
    let best = ProfilePoint {
        value: fit.parameters[index],
        deviance: 0.0,
        parameters: fit.parameters.clone(),
        at_bound: fit
            .at_bound
            .iter()
            .copied()
            .filter(|(j, _)| *j != index)
            .collect(),
        status: fit.status,
    };
    Profiler {
        problem,
        fit,
        index,
        bounds,
        options: *options,
        points: vec![best],
        work: 0,
    }
}

/// Interval of parameter `index` around a fit.
///
/// # Errors
/// When the lengths of fit and bounds differ.
pub fn profile<R: Residuals + ?Sized>(
    problem: &R,
    fit: &Fit,
    index: usize,
    bounds: &Bounds,
    options: &ProfileOptions,
) -> Result<Profile, BoundsError> {
    let mut profiler = profiler(problem, fit, index, bounds, options);
    let lower = profiler.end(Side::Lower)?;
    let upper = profiler.end(Side::Upper)?;
    Ok(profiler.finish(lower, upper))
}

/// The ends of the interval as numbers (open ends are infinite).
///
/// # Errors
/// When the lengths of fit and bounds differ.
pub fn profile_interval<R: Residuals + ?Sized>(
    problem: &R,
    fit: &Fit,
    index: usize,
    bounds: &Bounds,
    options: &ProfileOptions,
) -> Result<(f64, f64), BoundsError> {
    let profile = profile(problem, fit, index, bounds, options)?;
    Ok((
        profile.lower.value(Side::Lower),
        profile.upper.value(Side::Upper),
    ))
}

/// The profile at given values (for a figure), computed outwards from the best fit so that every fit starts from its
/// neighbour; points come back in order of value.
///
/// # Errors
/// When the lengths of fit and bounds differ.
pub fn profile_curve<R: Residuals + ?Sized>(
    problem: &R,
    fit: &Fit,
    index: usize,
    bounds: &Bounds,
    values: &[f64],
    options: &ProfileOptions,
) -> Result<Vec<ProfilePoint>, BoundsError> {
    let best = fit.parameters[index];
    let mut order: Vec<f64> = values
        .iter()
        .copied()
        .filter(|v| *v >= bounds.lower()[index] && *v <= bounds.upper()[index])
        .collect();
    order.sort_by(|a, b| (a - best).abs().total_cmp(&(b - best).abs()));
    let mut profiler = profiler(problem, fit, index, bounds, options);
    for value in order {
        profiler.at(value)?;
    }
    profiler.points.sort_by(|a, b| a.value.total_cmp(&b.value));
    Ok(profiler.points)
}
