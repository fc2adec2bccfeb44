//! A small document with one of everything and with hostile strings wherever a reader's data could bring them. Its
//! numbers are made up and mean nothing.
#![allow(missing_docs, unreachable_pub)]

use report::figure::{
    Animation, Axis, Band, BarGroup, BarPlot, Drawing, Figure, Frame, HeatMap, Ink, LinePlot, Mark,
    Provenance, Region, Rule, Series, Shape, bristle,
};
use report::{
    Answer, AuditItem, AuditOutcome, Block, CauseClass, Cell, Chain, CheckItem, Choice, ClaimRow,
    Column, Deviation, Document, Drift, DriftClass, DriftRow, Equation, Evidence, Header, Input,
    Multiverse, NegativeControl, NoticeKind, Prose, Run, Section, Station, Status, Subject,
    Suspect, SuspectState, Symbol, Table, Value, Verdict, literal,
};

/// What metadata could hold.
pub const HOSTILE: &str = "</script><script>alert('x')</script> <img src=https://example.org/x.png onerror=alert(1)> {{ v(\"no.such\") }} *b* $\\frac$ [a](javascript:alert(1)) `";

fn line(count: u32, f: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
    (0..count)
        .map(|k| {
            let x = 60.0 * f64::from(k) / f64::from(count - 1);
            [x, f(x)]
        })
        .collect()
}

fn forward(x: f64) -> f64 {
    0.9 * (1.0 - (-x / 4.0).exp()) + 0.04 * (-x / 20.0).exp()
}

fn reverse(x: f64) -> f64 {
    0.43 * (1.0 - (-x / 3.0).exp())
}

fn wiggle(x: f64) -> f64 {
    0.012 * (17.0 * x).sin() + 0.009 * (41.3 * x).cos()
}

fn provenance() -> Provenance {
    Provenance::here("validation", "curves")
        .with_input(HOSTILE, "blake3:0123456789abcdef")
        .with_parameter("theta0", "-0.278 rad")
}

fn curves() -> Figure {
    let plot = LinePlot {
        bands: vec![Band {
            label: "95 % of runs".into(),
            points: line(80, forward)
                .iter()
                .map(|p| [p[0], p[1] - 0.04, p[1] + 0.04])
                .collect(),
            ink: Ink::FORWARD,
        }],
        rules: vec![Rule::Horizontal(0.6682, "symmetric".into())],
        notes: vec![(30.0, 0.9049, "plateau".into())],
        ..LinePlot::new(
            Axis::new("speed", "mm/s"),
            Axis::new("coefficient of friction", "1"),
            vec![
                Series::dots(
                    "forward, three runs",
                    Ink::DATA,
                    line(1800, |x| forward(x) + wiggle(x)),
                ),
                Series::dots(
                    "reverse, three runs",
                    Ink::DATA,
                    line(1800, |x| reverse(x) + wiggle(x)),
                ),
                Series::line("model, forward", Ink::FORWARD, line(400, forward)),
                Series::line("model, reverse", Ink::REVERSE, line(400, reverse)),
            ],
        )
    };
    Figure::new(
        "fig-curves",
        "Friction against speed, both directions",
        "The model ({{ v(\"demo.steady_forward\") }} forward) through the runs of one made-up campaign.",
        Evidence::Synthetic,
        plot,
        provenance(),
    )
    .with_paper("Fig. 6")
    .with_paper_limits([0.0, 60.0], [0.0, 1.0], "range of the stated protocol")
    .with_claims(&["C02", "C09"])
}

fn scatter() -> Figure {
    let ratio = Series::points(
        "ratio",
        Ink::Slot(2),
        vec![[1e-2, 0.4], [1e-1, 0.7], [1.0, 1.1], [10.0, 2.2]],
    )
    .with_intervals(vec![[0.3, 0.5], [0.6, 0.8], [1.0, 1.2], [1.9, 2.6]])
    .marked(Mark::LinePoints);
    Figure::new(
        "fig-scatter",
        "A ratio over four decades",
        "Bars are 95 % intervals.",
        Evidence::Computed,
        LinePlot::new(
            Axis::new("weight", "1").log(),
            Axis::new("ratio", "1").log(),
            vec![ratio],
        ),
        Provenance::here("gait", "sweep"),
    )
}

fn gains() -> Figure {
    let group = |label: &str, ink, values: [f64; 3]| BarGroup {
        label: label.into(),
        values: values.iter().map(|v| Some(*v)).collect(),
        intervals: values.iter().map(|v| Some([v - 0.7, v + 0.7])).collect(),
        ink,
    };
    let plot = BarPlot {
        categories: vec!["−5°".into(), "0°".into(), "5°".into()],
        category_label: "pitch".into(),
        y: Axis::new("gain", "percent"),
        groups: vec![
            group("ours", Ink::FORWARD, [12.7, 18.6, 17.0]),
            group("published", Ink::PUBLISHED, [12.61, 18.79, 17.52]),
        ],
        rules: vec![],
    };
    Figure::new(
        "fig-gains",
        "Gain of the forward force",
        "By pitch.",
        Evidence::Computed,
        plot,
        Provenance::here("envelope", "gains"),
    )
    .with_claims(&["C12"])
}

fn map() -> Figure {
    let (rows, columns) = (6, 8);
    let values = (0..rows)
        .map(|r| {
            (0..columns)
                .map(|c| (r != 2 || c != 3).then(|| f64::from(r * c) - 12.0))
                .collect()
        })
        .collect();
    let plot = HeatMap {
        x: Axis::new("stiffness", "N/m"),
        y: Axis::new("damping", "s/m"),
        columns: (0..columns).map(|c| format!("{}e4", c + 1)).collect(),
        rows: (0..rows)
            .map(|r| format!("{}", 0.5 * f64::from(r)))
            .collect(),
        values,
        quantity: "gain".into(),
        unit: "percent".into(),
        centre: Some(0.0),
        numbers: true,
        levels: vec![(10.0, "10 %".into())],
        ..HeatMap::default()
    };
    Figure::new(
        "fig-map",
        "Gain over contact stiffness and damping",
        "One cell does not converge.",
        Evidence::Computed,
        plot,
        Provenance::here("gait", "map"),
    )
}

fn polygon() -> Figure {
    let region = |label: &str, ink, reach: f64| Region {
        label: label.into(),
        corners: vec![
            [0.0, 0.0],
            [reach, 1.1],
            [0.3, 1.9],
            [-0.8, 1.6],
            [-0.5, 0.9],
        ],
        ink,
    };
    let plot = LinePlot {
        x: Axis::new("forward force", "1"),
        y: Axis::new("vertical force", "1"),
        regions: vec![
            region("asymmetric", Ink::FORWARD, 0.98),
            region("symmetric", Ink::SYMMETRIC, 0.75),
        ],
        equal_aspect: true,
        ..LinePlot::default()
    };
    Figure::new(
        "fig-polygon",
        "Force envelope",
        "Normalised by the weight.",
        Evidence::Computed,
        plot,
        Provenance::here("envelope", "polygon"),
    )
    .with_paper("Fig. 13")
}

fn legs(phase: f64) -> Vec<Shape> {
    let hip = [0.0, 0.55 + 0.02 * (2.0 * phase).cos()];
    [0.0, std::f64::consts::PI]
        .into_iter()
        .enumerate()
        .map(|(leg, offset)| {
            let swing = 0.5 * (phase + offset).sin();
            let knee = [hip[0] + 0.3 * swing, hip[1] - 0.28];
            let foot = [knee[0] + 0.2 * swing - 0.1, knee[1] - 0.26];
            Shape::Line {
                points: vec![hip, knee, foot],
                ink: Ink::Slot(u8::try_from(leg).unwrap_or(0)),
                width: 4.0,
                dashed: false,
            }
        })
        .collect()
}

fn stride() -> Figure {
    let animation = Animation {
        unit: "m".into(),
        backdrop: vec![Shape::Line {
            points: vec![[-0.8, 0.0], [0.8, 0.0]],
            ink: Ink::Muted,
            width: 1.5,
            dashed: false,
        }],
        frames: (0..16)
            .map(|k| Frame {
                time_s: 0.02 * f64::from(k),
                shapes: legs(std::f64::consts::TAU * f64::from(k) / 16.0),
            })
            .collect(),
        still: vec![0, 5, 10],
        cycle_s: 2.0,
        legend: vec![
            (Ink::Slot(0), "front leg".into()),
            (Ink::Slot(1), "rear leg".into()),
        ],
        description: "Two legs swing.".into(),
    };
    Figure::new(
        "fig-stride",
        "One stride",
        "Slowed down.",
        Evidence::Computed,
        animation,
        Provenance::here("gait", "stride"),
    )
}

fn drawing() -> Figure {
    let drawing: Drawing = bristle(
        7.2,
        0.1,
        7.2,
        -0.278,
        &[
            ("forward", Ink::FORWARD, 0.278),
            ("reverse", Ink::REVERSE, -0.8),
        ],
    );
    Figure::new(
        "fig-bristle",
        "The bristle to scale",
        "Solid lines have the bristle’s own length.",
        Evidence::Published,
        drawing,
        Provenance::here("validation", "bristle"),
    )
    .with_paper("Fig. 2")
}

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

fn claims() -> Vec<ClaimRow> {
    let mut curves = ClaimRow::new(
        "C02",
        "with Table 1 the model matches the measurement in both directions",
        Verdict::Consistent,
        Evidence::Synthetic,
    );
    curves.locator = "section 2.3, Fig. 6".into();
    curves.quote = Some(HOSTILE.into());
    curves.published = "“matches”, no number".into();
    curves.ours = "rmse {{ v(\"demo.rmse\") }}".into();
    curves.tolerance = "rmse below the floor of the repeats".into();
    curves.reason = "a model cannot do better than the runs repeat".into();
    curves.account = "Checked on stand-in data, so the verdict can be *consistent* at best. See [Fig. 6](#fig-curves).\n\nA second paragraph.".into();
    curves.values = vec!["demo.rmse".into()];
    curves.figures = vec!["fig-curves".into(), "fig-absent".into()];
    let mut steady = ClaimRow::new(
        "C09",
        "steady coefficients $\\mu_f$ and $\\mu_r$",
        Verdict::Reproduced,
        Evidence::Published,
    );
    steady.published = "0.9049 [0.90485, 0.90495]".into();
    steady.ours = "{{ ci(\"demo.steady_forward\") }}".into();
    steady.deviation = Some("−0.03 of the last printed digit".into());
    steady.tolerance = "half a unit in the last printed digit".into();
    steady.reason = "printed numbers are intervals".into();
    steady.flips_at = Some("0.00003".into());
    let mut force = ClaimRow::new(
        "C12",
        "forward contact force rises by 12.61, 18.79, 17.52 % at pitch −5, 0, 5°",
        Verdict::Differs,
        Evidence::Computed,
    );
    force.published = "{{ published(\"demo.gain\") }}".into();
    force.ours = "{{ v(\"demo.gain\") }}".into();
    force.multiverse = Some(Multiverse {
        holds: 10,
        of: 12,
        axes: vec![
            ("hip".into(), vec!["centre".into(), "end".into()]),
            ("torso".into(), vec!["free".into(), "fixed".into()]),
        ],
        verdicts: [Verdict::Differs; 10]
            .into_iter()
            .chain([Verdict::Reproduced, Verdict::NotRun])
            .collect(),
        account: "the place of the hip decides".into(),
    });
    vec![
        curves,
        ClaimRow::new(
            "C04",
            "the measurement is highly repeatable",
            Verdict::NotTestable,
            Evidence::Synthetic,
        ),
        steady,
        ClaimRow::new(
            "C16",
            "the 3x3 brush has “six” brushes",
            Verdict::Contradicted,
            Evidence::Published,
        ),
        force,
        ClaimRow::new(
            "C22",
            "the larger force explains the higher speed",
            Verdict::NotRun,
            Evidence::Computed,
        ),
    ]
}

fn sections() -> Vec<Section> {
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

/// The document.
pub fn document() -> Document {
    let values = vec![
        Value::new(
            "demo.sigma0",
            1.640_123,
            "1/rad",
            "validation",
            Evidence::Synthetic,
        )
        .with_ci95(1.622, 1.658)
        .with_published("1.64"),
        Value::new("demo.rmse", 0.0123, "1", "validation", Evidence::Synthetic),
        Value::new(
            "demo.steady_forward",
            0.904_93,
            "1",
            "validation",
            Evidence::Published,
        )
        .with_ci95(0.90485, 0.90495)
        .with_published("0.9049"),
        Value::new(
            "demo.gain",
            18.604,
            "percent",
            "envelope",
            Evidence::Computed,
        )
        .with_published("18.79"),
    ];
    let results =
        serde_json::json!({ "schema": "bristle/results/1", "hostile": HOSTILE, "values": values });
    Document {
        title: "Asymmetric bristle: a demonstration".into(),
        lead: "A made-up document with one of everything. Its numbers mean nothing.".into(),
        subject: Subject {
            reference: format!("Nobody N. “{HOSTILE}” Journal of Nothing 1(1), 2024."),
            doi: Some("10.1000/xyz123".into()),
        },
        header: Header {
            program: "Bristle 0.1.0".into(),
            command: "cargo xtask reproduce".into(),
            inputs: vec![Input {
                path: HOSTILE.into(),
                hash: "blake3:0123".into(),
                kind: "synthetic".into(),
            }],
            facts: vec![
                ("Claims".into(), "6".into()),
                ("Seeds".into(), HOSTILE.into()),
            ],
            stages: vec![("validation".into(), "done".into())],
            repository: Some("https://example.org/bristle".into()),
        },
        run: Run {
            commit: "0123456789abcdef".into(),
            dirty: true,
            rustc: "rustc 1.95.0".into(),
            target: "x86_64-unknown-linux-gnu".into(),
            started: "2024-01-01T00:00:00Z".into(),
            finished: "2024-01-01T00:01:00Z".into(),
            seconds: [("C02".to_string(), 0.8), ("validation".to_string(), 3.2)].into(),
            link: None,
        },
        values,
        claims: claims(),
        deviations: vec![Deviation {
            claim: "C12".into(),
            cause: CauseClass::UnderSpecified,
            account: "The hip’s place is not stated.".into(),
            settles: "The appendix with the dynamics, or the authors’ code.".into(),
        }],
        audit: vec![
            AuditItem {
                id: "A01".into(),
                subject: "Mean of the steady coefficients".into(),
                locator: "section 2.4".into(),
                sum: "$(0.9049 + 0.4314)/2 = 0.66815$, printed 0.6682".into(),
                outcome: AuditOutcome::Holds,
                consequence: "Within rounding.".into(),
                claims: vec!["C09".into()],
            },
            AuditItem {
                id: "A02".into(),
                subject: "Number of brushes".into(),
                locator: "section 2.2".into(),
                sum: "$3 \\times 3 = 9 \\ne 6$".into(),
                outcome: AuditOutcome::Fails,
                consequence: "See [the claim](#C16).".into(),
                claims: vec!["C16".into()],
            },
            AuditItem {
                id: "A03".into(),
                subject: "Full scale of the sensor".into(),
                locator: String::new(),
                sum: "not stated".into(),
                outcome: AuditOutcome::Open,
                consequence: Prose::default(),
                claims: vec![],
            },
        ],
        sections: sections(),
        drift: Some(Drift {
            against: HOSTILE.into(),
            old_identity: "00".into(),
            unchanged: 3,
            rows: vec![DriftRow {
                id: "demo.gain".into(),
                old: Some(18.5),
                new: Some(18.604),
                unit: "percent".into(),
                tolerance_used_percent: Some(41.0),
                class: DriftClass::Algorithm,
                flips: vec!["C12".into()],
            }],
            verdicts: vec![("C12".into(), "reproduced".into(), "differs".into())],
            by_values: vec![("C09".into(), "differs".into(), "consistent".into())],
            platforms: Some(["aarch64, rustc 1".into(), HOSTILE.into()]),
        }),
        doubts: vec!["The load may not be the weight.".into()],
        controls: vec![
            NegativeControl {
                id: "N1".into(),
                mutation: "one published number altered".into(),
                expected: vec!["C09".into()],
                turned: vec!["C09".into()],
            },
            NegativeControl {
                id: "N2".into(),
                mutation: "columns swapped".into(),
                expected: vec!["C02".into()],
                turned: vec![],
            },
        ],
        synthetic: vec!["All campaigns.".into()],
        unpublished: vec!["Raw data.".into()],
        out_of_scope: vec!["Rubber (C14): no numbers.".into()],
        checklist: vec![CheckItem {
            id: "R01".into(),
            source: "ACM".into(),
            question: HOSTILE.into(),
            answer: Answer::Partly,
            evidence: "See the [ledger](#ledger).".into(),
        }],
        choices: vec![Choice {
            subject: "Stribeck exponent".into(),
            taken: "2".into(),
            status: Status::Inferred,
            sensitivity: "Moves $\\omega_{sc}$ only.".into(),
        }],
        glossary: vec![Symbol {
            latex: r"\theta_0".into(),
            meaning: "lean of a bristle at rest".into(),
            unit: "rad".into(),
        }],
        results,
    }
}
