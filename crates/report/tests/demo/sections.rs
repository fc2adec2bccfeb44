//! Sections with every kind of block: prose, notices, an equation, a table, a chain and the figures.

use report::{
    Block, Cell, Chain, Column, Equation, Evidence, NoticeKind, Section, Station, Status, Suspect,
    SuspectState, Table, Verdict, literal,
};

use super::HOSTILE;
use super::figures::{curves, drawing, gains, map, polygon, provenance, scatter, stride};

fn table() -> Table {
    Table {
        id: "tab-parameters".into(),
        title: "Parameters beside the published ones".into(),
        caption: "Intervals are 95 %.".into(),
        columns: vec![
            Column::text("parameter"),
            Column::number("ours", "1/rad"),
            Column::number("published", "1/rad"),
            Column::text("verdict"),
        ],
        rows: vec![
            vec![
                Cell::Prose("$\\sigma_0$".into()),
                Cell::Value("demo.sigma0".into()),
                Cell::Number(1.64),
                Cell::Verdict(Verdict::Consistent),
            ],
            vec![
                Cell::Text(HOSTILE.into()),
                Cell::Interval(0.5, [0.4, 0.6]),
                Cell::Missing("not published".into()),
                Cell::Verdict(Verdict::NotTestable),
            ],
        ],
        evidence: Some(Evidence::Synthetic),
        paper: Some("Table 1".into()),
        provenance: Some(provenance()),
        claims: vec!["C02".into(), "C99".into()],
    }
}

fn chain() -> Chain {
    let suspect = |label: &str, state, note: &str| Suspect {
        label: label.into(),
        state,
        note: note.into(),
    };
    let station = |name: &str, role: &str, suspects| Station {
        name: name.into(),
        role: role.into(),
        suspects,
    };
    Chain {
        id: "chain".into(),
        caption:
            "Truth moves from the stage to the recorded number; each suspect sits at its station."
                .into(),
        stations: vec![
            station(
                "Stage",
                "moves the counterface",
                vec![suspect(
                    "stage-tilt",
                    SuspectState::Undecidable,
                    "all runs have one load",
                )],
            ),
            station(
                "Contact",
                "bristles rub",
                vec![suspect("wear", SuspectState::RuledOut, "")],
            ),
            station(
                "Coupling",
                "the cord pulls",
                vec![suspect(
                    "cord-compliance",
                    SuspectState::Found,
                    "probability 0.99",
                )],
            ),
            station(
                "Sensor",
                "reads the tension",
                vec![suspect("sensor-lag", SuspectState::Equivalent, HOSTILE)],
            ),
        ],
    }
}

pub fn sections() -> Vec<Section> {
    vec![
        Section {
            id: "validation".into(),
            title: "Validation".into(),
            lead: "The curves agree within {{ v(\"demo.rmse\") }}.".into(),
            method: Some("Each run is predicted from its own motion; nothing is refitted.\n\nRead the band as the range of single runs.".into()),
            status: Some("done".into()),
            claims: vec!["C02".into()],
            blocks: vec![
                Block::notice(NoticeKind::Synthetic, "Stand-in data", "All curves here are synthetic."),
                Block::prose("A name from the metadata: ".to_string() + &literal(HOSTILE)),
                curves().into(),
                Block::Equation(Equation {
                    id: "E3".into(),
                    latex: r"\dot\theta = w - \sigma \frac{|w|}{g(w)}\,\theta".into(),
                    status: Status::Derived,
                    caption: "Rotation of the mean bristle.".into(),
                }),
                table().into(),
                Block::heading("more", "More figures"),
                drawing().into(),
                scatter().into(),
                Block::List(vec!["one".into(), "two".into()]),
            ],
        },
        Section {
            id: "biped".into(),
            title: "Envelope and gait".into(),
            lead: "Forward force rises by {{ v(\"demo.gain\") }}.".into(),
            blocks: vec![gains().into(), polygon().into(), map().into(), stride().into()],
            ..Section::default()
        },
        Section {
            id: "diagnosis".into(),
            title: "Diagnosis".into(),
            blocks: vec![
                Block::Chain(chain()),
                Block::notice(NoticeKind::Finding, "Found", "The cord."),
                Block::notice(NoticeKind::Caution, "Beware", "Extrapolation."),
                Block::notice(NoticeKind::Refusal, "No answer", "One load cannot tell."),
                Block::notice(NoticeKind::Note, HOSTILE, "Names stay text."),
            ],
            ..Section::default()
        },
    ]
}
