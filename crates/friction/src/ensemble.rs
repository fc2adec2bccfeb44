//! The picture from which the averaged law came: many leaning bristles, each held by an asperity until it lets go.
//!
//! Bristle i has rotation theta_i about its root, lean theta0 and gap h. While held, its tip moves with the substrate,
//! y = h tan(theta + theta0) (E2), and it carries (k/h) theta cos^2(theta + theta0) (E1). It lets go at a rotation of
//! theta_i = +-limit_i, swings back to theta = 0 and is held by the next asperity, with a new random limit. The force is
//! the mean over all bristles,
//!
//! ```text
//! mu = sigma0 mean_i theta_i cos^2(theta_i + theta0),    sigma0 = k/(N h)
//! ```
//!
//! After Haessig and Friedland (J. Dynamic Systems, Measurement, and Control 113, 1991), with rotation in the place of
//! displacement and frictionless asperities. Limits are uniform in [low, high]. Motion is followed exactly from event
//! to event, so the result depends on displacement only, not on how it is cut into steps. Randomness comes from the
//! generator that is passed in.

/// Why an ensemble cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EnsembleError {
    /// A setting that makes no sense.
    #[error("bristle ensemble: {0}")]
    Setting(&'static str),
}

/// Many leaning bristles.
#[derive(Clone, Debug, PartialEq)]
pub struct Ensemble {
    height_m: f64,
    lean_rad: f64,
    stiffness: f64,
    limits_rad: [f64; 2],
    bristles: Vec<Bristle>,
}

/// One bristle: displacement of its tip since theta = 0, and the rotation at which it lets go.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bristle {
    tip_m: f64,
    limit_rad: f64,
}

impl Ensemble {
    /// `count` bristles at rest with gap h (m), lean theta0 (rad), sigma0 (1/rad) and limits uniform in
    /// `limits_rad`; `uniform` yields numbers in [0, 1).
    ///
    /// # Errors
    /// No bristles, a gap or limits that are not positive, or a limit at which a bristle would lie flat.
    pub fn new(
        count: usize,
        height_m: f64,
        lean_rad: f64,
        stiffness: f64,
        limits_rad: [f64; 2],
        uniform: &mut impl FnMut() -> f64,
    ) -> Result<Self, EnsembleError> {
        let [low, high] = limits_rad;
        if count == 0 || !(height_m > 0.0 && height_m.is_finite()) {
            return Err(EnsembleError::Setting("needs bristles and a positive gap"));
        }
        if !(low > 0.0 && low <= high) {
            return Err(EnsembleError::Setting(
                "limits must be positive, the smaller first",
            ));
        }
        if high + lean_rad.abs() >= std::f64::consts::FRAC_PI_2 {
            return Err(EnsembleError::Setting(
                "a bristle would lie flat before it lets go",
            ));
        }
        let bristles = (0..count)
            .map(|_| Bristle {
                tip_m: 0.0,
                limit_rad: low + (high - low) * uniform(),
            })
            .collect();
        Ok(Self {
            height_m,
            lean_rad,
            stiffness,
            limits_rad,
            bristles,
        })
    }

    /// Displacement of a tip at which its bristle has turned by `rotation`.
    fn tip(&self, rotation: f64) -> f64 {
        // E2: y = h tan(theta + theta0), counted from theta = 0
        self.height_m * ((rotation + self.lean_rad).tan() - self.lean_rad.tan())
    }

    fn rotation(&self, tip_m: f64) -> f64 {
        (tip_m / self.height_m + self.lean_rad.tan()).atan() - self.lean_rad
    }

    /// Moves the substrate by `displacement_m` (signed) and returns mu.
    pub fn slide(&mut self, displacement_m: f64, uniform: &mut impl FnMut() -> f64) -> f64 {
        let sign = if displacement_m < 0.0 { -1.0 } else { 1.0 };
        let [low, high] = self.limits_rad;
        for i in 0..self.bristles.len() {
            let mut left = displacement_m;
            loop {
                let Bristle { tip_m, limit_rad } = self.bristles[i];
                let reach = self.tip(sign * limit_rad) - tip_m;
                if left * sign < reach * sign {
                    self.bristles[i].tip_m = tip_m + left;
                    break;
                }
                left -= reach;
                self.bristles[i] = Bristle {
                    tip_m: 0.0,
                    limit_rad: low + (high - low) * uniform(),
                };
            }
        }
        self.coefficient()
    }

    /// Mean rotation, rad.
    pub fn mean_rotation(&self) -> f64 {
        self.bristles
            .iter()
            .map(|b| self.rotation(b.tip_m))
            .sum::<f64>()
            / self.bristles.len() as f64
    }

    /// mu as it stands.
    pub fn coefficient(&self) -> f64 {
        // E1, E6: mu = sigma0 mean theta cos^2(theta + theta0)
        let sum: f64 = self
            .bristles
            .iter()
            .map(|b| {
                let theta = self.rotation(b.tip_m);
                theta * (theta + self.lean_rad).cos().powi(2)
            })
            .sum();
        self.stiffness * sum / self.bristles.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEIGHT: f64 = 7e-3;

    /// The golden-ratio sequence: evenly spread, no generator needed.
    fn spread() -> impl FnMut() -> f64 {
        let mut x = 0.5;
        move || {
            x = (x + 0.618_033_988_749_895_f64) % 1.0;
            x
        }
    }

    #[test]
    fn all_bristles_move_alike_until_the_first_lets_go() {
        let mut uniform = spread();
        let mut e =
            Ensemble::new(50, HEIGHT, -0.3, 1.5, [0.5, 0.7], &mut uniform).expect("sensible");
        let rotation = 0.4_f64;
        let mu = e.slide(e.tip(rotation), &mut uniform);
        assert!((mu - 1.5 * rotation * (rotation - 0.3).cos().powi(2)).abs() < 1e-12);
        assert!((e.mean_rotation() - rotation).abs() < 1e-12);
    }

    #[test]
    fn long_sliding_reaches_the_mean_over_one_hold() {
        // one limit L: tips are uniform in [0, y_L], so mean mu = sigma0/y_L integral theta cos^2 dy = sigma0 h L^2/(2 y_L)
        let limit = 0.6_f64;
        for (lean, sign) in [(-0.3, 1.0), (-0.3, -1.0), (0.0, 1.0)] {
            let mut uniform = spread();
            let mut e = Ensemble::new(1, HEIGHT, lean, 1.5, [limit, limit], &mut uniform)
                .expect("sensible");
            let hold = e.tip(sign * limit).abs();
            let n = 20_000;
            let mean = (0..n)
                .map(|_| e.slide(sign * 7.0 * hold / f64::from(n), &mut uniform))
                .sum::<f64>()
                / f64::from(n);
            let exact = sign * 1.5 * HEIGHT * limit * limit / (2.0 * hold);
            assert!((mean - exact).abs() < 2e-3, "lean {lean}: {mean} {exact}");
        }
    }

    #[test]
    fn friction_depends_on_direction_through_the_lean_alone() {
        let steady = |lean: f64, sign: f64| {
            let mut uniform = spread();
            let mut e =
                Ensemble::new(4000, HEIGHT, lean, 1.5, [0.3, 0.9], &mut uniform).expect("sensible");
            (0..40)
                .map(|_| e.slide(sign * 1e-3, &mut uniform))
                .skip(20)
                .sum::<f64>()
                / 20.0
        };
        assert!((steady(0.0, 1.0) + steady(0.0, -1.0)).abs() < 1e-12);
        assert!(steady(-0.3, 1.0) > -1.5 * steady(-0.3, -1.0));
        assert!((steady(-0.3, 1.0) + steady(0.3, -1.0)).abs() < 1e-12);
    }

    #[test]
    fn how_a_displacement_is_cut_does_not_matter() {
        let once = |parts: u32| {
            let mut uniform = spread();
            // one limit, so that the order in which limits are drawn cannot matter
            let mut e =
                Ensemble::new(3, HEIGHT, -0.3, 1.5, [0.6, 0.6], &mut uniform).expect("sensible");
            (0..parts)
                .map(|_| e.slide(0.05 / f64::from(parts), &mut uniform))
                .last()
                .expect("parts")
        };
        assert!((once(1) - once(64)).abs() < 1e-9);
    }

    #[test]
    fn senseless_settings_are_refused() {
        let mut u = spread();
        assert!(Ensemble::new(0, HEIGHT, 0.0, 1.0, [0.1, 0.2], &mut u).is_err());
        assert!(Ensemble::new(5, HEIGHT, 1.0, 1.0, [0.1, 0.8], &mut u).is_err());
        assert!(Ensemble::new(5, HEIGHT, 0.0, 1.0, [0.3, 0.2], &mut u).is_err());
    }
}
