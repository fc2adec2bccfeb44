//! Derivatives of a prediction: dual numbers, some columns at a time.
//!
//! Columns that leave the state of the contact alone (a factor on friction, a change of the record) are taken together
//! without integrating in dual numbers; initial states share one lane, since each belongs to one run.

use nalgebra::DMatrix;
use num_dual::DualSVec64;

use crate::chain::Pass;
use crate::contact::{Paths, Walks};
use crate::{ChainScalar, Experiment, Model, Reach};

/// What one lane of a dual number stands for.
#[derive(Clone, Copy, Debug)]
enum Lane {
    /// One parameter.
    One(usize),
    /// The initial state of whichever run is looked at.
    OwnInitialState,
}

pub(crate) fn columns(
    model: &Model,
    experiment: &Experiment,
    parameters: &[f64],
    columns: &[usize],
    walks: &Walks<'_>,
) -> DMatrix<f64> {
    let mut jacobian = DMatrix::zeros(experiment.samples(), columns.len());
    let initial = model.initial_states();
    let remembers = model.effects.iter().any(|cause| cause.memory() > 0);
    let (mut state, mut record) = (Vec::new(), Vec::new());
    let mut shared = false;
    for &column in columns {
        assert!(
            column < parameters.len(),
            "column {column} is beyond the parameters"
        );
        if initial.contains(&column) && !remembers {
            shared = true;
        } else if moves_the_state(model, parameters, column) {
            state.push(Lane::One(column));
        } else {
            record.push(Lane::One(column));
        }
    }
    if shared {
        state.push(Lane::OwnInitialState);
    }
    let task = Task {
        model,
        experiment,
        parameters,
        columns,
        walks,
    };
    for (lanes, state_varies) in [(state, true), (record, false)] {
        let mut rest = lanes.as_slice();
        while !rest.is_empty() {
            let taken = match rest.len() {
                1 => task.chunk::<1>(rest, state_varies, &mut jacobian),
                2..=4 => task.chunk::<4>(rest, state_varies, &mut jacobian),
                5..=8 => task.chunk::<8>(rest, state_varies, &mut jacobian),
                _ => task.chunk::<12>(rest, state_varies, &mut jacobian),
            };
            rest = &rest[taken..];
        }
    }
    jacobian
}

/// Friction in the record: d F / d ln g for a factor g on the friction that leaves the contact, N (rotary N m). Inertia, offsets
/// and weights do not follow friction and have no part in it; a lag or a gain of the sensor has.
pub(crate) fn friction(
    model: &Model,
    experiment: &Experiment,
    parameters: &[f64],
    paths: &Paths,
) -> Vec<f64> {
    type Dual = DualSVec64<1>;
    let constant: Vec<Dual> = parameters.iter().map(|&p| Dual::from_re(p)).collect();
    let record = Pass {
        model,
        experiment,
        parameters: &constant,
        active: model.off_null(parameters),
        state_varies: false,
        gain: Some(Dual::from_re(1.0).derivative(0)),
        walks: &Walks::forgotten(paths),
    }
    .predict();
    let of = |f: &Dual| match &f.eps.0 {
        Some(eps) => eps[0],
        None if f.re.is_nan() => f64::NAN,
        None => 0.0,
    };
    record.iter().map(of).collect()
}

/// Whether a parameter reaches the integration of the contact.
fn moves_the_state(model: &Model, parameters: &[f64], column: usize) -> bool {
    let effect = (0..model.effects.len()).find(|&i| model.span(i).contains(&column));
    let Some(effect) = effect else { return true };
    let reach = model.effects[effect].reach();
    if reach.moves_the_state() {
        return true;
    }
    // on a cord a factor on friction moves the slip
    let corded = model
        .off_null(parameters)
        .iter()
        .zip(&model.effects)
        .any(|(&active, cause)| active && cause.reach() == Reach::Coupling);
    reach == Reach::Factor && corded
}

struct Task<'a> {
    model: &'a Model,
    experiment: &'a Experiment,
    parameters: &'a [f64],
    columns: &'a [usize],
    walks: &'a Walks<'a>,
}

impl Task<'_> {
    /// Up to N lanes at once; how many were taken.
    fn chunk<const N: usize>(
        &self,
        lanes: &[Lane],
        state_varies: bool,
        jacobian: &mut DMatrix<f64>,
    ) -> usize
    where
        DualSVec64<N>: ChainScalar,
    {
        let lanes = &lanes[..lanes.len().min(N)];
        let model = self.model;
        let mut seeded: Vec<DualSVec64<N>> = self
            .parameters
            .iter()
            .map(|&p| DualSVec64::from_re(p))
            .collect();
        let mut active = model.off_null(self.parameters);
        for (k, lane) in lanes.iter().enumerate() {
            match *lane {
                Lane::One(column) => {
                    seeded[column] = DualSVec64::from_re(self.parameters[column]).derivative(k);
                    if let Some(i) =
                        (0..model.effects.len()).find(|&i| model.span(i).contains(&column))
                    {
                        active[i] = true;
                    }
                }
                Lane::OwnInitialState => {
                    for column in model.initial_states() {
                        seeded[column] = DualSVec64::from_re(self.parameters[column]).derivative(k);
                    }
                }
            }
        }
        let pass = Pass {
            model,
            experiment: self.experiment,
            parameters: &seeded,
            active,
            state_varies,
            gain: None,
            walks: self.walks,
        };
        let record = pass.predict();
        for (j, &column) in self.columns.iter().enumerate() {
            for (k, lane) in lanes.iter().enumerate() {
                match *lane {
                    Lane::One(own) if own == column => {
                        self.fill(&record, k, 0..record.len(), j, jacobian)
                    }
                    Lane::OwnInitialState if model.initial_states().contains(&column) => {
                        for (index, run) in self.experiment.runs.iter().enumerate() {
                            if model.initial_state_of(index) == Some(column) {
                                self.fill(&record, k, run.samples.clone(), j, jacobian);
                            }
                        }
                    }
                    _ => {}
                }
            }
        }
        lanes.len()
    }

    fn fill<const N: usize>(
        &self,
        record: &[DualSVec64<N>],
        lane: usize,
        samples: std::ops::Range<usize>,
        column: usize,
        jacobian: &mut DMatrix<f64>,
    ) {
        for i in samples {
            jacobian[(i, column)] = match &record[i].eps.0 {
                Some(eps) => eps[lane],
                // a run that could not be carried through has no derivative either
                None if record[i].re.is_nan() => f64::NAN,
                None => 0.0,
            };
        }
    }
}
