//! How the identified parameters move with the stiffness that one assumes for the cord.
//!
//! The paper hangs the brush on an elastic cord and gives no stiffness (C19). The campaign that was recorded through a
//! cord is fitted with the cord rigid and with a row of assumed stiffnesses; at each the parameters, the residual and
//! the likelihood are noted. The row is our choice: half-decades over what a cord between string and rod may have. The
//! damping is fitted with the law: held at nothing, it would ask for a ringing that no record shows, and the law would
//! bend away from it.

use campaign::Campaign;
use diagnosis::causes::CordCompliance;
use friction::LawKind;
use identification::{Identification, Question, Weighting, identify};
use rayon::prelude::*;
use report::figure::{Axis, Figure, Ink, LinePlot, Mark, Provenance, Rule, Series};
use report::{Cell, Column, Evidence, Table, Value};

use super::failed;
use super::figures::stamped;
use super::relative::{Curve, lines, ratio};
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

/// Damping of the cord, fitted.
const DAMPING: &str = "damping_n_s_m";

/// One assumed cord.
struct Point {
    stiffness_n_m: Option<f64>,
    found: Identification,
}

impl Point {
    /// Log-likelihood under the noise of the record; a fit that misses the record has none that could be compared.
    fn log_likelihood(&self) -> Option<f64> {
        (self.found.weighting == Weighting::Noise).then_some(self.found.log_likelihood)
    }
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
                .holding("compliance_m_n", 1.0 / stiffness);
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
    /// The likeliest of the points, the rigid one where none has a likelihood.
    fn best(&self) -> &Point {
        let mut best = &self.points[0];
        for point in &self.points {
            if point.log_likelihood() > best.log_likelihood() {
                best = point;
            }
        }
        best
    }

    /// What the row shows, in words.
    pub(super) fn words(&self) -> String {
        let likeliest = match self.best().stiffness_n_m {
            Some(_) => {
                "The likelihood is highest with a cord of {{ v(\"identification.cord.best_stiffness\") }} among those tried."
            }
            None => "No cord among those tried is likelier than a rigid one.",
        };
        format!(
            "This campaign was recorded through an elastic cord. Fitted as if the cord were rigid, the curves still look good by eye, with a residual of {{{{ v(\"identification.cord.rigid.rmse\") }}}}, but $\\theta_s/\\sigma$ comes out at {{{{ v(\"identification.cord.rigid.theta_s_over_sigma\") }}}} and $\\sigma_1$ at {{{{ v(\"identification.cord.rigid.sigma1\") }}}}. {likeliest} The paper gives no stiffness: Table 1 may hold the cord as well as the brush."
        )
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
            let mut add = |part: &str, number: f64, unit: &str| {
                let id = format!("identification.cord.{name}.{part}");
                values.push(value(id, number, unit));
            };
            if let Some(damping) = point.found.value(DAMPING) {
                add("damping", damping, "N s/m");
            }
            add("rmse", point.found.quality.rmse, "1");
        }
        if let Some(best) = self.best().stiffness_n_m {
            let id = "identification.cord.best_stiffness".into();
            values.push(value(id, best, "N/m"));
        }
        values
    }

    /// Each parameter over its value at the likeliest stiffness, against compliance.
    pub(super) fn figure(&self) -> Figure {
        let reference = &self.best().found;
        let compliance = |point: &Point| point.stiffness_n_m.map_or(0.0, |k| 1e3 / k);
        let curves: Vec<Curve> = NAMES
            .iter()
            .map(|name| {
                let at = |p: &Point| {
                    let ratio = ratio(p.found.value(name)?, reference.value(name)?)?;
                    Some([compliance(p), ratio])
                };
                let points = self.points.iter().filter_map(at).collect();
                ((*name).to_owned(), points)
            })
            .collect();
        let (mut series, missing) = lines(curves);
        let rmse = reference.quality.rmse;
        series.push(
            Series::line(
                "residual",
                Ink::Muted,
                self.points
                    .iter()
                    .filter_map(|p| Some([compliance(p), ratio(p.found.quality.rmse, rmse)?]))
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
            stamped(self.evidence, &format!("Recorded through a cord, fitted with cords of assumed stiffness; zero compliance is the plain fit. Parameters and residual, each over its value at the likeliest stiffness.{missing}")),
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
        let number = |value: Option<f64>, digits, otherwise: &str| {
            value.map_or_else(
                || Cell::Missing(otherwise.to_owned()),
                |value| Cell::Digits(value, digits),
            )
        };
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
                row.push(number(p.found.value(DAMPING), 3, "no cord"));
                row.push(Cell::Digits(p.found.quality.rmse, 3));
                let loss = p.log_likelihood().map(|own| 2.0 * (best - own));
                row.push(number(loss, 4, "misses the record"));
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
        columns.push(Column::number("damping", "N s/m"));
        columns.push(Column::number("residual", "1"));
        columns.push(Column::number("loss of fit", "1"));
        Table {
            id: "identified-cord-table".into(),
            title: "Parameters by assumed stiffness of the cord".into(),
            caption: "Stiffness assumed, damping fitted with the law. Loss of fit: twice the drop of the log-likelihood against the likeliest of the stiffnesses tried. A fit that misses the record by more than its noise is made with all samples weighted alike and has no likelihood to compare.".into(),
            columns,
            rows,
            evidence: Some(self.evidence),
            provenance: Some(self.provenance()),
            claims: vec!["C19".into()],
            ..Table::default()
        }
    }
}
