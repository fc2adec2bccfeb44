//! Rounding, percentages, counts, masses and the arithmetic of the protocol.

use report::AuditOutcome;

use super::{Book, GRAVITY_M_S2, Sum, outcome, shown};
use crate::published::PublishedError;

pub(super) fn check(book: &mut Book<'_>) -> Result<(), PublishedError> {
    speed_gain(book)?;
    mean_friction(book)?;
    twice_printed(book)?;
    brushes(book)?;
    masses(book)?;
    ramp(book)?;
    inertia(book)?;
    units(book);
    figure_reference(book);
    Ok(())
}

/// gain = v_asymmetric / v_symmetric - 1, over the rounding intervals of both speeds.
fn speed_gain(book: &mut Book<'_>) -> Result<(), PublishedError> {
    let asymmetric = book.interval("gait.best_speed.asymmetric")?;
    let symmetric = book.interval("gait.best_speed.symmetric")?;
    let gain = asymmetric.combine(symmetric, |a, s| 100.0 * (a / s - 1.0));
    let holds = gain.meets(book.interval("gait.gain")?);
    let range = book.range("gait_gain", gain, "percent");
    book.add(Sum {
        subject: "Gain of the mean best speed",
        locator: "Section 3, Fig. 12",
        sum: format!(
            "{} / {} - 1 lies in {range}; printed: {}",
            shown("gait.best_speed.asymmetric"),
            shown("gait.best_speed.symmetric"),
            shown("gait.gain")
        ),
        outcome: outcome(holds),
        consequence: "The printed percentage follows from the printed speeds.".into(),
        claims: &["C11"],
    });
    Ok(())
}

/// mean = (forward + reverse) / 2.
fn mean_friction(book: &mut Book<'_>) -> Result<(), PublishedError> {
    let forward = book.interval("steady.forward")?;
    let reverse = book.interval("steady.reverse")?;
    let mean = forward.combine(reverse, |f, r| 0.5 * (f + r));
    let holds = mean.meets(book.interval("steady.mean")?);
    let range = book.range("steady_mean", mean, "1");
    book.add(Sum {
        subject: "Mean of the steady coefficients",
        locator: "Section 3, force analysis",
        sum: format!(
            "({} + {}) / 2 lies in {range}; printed: {}",
            shown("steady.forward"),
            shown("steady.reverse"),
            shown("steady.mean")
        ),
        outcome: outcome(holds),
        consequence: "The symmetric coefficient is the mean of the two printed ones.".into(),
        claims: &["C09"],
    });
    Ok(())
}

/// Table 1 and the aluminium row of Table 2 are one row.
fn twice_printed(book: &mut Book<'_>) -> Result<(), PublishedError> {
    let equal = book.published.law("table1")? == book.published.law("table2.aluminium")?;
    book.add(Sum {
        subject: "Table 1 stands again in Table 2",
        locator: "Tables 1 and 2",
        sum: "all seven numbers of Table 1 against the aluminium row of Table 2".into(),
        outcome: outcome(equal),
        consequence: "One fit, printed twice.".into(),
        claims: &["C01", "C06"],
    });
    Ok(())
}

/// A 3x3 arrangement has nine places.
fn brushes(book: &mut Book<'_>) -> Result<(), PublishedError> {
    let places = book.value("brush.layout_3x3")?;
    let count = book.value("brush.count_3x3")?;
    let small = book.value("brush.layout_2x2")? == book.value("brush.count_2x2")?;
    book.sum("brushes_missing", places - count, "brushes");
    book.add(Sum {
        subject: "Brushes of the 2x2 and 3x3 layouts",
        locator: "Section 2, validation",
        sum: format!(
            "{} has {{{{ n(\"published.brush.layout_3x3\") }}}} places; the text counts \"{}\" (the 2x2 layout: {{{{ n(\"published.brush.layout_2x2\") }}}} places, \"{}\")",
            shown("brush.layout_3x3"),
            shown("brush.count_3x3"),
            shown("brush.count_2x2")
        ),
        outcome: outcome(places == count && small),
        consequence: "Either the layout or the count is a slip; load per brush depends on which.".into(),
        claims: &["C03", "C16"],
    });
    Ok(())
}

/// Mass of one brush if the fixture is the same: (m_3x3 - m_2x2) / (n_3x3 - n_2x2).
fn masses(book: &mut Book<'_>) -> Result<(), PublishedError> {
    let small = book.value("brush.mass_2x2")?;
    let large = book.value("brush.mass_3x3")?;
    let four = book.value("brush.count_2x2")?;
    let mut parts = Vec::new();
    for (name, count) in [
        ("six", book.value("brush.count_3x3")?),
        ("nine", book.value("brush.layout_3x3")?),
    ] {
        let brush = (large - small) / (count - four);
        let brush_shown = book.sum(&format!("brush_mass.{name}"), brush, "g");
        let fixture = book.sum(&format!("fixture_mass.{name}"), small - four * brush, "g");
        parts.push(format!(
            "with {name} brushes {brush_shown} each and {fixture} of fixture"
        ));
    }
    book.add(Sum {
        subject: "Masses of the two specimens",
        locator: "Section 2",
        sum: format!(
            "{} less {}, shared by the added brushes: {}",
            shown("brush.mass_3x3"),
            shown("brush.mass_2x2"),
            parts.join("; ")
        ),
        outcome: AuditOutcome::Open,
        consequence:
            "Both counts give positive masses: the masses do not tell which count is right.".into(),
        claims: &["C16"],
    });
    Ok(())
}

/// From rest at constant acceleration: T = 2 s / v, a = v^2 / (2 s).
fn ramp(book: &mut Book<'_>) -> Result<(), PublishedError> {
    let speed = book.value("protocol.end_speed")?;
    let travel = book.value("protocol.travel")?;
    let duration = 2.0 * travel / speed;
    let duration_shown = book.sum("ramp.duration", duration, "s");
    let acceleration = book.sum(
        "ramp.acceleration",
        speed * speed / (2.0 * travel),
        "mm/s^2",
    );
    let samples = book.sum(
        "ramp.samples",
        duration * book.value("rig.sample_rate")?,
        "samples",
    );
    let room = book.value("rig.stage_length")? - travel;
    let room_shown = book.sum("ramp.room", room, "mm");
    book.add(Sum {
        subject: "The ramp",
        locator: "Section 2, experiment",
        sum: format!(
            "$T = 2s/v$ = {duration_shown}, $a = v^2/(2s)$ = {acceleration}; {samples} at {}; the {} stage leaves {room_shown} for the brush",
            shown("rig.sample_rate"),
            shown("rig.stage_length")
        ),
        outcome: outcome(room > 0.0),
        consequence: "The ramp fits the stage. In it speed, time and place determine each other, so effects of the three cannot be told apart.".into(),
        claims: &["C15"],
    });
    Ok(())
}

/// The cord carries friction and the brush's inertia: m a against mu N.
fn inertia(book: &mut Book<'_>) -> Result<(), PublishedError> {
    let mass_kg = book.value("brush.mass_2x2")? / 1000.0;
    let speed = book.value("protocol.end_speed")? / 1000.0;
    let travel = book.value("protocol.travel")? / 1000.0;
    let inertia_n = mass_kg * speed * speed / (2.0 * travel);
    let friction_n = book.value("steady.reverse")? * mass_kg * GRAVITY_M_S2;
    let inertia_shown = book.sum("cord.inertia", inertia_n, "N");
    let friction_shown = book.sum("cord.friction", friction_n, "N");
    let share = 100.0 * inertia_n / friction_n;
    let share_shown = book.sum("cord.inertia_share", share, "percent");
    book.add(Sum {
        subject: "Tension of the cord and friction",
        locator: "Section 2, experiment",
        sum: format!(
            "if the brush took part in the stage's whole acceleration, $m a$ = {inertia_shown} against the smaller friction {friction_shown}: {share_shown}"
        ),
        outcome: outcome(share < 1.0),
        consequence: "The tension is the friction to within this share. The brush's own speed is another matter: it lags behind the stage while the cord stretches.".into(),
        claims: &["C19"],
    });
    Ok(())
}

/// The headers of Tables 1 and 2.
fn units(book: &mut Book<'_>) {
    book.add(Sum {
        subject: "Units in the headers of Tables 1 and 2",
        locator: "Tables 1 and 2",
        sum: "E3 needs $\\sigma$ and $g$ in one unit (both print 1/m: holds); E7 needs $\\sigma_1$ in s like $\\sigma_2$, since $\\dot\\theta$ and $w$ are both in rad/s, but only $\\sigma_2$ has the unit".into(),
        outcome: AuditOutcome::Fails,
        consequence: "A missing unit in a header. \"1/m\" on an angle's level is a leftover of LuGre, where the state is a length.".into(),
        claims: &["C07"],
    });
}

/// A reference to the wrong figure.
fn figure_reference(book: &mut Book<'_>) {
    book.add(Sum {
        subject: "Reference to a figure",
        locator: "Section 2, identification",
        sum: "the text says Fig. 8 twice where it describes Fig. 6 (2x2 measurement and fit)"
            .into(),
        outcome: AuditOutcome::Fails,
        consequence: "A slip without consequence: the description fits Fig. 6 only.".into(),
        claims: &["C02"],
    });
}
