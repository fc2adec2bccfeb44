//! A diagnosis as a person would tell it: the chain with the guilty station marked, curves before and after with the
//! noise band, rivals and what they lose, what remains unexplained and where, what to measure next.

use campaign::Campaign;
use diagnosis::answer::{Diagnosis, Finding, Hidden, Share, Undecidable};
use diagnosis::{Curves, Diagnosed, Status};
use report::figure::{Axis, Band, BarGroup, BarPlot, Figure, Ink, LinePlot, Provenance, Series};
use report::{
    Block, Cell, Chain, Column, NoticeKind, Section, Station, Suspect, SuspectState, Table, literal,
};

use crate::evidence_of;

/// Stage and function that stand on every figure.
const STAGE: &str = "diagnosis";
/// Runs in the figure of curves: the first one each way.
const SHOWN_RUNS: usize = 2;
/// Points of a line.
const SHOWN_POINTS: usize = 600;

/// What the page says first.
pub(crate) fn lead(answer: &Diagnosis) -> String {
    let named: Vec<String> = answer.findings.iter().map(phrase).collect();
    match answer.status {
        Status::Consistent => "The law agrees with this campaign to within its noise: no cause is named, and no gain may be claimed. \
             The table of hidden sizes says how large an effect of each cause could have gone unseen."
            .to_owned(),
        Status::Explained => format!("The law errs beyond the noise, and the error has a cause: {}.", named.join("; ")),
        Status::Ambiguous => format!(
            "The law errs beyond the noise. This protocol cannot tell its possible causes apart: {}.",
            named.join("; ")
        ),
        Status::Unexplained if named.is_empty() => {
            "The law errs beyond the noise, and no cause of the catalogue explains the error: it stays without a name."
                .to_owned()
        }
        Status::Unexplained => format!(
            "A part of the error has a cause ({}), and structure is left that no cause of the catalogue explains.",
            named.join("; ")
        ),
    }
}

fn phrase(finding: &Finding) -> String {
    if finding.equivalent.is_empty() {
        format!("`{}`", finding.cause)
    } else {
        format!(
            "`{}`, or as well `{}`",
            finding.cause,
            finding.equivalent.join("`, `")
        )
    }
}

/// The blocks of one campaign's diagnosis; `prefix` keeps ids apart on a page with several.
pub(crate) fn blocks(campaign: &Campaign, diagnosed: &Diagnosed, prefix: &str) -> Vec<Block> {
    let answer = &diagnosed.answer;
    let evidence = evidence_of(campaign.provenance);
    let mut blocks = vec![Block::Chain(chain(answer, prefix))];
    for note in &answer.notes {
        blocks.push(Block::notice(NoticeKind::Note, "Note", literal(note)));
    }
    if answer.unexplained.detected
        && let Some(place) = &answer.unexplained.r#where
    {
        blocks.push(Block::notice(
            NoticeKind::Refusal,
            "Left without a name",
            format!(
                "Structure is left along {}; the table of findings gives the stretch. Nothing in the catalogue explains it.",
                literal(&place.axis)
            ),
        ));
    }
    if !answer.findings.is_empty() || answer.unexplained.detected {
        blocks.push(findings(answer, evidence, prefix).into());
        blocks.push(curves(campaign, &diagnosed.curves, prefix).into());
    }
    if answer
        .findings
        .iter()
        .any(|f| !f.evidence.rivals.is_empty())
    {
        blocks.push(rivals(answer, evidence, prefix).into());
    }
    if lies_nowhere(&answer.anatomy) {
        blocks.push(Block::prose(nowhere(&answer.anatomy)));
    } else if !answer.anatomy.is_empty() {
        blocks.push(shares(campaign, answer, prefix).into());
    }
    if !answer.laws.is_empty() {
        blocks.push(laws(answer, evidence, prefix).into());
    }
    if answer.status == Status::Consistent {
        blocks.push(hidden(answer, evidence, prefix).into());
    }
    if !answer.undecidable.is_empty() {
        blocks.push(undecidable(&answer.undecidable, evidence, prefix).into());
    }
    blocks
}

/// A section of its own for one campaign.
pub(crate) fn section(campaign: &Campaign, diagnosed: &Diagnosed) -> Section {
    Section {
        id: "diagnosis".into(),
        title: "What the simulation gets wrong".into(),
        lead: lead(&diagnosed.answer).into(),
        blocks: blocks(campaign, diagnosed, "diagnosis"),
        ..Section::default()
    }
}

fn chain(answer: &Diagnosis, prefix: &str) -> Chain {
    let roles = [
        ("stage", "moves the plate"),
        ("coupling", "holds the specimen"),
        ("law", "makes friction of speed"),
        ("surface", "gives the place its friction"),
        ("history", "remembers what went before"),
        ("load", "presses"),
        ("sensor", "reads the force"),
        ("clock", "stamps the time"),
    ];
    let state = |id: &str| -> (SuspectState, &'static str) {
        if answer.findings.iter().any(|f| f.cause == id) {
            (SuspectState::Found, "explains the error")
        } else if answer
            .findings
            .iter()
            .any(|f| f.equivalent.iter().any(|e| e == id))
        {
            (SuspectState::Equivalent, "explains it as well")
        } else if answer
            .undecidable
            .iter()
            .any(|u| u.causes.iter().any(|c| c == id))
        {
            (SuspectState::Undecidable, "the last table says why")
        } else {
            (SuspectState::RuledOut, "")
        }
    };
    let catalogue = diagnosis::causes::catalogue();
    let stations = roles
        .iter()
        .map(|(name, role)| {
            let mut ids: Vec<&str> = catalogue
                .iter()
                .filter(|c| c.station().id() == *name)
                .map(|c| c.id())
                .collect();
            ids.dedup();
            let mut suspects: Vec<Suspect> = ids
                .into_iter()
                .map(|id| {
                    let (state, note) = state(id);
                    Suspect {
                        label: id.into(),
                        state,
                        note: note.into(),
                    }
                })
                .collect();
            suspects.sort_by_key(|s| {
                !matches!(s.state, SuspectState::Found | SuspectState::Equivalent)
            });
            Station {
                name: (*name).into(),
                role: (*role).into(),
                suspects,
            }
        })
        .collect();
    Chain {
        id: format!("{prefix}-chain"),
        caption: "The measurement chain, from the stage to the recorded force, with the suspects at each station.".into(),
        stations,
    }
}

fn interval(value: f64, ci95: Option<[f64; 2]>) -> Cell {
    ci95.map_or_else(|| Cell::from(value), |ci| Cell::Interval(value, ci))
}

fn findings(answer: &Diagnosis, evidence: report::Evidence, prefix: &str) -> Table {
    let mut rows = Vec::new();
    for finding in &answer.findings {
        for (k, parameter) in finding.parameters.iter().enumerate() {
            let first = k == 0;
            let gain = finding.gain.as_ref().and_then(|g| g.explained_fraction);
            rows.push(vec![
                // Every row says whose parameter it is: a header of a row is never empty.
                finding.cause.clone().into(),
                parameter.name.clone().into(),
                interval(parameter.value, parameter.ci95),
                parameter.unit.clone().into(),
                if first {
                    finding.probability.into()
                } else {
                    "".into()
                },
                match (first, gain) {
                    (true, Some(g)) => g.into(),
                    (true, None) => Cell::Missing(
                        "not judged: no run can be left out, or within the floor's uncertainty"
                            .into(),
                    ),
                    _ => "".into(),
                },
                if first {
                    finding.experiment.clone().unwrap_or_default().into()
                } else {
                    "".into()
                },
            ]);
        }
    }
    if let Some(place) = answer
        .unexplained
        .r#where
        .as_ref()
        .filter(|_| answer.unexplained.detected)
    {
        rows.push(vec![
            "(unexplained)".into(),
            format!("along {}", place.axis).into(),
            Cell::Interval(0.5 * (place.from + place.to), [place.from, place.to]),
            place.unit.clone().into(),
            "".into(),
            "".into(),
            "".into(),
        ]);
    }
    Table {
        id: format!("{prefix}-findings"),
        title: "What was found".into(),
        caption: "Named causes with their sizes (95 % intervals), their posterior weight (none of these counted), the share of the \
                  explainable error that each removes on runs left out, and the run that would separate it from causes that explain \
                  the campaign as well."
            .into(),
        columns: vec![
            Column::text("cause"),
            Column::text("parameter"),
            Column::number("value", ""),
            Column::text("unit"),
            Column::number("weight", ""),
            Column::number("gain", "1"),
            Column::text("next experiment"),
        ],
        rows,
        evidence: Some(evidence),
        provenance: Some(Provenance::here(STAGE, "findings")),
        ..Table::default()
    }
}

fn rivals(answer: &Diagnosis, evidence: report::Evidence, prefix: &str) -> Table {
    let rows = answer
        .findings
        .iter()
        .flat_map(|finding| {
            finding.evidence.rivals.iter().take(5).map(|rival| {
                vec![
                    finding.cause.clone().into(),
                    rival.cause.clone().into(),
                    rival.delta.into(),
                    rival
                        .separation
                        .map_or(Cell::Missing("not computed".into()), Cell::from),
                ]
            })
        })
        .collect();
    Table {
        id: format!("{prefix}-rivals"),
        title: "Rivals and what they lose".into(),
        caption: "Log-likelihood of the campaign with the rival in the cause's place, less that with the cause; and how far apart the \
                  two predictions stay when the rival imitates the cause as well as it can, in standard deviations of the noise."
            .into(),
        columns: vec![
            Column::text("cause"),
            Column::text("rival"),
            Column::number("log-likelihood lost", ""),
            Column::number("separation", "sd"),
        ],
        rows,
        evidence: Some(evidence),
        provenance: Some(Provenance::here(STAGE, "rivals")),
        ..Table::default()
    }
}

fn laws(answer: &Diagnosis, evidence: report::Evidence, prefix: &str) -> Table {
    Table {
        id: format!("{prefix}-laws"),
        title: "All laws on this campaign".into(),
        caption: "Each law fitted alone: error of the fit, and corrected Akaike criterion above the best law's. All laws are compared under one noise, that beneath the law whose fit errs least: runs may differ by gains as far as they do beside that law, and what is sharp counts more than what is slow, so that error and criterion need not order alike.".into(),
        columns: vec![
            Column::text("law"),
            Column::number("error", &answer.noise_floor.unit),
            Column::number("criterion above best", ""),
        ],
        rows: answer
            .laws
            .iter()
            .map(|l| vec![l.law.clone().into(), l.rmse.into(), l.delta_aicc.into()])
            .collect(),
        evidence: Some(evidence),
        provenance: Some(Provenance::here(STAGE, "laws")),
        ..Table::default()
    }
}

fn hidden(answer: &Diagnosis, evidence: report::Evidence, prefix: &str) -> Table {
    let mut hidden: Vec<_> = answer.hidden.iter().collect();
    hidden.sort_by(|a, b| (&a.cause, &a.parameter).cmp(&(&b.cause, &b.parameter)));
    Table {
        id: format!("{prefix}-hidden"),
        title: "What could have hidden".into(),
        caption:
            "For each cause the size that this campaign would have shown in nine cases of ten."
                .into(),
        columns: vec![
            Column::text("cause"),
            Column::text("parameter"),
            Column::number("size", ""),
            Column::text("unit"),
        ],
        rows: hidden
            .into_iter()
            .map(|h| {
                vec![
                    h.cause.clone().into(),
                    h.parameter.clone().into(),
                    size(h),
                    report::printed_unit(&h.unit).into(),
                ]
            })
            .collect(),
        evidence: Some(evidence),
        provenance: Some(Provenance::here(STAGE, "hidden")),
        ..Table::default()
    }
}

/// The size of a cause that would be found.
pub(crate) fn size(hidden: &Hidden) -> Cell {
    let absorbed = Cell::Missing("no size: the law absorbs it".into());
    hidden.size.map_or(absorbed, Cell::from)
}

/// What a protocol ties together or cannot show, and what would decide.
pub(crate) fn undecidable(open: &[Undecidable], evidence: report::Evidence, prefix: &str) -> Table {
    Table {
        id: format!("{prefix}-undecidable"),
        title: "What this protocol cannot decide, and what would".into(),
        caption: "Causes that this protocol ties together or cannot show, and the cheapest experiment that breaks each tie.".into(),
        columns: vec![Column::text("causes"), Column::text("because"), Column::text("experiment")],
        rows: open
            .iter()
            .map(|u| vec![u.causes.join(", ").into(), u.because.clone().into(), u.experiment.clone().into()])
            .collect(),
        evidence: Some(evidence),
        provenance: Some(Provenance::here(STAGE, "undecidable")),
        ..Table::default()
    }
}

/// Recorded force, law alone, law with the named causes and the noise band, the first run each way.
fn curves(campaign: &Campaign, curves: &Curves, prefix: &str) -> Figure {
    let mut shown: Vec<usize> = Vec::new();
    for direction in [campaign::Direction::Forward, campaign::Direction::Reverse] {
        shown.extend(campaign.runs.iter().position(|r| r.direction == direction));
    }
    if shown.is_empty() {
        shown.push(0);
    }
    shown.truncate(SHOWN_RUNS);
    let mut series = Vec::new();
    let mut bands = Vec::new();
    for &k in &shown {
        let run = curves.runs[k].clone();
        let step = run.len().div_ceil(SHOWN_POINTS).max(1);
        let points = |y: &[f64]| -> Vec<[f64; 2]> {
            run.clone()
                .step_by(step)
                .map(|i| [curves.time_s[i], y[i]])
                .collect()
        };
        bands.push(Band {
            label: "noise, 95 %".into(),
            points: run
                .clone()
                .step_by(step)
                .map(|i| {
                    let (m, h) = (curves.extended[i], curves.band[i]);
                    [curves.time_s[i], m - h, m + h]
                })
                .collect(),
            ink: Ink::EXTENDED,
        });
        series.push(Series::dots(
            "recorded",
            Ink::DATA,
            points(&curves.measured),
        ));
        series.push(Series::line("law alone", Ink::FORWARD, points(&curves.law)));
        series.push(Series::line(
            "law with the named causes",
            Ink::EXTENDED,
            points(&curves.extended),
        ));
    }
    let unit = match campaign.axis {
        campaign::Axis::Linear => "N",
        campaign::Axis::Rotary => "N m",
    };
    let mut plot = LinePlot::new(
        Axis::new("time in the run", "s"),
        Axis::new("force", unit),
        series,
    );
    plot.bands = bands;
    Figure::new(
        &format!("{prefix}-curves"),
        "Before and after",
        "Recorded force, the law alone, and the law with the named causes within the noise band; the first run each way (that in reverse has the negative forces).",
        evidence_of(campaign.provenance),
        plot,
        Provenance::here(STAGE, "curves"),
    )
}

/// Whether the axes were looked along and none holds a share of the error: a chart of it would be empty.
fn lies_nowhere(anatomy: &[Share]) -> bool {
    !anatomy.is_empty() && anatomy.iter().all(|axis| axis.share <= 0.0)
}

/// What stands in the place of the empty chart.
fn nowhere(anatomy: &[Share]) -> String {
    let axes: Vec<&str> = anatomy.iter().map(|axis| axis.axis.as_str()).collect();
    literal(&format!(
        "Where the error of the law alone lies: nowhere. Along none of the axes {} do the means of the residual hold more than noise leaves, so there is no share to draw.",
        axes.join(", ")
    ))
}

/// Shares of the explainable error along each axis.
fn shares(campaign: &Campaign, answer: &Diagnosis, prefix: &str) -> Figure {
    let groups = vec![BarGroup {
        label: "law alone".into(),
        ink: Ink::FORWARD,
        values: answer.anatomy.iter().map(|s| Some(s.share)).collect(),
        intervals: Vec::new(),
    }];
    let plot = BarPlot {
        categories: answer.anatomy.iter().map(|s| s.axis.clone()).collect(),
        category_label: "axis".into(),
        y: Axis::new("share of the explainable error", "1").between(0.0, 1.0),
        groups,
        ..BarPlot::default()
    };
    Figure::new(
        &format!("{prefix}-anatomy"),
        "Where the error of the law alone lies",
        format!(
            "Share of the explainable error (total less noise floor) that the means in bins along each axis hold. In a ramp, time, place \
             and speed are one another, so shares overlap.{}",
            if answer.status == Status::Consistent {
                " The law agrees with this campaign to within its noise: what is shared out here is a remainder that noise alone can leave."
            } else {
                ""
            }
        ),
        evidence_of(campaign.provenance),
        plot,
        Provenance::here(STAGE, "shares"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn along(axis: &str, share: f64) -> Share {
        Share {
            axis: axis.into(),
            share,
            profile: Vec::new(),
            unit: "1".into(),
        }
    }

    #[test]
    fn an_anatomy_without_any_share_is_told_in_words() {
        let flat = [along("time", 0.0), along("speed", 0.0)];
        assert!(lies_nowhere(&flat));
        assert!(nowhere(&flat).contains("time, speed"));
        assert!(!lies_nowhere(&[along("time", 0.0), along("speed", 0.2)]));
        assert!(!lies_nowhere(&[]), "nothing was looked at: nothing is said");
    }
}
