//! Curves of the gait stage: best speeds (Fig. 12), force directions (Fig. 11), the map of the gain.

use biped::gait::catalogue::{Choice, Mount, WEIGHTS};
use biped::gait::motion::Motion;
use biped::gait::{PHASES, STANDING};
use biped::kinematics::Leg;
use report::figure::{Axis, Figure, HeatMap, Ink, LinePlot, Mark, Provenance, Rule, Series};
use report::{Cell, Column, Evidence, Table};

use crate::published::Published;
use crate::stage::StageError;

fn ink(mount: Mount) -> Ink {
    match mount {
        Mount::Symmetric => Ink::SYMMETRIC,
        Mount::Asymmetric => Ink::FORWARD,
        Mount::Backwards => Ink::REVERSE,
    }
}

/// Speeds of one brush over the speed weights.
pub(super) struct Speeds {
    pub(super) mount: Mount,
    /// Of strides with a certificate.
    pub(super) certified: Vec<Option<f64>>,
    /// Of the others.
    pub(super) open: Vec<Option<f64>>,
}

fn over_weights(speeds: &[Option<f64>]) -> Vec<[f64; 2]> {
    WEIGHTS
        .iter()
        .zip(speeds)
        .map(|(weight, speed)| [*weight, speed.unwrap_or(f64::NAN)])
        .collect()
}

/// Fig. 12: best mean speed against the speed weight.
pub(super) fn speeds(
    id: &str,
    title: &str,
    rows: &[Speeds],
    published: &Published,
) -> Result<Figure, StageError> {
    let mut series = Vec::new();
    for row in rows {
        let line = Series::line(row.mount.id(), ink(row.mount), over_weights(&row.certified));
        series.push(line.marked(Mark::LinePoints));
        if row.open.iter().any(Option::is_some) {
            let name = format!("{}, no certificate", row.mount.id());
            let points = Series::line(&name, Ink::Muted, over_weights(&row.open));
            series.push(points.marked(Mark::Points));
        }
    }
    let printed = |brush: &str| published.value(&format!("gait.best_speed.{brush}"));
    let plot = LinePlot {
        x: Axis::new("speed weight Q_v", "s²/m²").log(),
        y: Axis::new("mean speed of the best stride", "m/s"),
        series,
        rules: vec![
            Rule::Horizontal(printed("asymmetric")?, "printed mean, asymmetric".into()),
            Rule::Horizontal(printed("symmetric")?, "printed mean, symmetric".into()),
        ],
        ..LinePlot::default()
    };
    Ok(Figure::new(
        id,
        title,
        "Best stride found for each weight of the speed at a target of 20 m/s, brush by brush. Horizontal lines: the \
         paper's means.",
        Evidence::Computed,
        plot,
        Provenance::here("gait", "biped::gait::chain::solve_all"),
    )
    .with_paper("Fig. 12")
    .with_claims(&["C11"]))
}

/// Fig. 11: direction of the ground force over the stride, both legs, two brushes.
pub(super) fn directions(rows: &[(Mount, &Motion)], limits: [f64; 3]) -> Figure {
    let mut series = Vec::new();
    for (mount, motion) in rows {
        for leg in Leg::BOTH {
            let mut points = Vec::new();
            for phase in (0..PHASES).filter(|&phase| STANDING[phase] == Some(leg)) {
                points.extend(
                    motion
                        .samples
                        .iter()
                        .filter(|s| s.phase == phase && s.force_n[1] > 1.0)
                        .map(|s| [1e3 * s.time_s, s.force_n[0] / s.force_n[1]]),
                );
            }
            let name = if leg == Leg::Front { "front" } else { "rear" };
            let mark = if leg == Leg::Front {
                Mark::Line
            } else {
                Mark::LinePoints
            };
            series.push(
                Series::line(&format!("{}, {name} leg", mount.id()), ink(*mount), points)
                    .marked(mark),
            );
        }
    }
    let plot = LinePlot {
        x: Axis::new("time", "ms"),
        y: Axis::new("forward over vertical force", ""),
        series,
        rules: vec![
            Rule::Horizontal(limits[0], "forward limit".into()),
            Rule::Horizontal(-limits[1], "reverse limit".into()),
            Rule::Horizontal(limits[2], "symmetric limit".into()),
            Rule::Horizontal(-limits[2], String::new()),
        ],
        ..LinePlot::default()
    };
    Figure::new(
        "fig-11",
        "Force directions over one stride at a target of 8 m/s",
        "With the asymmetric brush the feet push forward in directions that the symmetric coefficient does not allow.",
        Evidence::Computed,
        plot,
        Provenance::here("gait", "biped::gait::motion::Motion::new"),
    )
    .with_paper("Fig. 11")
    .with_claims(&["C10"])
}

/// Path of both feet and the torso over one stride.
pub(super) fn paths(motion: &Motion, biped: &biped::parameters::Biped) -> Figure {
    let foot = |leg: Leg| -> Vec<[f64; 2]> {
        motion
            .samples
            .iter()
            .map(|s| biped::kinematics::leg_points(biped, &s.q, leg).foot)
            .collect()
    };
    let torso = motion.samples.iter().map(|s| [s.q[0], s.q[1]]).collect();
    let plot = LinePlot {
        x: Axis::new("way", "m"),
        y: Axis::new("height", "m"),
        series: vec![
            Series::line("torso", Ink::Muted, torso),
            Series::line("front foot", Ink::Slot(4), foot(Leg::Front)),
            Series::line("rear foot", Ink::Slot(5), foot(Leg::Rear)),
        ],
        rules: vec![Rule::Horizontal(0.0, "ground".into())],
        ..LinePlot::default()
    };
    Figure::new(
        "fig-11-paths",
        "Trajectory of torso and feet at a target of 8 m/s",
        "One stride with the asymmetric brush: front stance, flight, rear stance, flight.",
        Evidence::Computed,
        plot,
        Provenance::here("gait", "biped::gait::motion::Motion::new"),
    )
    .with_paper("Fig. 11")
}

/// The gain over contact stiffness and loss; cells without two certified strides stay empty.
pub(super) fn map(
    stiffnesses: &[f64],
    losses: &[f64],
    cells: &[Vec<Option<f64>>],
    printed_gain: f64,
) -> Figure {
    let heat = HeatMap {
        x: Axis::new("contact loss c", "s/m"),
        y: Axis::new("contact stiffness k", "N/m^1.5"),
        columns: losses.iter().map(|c| format!("{c}")).collect(),
        rows: stiffnesses.iter().map(|k| format!("{k:.0e}")).collect(),
        values: cells.to_vec(),
        quantity: "gain of the best speed".into(),
        unit: "percent".into(),
        centre: Some(0.0),
        numbers: true,
        levels: vec![(printed_gain, "printed".into())],
        ..HeatMap::default()
    };
    Figure::new(
        "gait-map",
        "The gain is a map, not a number",
        "Gain of the best speed by the asymmetric over the symmetric brush at one speed weight, over the two contact \
         parameters that the paper does not print. Only cells in which both strides are certified carry a number.",
        Evidence::Computed,
        heat,
        Provenance::here("gait", "biped::gait::chain::solve_all"),
    )
    .with_claims(&["C11", "C22"])
}

/// What a choice means, in words.
fn meaning(choice: Choice) -> &'static str {
    match choice {
        Choice::Own => "this project's choices",
        Choice::ShortStance => "no stance longer than 60 ms",
        Choice::LongStance => "stances up to 150 ms",
        Choice::SlowJoints => "joints no faster than 40 rad/s",
        Choice::NarrowHips => "hips from -80 to 40 degrees",
        Choice::SharpFriction => "friction turns within 0.03 m/s",
        Choice::BluntFriction => "friction turns within 0.3 m/s",
        Choice::ShallowFoot => "foot no deeper than 20 mm",
        Choice::FineMesh => "every interval halved",
    }
}

/// The gain under each of the choices that the paper leaves open.
pub(super) fn choices(rows: &[Choice]) -> Table {
    let rows = rows
        .iter()
        .map(|&choice| {
            let value = |part: &str| Cell::Value(format!("gait.choice.{}.{part}", choice.id()));
            vec![
                Cell::from(meaning(choice)),
                value("symmetric"),
                value("asymmetric"),
                value("gain"),
            ]
        })
        .collect();
    Table {
        id: "gait-choices".into(),
        title: "The other choices that the paper leaves open".into(),
        caption: "Best speeds and gain at the contact of the sweep and one speed weight, one choice changed at a time. Rows without \
                  two certified strides are left out."
            .into(),
        columns: vec![
            Column::text("choice"),
            Column::number("symmetric", "m/s"),
            Column::number("asymmetric", "m/s"),
            Column::number("gain", "percent"),
        ],
        rows,
        evidence: Some(Evidence::Computed),
        provenance: Some(Provenance::here("gait", "biped::gait::chain::solve_all")),
        claims: vec!["C11".into(), "C22".into()],
        ..Table::default()
    }
}
