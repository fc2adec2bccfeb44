//! sigma0 = k/(N h): what follows for other counterfaces, other loads and other numbers of brushes.

use report::AuditOutcome;

use super::{Book, Sum, outcome, shown};
use crate::published::{Interval, PublishedError};

pub(super) fn check(book: &mut Book<'_>) -> Result<(), PublishedError> {
    counterfaces(book)?;
    loads(book)?;
    start_value(book)
}

/// One brush and one load: sigma0 may not depend on the counterface.
fn counterfaces(book: &mut Book<'_>) -> Result<(), PublishedError> {
    let sigma0 = |material: &str| book.interval(&format!("table2.{material}.sigma0"));
    let rows = [sigma0("aluminium")?, sigma0("nylon")?, sigma0("ceramic")?];
    let lowest_upper = rows
        .iter()
        .map(|row| row.upper)
        .fold(f64::INFINITY, f64::min);
    let highest_lower = rows
        .iter()
        .map(|row| row.lower)
        .fold(f64::NEG_INFINITY, f64::max);
    let middle = |row: &Interval| 0.5 * (row.lower + row.upper);
    let largest = rows.iter().map(middle).fold(f64::NEG_INFINITY, f64::max);
    let smallest = rows.iter().map(middle).fold(f64::INFINITY, f64::min);
    let ratio = book.sum("sigma0_ratio", largest / smallest, "1");
    book.add(Sum {
        subject: "Stiffness on three counterfaces",
        locator: "E7, Table 2",
        sum: format!(
            "$\\sigma_0 = k/(N h)$ holds nothing of the counterface, yet the same brush under the same load has {}, {} and {}: largest over smallest {ratio}",
            shown("table2.aluminium.sigma0"),
            shown("table2.nylon.sigma0"),
            shown("table2.ceramic.sigma0")
        ),
        outcome: outcome(highest_lower <= lowest_upper),
        consequence: "sigma0 as fitted is not k/(N h) of the brush alone.".into(),
        claims: &["C06", "C20"],
    });
    Ok(())
}

/// k grows with the number of brushes, N with the mass: sigma0 of the 3x3 predicted from the 2x2.
fn loads(book: &mut Book<'_>) -> Result<(), PublishedError> {
    let sigma0 = book.interval("table1.sigma0")?;
    let loads = book
        .interval("brush.mass_2x2")?
        .combine(book.interval("brush.mass_3x3")?, |small, large| {
            small / large
        });
    let four = book.value("brush.count_2x2")?;
    let mut ranges = Vec::new();
    let mut kept = true;
    for (name, id) in [("six", "brush.count_3x3"), ("nine", "brush.layout_3x3")] {
        let brushes = book.value(id)? / four;
        let predicted = sigma0.combine(loads, |sigma0, loads| sigma0 * loads * brushes);
        kept &= predicted.meets(sigma0);
        ranges.push(format!(
            "{} for {name} brushes",
            book.range(&format!("sigma0_3x3.{name}"), predicted, "1")
        ));
    }
    book.add(Sum {
        subject: "Stiffness of the 3x3 brush",
        locator: "E7, Section 2, validation",
        sum: format!(
            "$\\sigma_0 = k/(N h)$ with $k$ by number of brushes and $N$ by mass: {}; the paper keeps {}",
            ranges.join(", "),
            shown("table1.sigma0")
        ),
        outcome: outcome(kept),
        consequence: "Keeping Table 1 for the 3x3 needs k to grow like the load. The slope of friction at the start of a 3x3 run tells: a sharp test of the model and of the count.".into(),
        claims: &["C03", "C16", "C20"],
    });
    book.add(Sum {
        subject: "Friction and load",
        locator: "E1, E6",
        sum: "$F_f = (k/h)\\,\\theta\\cos^2(\\theta+\\theta_0)$ holds no $N$; dividing by $N$ and calling $k/(Nh)$ a constant makes friction proportional to it".into(),
        outcome: AuditOutcome::Fails,
        consequence: "The derivation gives friction that does not depend on the load; the model that is used gives friction proportional to it.".into(),
        claims: &["C20"],
    });
    Ok(())
}

/// sigma cannot be identified; that it stayed near the value of the paper's reference 20 fits an optimiser's start.
fn start_value(book: &mut Book<'_>) -> Result<(), PublishedError> {
    let reference = book.value("lugre20.sigma")?;
    let mut shares = Vec::new();
    for material in ["aluminium", "nylon", "ceramic"] {
        let sigma = book.value(&format!("table2.{material}.sigma"))?;
        shares.push(book.sum(
            &format!("sigma_over_reference.{material}"),
            sigma / reference,
            "1",
        ));
    }
    book.add(Sum {
        subject: "Where sigma came out",
        locator: "Table 2; Section 1, after E8",
        sum: format!(
            "sigma over the {} of the paper's reference 20: {} (aluminium, nylon, ceramic)",
            shown("lugre20.sigma"),
            shares.join(", ")
        ),
        outcome: AuditOutcome::Open,
        consequence: "Nothing measurable depends on sigma alone (scale ray of E3): values near the literature's fit an optimiser that stayed near its start.".into(),
        claims: &["C18"],
    });
    Ok(())
}
