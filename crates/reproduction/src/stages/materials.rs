//! Three counterfaces alike: direction dependence by difference and by ratio, with intervals.
//!
//! Steady friction of a run is the mean of |mu| from 20 to 60 mm/s. Runs differ by a gain: its relative variance is
//! pooled over both directions of a counterface (r runs, d directions: r - d degrees of freedom), and
//!
//! ```text
//! forward  m_f        sd = m_f s/sqrt(r_f)
//! difference m_f - m_r   sd = s sqrt(m_f^2/r_f + m_r^2/r_r)
//! ratio    m_f/m_r    sd = (m_f/m_r) s sqrt(1/r_f + 1/r_r)
//! ```

use std::collections::BTreeMap;

use campaign::{Campaign, Direction};
use fitting::criteria::t_quantile;
use identification::LEVEL;
use report::figure::{Axis, BarGroup, BarPlot, Figure, Ink, LinePlot, Provenance, Series};
use report::{Block, Cell, Column, Evidence, NoticeKind, Section, Table, Value};
use rig::Experiment;

use super::friction_curves::{coefficient_against_speed, plateaus, runs_in};
use super::identification::{MATERIALS, failed};
use crate::multiverse::{Point, Worlds};
use crate::stage::{Needs, Stage, StageContext, StageError, StageOutput};

/// The stage.
pub(super) struct Materials;

/// The window of steady friction, m/s: after the bristles have bent, up to the top speed. The paper states none.
const WINDOW_M_S: (f64, f64) = (0.02, 0.06);

/// A number with its interval.
#[derive(Clone, Copy)]
struct Measured {
    value: f64,
    half: f64,
}

impl Measured {
    fn interval(self) -> [f64; 2] {
        [self.value - self.half, self.value + self.half]
    }
}

/// Steady friction of one counterface over a window of speeds.
#[derive(Clone, Copy)]
struct Steady {
    forward: Measured,
    reverse: Measured,
    difference: Measured,
    ratio: Measured,
}

impl Steady {
    /// `None` without runs in both directions inside the window (m/s).
    fn of(campaign: &Campaign, window: (f64, f64)) -> Option<Self> {
        let of = |direction| plateaus(campaign, direction, window.0, window.1);
        let (forward, reverse) = (of(Direction::Forward), of(Direction::Reverse));
        if forward.is_empty() || reverse.is_empty() {
            return None;
        }
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let (mf, mr) = (mean(&forward), mean(&reverse));
        let (nf, nr) = (forward.len() as f64, reverse.len() as f64);
        let squares: f64 = forward.iter().map(|x| (x / mf - 1.0).powi(2)).sum::<f64>()
            + reverse.iter().map(|x| (x / mr - 1.0).powi(2)).sum::<f64>();
        let degrees = nf + nr - 2.0;
        let (scatter, quantile) = if degrees > 0.0 {
            ((squares / degrees).sqrt(), t_quantile(LEVEL, degrees))
        } else {
            // One run a direction says nothing of scatter: no interval.
            (f64::NAN, f64::NAN)
        };
        let measured = |value: f64, sd: f64| Measured {
            value,
            half: quantile * sd,
        };
        Some(Self {
            forward: measured(mf, mf * scatter / nf.sqrt()),
            reverse: measured(mr, mr * scatter / nr.sqrt()),
            difference: measured(mf - mr, scatter * (mf * mf / nf + mr * mr / nr).sqrt()),
            ratio: measured(mf / mr, mf / mr * scatter * (1.0 / nf + 1.0 / nr).sqrt()),
        })
    }
}

/// Direction dependence of one counterface.
struct Dependence {
    material: &'static str,
    steady: Steady,
    evidence: Evidence,
    curves: [Vec<[f64; 2]>; 2],
    inputs: Vec<(String, String)>,
}

fn dependence(material: &'static str, campaign: &Campaign) -> Result<Dependence, StageError> {
    let steady = Steady::of(campaign, WINDOW_M_S).ok_or_else(|| {
        StageError::Failed(format!(
            "{}: direction dependence needs runs in both directions between {} and {} mm/s",
            campaign.name,
            1e3 * WINDOW_M_S.0,
            1e3 * WINDOW_M_S.1
        ))
    })?;
    let experiment = Experiment::new(campaign).map_err(failed)?;
    let curve = |direction| {
        runs_in(campaign, direction)
            .first()
            .map(|&k| coefficient_against_speed(&experiment, k, None))
            .unwrap_or_default()
    };
    Ok(Dependence {
        material,
        steady,
        evidence: crate::evidence_of(campaign.provenance),
        curves: [curve(Direction::Forward), curve(Direction::Reverse)],
        inputs: campaign
            .input_hashes
            .iter()
            .map(|(path, hash)| (format!("{}/{path}", campaign.name), hash.clone()))
            .collect(),
    })
}

/// Windows of "steady" that may be meant, m/s.
const WINDOW_STARTS_M_S: [f64; 3] = [0.01, 0.02, 0.03];
const WINDOW_ENDS_M_S: [f64; 2] = [0.05, 0.06];

fn windows() -> impl Iterator<Item = (f64, f64)> {
    WINDOW_STARTS_M_S
        .into_iter()
        .flat_map(|from| WINDOW_ENDS_M_S.map(|to| (from, to)))
}

/// The choices of a window.
fn window_axes() -> Vec<(String, Vec<String>)> {
    let millimetres = |ends: &[f64]| {
        ends.iter()
            .map(|v| format!("{:.0} mm/s", 1e3 * v))
            .collect()
    };
    vec![
        ("window from".into(), millimetres(&WINDOW_STARTS_M_S)),
        ("window to".into(), millimetres(&WINDOW_ENDS_M_S)),
    ]
}

/// The plateaus on aluminium over every window.
fn plateau_worlds(aluminium: &Campaign) -> Worlds {
    let point = |one: Measured| Point {
        value: one.value,
        ci95: Some(one.interval()).filter(|ends| ends.iter().all(|end| end.is_finite())),
    };
    Worlds {
        axes: window_axes(),
        values: windows()
            .map(|window| {
                Steady::of(aluminium, window).map_or_else(BTreeMap::new, |steady| {
                    BTreeMap::from([
                        (
                            "materials.aluminium.steady_forward".to_owned(),
                            point(steady.forward),
                        ),
                        (
                            "materials.aluminium.steady_reverse".to_owned(),
                            point(steady.reverse),
                        ),
                    ])
                })
            })
            .collect(),
    }
}

/// The measure by which counterfaces are put in order, difference or ratio (its logarithm: zero means none), over every
/// window. The judgement compares whatever stands in the place of the difference.
fn order_worlds(campaigns: &[(&'static str, &Campaign)]) -> Worlds {
    let measures: [fn(&Steady) -> f64; 2] = [
        |steady| steady.difference.value,
        |steady| steady.ratio.value.ln(),
    ];
    let mut axes = vec![(
        "measure".to_owned(),
        ["difference", "ratio"].map(String::from).to_vec(),
    )];
    axes.extend(window_axes());
    let world = |measure: fn(&Steady) -> f64, window| -> Option<BTreeMap<String, Point>> {
        campaigns
            .iter()
            .map(|(material, campaign)| {
                let steady = Steady::of(campaign, window)?;
                let id = format!("materials.{material}.difference");
                Some((id, Point::from(measure(&steady))))
            })
            .collect()
    };
    Worlds {
        axes,
        values: measures
            .into_iter()
            .flat_map(|measure| windows().map(move |window| (measure, window)))
            .map(|(measure, window)| world(measure, window).unwrap_or_default())
            .collect(),
    }
}

impl Stage for Materials {
    fn id(&self) -> &'static str {
        "materials"
    }

    fn title(&self) -> &'static str {
        "direction dependence on three counterfaces"
    }

    fn needs(&self) -> Needs {
        Needs {
            campaigns: &[
                "brush-2x2-aluminium",
                "brush-2x2-nylon",
                "brush-2x2-ceramic",
            ],
            stages: &["identification"],
            model: false,
        }
    }

    fn run(&self, context: &StageContext<'_>) -> Result<StageOutput, StageError> {
        let campaigns = MATERIALS
            .iter()
            .map(|(material, name)| Ok((*material, context.campaign(name)?)))
            .collect::<Result<Vec<_>, StageError>>()?;
        let all = campaigns
            .iter()
            .map(|(material, campaign)| dependence(material, campaign))
            .collect::<Result<Vec<_>, _>>()?;
        let mut output = StageOutput::done();
        for one in &all {
            for (part, found) in [
                ("steady_forward", one.steady.forward),
                ("steady_reverse", one.steady.reverse),
                ("difference", one.steady.difference),
                ("ratio", one.steady.ratio),
            ] {
                let id = format!("materials.{}.{part}", one.material);
                let [low, high] = found.interval();
                let mut value = Value::new(id, found.value, "1", "materials", one.evidence)
                    .with_ci95(low, high);
                if one.material == "aluminium" && part.starts_with("steady") {
                    let printed = format!("steady.{}", part.trim_start_matches("steady_"));
                    value =
                        value.with_published(context.published.number(&printed)?.printed.clone());
                }
                output.values.push(value);
            }
        }
        let opened: Vec<(&'static str, &Campaign)> = campaigns
            .iter()
            .map(|(material, campaign)| (*material, &**campaign))
            .collect();
        for (claim, worlds) in [
            ("C05", order_worlds(&opened)),
            ("C09", plateau_worlds(opened[0].1)),
        ] {
            output
                .artefacts
                .extend([worlds.artefact(claim).map_err(failed)?]);
        }
        output.sections = vec![section(&all)];
        Ok(output)
    }
}

/// Names in falling order of a measure, and whether every neighbour pair is clear of the other's interval.
fn order(all: &[Dependence], of: fn(&Dependence) -> Measured) -> (Vec<&'static str>, bool) {
    let mut sorted: Vec<&Dependence> = all.iter().collect();
    sorted.sort_by(|a, b| of(b).value.total_cmp(&of(a).value));
    let clear = sorted
        .windows(2)
        .all(|pair| of(pair[0]).interval()[0] > of(pair[1]).interval()[1]);
    (sorted.iter().map(|one| one.material).collect(), clear)
}

fn section(all: &[Dependence]) -> Section {
    let evidence = if all.iter().any(|one| one.evidence == Evidence::Synthetic) {
        Evidence::Synthetic
    } else {
        Evidence::Measured
    };
    let words = |(names, clear): &(Vec<&str>, bool)| {
        let sure = if *clear {
            "the intervals are apart"
        } else {
            "some intervals overlap"
        };
        format!("{} ({sure})", names.join(", then "))
    };
    let (difference, ratio) = (
        order(all, |one| one.steady.difference),
        order(all, |one| one.steady.ratio),
    );
    let follows = if difference.0 == ratio.0 {
        "Both measures give one order, so the claim does not hang on which is meant."
    } else {
        "The two measures disagree: the claim holds or falls with a measure that the paper does not state. A foot that pushes off with one load feels the difference; a foot that must hold in one direction and slip in the other feels the ratio."
    };
    let mut blocks = Vec::new();
    if evidence == Evidence::Synthetic {
        blocks.push(Block::notice(
            NoticeKind::Synthetic,
            "Stand-in data",
            "Records made from Table 2; the order by either measure is that of the printed parameters.",
        ));
    }
    blocks.extend([
        curves(all, evidence).into(),
        bars(all, evidence).into(),
        table(all, evidence).into(),
        Block::notice(
            NoticeKind::Finding,
            "By difference and by ratio",
            format!(
                "By difference: {}. By ratio: {}. {follows}",
                words(&difference),
                words(&ratio)
            ),
        ),
        Block::prose("The stiffness $\\sigma_0 = k/(N h)$ holds nothing of the counterface, and brush and load were the same; yet the fits give $\\sigma_0$ = {{ v(\"identification.aluminium.sigma0\") }} on aluminium, {{ v(\"identification.nylon.sigma0\") }} on nylon and {{ v(\"identification.ceramic.sigma0\") }} on ceramic. Either the bristle law lumps the counterface into its stiffness, or the deflection is not what it is called. On nylon $\\sigma_2$ comes out as {{ ci(\"identification.nylon.sigma2\") }}: nothing to tell it from zero."),
    ]);
    Section {
        id: "materials".into(),
        title: "Materials: direction dependence on three counterfaces".into(),
        lead: format!(
            "Forward friction exceeds reverse friction on all counterfaces. By difference the order is {}; by ratio {}.",
            difference.0.join(", "),
            ratio.0.join(", ")
        )
        .into(),
        method: Some("Steady friction is the mean of $|\\mu|$ from 20 to 60 mm/s of each run (the paper states no window). Intervals: t quantile on the scatter of the runs' means, pooled over both directions. The parameters are those of the identification, the three campaigns treated alike.".into()),
        status: None,
        claims: ["C05", "C06", "C09", "C21"].map(String::from).to_vec(),
        blocks,
    }
}

#[track_caller]
fn provenance(all: &[Dependence], function: &str) -> Provenance {
    let mut made = Provenance::here("materials", function);
    for (path, hash) in all.iter().flat_map(|one| &one.inputs) {
        made = made.with_input(path.clone(), hash.clone());
    }
    made
}

fn stamped(evidence: Evidence, caption: &str) -> String {
    super::identification::figures::stamped(evidence, caption)
}

fn curves(all: &[Dependence], evidence: Evidence) -> Figure {
    let series = all
        .iter()
        .enumerate()
        .flat_map(|(k, one)| {
            let ink = Ink::Slot(k as u8);
            let [forward, reverse] = one.curves.clone();
            [
                Series::line(&format!("{}, forward", one.material), ink, forward),
                Series::line(&format!("{}, reverse", one.material), ink, reverse),
            ]
        })
        .collect();
    Figure::new(
        "materials-mu-speed",
        "Coefficient of friction on three counterfaces",
        stamped(
            evidence,
            "First run of each direction: the upper curve of each colour is forward.",
        ),
        evidence,
        LinePlot::new(
            Axis::new("speed", "mm/s"),
            Axis::new("coefficient of friction", "1"),
            series,
        ),
        provenance(all, "curves"),
    )
    .with_paper("Fig. 9")
    .with_paper_limits(
        [0.0, 60.0],
        [0.0, 1.2],
        "0 to 60 mm/s: the range of the protocol; the other axis is ours",
    )
    .with_claims(&["C05", "C06"])
}

fn bars(all: &[Dependence], evidence: Evidence) -> Figure {
    let group = |label: &str, ink: Ink, of: fn(&Dependence) -> Measured| BarGroup {
        label: label.into(),
        values: all.iter().map(|one| Some(of(one).value)).collect(),
        intervals: all
            .iter()
            .map(|one| Some(of(one).interval()).filter(|i| i[0].is_finite()))
            .collect(),
        ink,
    };
    let plot = BarPlot {
        categories: all.iter().map(|one| one.material.to_owned()).collect(),
        category_label: "counterface".into(),
        y: Axis::new("direction dependence", "1"),
        groups: vec![
            group("difference, forward less reverse", Ink::Slot(0), |one| {
                one.steady.difference
            }),
            group("ratio, forward over reverse", Ink::Slot(1), |one| {
                one.steady.ratio
            }),
        ],
        rules: vec![report::figure::Rule::Horizontal(
            1.0,
            "ratio without dependence".into(),
        )],
    };
    Figure::new(
        "materials-dependence",
        "Direction dependence by two measures",
        stamped(
            evidence,
            "Bars with 95 % intervals. The order of the counterfaces may depend on the measure.",
        ),
        evidence,
        plot,
        provenance(all, "bars"),
    )
    .with_claims(&["C05"])
}

fn table(all: &[Dependence], evidence: Evidence) -> Table {
    Table {
        id: "materials-steady".into(),
        title: "Steady friction and its dependence on direction".into(),
        caption: "Mean of |mu| from 20 to 60 mm/s with 95 % intervals.".into(),
        columns: vec![
            Column::text("counterface"),
            Column::number("forward", "1"),
            Column::number("reverse", "1"),
            Column::number("difference", "1"),
            Column::number("ratio", "1"),
        ],
        rows: all
            .iter()
            .map(|one| {
                let cell = |part: &str| Cell::Value(format!("materials.{}.{part}", one.material));
                vec![
                    Cell::from(one.material),
                    cell("steady_forward"),
                    cell("steady_reverse"),
                    cell("difference"),
                    cell("ratio"),
                ]
            })
            .collect(),
        evidence: Some(evidence),
        provenance: Some(provenance(all, "table")),
        claims: ["C05", "C09"].map(String::from).to_vec(),
        ..Table::default()
    }
}
