//! The law far beyond its data: friction against speed over six decades.

use friction::{Law, LawKind};
use report::figure::{Axis, Figure, Ink, LinePlot, Provenance, Rule, Series};
use report::{Evidence, Value};

use crate::published::Published;
use crate::stage::StageError;

/// Speed at which the paper's measurements end, m/s.
const DATA_END_M_S: f64 = 0.06;

/// The asymmetric law of Table 1 with this lean.
fn law(published: &Published, lean_rad: f64) -> Result<Law<f64>, StageError> {
    let n = published.law("table1")?;
    let height_m = 1e-3 * published.value("brush.contact_height")?;
    // The file's order of the identifiable form is the law's own.
    let paper = [
        n.sigma, n.sigma0, n.sigma1, n.sigma2, n.theta_c, n.theta_s, n.omega_sc, lean_rad,
    ];
    let parameters = friction::paper_form::identifiable(&paper);
    LawKind::AsymmetricBristle
        .build(&parameters, Some(height_m))
        .map_err(|error| StageError::Failed(error.to_string()))
}

/// The lean at which the law meets both steady coefficients best at the end of the data: bracketed,
/// then golden section on the sum of squares.
fn lean_rad(published: &Published) -> Result<f64, StageError> {
    let (forward, reverse) = (
        published.value("steady.forward")?,
        published.value("steady.reverse")?,
    );
    let miss = |lean: f64| -> Result<f64, StageError> {
        let law = law(published, lean)?;
        let f = law.steady_coefficient(DATA_END_M_S) - forward;
        let r = -law.steady_coefficient(-DATA_END_M_S) - reverse;
        Ok(f * f + r * r)
    };
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut low, mut high) = (-0.6, 0.0);
    for _ in 0..80 {
        let (a, b) = (high - ratio * (high - low), low + ratio * (high - low));
        if miss(a)? < miss(b)? {
            high = b
        } else {
            low = a
        }
    }
    Ok(0.5 * (low + high))
}

/// The figure and its values; `gait_m_s`: slip speeds that the strides reach.
pub(super) fn figure(
    published: &Published,
    coefficients: [f64; 2],
    gait_m_s: f64,
) -> Result<(Figure, Vec<Value>), StageError> {
    let lean = lean_rad(published)?;
    let law = law(published, lean)?;
    let speeds: Vec<f64> = (0..=120)
        .map(|k| 10f64.powf(-4.0 + 0.05 * f64::from(k)))
        .collect();
    let curve = |sign: f64| -> Vec<[f64; 2]> {
        speeds
            .iter()
            .map(|&v| [v, sign * law.steady_coefficient(sign * v)])
            .collect()
    };
    let held = |mu: f64| vec![[speeds[0], mu], [speeds[speeds.len() - 1], mu]];
    let plot = LinePlot {
        x: Axis::new("slip speed", "m/s").log(),
        y: Axis::new("friction coefficient, steady", "").between(0.0, 4.0),
        series: vec![
            Series::line("law of Table 1, forward", Ink::FORWARD, curve(1.0)),
            Series::line("law of Table 1, reverse", Ink::REVERSE, curve(-1.0)),
            Series::line(
                "used by the gait, forward",
                Ink::Slot(5),
                held(coefficients[0]),
            ),
            Series::line(
                "used by the gait, reverse",
                Ink::Slot(6),
                held(coefficients[1]),
            ),
        ],
        rules: vec![
            Rule::Vertical(DATA_END_M_S, "data end".into()),
            Rule::Vertical(gait_m_s, "the gait's largest slip".into()),
        ],
        ..LinePlot::default()
    };
    let value = |id: &str, number: f64, unit: &str| {
        Value::new(id, number, unit, "gait", Evidence::Computed)
    };
    let values = vec![
        value("gait.extrapolation.lean", lean, "rad"),
        value(
            "gait.extrapolation.forward_at_1",
            law.steady_coefficient(1.0),
            "1",
        ),
        value(
            "gait.extrapolation.forward_at_5",
            law.steady_coefficient(5.0),
            "1",
        ),
        value("gait.extrapolation.largest_slip", gait_m_s, "m/s"),
        value(
            "gait.extrapolation.decades",
            (gait_m_s / DATA_END_M_S).log10(),
            "1",
        ),
    ];
    let figure = Figure::new(
        "gait-extrapolation",
        "Where the data end and where the gait lives",
        "Steady friction of the identified law against speed. Its damping and viscous terms grow without bound: read \
         literally at {{ v(\"gait.extrapolation.largest_slip\", 2) }}, friction would never limit a foot and asymmetry would \
         change nothing. The gait therefore holds the steady coefficients, which is an assumption.",
        Evidence::Published,
        plot,
        Provenance::here("gait", "friction::Law::steady_coefficient"),
    )
    .with_claims(&["C10", "C11"]);
    Ok((figure, values))
}
