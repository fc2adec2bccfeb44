//! The force envelope of a foot (Fig. 13, claims C12 and C13).

use std::collections::BTreeMap;

use biped::contact::Brush;
use biped::envelope::family::{Reading, readings};
use biped::envelope::programme::Binding;
use biped::envelope::{
    Body, EnvelopeError, ForceMap, Gain, Posture, Variant, gain, polygon, programme,
};
use biped::parameters::Biped;
use nalgebra::Vector2;
use report::figure::{Axis, Figure, Ink, LinePlot, Mark, Provenance, Region, Rule, Series};
use report::{Block, Cell, Column, Evidence, NoticeKind, Section, Table, Value};

use super::machine;
use crate::multiverse::{Point, Worlds};
use crate::stage::{Needs, Stage, StageContext, StageError, StageOutput, TableFile};

/// The envelope.
pub(super) struct Envelope;

/// Pitches of the paper, in degrees and in its own sign: nose up is negative.
const PITCHES: [(&str, f64); 3] = [("pitch-5", -5.0), ("pitch0", 0.0), ("pitch+5", 5.0)];

impl From<EnvelopeError> for StageError {
    fn from(error: EnvelopeError) -> Self {
        StageError::Failed(error.to_string())
    }
}

impl Stage for Envelope {
    fn id(&self) -> &'static str {
        "envelope"
    }

    fn title(&self) -> &'static str {
        "force envelope of a foot"
    }

    fn needs(&self) -> Needs {
        Needs::default()
    }

    fn run(&self, context: &StageContext<'_>) -> Result<StageOutput, StageError> {
        let biped = machine::biped(context.published)?;
        let brush = machine::brush(context.published)?;
        let thigh = context.published.value("envelope.thigh_angle")?;
        let knee = context.published.value("envelope.knee_angle")?;
        let postures = PITCHES.map(|(_, pitch)| Posture {
            pitch_rad: -pitch.to_radians(),
            hip_rad: thigh.to_radians(),
            knee_rad: knee.to_radians(),
        });

        let mut output = StageOutput::done();
        let mut blocks = Vec::new();
        let mut mechanism = Vec::new();
        let mut largest_gap: f64 = 0.0;
        let mut gains = Vec::new();
        for ((name, pitch), posture) in PITCHES.into_iter().zip(postures) {
            let gain = gain(&biped, Variant::NATURAL, posture, brush)?;
            for (kind, number) in [
                ("gain", gain.forward_percent),
                ("vertical", gain.vertical_percent),
            ] {
                let id = format!("envelope.{kind}.{name}");
                let mut value = Value::new(&id, number, "percent", self.id(), Evidence::Computed);
                if let Some(printed) = context.published.get(&id) {
                    value = value.with_published(&printed.printed);
                }
                output.values.push(value);
            }
            let (row, gap) = bindings(&biped, posture, brush, &gain, pitch)?;
            largest_gap = largest_gap.max(gap);
            mechanism.push(row);
            blocks.push(Block::from(panel(&biped, posture, brush, name, pitch)?));
            gains.push(gain);
        }
        let spread = spread(gains.iter().map(|gain| gain.asymmetric_n[1]));
        for (id, number, unit) in [
            ("envelope.vertical_spread", spread, "percent"),
            ("envelope.two_paths_gap", largest_gap, "1"),
        ] {
            output
                .values
                .push(Value::new(id, number, unit, self.id(), Evidence::Computed));
        }
        let family = readings(&biped, &postures, brush)?;
        family_values(&family, &mut output);
        output.tables.push(family_csv(&family));
        for claim in ["C12", "C13"] {
            let worlds = worlds(&family).artefact(claim);
            output
                .artefacts
                .extend([worlds.map_err(|error| StageError::Failed(error.to_string()))?]);
        }
        output
            .work
            .insert("readings of the family".into(), family.len() as u64);
        blocks.push(Block::from(mechanism_table(mechanism)));
        blocks.push(Block::from(family_figure(&family, context)?));
        blocks.push(Block::notice(
            NoticeKind::Note,
            "Sign of the pitch",
            "The gains come in the paper's order only if its -5 deg means nose up. Ids and figures use the paper's sign.",
        ));
        output.sections.push(section(blocks));
        Ok(output)
    }
}

fn section(blocks: Vec<Block>) -> Section {
    Section {
        id: "envelope".into(),
        title: "Force envelope of a foot".into(),
        lead: "With the asymmetric brush the largest forward force rises by {{ v(\"envelope.gain.pitch-5\", 4) }}, \
               {{ v(\"envelope.gain.pitch0\", 4) }} and {{ v(\"envelope.gain.pitch+5\", 4) }} at the paper's pitches of \
               -5, 0 and 5 deg; the paper prints {{ published(\"envelope.gain.pitch-5\") }}, \
               {{ published(\"envelope.gain.pitch0\") }} and {{ published(\"envelope.gain.pitch+5\") }}."
            .into(),
        method: Some(
            "Torso and one leg, hip at the torso's centre, at rest with the foot fixed: \
             $F(\\tau) = -(J M^{-1} J^T)^{-1} J M^{-1} (S \\tau - G)$. The torques within their limits give a \
             parallelogram of forces; the friction cone cuts it. The largest force is found twice, as a corner of the \
             exact polygon and by a linear programme in Clarabel; the two differ by at most \
             {{ v(\"envelope.two_paths_gap\", 2) }} relative."
                .into(),
        ),
        claims: vec!["C12".into(), "C13".into()],
        blocks,
        ..Section::default()
    }
}

/// Which limits end the forward force in one posture, and how far the two paths differ.
fn bindings(
    biped: &Biped,
    posture: Posture,
    brush: Brush,
    gain: &Gain,
    pitch: f64,
) -> Result<(Vec<Cell>, f64), StageError> {
    let map = ForceMap::new(biped, Variant::NATURAL, posture)?;
    let mut row: Vec<Cell> = vec![Cell::Text(signed(pitch))];
    let mut gap: f64 = 0.0;
    for (brush, exact) in [
        (brush.symmetric(), gain.symmetric_n),
        (brush, gain.asymmetric_n),
    ] {
        let mut names = Vec::new();
        for (component, exact) in exact.into_iter().enumerate() {
            let mut direction = Vector2::zeros();
            direction[component] = 1.0;
            let optimum = programme::largest(&map, brush, direction)?;
            gap = gap.max((optimum.force_n[component] - exact).abs() / exact.abs());
            if component == 0 {
                names = optimum
                    .binding
                    .iter()
                    .map(|binding| binding_name(*binding))
                    .collect();
            }
        }
        row.push(Cell::from(exact[0]));
        row.push(Cell::Text(names.join(" and ")));
    }
    row.push(Cell::Digits(gain.forward_percent, 4));
    Ok((row, gap))
}

fn binding_name(binding: Binding) -> &'static str {
    match binding {
        Binding::Torque { joint: 0, .. } => "hip torque",
        Binding::Torque { joint: 1, .. } => "knee torque",
        Binding::Torque { .. } => "torque of the other leg",
        Binding::FrictionForward => "friction",
        Binding::FrictionReverse => "reverse friction",
    }
}

fn mechanism_table(rows: Vec<Vec<Cell>>) -> Table {
    Table {
        id: "envelope-mechanism".into(),
        title: "Which limits end the forward force".into(),
        caption: "More friction helps only until the next torque limit: where the corner moves from the knee's limit to \
                  the hip's, the gain is smaller than the gain of friction."
            .into(),
        columns: vec![
            Column::text("pitch (paper's sign)"),
            Column::number("symmetric, largest forward force", "N"),
            Column::text("ended by"),
            Column::number("asymmetric, largest forward force", "N"),
            Column::text("ended by"),
            Column::number("gain", "percent"),
        ],
        rows,
        evidence: Some(Evidence::Computed),
        provenance: Some(Provenance::here("envelope", "biped::envelope::programme")),
        claims: vec!["C12".into()],
        ..Table::default()
    }
}

/// A pitch with its sign, of which zero has none.
fn signed(pitch: f64) -> String {
    if pitch == 0.0 {
        "0 deg".into()
    } else {
        format!("{pitch:+.0} deg")
    }
}

/// One panel of Fig. 13: force regions over the weight of torso and one leg.
fn panel(
    biped: &Biped,
    posture: Posture,
    brush: Brush,
    name: &str,
    pitch: f64,
) -> Result<Figure, StageError> {
    let map = ForceMap::new(biped, Variant::NATURAL, posture)?;
    let weight = biped.one_leg_mass_kg() * biped.gravity_m_s2;
    let scaled = |corners: Vec<Vector2<f64>>| -> Vec<[f64; 2]> {
        corners
            .iter()
            .map(|corner| [corner[0] / weight, corner[1] / weight])
            .collect()
    };
    let torques = polygon::zonogon(&map);
    let region = |brush: Brush| scaled(polygon::cut_by_friction(&torques, brush));
    let plot = LinePlot {
        x: Axis::new("forward force / weight", ""),
        y: Axis::new("vertical force / weight", ""),
        regions: vec![
            Region {
                label: "torque limits".into(),
                corners: scaled(torques.clone()),
                ink: Ink::Muted,
            },
            Region {
                label: "with asymmetric friction".into(),
                corners: region(brush),
                ink: Ink::FORWARD,
            },
            Region {
                label: "with symmetric friction".into(),
                corners: region(brush.symmetric()),
                ink: Ink::SYMMETRIC,
            },
        ],
        equal_aspect: true,
        ..LinePlot::default()
    };
    let id = format!(
        "fig-13-{}",
        name.replace('+', "plus-").replace("pitch-", "pitch-minus-")
    );
    let caption = format!(
        "Forces that the torques can hold, cut by friction, over the weight of torso and one leg. The largest forward \
         force rises by {{{{ v(\"envelope.gain.{name}\", 4) }}}}, the largest vertical force changes by \
         {{{{ v(\"envelope.vertical.{name}\", 3) }}}}."
    );
    Ok(Figure::new(
        &id,
        &format!("Force envelope at pitch {}", signed(pitch)),
        caption,
        Evidence::Computed,
        plot,
        Provenance::here("envelope", "biped::envelope::polygon"),
    )
    .with_paper("Fig. 13")
    .with_claims(&["C12", "C13"]))
}

/// A name of the program as words: `FixedTorso` as `fixed torso`.
fn spaced(name: &str) -> String {
    let mut words = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !words.is_empty() {
            words.push(' ');
        }
        words.extend(letter.to_lowercase());
    }
    words
}

/// The gains of every reading of the family, in its order.
fn worlds(family: &[Reading]) -> Worlds {
    let options = |of: &dyn Fn(&Reading) -> String| {
        let mut seen = Vec::new();
        for option in family.iter().map(of) {
            if !seen.contains(&option) {
                seen.push(option);
            }
        }
        seen
    };
    Worlds {
        axes: vec![
            (
                "bodies".into(),
                options(&|r| spaced(&format!("{:?}", r.variant.body))),
            ),
            (
                "hip".into(),
                options(&|r| spaced(&format!("{:?}", r.variant.hip))),
            ),
            ("weight".into(), vec!["with".into(), "without".into()]),
            (
                "links".into(),
                options(&|r| spaced(&format!("{:?}", r.links))),
            ),
        ],
        values: family.iter().map(world).collect(),
    }
}

/// What one reading gives for the values of C12 and C13.
fn world(reading: &Reading) -> BTreeMap<String, Point> {
    let mut values = BTreeMap::new();
    for ((name, _), gain) in PITCHES.iter().zip(&reading.gains) {
        values.insert(format!("envelope.gain.{name}"), gain.forward_percent.into());
        values.insert(
            format!("envelope.vertical.{name}"),
            gain.vertical_percent.into(),
        );
    }
    let heights = reading.gains.iter().map(|gain| gain.asymmetric_n[1]);
    values.insert("envelope.vertical_spread".into(), spread(heights).into());
    values
}

/// Largest over smallest less one, percent.
fn spread(heights: impl Iterator<Item = f64> + Clone) -> f64 {
    let highest = heights.clone().fold(f64::NEG_INFINITY, f64::max);
    let lowest = heights.fold(f64::INFINITY, f64::min);
    100.0 * (highest / lowest - 1.0)
}

/// Range of the gains over the family.
fn family_values(family: &[Reading], output: &mut StageOutput) {
    for (k, (name, _)) in PITCHES.iter().enumerate() {
        let gains = || {
            family
                .iter()
                .map(|reading| reading.gains[k].forward_percent)
        };
        for (end, number) in [
            ("lowest", gains().fold(f64::INFINITY, f64::min)),
            ("highest", gains().fold(f64::NEG_INFINITY, f64::max)),
        ] {
            let id = format!("envelope.family.{name}.{end}");
            output.values.push(Value::new(
                id,
                number,
                "percent",
                "envelope",
                Evidence::Computed,
            ));
        }
    }
}

fn family_csv(family: &[Reading]) -> TableFile {
    let mut csv = String::from(
        "body,hip,weight,links,gain_pitch_minus_5_percent,gain_pitch_0_percent,gain_pitch_plus_5_percent\n",
    );
    for reading in family {
        let Variant { body, hip, weight } = reading.variant;
        let gains: Vec<String> = reading
            .gains
            .iter()
            .map(|gain| gain.forward_percent.to_string())
            .collect();
        csv.push_str(&format!(
            "{body:?},{hip:?},{weight},{:?},{}\n",
            reading.links,
            gains.join(",")
        ));
    }
    TableFile {
        name: "envelope-readings".into(),
        csv,
    }
}

/// All readings beside the printed gains.
fn family_figure(family: &[Reading], context: &StageContext<'_>) -> Result<Figure, StageError> {
    let points = |wanted: &dyn Fn(&Reading) -> bool| -> Vec<[f64; 2]> {
        family
            .iter()
            .filter(|reading| wanted(reading))
            .flat_map(|reading| {
                PITCHES
                    .iter()
                    .zip(&reading.gains)
                    .map(|((_, pitch), gain)| [*pitch, gain.forward_percent])
            })
            .collect()
    };
    let printed = PITCHES
        .iter()
        .map(|(name, pitch)| {
            Ok([
                *pitch,
                context.published.value(&format!("envelope.gain.{name}"))?,
            ])
        })
        .collect::<Result<Vec<_>, StageError>>()?;
    let one_leg = |reading: &Reading| {
        matches!(
            reading.variant.body,
            Body::FloatingOneLeg | Body::FixedTorso
        )
    };
    let plot = LinePlot {
        x: Axis::new("pitch (paper's sign)", "deg").between(-7.0, 7.0),
        y: Axis::new("gain of the largest forward force", "percent"),
        series: vec![
            Series::points("one leg", Ink::Slot(5), points(&one_leg)).marked(Mark::Dots),
            Series::points("both legs", Ink::Slot(6), points(&|r| !one_leg(r))).marked(Mark::Dots),
            Series::points(
                "natural variant",
                Ink::FORWARD,
                points(&|r| r == &family[0]),
            )
            .marked(Mark::LinePoints),
            Series::points("printed", Ink::PUBLISHED, printed).marked(Mark::LinePoints),
        ],
        rules: vec![Rule::Horizontal(0.0, String::new())],
        ..LinePlot::default()
    };
    Ok(Figure::new(
        "envelope-family",
        "The same three numbers under every reading of the model",
        "Every open choice of the envelope at once: which bodies take part, where the hip sits, whether weight counts, how \
         the table's inertias are read. The natural variant has no free parameter.",
        Evidence::Computed,
        plot,
        Provenance::here("envelope", "biped::envelope::family::readings"),
    )
    .with_claims(&["C12"]))
}

#[cfg(test)]
mod tests {
    #[test]
    fn names_become_words() {
        assert_eq!(super::spaced("CentresInTheMiddle"), "centres in the middle");
        assert_eq!(super::spaced("centre"), "centre");
    }
}
