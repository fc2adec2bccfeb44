//! The report of one campaign: a short document with the same parts as the large one.

use campaign::Campaign;
use report::figure::{Axis, Figure, Ink, LinePlot, Provenance, Series};
use report::{Document, Header, Input, Run, Section, Subject, literal};

use crate::evidence_of;

/// Runs that a figure of a single campaign shows: more would hide each other.
const SHOWN_RUNS: usize = 4;
/// Points that a line of such a figure needs at most.
const SHOWN_POINTS: usize = 1500;

/// A document about one campaign.
pub(crate) fn document(
    campaign: &Campaign,
    title: &str,
    lead: String,
    command: &str,
    run: Run,
    sections: Vec<Section>,
    results: serde_json::Value,
) -> Document {
    let kind = evidence_of(campaign.provenance).word();
    Document {
        title: format!("{title}: {}", campaign.title),
        lead: lead.into(),
        subject: Subject {
            reference: campaign.title.clone(),
            doi: None,
        },
        header: Header {
            program: format!("Bristle {}", env!("CARGO_PKG_VERSION")),
            command: command.to_owned(),
            inputs: campaign
                .input_hashes
                .iter()
                .map(|(path, hash)| Input {
                    path: path.clone(),
                    hash: format!("blake3:{hash}"),
                    kind: kind.to_owned(),
                })
                .collect(),
            ..Header::default()
        },
        run,
        sections,
        results,
        synthetic: match campaign.provenance {
            campaign::Provenance::Synthetic => {
                vec![
                    format!(
                        "`{}`: its metadata say that a program made it",
                        literal(&campaign.name)
                    )
                    .into(),
                ]
            }
            campaign::Provenance::Measured => Vec::new(),
        },
        ..Document::default()
    }
}

/// Unit of the recorded force.
pub(crate) fn force_unit(campaign: &Campaign) -> &'static str {
    match campaign.axis {
        campaign::Axis::Linear => "N",
        campaign::Axis::Rotary => "N m",
    }
}

/// Residual (recorded less predicted force) of the first runs against time. `predicted` is stacked by run.
pub(crate) fn residual_figure(campaign: &Campaign, predicted: &[f64], id: &str) -> Figure {
    let mut start = 0;
    let mut series = Vec::new();
    for (run, ink) in campaign
        .runs
        .iter()
        .zip((0_u8..).map(Ink::Slot))
        .take(SHOWN_RUNS)
    {
        let end = start + run.time_s.len();
        let residual = run
            .force_n
            .iter()
            .zip(&predicted[start..end])
            .map(|(f, p)| f - p);
        let points: Vec<[f64; 2]> = run
            .time_s
            .iter()
            .zip(residual)
            .map(|(t, r)| [*t, r])
            .collect();
        series.push(Series::dots(&run.name, ink, thinned(points)));
        start = end;
    }
    let plot = LinePlot::new(
        Axis::new("time in the run", "s"),
        Axis::new("recorded less predicted force", force_unit(campaign)),
        series,
    );
    Figure::new(
        id,
        "What the law leaves",
        format!(
            "Residual of the first {} of {} runs. Structure that repeats from run to run is something that the law does not say.",
            campaign.runs.len().min(SHOWN_RUNS),
            campaign.runs.len()
        ),
        evidence_of(campaign.provenance),
        plot,
        Provenance::here("identify", "residual_figure"),
    )
}

/// Recorded and predicted force of one run against velocity.
pub(crate) fn fit_figure(campaign: &Campaign, predicted: &[f64], id: &str) -> Figure {
    let run = &campaign.runs[0];
    let against = |force: &[f64]| -> Vec<[f64; 2]> {
        thinned(
            run.velocity_m_s
                .iter()
                .zip(force)
                .map(|(v, f)| [1000.0 * v, *f])
                .collect(),
        )
    };
    let unit = match campaign.axis {
        campaign::Axis::Linear => "mm/s",
        campaign::Axis::Rotary => "mrad/s",
    };
    let plot = LinePlot::new(
        Axis::new("velocity", unit),
        Axis::new("force", force_unit(campaign)),
        vec![
            Series::dots("recorded", Ink::DATA, against(&run.force_n)),
            Series::line(
                "predicted",
                Ink::FORWARD,
                against(&predicted[..run.time_s.len()]),
            ),
        ],
    );
    Figure::new(
        id,
        "Recorded and predicted force",
        format!("Run {} against its velocity.", literal(&run.name)),
        evidence_of(campaign.provenance),
        plot,
        Provenance::here("identify", "fit_figure"),
    )
}

/// Every n-th point, so that no more than the page needs are drawn.
fn thinned(points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let step = points.len().div_ceil(SHOWN_POINTS).max(1);
    points.into_iter().step_by(step).collect()
}
