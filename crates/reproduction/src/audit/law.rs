//! The law at the printed parameters: the lean that the steady coefficients bracket, the size of each term, static
//! against dynamic friction, the scale ray, extrapolation.

use friction::Exponent;
use report::figure::{Figure, Provenance};
use report::{AuditOutcome, Block, Cell, Column, Evidence, Section, Table};

use super::bristle::{Bristle, Placement};
use super::{Book, Sum, outcome, shown};
use crate::published::{LawNumbers, PublishedError};

/// Bracket of theta0, rad: between them steady friction forward falls and in reverse grows with theta0.
const LEAN_BRACKET: (f64, f64) = (-0.5, 0.0);

/// One reading of "steady" with the leans that it gives.
pub(super) struct Row {
    placement: Placement,
    window: &'static str,
    id: String,
    forward: f64,
    reverse: f64,
    joint: f64,
    residuals: [f64; 2],
}

/// The bracket table and the lean that the other sums use.
pub(super) struct LeanTable {
    rows: Vec<Row>,
    /// Joint lean of the reading that other sums use: cosine on all terms, mean from 10 to 60 mm/s.
    pub(super) joint: f64,
}

/// What the steady coefficients ask of the lean of a law under one reading of "steady".
#[derive(Clone, Copy)]
pub(super) struct Leans {
    base: Bristle,
    /// Speeds over which steady friction is averaged, m/s; one speed where both are equal.
    window_m_s: [f64; 2],
    /// Printed coefficients, forward and reverse.
    mu: [f64; 2],
}

impl Leans {
    pub(super) fn of(base: Bristle, window_m_s: [f64; 2], mu: [f64; 2]) -> Self {
        Self {
            base,
            window_m_s,
            mu,
        }
    }

    /// Steady friction less the printed one, forward and reverse.
    pub(super) fn residuals(&self, lean: f64) -> [f64; 2] {
        let law = Bristle { lean, ..self.base };
        let [from, top] = self.window_m_s;
        let steady = |sign: f64| {
            if from < top {
                law.mean_steady(sign * from, sign * top)
            } else {
                law.steady(sign * top).mu.abs()
            }
        };
        [steady(1.0) - self.mu[0], steady(-1.0) - self.mu[1]]
    }

    /// From the forward coefficient alone; NaN where no lean gives it.
    pub(super) fn forward(&self) -> f64 {
        root(|lean| self.residuals(lean)[0])
    }

    /// From the reverse coefficient alone; NaN where no lean gives it.
    pub(super) fn reverse(&self) -> f64 {
        root(|lean| self.residuals(lean)[1])
    }

    /// From both by least squares.
    pub(super) fn joint(&self) -> f64 {
        least(|lean| self.residuals(lean).iter().map(|r| r * r).sum())
    }

    /// From both by the least largest residual.
    pub(super) fn fairest(&self) -> f64 {
        least(|lean| largest(self.residuals(lean)))
    }
}

/// The larger of two residuals without its sign.
pub(super) fn largest(residuals: [f64; 2]) -> f64 {
    residuals.into_iter().fold(0.0, |most, r| most.max(r.abs()))
}

/// The lean from the steady coefficients: forward alone, reverse alone, both by least squares; two placements of the
/// cosine, two windows.
pub(super) fn lean(book: &mut Book<'_>) -> Result<LeanTable, PublishedError> {
    let forward_mu = book.value("steady.forward")?;
    let reverse_mu = book.value("steady.reverse")?;
    let top = book.value("protocol.end_speed")? / 1000.0;
    let mut rows = Vec::new();
    for placement in [Placement::AllTerms, Placement::StiffnessOnly] {
        for (window, from) in [("mean from 10 to 60 mm/s", 0.01), ("at 60 mm/s", top)] {
            let base = bristle(book, "table1", 0.0, placement)?;
            let leans = Leans::of(base, [from, top], [forward_mu, reverse_mu]);
            let place = if placement == Placement::AllTerms {
                "all_terms"
            } else {
                "stiffness_only"
            };
            let span = if from < top { "mean" } else { "top" };
            rows.push(Row {
                placement,
                window,
                id: format!("lean.{place}.{span}"),
                forward: leans.forward(),
                reverse: leans.reverse(),
                joint: leans.joint(),
                residuals: leans.residuals(leans.joint()),
            });
        }
    }
    for row in &rows {
        let name = |part: &str| format!("{}.{part}", row.id);
        book.computed(&name("forward"), row.forward, "rad");
        book.computed(&name("reverse"), row.reverse, "rad");
        book.computed(&name("joint"), row.joint, "rad");
        book.computed(&name("residual_forward"), row.residuals[0], "1");
        book.computed(&name("residual_reverse"), row.residuals[1], "1");
    }
    let worst = rows
        .iter()
        .flat_map(|row| row.residuals)
        .fold(0.0_f64, |worst, r| worst.max(r.abs()));
    let worst_shown = book.computed("lean.largest_residual", worst, "1");
    let joint = rows[0].joint;
    book.add(Sum {
        subject: "One lean for both directions",
        locator: "E3-E7, Table 1; Section 3, force analysis",
        sum: format!(
            "theta0 from {} forward alone, from {} reverse alone, and from both: the table of leans; the largest residual with one lean is {worst_shown}",
            shown("steady.forward"),
            shown("steady.reverse")
        ),
        outcome: AuditOutcome::Open,
        consequence: "One lean explains both coefficients to within the spread of the unpublished choices (window, place of the cosine). theta0 itself is not published.".into(),
        claims: &["C09", "C21"],
    });
    Ok(LeanTable { rows, joint })
}

/// The bracket table for the page.
pub(super) fn section(lean: &LeanTable, drawn: Figure) -> Section {
    let value = |row: &Row, part: &str| Cell::Value(format!("audit.{}.{part}", row.id));
    let rows = lean
        .rows
        .iter()
        .map(|row| {
            let place = if row.placement == Placement::AllTerms {
                "all terms of E7"
            } else {
                "the stiffness term only"
            };
            let mut cells = vec![Cell::from(place), Cell::from(row.window)];
            cells.extend(
                [
                    "forward",
                    "reverse",
                    "joint",
                    "residual_forward",
                    "residual_reverse",
                ]
                .map(|part| value(row, part)),
            );
            cells
        })
        .collect();
    let table = Table {
        id: "lean-brackets".into(),
        title: "Lean that the published steady coefficients ask for".into(),
        caption: "Steady friction of E3 to E7 with Table 1, solved for $\\theta_0$: from the forward coefficient alone, from the reverse one alone, and from both by least squares, with what then remains.".into(),
        columns: vec![
            Column::text("cosine on"),
            Column::text("steady means"),
            Column::number("forward alone", "rad"),
            Column::number("reverse alone", "rad"),
            Column::number("both", "rad"),
            Column::number("residual forward", "1"),
            Column::number("residual reverse", "1"),
        ],
        rows,
        evidence: Some(Evidence::Computed),
        provenance: Some(Provenance::here("audit", "law::lean")),
        claims: vec!["C09".into(), "C21".into()],
        ..Table::default()
    };
    Section {
        id: "audit-lean".into(),
        title: "The lean θ₀, which the paper does not print".into(),
        lead: "The printed steady coefficients bracket $\\theta_0$; where in the bracket depends on two choices that the paper does not state. With the cosine on all terms and the mean from 10 to 60 mm/s both together give {{ v(\"audit.lean.all_terms.mean.joint\") }}.".into(),
        method: Some("Steady state of E3 is $\\theta = g(w)/\\sigma$ with $w = (v/h)\\cos^2(\\theta+\\theta_0)$, solved as a fixed point; the coefficient is E7 with $\\dot\\theta = 0$. Roots by bisection, both directions together by golden section.".into()),
        status: None,
        claims: vec!["C09".into(), "C21".into()],
        blocks: vec![drawn.into(), Block::Table(table)],
    }
}

/// Sums that use the lean.
pub(super) fn check(book: &mut Book<'_>, lean: f64) -> Result<(), PublishedError> {
    terms(book, lean)?;
    static_and_dynamic(book, lean)?;
    scale_ray(book, lean)?;
    extrapolation(book, lean)
}

/// Largest damping and viscous term of a ramp against the steady stiffness term.
fn terms(book: &mut Book<'_>, lean: f64) -> Result<(), PublishedError> {
    let law = bristle(book, "table1", lean, Placement::AllTerms)?;
    let (acceleration, duration) = protocol(book)?;
    let ramp = law.ramp(acceleration, duration, RAMP_STEPS);
    let steady = ramp.last().map_or(f64::NAN, |terms| terms.stiffness);
    let largest = |part: fn(&super::bristle::Terms) -> f64| {
        100.0
            * ramp
                .iter()
                .map(|terms| part(terms).abs())
                .fold(0.0, f64::max)
            / steady
    };
    let damping = book.computed("terms.damping", largest(|terms| terms.damping), "percent");
    let viscous = book.computed("terms.viscous", largest(|terms| terms.viscous), "percent");
    book.add(Sum {
        subject: "Size of the damping and viscous terms",
        locator: "Section 1, after E8; Table 1",
        sum: format!("over a forward ramp with Table 1 the largest $\\sigma_1\\dot\\theta$ is {damping} and the largest $\\sigma_2 w$ {viscous} of the steady $\\sigma_0\\theta$"),
        outcome: AuditOutcome::Holds,
        consequence: "sigma0 has no unit and the others are in s: only the terms can be compared. Up to 60 mm/s both are an order smaller; the viscous term grows with speed and rules at metres per second.".into(),
        claims: &["C07"],
    });
    Ok(())
}

/// The stiffness term at theta_s/sigma (slow) over that at theta_c/sigma (fast) less one, percent.
pub(super) fn static_excess(p: &LawNumbers, lean: f64) -> f64 {
    let mu = |theta: f64| p.sigma0 * theta * (theta + lean).cos().powi(2);
    let (slow, fast) = (p.theta_s / p.sigma, p.theta_c / p.sigma);
    100.0 * (mu(slow) / mu(fast) - 1.0)
}

/// mu at theta_s/sigma (slow) against mu at theta_c/sigma (fast, without the viscous term), either direction.
fn static_and_dynamic(book: &mut Book<'_>, lean: f64) -> Result<(), PublishedError> {
    let p = book.published.law("table1")?;
    let mut excess = Vec::new();
    for (name, lean) in [("forward", lean), ("reverse", -lean)] {
        let value = static_excess(&p, lean);
        excess.push((
            value,
            book.computed(&format!("static_excess.{name}"), value, "percent"),
        ));
    }
    book.add(Sum {
        subject: "θs and θc as static and dynamic friction",
        locator: "E5, E7, Table 1",
        sum: format!(
            "$\\theta\\cos^2(\\theta+\\theta_0)$ at $\\theta_s/\\sigma$ over that at $\\theta_c/\\sigma$: {} forward, {} in reverse",
            excess[0].1, excess[1].1
        ),
        outcome: outcome(excess.iter().all(|(value, _)| *value > 0.0)),
        consequence: "Past the maximum of theta cos^2 more rotation gives less friction: in reverse the static level is the lower one, and friction rises with speed where the words say that it falls.".into(),
        claims: &["C17"],
    });
    Ok(())
}

/// Largest change of mu over a ramp where sigma, theta_c and theta_s are multiplied by one factor.
pub(super) fn largest_change(law: Bristle, acceleration: f64, duration: f64) -> f64 {
    let reference = law.ramp(acceleration, duration, RAMP_STEPS);
    let mut largest = 0.0_f64;
    for factor in [0.5, 3.0] {
        let p = LawNumbers {
            sigma: factor * law.p.sigma,
            theta_c: factor * law.p.theta_c,
            theta_s: factor * law.p.theta_s,
            ..law.p
        };
        let scaled = Bristle { p, ..law }.ramp(acceleration, duration, RAMP_STEPS);
        for (one, other) in reference.iter().zip(&scaled) {
            largest = largest.max((one.mu - other.mu).abs());
        }
    }
    largest
}

/// How many of the seven a ramp determines, by that change.
pub(super) fn parameters_found(largest_change: f64) -> f64 {
    // Rounding of the ramp's 4 x RAMP_STEPS evaluations is far below 1e-9; a parameter that matters moves mu by percents.
    if largest_change < 1e-9 { 6.0 } else { 7.0 }
}

/// sigma, theta_c, theta_s times one factor: mu of a ramp does not change.
fn scale_ray(book: &mut Book<'_>, lean: f64) -> Result<(), PublishedError> {
    let law = bristle(book, "table1", lean, Placement::AllTerms)?;
    let (acceleration, duration) = protocol(book)?;
    let largest = largest_change(law, acceleration, duration);
    let free = parameters_found(largest);
    let largest = book.computed("scale_ray.largest_change", largest, "1");
    let free_shown = book.computed("scale_ray.parameters", free, "parameters");
    book.add(Sum {
        subject: "The scale of σ, θc and θs",
        locator: "E3, E9, Table 1",
        sum: format!(
            "E3 holds $\\sigma/g(w)$ only; all three times 0.5 and times 3 change the coefficient of a ramp by at most {largest}: {free_shown} of the seven can be found"
        ),
        outcome: outcome(free >= 7.0),
        consequence: "Table 1 prints seven numbers for at most six that any measurement can determine.".into(),
        claims: &["C18"],
    });
    Ok(())
}

/// Steady friction where the gait uses it.
fn extrapolation(book: &mut Book<'_>, lean: f64) -> Result<(), PublishedError> {
    let law = bristle(book, "table1", lean, Placement::AllTerms)?;
    let fastest = book.value("protocol.end_speed")? / 1000.0;
    let aim = book.value("gait.target_speed_fig11")?;
    let at_one = book.computed("steady_mu_at_1_m_s", law.steady(1.0).mu, "1");
    let at_aim = book.computed("steady_mu_at_aim", law.steady(aim).mu, "1");
    let factor = book.sum("extrapolation_factor", aim / fastest, "1");
    book.add(Sum {
        subject: "The law at gait speed",
        locator: "Section 3, Fig. 11",
        sum: format!(
            "identified up to {}, used up to {} ({factor} times as fast): steady coefficient forward {at_one} at 1 m/s and {at_aim} at the target speed",
            shown("protocol.end_speed"),
            shown("gait.target_speed_fig11")
        ),
        outcome: AuditOutcome::Fails,
        consequence: "The viscous term makes friction grow without bound. A gait must use the law inside its validity; with Table 1 as printed the forward limit would never bind.".into(),
        claims: &["C10", "C11"],
    });
    Ok(())
}

/// Steps of a ramp: the coefficient changes by less than 1e-9 when they are halved.
const RAMP_STEPS: usize = 20_000;

pub(super) fn bristle(
    book: &Book<'_>,
    row: &str,
    lean: f64,
    placement: Placement,
) -> Result<Bristle, PublishedError> {
    Ok(Bristle {
        p: book.published.law(row)?,
        height_m: book.value("brush.contact_height")? / 1000.0,
        lean,
        placement,
        exponent: Exponent::Two,
    })
}

/// Acceleration, m/s^2, and duration, s, of the published ramp.
pub(super) fn protocol(book: &Book<'_>) -> Result<(f64, f64), PublishedError> {
    let speed = book.value("protocol.end_speed")? / 1000.0;
    let travel = book.value("protocol.travel")? / 1000.0;
    Ok((speed * speed / (2.0 * travel), 2.0 * travel / speed))
}

/// Root of a monotone function in the bracket of the lean, by bisection to rounding; NaN where the bracket holds none.
fn root(f: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = LEAN_BRACKET;
    let rising = f(high) > f(low);
    if f(low) * f(high) > 0.0 {
        return f64::NAN;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if (f(middle) > 0.0) == rising {
            high = middle
        } else {
            low = middle
        }
    }
    0.5 * (low + high)
}

/// Place of the least value in the bracket of the lean, by golden section.
fn least(f: impl Fn(f64) -> f64) -> f64 {
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut low, mut high) = LEAN_BRACKET;
    for _ in 0..70 {
        let (left, right) = (high - ratio * (high - low), low + ratio * (high - low));
        if f(left) < f(right) {
            high = right
        } else {
            low = left
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::published::Published;

    #[test]
    fn halving_the_step_of_a_ramp_changes_nothing_that_is_reported() {
        let published = Published::shipped();
        let book = Book::new(&published);
        let law = bristle(&book, "table1", -0.28, Placement::AllTerms).unwrap();
        let coarse = law.ramp(0.006, 10.0, RAMP_STEPS / 2);
        let fine = law.ramp(0.006, 10.0, RAMP_STEPS);
        for (i, terms) in coarse.iter().enumerate() {
            assert!((terms.mu - fine[2 * i].mu).abs() < 1e-9, "sample {i}");
        }
    }

    #[test]
    fn a_ramp_ends_in_the_steady_state_of_its_last_speed() {
        let published = Published::shipped();
        let book = Book::new(&published);
        let law = bristle(&book, "table2.ceramic", -0.28, Placement::AllTerms).unwrap();
        let end = law.ramp(0.006, 10.0, RAMP_STEPS).pop().unwrap();
        assert!((end.stiffness - law.steady(0.06).stiffness).abs() < 1e-4);
    }

    #[test]
    fn exchange_of_direction_and_sign_of_the_lean_is_a_symmetry() {
        let published = Published::shipped();
        let book = Book::new(&published);
        let law = bristle(&book, "table2.nylon", -0.28, Placement::StiffnessOnly).unwrap();
        let mirrored = Bristle { lean: 0.28, ..law };
        assert!((law.steady(0.03).mu + mirrored.steady(-0.03).mu).abs() < 1e-14);
    }
}
