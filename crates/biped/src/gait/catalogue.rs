//! Named gait problems: what the paper fixes (targets, weights, brushes) and what it leaves open.
//!
//! The paper publishes neither contact nor limits. A name says which choice of these a stride belongs to; two names
//! that differ in one choice are neighbours, and a stride of the one is a start for the other.

use super::{Contact, Goal, Limits, Mesh, Problem, Touchdown};
use crate::contact::{Brush, Ground};
use crate::parameters::Biped;
use serde::{Deserialize, Serialize};

/// Speed weights of Fig. 12, s^2/m^2.
pub const WEIGHTS: [f64; 7] = [0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0];
/// Weight of the map and of the strides at the lower target, s^2/m^2.
pub const MAP_WEIGHT: f64 = 1.0;
/// Weights at which strides are solved on the halved mesh as well, s^2/m^2.
pub const FINE_WEIGHTS: [f64; 3] = [0.01, 0.1, 1.0];
/// Stiffnesses of the map, N/m^1.5.
pub const STIFFNESSES: [f64; 4] = [5e4, 1e5, 2e5, 4e5];
/// Losses of the map, s/m.
pub const LOSSES: [f64; 4] = [0.3, 1.0, 2.0, 3.0];
/// Stiffness, N/m^1.5, and loss, s/m, of the compliant contact of the sweep.
pub const CONTACT: (f64, f64) = (2e5, 1.0);
/// Speed over which friction changes its sign, m/s.
const SLIP_SCALE_M_S: f64 = 0.1;
/// Weight of the mean squared joint rates, s^2.
const RATE_WEIGHT_S2: f64 = 1e-6;

/// How the brush is mounted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mount {
    /// The mean coefficient both ways.
    Symmetric,
    /// The larger coefficient drives forward.
    Asymmetric,
    /// The larger coefficient brakes.
    Backwards,
}

impl Mount {
    /// All three, in the order of tables and legends.
    pub const ALL: [Mount; 3] = [Mount::Symmetric, Mount::Asymmetric, Mount::Backwards];

    /// The word in names.
    pub fn id(self) -> &'static str {
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

/// Kind of contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Rigid foot with impact.
    Rigid,
    /// Hertz with loss.
    Compliant,
}

/// One deviation from the project's own choices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Choice {
    /// None.
    #[default]
    Own,
    /// No stance longer than 60 ms.
    ShortStance,
    /// Stances up to 150 ms, on intervals that are as much longer.
    LongStance,
    /// Joint rates up to 40 rad/s.
    SlowJoints,
    /// Hips from -80 to 40 degrees.
    NarrowHips,
    /// Friction changes its sign over 0.03 m/s.
    SharpFriction,
    /// Friction changes its sign over 0.3 m/s.
    BluntFriction,
    /// A foot that sinks in 20 mm at most.
    ShallowFoot,
    /// Every interval of the collocation halved: no choice of a machine, but what the mesh does to the numbers.
    FineMesh,
}

impl Choice {
    /// All deviations that change the machine, its contact or its limits.
    pub const ALL: [Choice; 7] = [
        Choice::ShortStance,
        Choice::LongStance,
        Choice::SlowJoints,
        Choice::NarrowHips,
        Choice::SharpFriction,
        Choice::BluntFriction,
        Choice::ShallowFoot,
    ];

    /// The word in names.
    pub fn id(self) -> &'static str {
        match self {
            Choice::Own => "own",
            Choice::ShortStance => "short-stance",
            Choice::LongStance => "long-stance",
            Choice::SlowJoints => "slow-joints",
            Choice::NarrowHips => "narrow-hips",
            Choice::SharpFriction => "sharp-friction",
            Choice::BluntFriction => "blunt-friction",
            Choice::ShallowFoot => "shallow-foot",
            Choice::FineMesh => "fine-mesh",
        }
    }

    fn slip_scale_m_s(self) -> f64 {
        match self {
            Choice::SharpFriction => 0.03,
            Choice::BluntFriction => 0.3,
            _ => SLIP_SCALE_M_S,
        }
    }

    fn limits(self) -> Limits {
        let own = Limits::default();
        match self {
            Choice::ShortStance => Limits {
                longest_stance_s: 0.06,
                ..own
            },
            Choice::LongStance => Limits {
                longest_stance_s: 0.15,
                ..own
            },
            Choice::SlowJoints => Limits {
                joint_rate_rad_s: 40.0,
                ..own
            },
            Choice::NarrowHips => Limits {
                hip_rad: [-80.0_f64, 40.0].map(f64::to_radians),
                ..own
            },
            Choice::ShallowFoot => Limits {
                foot_depth_m: 0.02,
                ..own
            },
            Choice::Own | Choice::SharpFriction | Choice::BluntFriction | Choice::FineMesh => own,
        }
    }
}

/// The name of a problem.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize, Deserialize)]
pub struct Name {
    /// Kind of contact.
    pub kind: Kind,
    /// Stiffness, N/m^1.5 (0 if rigid).
    pub k: f64,
    /// Loss, s/m (0 if rigid).
    pub c: f64,
    /// Mounting of the brush.
    pub brush: Mount,
    /// Speed weight, s^2/m^2.
    pub weight: f64,
    /// Speed aimed at, m/s.
    pub aim: f64,
    /// Deviation from the project's own choices.
    #[serde(default)]
    pub choice: Choice,
}

impl Name {
    /// A stride on a compliant contact (stiffness, loss) with the project's own choices.
    pub fn compliant((k, c): (f64, f64), brush: Mount, weight: f64, aim: f64) -> Self {
        Self {
            kind: Kind::Compliant,
            k,
            c,
            brush,
            weight,
            aim,
            choice: Choice::Own,
        }
    }

    /// A stride on a rigid contact with the project's own choices.
    pub fn rigid(brush: Mount, weight: f64, aim: f64) -> Self {
        Self {
            kind: Kind::Rigid,
            ..Self::compliant((0.0, 0.0), brush, weight, aim)
        }
    }

    /// The same with another choice.
    #[must_use]
    pub fn with_choice(self, choice: Choice) -> Self {
        Self { choice, ..self }
    }

    /// The mesh of its strides. A compliant foot strikes within some 3 ms, which must not fall between two points.
    fn mesh(&self) -> Mesh {
        let own = match self.kind {
            Kind::Rigid => Mesh::default(),
            Kind::Compliant => Mesh::for_strikes(28, 8),
        };
        let halved = if self.choice == Choice::FineMesh {
            2
        } else {
            1
        };
        own.times(halved)
    }

    /// The contact of this name.
    pub(super) fn contact(&self) -> Contact {
        match self.kind {
            Kind::Rigid => Contact::Rigid(Touchdown::Impact),
            Kind::Compliant => Contact::Compliant(Ground {
                stiffness_n_m15: self.k,
                loss_s_m: self.c,
                slip_scale_m_s: self.choice.slip_scale_m_s(),
            }),
        }
    }

    /// The problem of this name for a machine and its brush.
    pub fn problem(&self, biped: &Biped, brush: Brush) -> Problem {
        Problem {
            biped: *biped,
            brush: self.brush.brush(brush),
            contact: self.contact(),
            goal: Goal::Speed {
                weight: self.weight,
                aim_m_s: self.aim,
            },
            limits: self.choice.limits(),
            mesh: self.mesh(),
            rate_weight_s2: RATE_WEIGHT_S2,
        }
    }

    /// Do two names differ in one choice, by one step of its list?
    pub fn is_beside(&self, other: &Self) -> bool {
        self.steps_apart(other) == Some(1)
    }

    /// Steps between two names, summed over their choices; none between two kinds of contact.
    pub fn steps_apart(&self, other: &Self) -> Option<usize> {
        let apart = |list: &[f64], a: f64, b: f64| {
            let place = |x: f64| list.iter().position(|&y| y == x);
            match (place(a), place(b)) {
                (Some(i), Some(j)) => i.abs_diff(j),
                _ => usize::from(a != b),
            }
        };
        let choice = match (self.choice, other.choice) {
            (a, b) if a == b => 0,
            (Choice::Own, _) | (_, Choice::Own) => 1,
            _ => 2,
        };
        let steps = apart(&STIFFNESSES, self.k, other.k)
            + apart(&LOSSES, self.c, other.c)
            + apart(&WEIGHTS, self.weight, other.weight)
            + usize::from(self.aim != other.aim)
            + usize::from(self.brush != other.brush)
            + choice;
        (self.kind == other.kind).then_some(steps)
    }
}

/// What another mounting of the brush counts beside ratios of stiffness, loss and weight: [`Name::distance`].
const BRUSH_APART: f64 = 0.4;
/// What the logarithm of the ratio of two weights counts: a stride that got better led on to better ones at other weights in five to
/// nine steps.
const WEIGHT_APART: f64 = 0.4;
/// What another choice counts.
const CHOICE_APART: f64 = 0.5;

impl Name {
    /// How far a stride of the one is from being a good start for the other; none between two kinds of contact. Sum of
    /// |ln| of the ratios of stiffness, loss, weight and aim, and of what brush and choice count. The numbers for these order what a search
    /// of the map saw: of 88 starts from another brush alone 61 ended at a certificate and 23 in a better stride, of 53 from another
    /// stiffness 17 and 4, of 32 from another loss 14 and 2, of 57 from another brush and another stiffness or loss 9 and 2.
    pub fn distance(&self, other: &Self) -> Option<f64> {
        let ratio = |a: f64, b: f64| if a == b { 0.0 } else { (a / b).ln().abs() };
        let brush = if self.brush == other.brush {
            0.0
        } else {
            BRUSH_APART
        };
        let choices = match (self.choice, other.choice) {
            (a, b) if a == b => 0.0,
            (Choice::Own, _) | (_, Choice::Own) => 1.0,
            _ => 2.0,
        };
        let distance = ratio(self.k, other.k)
            + ratio(self.c, other.c)
            + WEIGHT_APART * ratio(self.weight, other.weight)
            + ratio(self.aim, other.aim)
            + brush
            + CHOICE_APART * choices;
        (self.kind == other.kind).then_some(distance)
    }
}

/// Every problem of the chapter on the gait: the sweep over the weights on both contacts, the lower
/// target, the map over stiffness and loss, and the other open choices.
pub fn all(low_m_s: f64, high_m_s: f64) -> Vec<Name> {
    let mut names = Vec::new();
    for brush in Mount::ALL {
        for weight in WEIGHTS {
            names.push(Name::rigid(brush, weight, high_m_s));
            names.push(Name::compliant(CONTACT, brush, weight, high_m_s));
        }
        names.push(Name::rigid(brush, MAP_WEIGHT, low_m_s));
        names.push(Name::compliant(CONTACT, brush, MAP_WEIGHT, low_m_s));
        for k in STIFFNESSES {
            for c in LOSSES {
                if (k, c) != CONTACT {
                    names.push(Name::compliant((k, c), brush, MAP_WEIGHT, high_m_s));
                }
            }
        }
        if brush != Mount::Backwards {
            let own = Name::compliant(CONTACT, brush, MAP_WEIGHT, high_m_s);
            names.extend(Choice::ALL.map(|choice| own.with_choice(choice)));
            names.extend(FINE_WEIGHTS.map(|weight| {
                Name::compliant(CONTACT, brush, weight, high_m_s).with_choice(Choice::FineMesh)
            }));
        }
    }
    names
}
