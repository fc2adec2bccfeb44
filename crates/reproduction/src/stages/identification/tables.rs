//! Tables of the stage.

use fitting::Verdict;
use identification::LawFit;
use report::figure::Provenance;
use report::{Cell, Column, Evidence, Table};

use super::cord::NAMES;
use super::{HeldLean, Identified};

pub(super) fn symbol(name: &str) -> &str {
    match name {
        "theta_c_over_sigma" => "$\\theta_c/\\sigma$",
        "theta_s_over_sigma" => "$\\theta_s/\\sigma$",
        "sigma0" => "$\\sigma_0$",
        "sigma1" => "$\\sigma_1$",
        "sigma2" => "$\\sigma_2$",
        "omega_sc" => "$\\omega_{sc}$",
        "theta0" => "$\\theta_0$",
        other => other,
    }
}

#[track_caller]
fn provenance(function: &str, one: &Identified) -> Provenance {
    let mut made = Provenance::here("identification", function);
    for (path, hash) in &one.campaign.input_hashes {
        made = made.with_input(format!("{}/{path}", one.campaign.name), hash.clone());
    }
    made
}

/// The same where all counterfaces take part.
#[track_caller]
fn all_of(function: &str, materials: &[Identified]) -> Provenance {
    let made = Provenance::here("identification", function);
    let inputs = materials
        .iter()
        .flat_map(|one| provenance(function, one).inputs);
    inputs.fold(made, |made, (path, hash)| made.with_input(path, hash))
}

pub(super) fn parameters(one: &Identified) -> Table {
    let stem = format!("identification.{}", one.material);
    let inside: Vec<&str> = one
        .found
        .estimates
        .iter()
        .filter(|e| !e.held && e.at_bound.is_none())
        .map(|e| e.name.as_str())
        .collect();
    let rows = one
        .found
        .estimates
        .iter()
        .map(|e| {
            let published = report::Prose(if e.name == "theta0" {
                "not printed".into()
            } else {
                format!("{{{{ published(\"{stem}.{}\") }}}}", e.name)
            });
            let drivers = e.drivers;
            let boot = one.bootstrap.as_ref().and_then(|draws| {
                let column = inside.iter().position(|n| *n == e.name)?;
                draws.percentile_interval(column, identification::LEVEL)
            });
            vec![
                Cell::Prose(symbol(&e.name).into()),
                Cell::Value(format!("{stem}.{}", e.name)),
                Cell::Prose(published),
                drivers.map_or_else(|| "".into(), |d| Cell::Digits(100.0 * d.gain_share, 2)),
                drivers.map_or_else(|| "".into(), |d| Cell::Digits(d.degrees, 2)),
                boot.map_or_else(
                    || Cell::Missing("on a bound".into()),
                    |(low, high)| Cell::Interval(e.value, [low, high]),
                ),
                Cell::Text(words(e.verdict, e.at_bound.is_some())),
            ]
        })
        .collect();
    Table {
        id: "identified-parameters".into(),
        title: "Parameters of the asymmetric law, 2x2 brush on aluminium".into(),
        caption: "95 % intervals by profile likelihood. Gain: share of the variance that comes from the gains of the runs; freedom: degrees of freedom of the t quantile. The bootstrap (percentiles over resampled runs) is printed as a diagnostic: with so few runs it is too narrow and may leave out the estimate itself.".into(),
        columns: vec![
            Column::text("parameter"),
            Column::number("value and 95 % interval", ""),
            Column::number("printed", ""),
            Column::number("gain", "%"),
            Column::number("freedom", ""),
            Column::number("bootstrap", ""),
            Column::text("the data"),
        ],
        rows,
        evidence: Some(one.evidence),
        paper: Some("Table 1".into()),
        provenance: Some(provenance("identify", one)),
        claims: ["C01", "C18"].map(String::from).to_vec(),
    }
}

/// The parameters on all counterfaces beside the printed ones.
pub(super) fn counterfaces(materials: &[Identified]) -> Table {
    let row = |one: &Identified, name: &str| {
        let id = format!("identification.{}.{name}", one.material);
        let printed = if name == "theta0" {
            "not printed".to_owned()
        } else {
            format!("{{{{ published(\"{id}\") }}}}")
        };
        vec![
            Cell::Prose(format!("{}, {}", one.material, symbol(name)).into()),
            Cell::Prose(printed.into()),
            Cell::Value(id),
        ]
    };
    Table {
        id: "identified-counterfaces".into(),
        title: "Parameters on three counterfaces".into(),
        caption: "The printed numbers and ours with their 95 % intervals. Of $\\sigma$, $\\theta_c$ and $\\theta_s$ only the ratios can be compared.".into(),
        columns: vec![
            Column::text("counterface, parameter"),
            Column::number("printed", ""),
            Column::number("value and 95 % interval", ""),
        ],
        rows: materials
            .iter()
            .flat_map(|one| NAMES.iter().map(move |name| row(one, name)))
            .collect(),
        evidence: Some(weakest(materials)),
        paper: Some("Table 2".into()),
        provenance: Some(all_of("identify", materials)),
        claims: vec!["C06".into()],
    }
}

/// Half widths beside the least that the records allow.
pub(super) fn widths(materials: &[Identified]) -> Table {
    let normal = fitting::criteria::t_quantile(identification::LEVEL, f64::INFINITY);
    let percent = |half: Option<f64>, value: f64, why: &str| match half {
        Some(half) if half.is_finite() && value != 0.0 => {
            Cell::Digits(100.0 * half / value.abs(), 2)
        }
        _ => Cell::Missing(why.into()),
    };
    let rows = materials
        .iter()
        .flat_map(|one| {
            one.found.estimates.iter().enumerate().map(move |(j, e)| {
                let half = e
                    .interval
                    .as_ref()
                    .map(|i| (i.high() - e.value).max(e.value - i.low()));
                let least = one.least_sd.as_ref().map(|all| normal * all[j]);
                vec![
                    Cell::Prose(format!("{}, {}", one.material, symbol(&e.name)).into()),
                    percent(half, e.value, "open or at zero"),
                    percent(least, e.value, "no bound, or at zero"),
                ]
            })
        })
        .collect();
    Table {
        id: "identified-widths".into(),
        title: "How narrow the intervals are, and how narrow they can be".into(),
        caption: "Half widths of the 95 % intervals in percent of the value. Least: the Cramér-Rao bound of these motions under the estimated noise, if that noise were known; a parameter that lies on a bound leaves less open than it allows for. Where both are wide the protocol lacks the information: another record would help, another estimator would not.".into(),
        columns: vec![
            Column::text("counterface, parameter"),
            Column::number("half width", "%"),
            Column::number("least", "%"),
        ],
        rows,
        evidence: Some(weakest(materials)),
        provenance: Some(all_of("widths", materials)),
        claims: ["C01", "C06"].map(String::from).to_vec(),
        ..Table::default()
    }
}

fn words(verdict: Verdict, at_bound: bool) -> String {
    match (verdict, at_bound) {
        (_, true) => "on its bound: one-sided".into(),
        (Verdict::Identifiable, _) => "determine it".into(),
        (Verdict::PracticallyNonIdentifiable, _) => "hide it in their noise".into(),
        (Verdict::StructurallyNonIdentifiable, _) => "cannot determine it".into(),
    }
}

pub(super) fn noise(materials: &[Identified]) -> Table {
    let rows = materials
        .iter()
        .map(|one| {
            let cell = |part: &str| Cell::Value(format!("identification.{}.{part}", one.material));
            vec![
                Cell::from(one.material),
                cell("run_scatter"),
                cell("roughness_private"),
                cell("roughness_plate"),
                cell("roughness_length"),
                cell("sensor_noise"),
                cell("lack_of_fit_p"),
            ]
        })
        .collect();
    Table {
        id: "identified-noise".into(),
        title: "The noise, estimated from the records".into(),
        caption: "Scatter between runs and roughness are fractions of the friction force (standard deviations); the roughness is correlated over the given length of sliding; the part fixed to the plate repeats in every run. Last column: probability of as much common structure by noise alone.".into(),
        columns: vec![
            Column::text("counterface"),
            Column::number("between runs", "1"),
            Column::number("roughness, own", "1"),
            Column::number("roughness, plate", "1"),
            Column::number("length", "mm"),
            Column::number("sensor", "N"),
            Column::number("lack of fit, p", "1"),
        ],
        rows,
        evidence: Some(weakest(materials)),
        provenance: Some(all_of("noise", materials)),
        claims: vec!["C04".into()],
        ..Table::default()
    }
}

fn weakest(materials: &[Identified]) -> Evidence {
    if materials
        .iter()
        .any(|one| one.evidence == Evidence::Synthetic)
    {
        Evidence::Synthetic
    } else {
        Evidence::Measured
    }
}

/// Parameters that move with the lean: all of the law's but the lean itself, its last.
fn beside_the_lean() -> impl Iterator<Item = &'static str> {
    NAMES[..NAMES.len() - 1].iter().copied()
}

pub(super) fn held_leans(one: &Identified, leans: &[HeldLean]) -> Table {
    let row = |name: Cell, found: &identification::Identification| {
        let mut cells = vec![
            name,
            Cell::Digits(found.value("theta0").unwrap_or(f64::NAN), 3),
        ];
        for parameter in beside_the_lean() {
            cells.push(Cell::Digits(found.value(parameter).unwrap_or(f64::NAN), 4));
        }
        cells.push(Cell::Digits(found.quality.rmse, 3));
        cells
    };
    let mut rows = vec![row(Cell::from("free"), &one.found)];
    rows.extend(
        leans
            .iter()
            .map(|held| row(Cell::from(held.reading), &held.found)),
    );
    let mut columns = vec![
        Column::text("$\\theta_0$ held at the lean of"),
        Column::number(symbol("theta0"), "rad"),
    ];
    for name in beside_the_lean() {
        let unit = one.found.estimate(name).map_or("", |e| e.unit.as_str());
        columns.push(Column::number(symbol(name), unit));
    }
    columns.push(Column::number("residual", "1"));
    Table {
        id: "identified-held-leans".into(),
        title: "The lean free, and held".into(),
        caption: "Parameters on aluminium with $\\theta_0$ free and held at each reading of the published steady coefficients. Compare the residuals: the likelihoods of the rows are restricted ones, of another number of parameters and with a noise of their own, and their difference would measure neither. What the data say about a held lean is in the profile of $\\theta_0$.".into(),
        columns,
        rows,
        evidence: Some(one.evidence),
        provenance: Some(provenance("held_leans", one)),
        claims: ["C01", "C21"].map(String::from).to_vec(),
        ..Table::default()
    }
}

pub(super) fn laws(one: &Identified, laws: &[LawFit]) -> Table {
    let best = laws
        .iter()
        .filter_map(|law| law.identification.as_ref().ok())
        .map(|found| found.aicc)
        .fold(f64::INFINITY, f64::min);
    let rows = laws
        .iter()
        .map(|law| {
            let id = law.law.id();
            let (aicc, rmse) = match &law.identification {
                Ok(found) => (
                    Cell::Digits(found.aicc - best, 4),
                    Cell::Digits(found.quality.rmse, 3),
                ),
                Err(error) => (
                    Cell::Missing(error.to_string()),
                    Cell::Missing(error.to_string()),
                ),
            };
            let held = match &law.held_out {
                Some(_) => Cell::Value(format!("identification.laws.{id}.held_out_rmse")),
                None => Cell::Missing("no repeats".into()),
            };
            let ratio = law.direction_ratio.map_or_else(
                || Cell::Missing("one direction".into()),
                |r| Cell::Digits(r, 4),
            );
            vec![
                Cell::from(id),
                Cell::from(law.law.parameters().len() as f64),
                rmse,
                held,
                aicc,
                ratio,
                Cell::from(if law.directional { "yes" } else { "no" }),
            ]
        })
        .collect();
    Table {
        id: "identified-laws".into(),
        title: "Seven laws on the same records".into(),
        caption: "Each law fitted alike, its noise estimated with it. Held out: one run of each direction left out in turn, error on it. AICc: difference to the best law. Forward over reverse: ratio of the fitted friction above half of the top speed.".into(),
        columns: vec![
            Column::text("law"),
            Column::number("parameters", ""),
            Column::number("residual", "1"),
            Column::number("held out", "1"),
            Column::number("AICc above best", "1"),
            Column::number("forward over reverse", "1"),
            Column::text("can depend on direction"),
        ],
        rows,
        evidence: Some(one.evidence),
        provenance: Some(provenance("compare_laws", one)),
        claims: ["C02", "C21"].map(String::from).to_vec(),
        ..Table::default()
    }
}
