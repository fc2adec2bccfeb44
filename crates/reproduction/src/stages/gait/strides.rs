//! The strides of the stage: which problems are solved, and from where.

use biped::contact::{Brush, Ground};
use biped::gait::chain::{Case, Outcome, solve_all};
use biped::gait::layout::Layout;
use biped::gait::{Contact, Goal, Limits, Mesh, Problem, Touchdown};
use biped::parameters::Biped;
use serde::Deserialize;
use trajectory::Options;

use crate::stage::StageError;

/// Speed weights of Fig. 12.
pub(super) const WEIGHTS: [f64; 7] = [0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0];
/// Weight of the map and of the strides at the lower target.
pub(super) const MAP_WEIGHT: f64 = 1.0;
/// Stiffness, N/m^1.5, and loss, s/m, of the compliant contact of the sweep.
pub(super) const CONTACT: (f64, f64) = (2e5, 1.0);
/// Speed over which friction changes its sign, m/s.
const SLIP_SCALE_M_S: f64 = 0.1;
/// Weight of the mean squared joint rates, s^2.
const RATE_WEIGHT_S2: f64 = 1e-6;
/// Steps that a solve may take from a start that is already near.
const MAX_ITERATIONS: usize = 30;

/// How the brush is mounted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Mount {
    /// The mean coefficient both ways.
    Symmetric,
    /// The larger coefficient drives forward.
    Asymmetric,
    /// The larger coefficient brakes.
    Backwards,
}

impl Mount {
    /// All three, in the order of tables and legends.
    pub(super) const ALL: [Mount; 3] = [Mount::Symmetric, Mount::Asymmetric, Mount::Backwards];

    /// The word in value ids.
    pub(super) fn id(self) -> &'static str {
        match self {
            Mount::Symmetric => "symmetric",
            Mount::Asymmetric => "asymmetric",
            Mount::Backwards => "backwards",
        }
    }

    fn brush(self, brush: Brush) -> Brush {
        match self {
            Mount::Symmetric => brush.symmetric(),
            Mount::Asymmetric => brush,
            Mount::Backwards => brush.backwards(),
        }
    }
}

/// Contact of a stride as the file of starts names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Kind {
    /// Rigid foot with impact.
    Rigid,
    /// Hertz with loss.
    Compliant,
}

/// One start: a problem and a vector of its variables.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct Start {
    pub(super) kind: Kind,
    /// Stiffness, N/m^1.5 (0 if rigid).
    pub(super) k: f64,
    /// Loss, s/m (0 if rigid).
    pub(super) c: f64,
    pub(super) brush: Mount,
    pub(super) weight: f64,
    pub(super) aim: f64,
    x: Vec<f64>,
}

#[derive(Deserialize)]
struct File {
    starts: Vec<Start>,
}

/// A solved stride with the name of its problem.
#[derive(Clone, Debug)]
pub(super) struct Solved {
    pub(super) start: Start,
    pub(super) outcome: Outcome,
}

impl Solved {
    /// Whether it belongs to this contact, brush, weight and target.
    pub(super) fn is(
        &self,
        kind: Kind,
        contact: (f64, f64),
        brush: Mount,
        weight: f64,
        aim: f64,
    ) -> bool {
        let s = &self.start;
        let same_contact = kind == Kind::Rigid || (s.k, s.c) == contact;
        s.kind == kind && same_contact && s.brush == brush && s.weight == weight && s.aim == aim
    }
}

/// The shipped starts.
const STARTS: &str = include_str!("../../../../../data/strides.json");

/// The problem that a start belongs to.
fn problem(biped: &Biped, brush: Brush, start: &Start) -> Problem {
    let contact = match start.kind {
        Kind::Rigid => Contact::Rigid(Touchdown::Impact),
        Kind::Compliant => Contact::Compliant(Ground {
            stiffness_n_m15: start.k,
            loss_s_m: start.c,
            slip_scale_m_s: SLIP_SCALE_M_S,
        }),
    };
    Problem {
        biped: *biped,
        brush: start.brush.brush(brush),
        contact,
        goal: Goal::Speed {
            weight: start.weight,
            aim_m_s: start.aim,
        },
        limits: Limits::default(),
        mesh: Mesh::default(),
        rate_weight_s2: RATE_WEIGHT_S2,
    }
}

fn options() -> Options {
    Options {
        max_iterations: MAX_ITERATIONS,
        ..Options::default()
    }
}

/// Solves every problem of the file that `wanted` takes, each from its start.
pub(super) fn solve(
    biped: &Biped,
    brush: Brush,
    wanted: impl Fn(&Start) -> bool,
) -> Result<Vec<Solved>, StageError> {
    let file: File = serde_json::from_str(STARTS)
        .map_err(|error| StageError::Failed(format!("data/strides.json: {error}")))?;
    let starts: Vec<Start> = file
        .starts
        .into_iter()
        .filter(|start| wanted(start))
        .collect();
    let cases: Vec<Case> = starts
        .iter()
        .map(|start| Case {
            problem: problem(biped, brush, start),
            starts: vec![start.x.clone()],
        })
        .collect();
    let outcomes =
        solve_all(&cases, &options()).map_err(|error| StageError::Failed(error.to_string()))?;
    Ok(starts
        .into_iter()
        .zip(outcomes)
        .map(|(start, outcome)| Solved { start, outcome })
        .collect())
}

/// Accelerating strides: periodic but for the forward speed, from the periodic stride of the same brush.
pub(super) fn accelerate(periodic: &[&Solved], start_m_s: f64) -> Result<Vec<Solved>, StageError> {
    let cases: Vec<Case> = periodic
        .iter()
        .map(|solved| {
            let goal = Goal::Acceleration {
                weight: 1.0,
                start_m_s,
            };
            let problem = Problem {
                goal,
                ..solved.outcome.problem
            };
            let mut x = solved.outcome.x.clone();
            x.resize(Layout::new(&problem).count(), 0.0);
            Case {
                problem,
                starts: vec![x],
            }
        })
        .collect();
    let options = Options {
        max_iterations: 2 * MAX_ITERATIONS,
        ..options()
    };
    let outcomes =
        solve_all(&cases, &options).map_err(|error| StageError::Failed(error.to_string()))?;
    Ok(periodic
        .iter()
        .zip(outcomes)
        .map(|(solved, outcome)| Solved {
            start: solved.start.clone(),
            outcome,
        })
        .collect())
}
