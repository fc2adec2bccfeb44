//! Geometry and balance of one bristle: reach, smallness of theta, vertical share, number of bristles.

use report::AuditOutcome;

use super::{Book, GRAVITY_M_S2, STEEL_MODULUS_PA, Sum, outcome, shown};
use crate::published::PublishedError;

pub(super) fn check(book: &mut Book<'_>, lean: f64) -> Result<(), PublishedError> {
    small_angle(book)?;
    reach(book, lean)?;
    vertical_share(book, lean)?;
    cantilevers(book)
}

/// Steady theta = theta_c/sigma and cos^2 of it.
fn small_angle(book: &mut Book<'_>) -> Result<(), PublishedError> {
    let theta = book.value("table1.theta_c")? / book.value("table1.sigma")?;
    let theta_shown = book.sum("steady_theta", theta, "rad");
    let degrees = book.sum("steady_theta_deg", theta.to_degrees(), "deg");
    let loss = 1.0 - theta.cos().powi(2);
    let cos2 = book.sum("steady_cos2", theta.cos().powi(2), "1");
    book.sum("steady_cos2_loss", loss, "1");
    book.add(Sum {
        subject: "Smallness of the bristle's rotation",
        locator: "E8, Table 1",
        sum: format!(
            "steady $\\theta = \\theta_c/\\sigma$ = {} / {} = {theta_shown} = {degrees}; $\\cos^2\\theta$ = {cos2}",
            shown("table1.theta_c"),
            shown("table1.sigma")
        ),
        outcome: outcome(loss < 0.05),
        consequence: "The rotation is not small: with theta0 = 0 the model is the symmetric bristle, not LuGre.".into(),
        claims: &["C08"],
    });
    Ok(())
}

/// r = h / cos(theta + theta0) >= h: where on the bristle the contact lies.
fn reach(book: &mut Book<'_>, lean: f64) -> Result<(), PublishedError> {
    let h = book.value("brush.contact_height")?;
    let length = book.value("brush.bristle_length")?;
    let theta = book.value("table1.theta_c")? / book.value("table1.sigma")?;
    let r = |angle: f64| h / angle.cos();
    let rest = book.computed("reach.rest", r(lean), "mm");
    let forward = book.computed("reach.forward", r(theta + lean), "mm");
    let reverse = book.computed("reach.reverse", r(lean - theta), "mm");
    let holds = [r(lean), r(theta + lean), r(lean - theta)]
        .into_iter()
        .all(|r| r <= length);
    book.add(Sum {
        subject: "Reach of the bristle",
        locator: "E1; Section 2, identification",
        sum: format!(
            "$r = h/\\cos(\\theta+\\theta_0)$ is {rest} at rest, {forward} forward and {reverse} in reverse, with $h$ = {} and a bristle of {}",
            shown("brush.contact_height"),
            shown("brush.bristle_length")
        ),
        outcome: outcome(holds),
        consequence: "With h equal to the bristle's length the contact lies at or beyond the tip at every angle; h equal to the length needs theta0 = 0.".into(),
        claims: &["C21"],
    });
    Ok(())
}

/// The contact force stands at right angles to the bristle: vertical part = F_f tan(theta + theta0).
fn vertical_share(book: &mut Book<'_>, lean: f64) -> Result<(), PublishedError> {
    let theta = book.value("table1.theta_c")? / book.value("table1.sigma")?;
    let share = |mu: f64, angle: f64| 100.0 * mu * angle.tan().abs();
    let forward = share(book.value("steady.forward")?, theta + lean);
    let reverse = share(book.value("steady.reverse")?, theta - lean);
    let forward = book.computed("vertical_share.forward", forward, "percent");
    let reverse = book.computed("vertical_share.reverse", reverse, "percent");
    book.add(Sum {
        subject: "Vertical balance of a bristle",
        locator: "E1",
        sum: format!("$F_f\\tan(\\theta+\\theta_0)$ is {forward} of the normal load forward and {reverse} in reverse"),
        outcome: AuditOutcome::Open,
        consequence: "Only the horizontal part of the contact force is used. A part of the load of this size is carried by, or pulls on, the bent bristles and is nowhere in the model.".into(),
        claims: &["C20", "C21"],
    });
    Ok(())
}

/// k = sigma0 N h against 3 E I / L for one bristle, I = pi d^4 / 64.
fn cantilevers(book: &mut Book<'_>) -> Result<(), PublishedError> {
    let load_n = book.value("brush.mass_2x2")? / 1000.0 * GRAVITY_M_S2;
    let h_m = book.value("brush.contact_height")? / 1000.0;
    let k = book.value("table1.sigma0")? * load_n * h_m;
    let d_m = book.value("brush.bristle_diameter")? / 1000.0;
    let length_m = book.value("brush.bristle_length")? / 1000.0;
    let second_moment = std::f64::consts::PI * d_m.powi(4) / 64.0;
    // Tip stiffness 3 E I/L^3 times L^2: torque about the root per angle of the chord.
    let one = 3.0 * STEEL_MODULUS_PA * second_moment / length_m;
    let load_shown = book.sum("load_2x2", load_n, "N");
    let k_shown = book.sum("torsion_stiffness", k, "N m/rad");
    let count = book.computed("bristles", k / one, "bristles");
    let a_brush = book.computed(
        "bristles_per_brush",
        k / one / book.value("brush.count_2x2")?,
        "bristles",
    );
    book.add(Sum {
        subject: "Number of bristles in contact",
        locator: "E7, Table 1",
        sum: format!(
            "$N = m g$ = {load_shown}; $k = \\sigma_0 N h$ = {k_shown}, that of {count} steel cantilevers of this size (200 GPa), {a_brush} a brush"
        ),
        outcome: AuditOutcome::Holds,
        consequence: "A plausible number of bristles, if the load is the stated weight (assumed: the paper does not say so).".into(),
        claims: &["C01", "C20"],
    });
    Ok(())
}
