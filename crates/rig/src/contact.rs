//! The contact of the rigid chain: coefficient of friction at the samples of a run, from paths that are walked once.
//!
//! Derivatives come in several passes over the same motions: some columns at a time, and once for what leaves the state alone. The
//! state's path is the same in all of them, unless an effect at its null takes part for its derivatives and asks for other knots.

use std::sync::{Arc, Mutex, PoisonError};

use friction::{IntegrationError, Law, Path, Record, Scalar, integrate};

/// Relative difference of numbers that are equal but for rounding: a quotient in dual numbers is the product with an inverse.
const ROUNDING: f64 = 1e-13;

/// Paths of the contact's state along the runs of a campaign, walked by one prediction, for others beside it: a cause that only
/// changes what happens to friction afterwards leaves the state where it was. A path serves the law, motion and first state
/// that it was walked for and no other, so predictions are the same whatever paths are offered to them.
#[derive(Clone, Default)]
pub struct Paths(Vec<Option<Arc<Walked>>>);

/// The paths of a pass: those that are known, and those that it walks, kept for the passes that follow it (each in its own place, so that runs
/// may be walked side by side) or forgotten.
pub(crate) struct Walks<'a> {
    known: &'a Paths,
    own: Option<Vec<Mutex<Option<Arc<Walked>>>>>,
}

/// A path with what it was walked for.
struct Walked {
    law: Law<f64>,
    initial: f64,
    knots: Vec<usize>,
    velocity: Vec<f64>,
    curve_speed: Option<Vec<f64>>,
    viscous_speed: Option<Vec<f64>>,
    rest_gain: Option<Vec<f64>>,
    path: Path,
    coefficients: Vec<f64>,
}

impl Paths {
    /// No paths.
    pub const NONE: &'static Self = &Self(Vec::new());

    fn of(&self, run: usize) -> Option<&Arc<Walked>> {
        self.0.get(run)?.as_ref()
    }
}

impl<'a> Walks<'a> {
    pub(crate) fn kept(known: &'a Paths, places: usize) -> Self {
        let own = Some((0..places).map(|_| Mutex::default()).collect());
        Self { known, own }
    }

    pub(crate) fn forgotten(known: &'a Paths) -> Self {
        Self { known, own: None }
    }

    /// All paths that were walked or served.
    pub(crate) fn into_paths(self) -> Paths {
        let walked = self.own.into_iter().flatten();
        let inner = |place: Mutex<_>| place.into_inner().unwrap_or_else(PoisonError::into_inner);
        Paths(walked.map(inner).collect())
    }

    /// Coefficient of friction at the samples of a run, with derivatives if `varies` and paths are kept.
    pub(crate) fn coefficients<D: Scalar>(
        &self,
        run: usize,
        law: &Law<D>,
        record: &Record<'_, D>,
        initial: D,
        varies: bool,
    ) -> Result<Vec<D>, IntegrationError> {
        let reals = record.real();
        let (real, motion) = (law.real(), reals.record());
        let start = initial.value();
        let constant = |values: &[f64]| values.iter().copied().map(D::constant).collect();
        let fits = |walked: &&Arc<Walked>| walked.is_for(&real, &motion, start);
        let Some(own) = &self.own else {
            if let Some(walked) = self.known.of(run).filter(fits) {
                return Ok(constant(&walked.coefficients));
            }
            let states = integrate(&real, &motion, start)?;
            return Ok(constant(&real.coefficients(&motion, &states)));
        };
        let place = || own[run].lock().unwrap_or_else(PoisonError::into_inner);
        let last = place().clone();
        let walked = match last
            .as_ref()
            .filter(fits)
            .or(self.known.of(run).filter(fits))
        {
            Some(walked) => Arc::clone(walked),
            None => Arc::new(Walked::new(real, &motion, start)?),
        };
        *place() = Some(Arc::clone(&walked));
        if D::NDERIV == 0 || !varies {
            return Ok(constant(&walked.coefficients));
        }
        let states = walked.path.lift(law, record, initial)?;
        Ok(law.coefficients(record, &states))
    }
}

impl Walked {
    fn new(
        law: Law<f64>,
        record: &Record<'_, f64>,
        initial: f64,
    ) -> Result<Self, IntegrationError> {
        let path = Path::along(&law, record, initial)?;
        Ok(Self {
            coefficients: law.coefficients(record, path.states()),
            law,
            initial,
            knots: record.knots.to_vec(),
            velocity: record.velocity.to_vec(),
            curve_speed: record.curve_speed.map(<[f64]>::to_vec),
            viscous_speed: record.viscous_speed.map(<[f64]>::to_vec),
            rest_gain: record.rest_gain.map(<[f64]>::to_vec),
            path,
        })
    }

    fn is_for(&self, law: &Law<f64>, record: &Record<'_, f64>, initial: f64) -> bool {
        self.initial == initial
            && self.law.is_but_for_rounding(law, ROUNDING)
            && self.knots == record.knots
            && same(&self.velocity, record.velocity)
            && same_or_none(self.curve_speed.as_deref(), record.curve_speed)
            && same_or_none(self.viscous_speed.as_deref(), record.viscous_speed)
            && same_or_none(self.rest_gain.as_deref(), record.rest_gain)
    }
}

fn same_or_none(ours: Option<&[f64]>, theirs: Option<&[f64]>) -> bool {
    match (ours, theirs) {
        (Some(ours), Some(theirs)) => same(ours, theirs),
        (None, None) => true,
        _ => false,
    }
}

fn same(ours: &[f64], theirs: &[f64]) -> bool {
    let close = |(a, b): (&f64, &f64)| (a - b).abs() <= ROUNDING * a.abs();
    ours.len() == theirs.len() && ours.iter().zip(theirs).all(close)
}

#[cfg(test)]
mod tests {
    use friction::{LawKind, Record};

    use super::Walked;

    /// A kept path serves the same law and motion but for rounding, and no other.
    #[test]
    fn a_path_serves_only_what_it_was_walked_for() {
        let build = |p: &[f64; 7]| {
            LawKind::AsymmetricBristle
                .build(p, Some(7e-3))
                .expect("complete")
        };
        let parameters = [0.5, 0.62, 1.5, 0.1, 0.01, 1.5, -0.3];
        let time: Vec<f64> = (0..50).map(|i| f64::from(i) / 60.0).collect();
        let velocity: Vec<f64> = time.iter().map(|t| 0.006 * t).collect();
        let record = |velocity, curve_speed, knots| Record {
            curve_speed,
            ..Record::of_slip(&time, velocity, knots)
        };
        let ends = [0, 49];
        let asked = record(velocity.as_slice(), None, &ends[..]);
        let walked = Walked::new(build(&parameters), &asked, 0.0).expect("finite");
        assert!(walked.is_for(&build(&parameters), &asked, 0.0));
        for k in 0..parameters.len() {
            let mut moved = parameters;
            moved[k] *= 1.0 + 1e-15;
            assert!(walked.is_for(&build(&moved), &asked, 0.0), "{k}");
            moved[k] *= 1.0 + 1e-9;
            assert!(!walked.is_for(&build(&moved), &asked, 0.0), "{k}");
        }
        let law = build(&parameters);
        let faster: Vec<f64> = velocity.iter().map(|v| v * (1.0 + 1e-9)).collect();
        assert!(!walked.is_for(&law, &asked, 1e-9));
        assert!(!walked.is_for(&law, &record(&faster, None, &ends[..]), 0.0));
        let read = Some(velocity.as_slice());
        assert!(!walked.is_for(&law, &record(&velocity, read, &ends[..]), 0.0));
        assert!(!walked.is_for(&law, &record(&velocity, None, &[0, 20, 49][..]), 0.0));
    }
}
