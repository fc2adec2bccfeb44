//! How the identified parameters move with the stiffness that one assumes for the cord.
//!
//! The paper hangs the brush on an elastic cord and gives no stiffness (C19). The campaign that was recorded through a
//! cord is fitted with the cord rigid and with a row of assumed stiffnesses; at each the parameters, the residual and
//! the likelihood are noted. The row is our choice: half-decades over what a cord between string and rod may have.

use campaign::Campaign;
use diagnosis::causes::CordCompliance;
use friction::LawKind;
use identification::{Identification, Question, identify};
use rayon::prelude::*;
use report::figure::{Axis, Figure, Ink, LinePlot, Mark, Provenance, Rule, Series};
use report::{Cell, Column, Evidence, Table, Value};

use super::failed;
use super::figures::stamped;
use crate::stage::StageError;

/// Assumed stiffnesses, N/m, stiffest first.
const STIFFNESSES: [f64; 6] = [1e4, 5e3, 2e3, 1e3, 7e2, 5e2];
/// The same for a quick look.
const QUICK: [f64; 3] = [1e4, 2e3, 1e3];
/// Parameters of the asymmetric law that data can tell, the lean last.
pub(super) const NAMES: [&str; 7] = [
    "theta_c_over_sigma",
    "theta_s_over_sigma",
    "sigma0",
    "sigma1",
    "sigma2",
    "omega_sc",
    "theta0",
];

/// One assumed cord.
struct Point {
    stiffness_n_m: Option<f64>,
    found: Identification,
}

/// The rigid fit and those with assumed cords.
pub(super) struct Sweep {
    evidence: Evidence,
    points: Vec<Point>,
    inputs: Vec<(String, String)>,
}

/// Fits the campaign rigid and with every assumed stiffness.
pub(super) fn sweep(campaign: &Campaign, quick: bool) -> Result<Sweep, StageError> {
    let plain = Question::of(LawKind::AsymmetricBristle).values_only();
    let rigid = identify(campaign, &plain).map_err(failed)?;
    let mut points = vec![Point {
        stiffness_n_m: None,
        found: rigid,
    }];
    let row: &[f64] = if quick { &QUICK } else { &STIFFNESSES };
    // Valleys change with the stiffness, so every fit begins at the record's own starts.
    let corded = row
        .par_iter()
        .map(|&stiffness| {
            let question = Question::of(LawKind::AsymmetricBristle)
                .values_only()
                .with_effects(vec![Box::new(CordCompliance)])
                .holding("compliance_m_n", 1.0 / stiffness)
                .holding("damping_n_s_m", 0.0);
            Ok(Point {
                stiffness_n_m: Some(stiffness),
                found: identify(campaign, &question).map_err(failed)?,
            })
        })
        .collect::<Result<Vec<_>, StageError>>()?;
    points.extend(corded);
    Ok(Sweep {
        evidence: crate::evidence_of(campaign.provenance),
        points,
        inputs: campaign.input_hashes.clone(),
    })
}

impl Sweep {
    fn best(&self) -> &Point {
        let mut best = &self.points[0];
        for point in &self.points {
            if point.found.log_likelihood > best.found.log_likelihood {
                best = point;
            }
        }
        best
    }

    pub(super) fn values(&self) -> Vec<Value> {
        let value = |id: String, number: f64, unit: &str| {
            Value::new(id, number, unit, "identification", self.evidence)
        };
        let mut values = Vec::new();
        for point in &self.points {
            let name = point
                .stiffness_n_m
                .map_or("rigid".to_owned(), |k| format!("{k:.0}"));
            for estimate in &point.found.estimates {
                if NAMES.contains(&estimate.name.as_str()) {
                    let id = format!("identification.cord.{name}.{}", estimate.name);
                    values.push(value(id, estimate.value, &estimate.unit));
                }
            }
            let id = format!("identification.cord.{name}.rmse");
            values.push(value(id, point.found.quality.rmse, "1"));
        }
        let best = self.best().stiffness_n_m.unwrap_or(f64::INFINITY);
        values.push(value(
            "identification.cord.best_stiffness".into(),
            best,
            "N/m",
        ));
        values
    }

    /// Each parameter over its value at the likeliest stiffness, against compliance.
    pub(super) fn figure(&self) -> Figure {
        let reference = &self.best().found;
        let compliance = |point: &Point| point.stiffness_n_m.map_or(0.0, |k| 1e3 / k);
        let mut series: Vec<Series> = NAMES
            .iter()
            .enumerate()
            .map(|(k, name)| {
                let points = self
                    .points
                    .iter()
                    .filter_map(|p| {
                        let ratio = p.found.value(name)? / reference.value(name)?;
                        Some([compliance(p), ratio])
                    })
                    .collect();
                Series::line(name, Ink::Slot(k as u8), points).marked(Mark::LinePoints)
            })
            .collect();
        let rmse = reference.quality.rmse;
        series.push(
            Series::line(
                "residual",
                Ink::Muted,
                self.points
                    .iter()
                    .map(|p| [compliance(p), p.found.quality.rmse / rmse])
                    .collect(),
            )
            .marked(Mark::Points),
        );
        let mut plot = LinePlot::new(
            Axis::new("assumed compliance of the cord", "mm/N"),
            Axis::new("over the value at the likeliest stiffness", "1"),
            series,
        );
        plot.rules = vec![Rule::Horizontal(1.0, String::new())];
        let made = self.provenance();
        Figure::new(
            "identified-cord",
            "What a forgotten cord does to the parameters",
            stamped(self.evidence, "Recorded through a cord, fitted with cords of assumed stiffness; zero compliance is the plain fit. The residual hardly tells, the parameters do."),
            self.evidence,
            plot,
            made,
        )
        .with_claims(&["C01", "C19"])
    }

    #[track_caller]
    fn provenance(&self) -> Provenance {
        let made = Provenance::here("identification", "cord::sweep");
        self.inputs.iter().fold(made, |made, (path, hash)| {
            made.with_input(path.clone(), hash.clone())
        })
    }

    pub(super) fn table(&self) -> Table {
        let best = self.best().found.log_likelihood;
        let rows = self
            .points
            .iter()
            .map(|p| {
                let mut row = vec![p.stiffness_n_m.map_or_else(
                    || Cell::from("rigid"),
                    |k| Cell::Text(format!("{k:.0} N/m")),
                )];
                row.extend(
                    NAMES
                        .iter()
                        .map(|name| Cell::Digits(p.found.value(name).unwrap_or(f64::NAN), 4)),
                );
                row.push(Cell::Digits(p.found.quality.rmse, 3));
                row.push(Cell::Digits(2.0 * (best - p.found.log_likelihood), 4));
                row
            })
            .collect();
        let mut columns = vec![Column::text("cord")];
        columns.extend(NAMES.iter().map(|name| {
            let unit = self.points[0]
                .found
                .estimate(name)
                .map_or("", |e| e.unit.as_str());
            Column::number(super::tables::symbol(name), unit)
        }));
        columns.push(Column::number("residual", "1"));
        columns.push(Column::number("loss of fit", "1"));
        Table {
            id: "identified-cord-table".into(),
            title: "Parameters by assumed stiffness of the cord".into(),
            caption: "Loss of fit: twice the drop of the log-likelihood against the likeliest of the stiffnesses tried.".into(),
            columns,
            rows,
            evidence: Some(self.evidence),
            provenance: Some(self.provenance()),
            claims: vec!["C19".into()],
            ..Table::default()
        }
    }
}
