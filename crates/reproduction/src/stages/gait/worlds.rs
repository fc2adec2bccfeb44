//! The claims about the gait over what the paper leaves open: contact, limits, target, and whether a stride must end as fast as
//! it began; and over the mesh on which a stride is integrated.

use std::collections::BTreeMap;

use biped::gait::catalogue::{
    CONTACT, Choice, FINE_WEIGHTS, LOSSES, MAP_WEIGHT, Mount, Name, STIFFNESSES, WEIGHTS,
};
use report::Value;

use super::strides::Solved;
use super::{Targets, gain_percent, pair};
use crate::multiverse::{Point, Worlds};

/// One option: its words, and the values that it gives (none where a stride carries no certificate).
type World = (String, BTreeMap<String, Point>);

/// The worlds of C10, C11 and C22; `values` are those of the stage, sweeps and accelerating strides among them.
pub(super) fn all(
    solved: &[Solved],
    targets: &Targets,
    values: &[Value],
) -> [(&'static str, Worlds); 3] {
    let open = open_choices(targets);
    let one_weight: Vec<World> = open
        .iter()
        .map(|(words, name)| (words.clone(), speeds(solved, *name)))
        .collect();
    let sweeps = [
        ("compliant, mean of seven weights", "gait"),
        ("rigid with impact, mean of seven weights", "gait.rigid"),
    ]
    .map(|(words, prefix)| (words.to_owned(), of_sweep(values, prefix)));
    let speeds: Vec<World> = sweeps.into_iter().chain(one_weight).collect();
    let mut gains: Vec<World> = speeds
        .iter()
        .map(|(words, world)| {
            let gain = world.get(GAIN).map(|gain| (GAIN.to_owned(), *gain));
            (words.clone(), gain.into_iter().collect())
        })
        .collect();
    let accelerating = number(values, "gait.acceleration.gain")
        .map(|gain| (GAIN.to_owned(), Point::from(gain)))
        .into_iter()
        .collect();
    gains.push((
        "accelerating stride, gain of acceleration".to_owned(),
        accelerating,
    ));
    [
        (
            "C10",
            worlds("stride", directions(solved, targets, &open).into_iter()),
        ),
        (
            "C11",
            worlds(
                "contact, limits and mesh (Q_v = 1 where neither weight nor mean is named)",
                speeds.into_iter(),
            ),
        ),
        (
            "C22",
            worlds(
                "stride (Q_v = 1 where neither weight nor mean is named)",
                gains.into_iter(),
            ),
        ),
    ]
}

const GAIN: &str = "gait.gain";

fn worlds(axis: &str, options: impl Iterator<Item = World>) -> Worlds {
    let (words, values) = options.unzip();
    Worlds {
        axes: vec![(axis.to_owned(), words)],
        values,
    }
}

/// Contacts of the map, then the other choices, then the finer mesh, at the upper target; names of the symmetric brush.
fn open_choices(targets: &Targets) -> Vec<(String, Name)> {
    let cells = STIFFNESSES
        .into_iter()
        .flat_map(|k| LOSSES.map(|c| (k, c)))
        .map(|(k, c)| {
            let name = Name::compliant((k, c), Mount::Symmetric, MAP_WEIGHT, targets.high);
            (format!("k {k:e} N/m^1.5, c {c} s/m"), name)
        });
    let choices = Choice::ALL.into_iter().map(|choice| {
        let name = Name::compliant(CONTACT, Mount::Symmetric, MAP_WEIGHT, targets.high);
        (choice.id().replace('-', " "), name.with_choice(choice))
    });
    let finer = FINE_WEIGHTS.into_iter().map(|weight| {
        let name = Name::compliant(CONTACT, Mount::Symmetric, weight, targets.high);
        (
            format!("every interval halved, Q_v {weight}"),
            name.with_choice(Choice::FineMesh),
        )
    });
    cells.chain(choices).chain(finer).collect()
}

fn speeds(solved: &[Solved], name: Name) -> BTreeMap<String, Point> {
    let Some(strides) = pair(solved, name) else {
        return BTreeMap::new();
    };
    let [symmetric, asymmetric] = strides.map(|s| s.outcome.motion.speed_m_s);
    [
        ("gait.best_speed.symmetric", symmetric),
        ("gait.best_speed.asymmetric", asymmetric),
        (GAIN, gain_percent([symmetric, asymmetric])),
    ]
    .map(|(id, value)| (id.to_owned(), Point::from(value)))
    .into()
}

fn number(values: &[Value], id: &str) -> Option<f64> {
    let value = values.iter().find(|value| value.id == id)?;
    value.value.filter(|number| number.is_finite())
}

/// The means of a sweep as the stage has them.
fn of_sweep(values: &[Value], prefix: &str) -> BTreeMap<String, Point> {
    let ids = ["best_speed.symmetric", "best_speed.asymmetric", "gain"];
    let all: Option<BTreeMap<String, Point>> = ids
        .into_iter()
        .map(|id| {
            let number = number(values, &format!("{prefix}.{id}"))?;
            Some((format!("gait.{id}"), Point::from(number)))
        })
        .collect();
    all.unwrap_or_default()
}

/// Largest force directions: at the lower target, then at the upper one over the weights and over what is open.
fn directions(solved: &[Solved], targets: &Targets, open: &[(String, Name)]) -> Vec<World> {
    let at = |weight, aim| Name::compliant(CONTACT, Mount::Symmetric, weight, aim);
    let lower = (
        format!("target {} m/s", targets.low),
        at(MAP_WEIGHT, targets.low),
    );
    let weights = WEIGHTS.into_iter().map(|weight| {
        let words = format!("target {} m/s, Q_v {weight}", targets.high);
        (words, at(weight, targets.high))
    });
    let others = open
        .iter()
        .map(|(words, name)| (format!("target {} m/s, {words}", targets.high), *name));
    std::iter::once(lower)
        .chain(weights)
        .chain(others)
        .map(|(words, name)| {
            let world = pair(solved, name).map_or_else(BTreeMap::new, |strides| {
                let [symmetric, asymmetric] = strides.map(|s| s.outcome.motion.directions()[1]);
                [("symmetric", symmetric), ("asymmetric", asymmetric)]
                    .map(|(brush, value)| {
                        let id = format!("gait.force_direction.{brush}.largest");
                        (id, Point::from(value))
                    })
                    .into()
            });
            (words, world)
        })
        .collect()
}
