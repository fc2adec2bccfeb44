//! Table 3: inertias and the total mass.

use report::AuditOutcome;

use super::{Book, Sum, outcome, shown};
use crate::published::PublishedError;

pub(super) fn check(book: &mut Book<'_>) -> Result<(), PublishedError> {
    shank(book)?;
    total_mass(book)
}

/// A body of mass m within length L has at most m L^2/4 about its mass centre (half of the mass at either end); with its
/// centre at l from one end at most m l (L - l).
fn shank(book: &mut Book<'_>) -> Result<(), PublishedError> {
    let mass = book.interval("table3.shank_mass")?;
    let [span, place] = [
        book.interval("table3.shank_length")?,
        book.interval("table3.shank_centre")?,
    ];
    // The most that rounding allows.
    let widest = mass.upper * place.upper * (span.upper - place.upper);
    let length = book.value("table3.shank_length")?;
    let centre = book.value("table3.shank_centre")?;
    let middle = 0.5 * (mass.lower + mass.upper);
    let any = middle * length * length / 4.0;
    let stated = middle * centre * (length - centre);
    let any_shown = book.sum("shank_inertia_bound", any, "kg m^2");
    let stated_shown = book.sum("shank_inertia_bound_at_centre", stated, "kg m^2");
    let printed = book.interval("table3.shank_inertia")?;
    book.add(Sum {
        subject: "Inertia of the shank",
        locator: "Table 3",
        sum: format!(
            "{} within {}: at most $m L^2/4$ = {any_shown} for any centre, $m l (L-l)$ = {stated_shown} with the centre at {}; printed {}",
            shown("table3.shank_mass"),
            shown("table3.shank_length"),
            shown("table3.shank_centre"),
            shown("table3.shank_inertia")
        ),
        outcome: outcome(printed.lower <= widest),
        consequence: "No body of this mass and length with its centre there has this inertia, whatever the rounding; with the centre free only one with most of its mass at its two ends. The order of the columns (the headers are lost), or a rotor's inertia, is open.".into(),
        claims: &["C11", "C12"],
    });
    Ok(())
}

/// m0 + m1 + m2 against the mass of the whole biped.
fn total_mass(book: &mut Book<'_>) -> Result<(), PublishedError> {
    let torso = book.value("table3.torso_mass")?;
    let leg = book.value("table3.thigh_mass")? + book.value("table3.shank_mass")?;
    let stated = book.sum("mass_one_leg", torso + leg, "kg");
    let biped = book.sum("mass_biped", torso + 2.0 * leg, "kg");
    book.add(Sum {
        subject: "Mass that normalises the envelope",
        locator: "Section 3, Fig. 13",
        sum: format!("$m_0+m_1+m_2$ = {stated} is the torso with one leg; the biped of Fig. 10 has {biped}"),
        outcome: AuditOutcome::Open,
        consequence: "The stated total fits an envelope computed for the torso with one leg. Gains do not depend on the normalisation.".into(),
        claims: &["C12"],
    });
    Ok(())
}
