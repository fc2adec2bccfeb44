//! The paper against itself: sums over its printed numbers alone, before anything is simulated.
//!
//! Every sum writes the numbers that it used and found as values (`audit.*`, `published.*`), so that the page shows them
//! from the results and never from a text. What holds is listed with what does not.

mod bristle;
mod geometry;
mod law;
mod printed;
mod robot;
mod shown;
mod stiffness;
mod worlds;

use report::{AuditItem, AuditOutcome, Evidence, Section, Value, typeset_prose};

use crate::multiverse::Worlds;
use crate::published::{Interval, Published, PublishedError};

/// Standard gravity, m/s^2 (3rd CGPM, 1901; exact by definition).
const GRAVITY_M_S2: f64 = 9.806_65;

/// Young's modulus of spring steel wire, Pa (handbook value; the paper gives none).
const STEEL_MODULUS_PA: f64 = 200e9;

/// What the audit found.
pub(crate) struct Audit {
    pub(crate) values: Vec<Value>,
    pub(crate) items: Vec<AuditItem>,
    pub(crate) sections: Vec<Section>,
}

/// Checks everything.
///
/// # Errors
/// Where a published number is missing.
pub(crate) fn examine(published: &Published) -> Result<Audit, PublishedError> {
    let mut book = Book::new(published);
    printed::check(&mut book)?;
    let lean = law::lean(&mut book)?;
    geometry::check(&mut book, lean.joint)?;
    stiffness::check(&mut book)?;
    law::check(&mut book, lean.joint)?;
    robot::check(&mut book)?;
    let drawn = shown::bristle_to_scale(&book, lean.joint)?;
    Ok(Audit {
        values: book.values,
        items: book.items,
        sections: vec![law::section(&lean, drawn), shown::robot()],
    })
}

/// Claims that the audit decides, with what every combination of choices gives for them.
///
/// # Errors
/// Where a published number is missing.
pub(crate) fn worlds(published: &Published) -> Result<Vec<(&'static str, Worlds)>, PublishedError> {
    worlds::all(&Book::new(published))
}

/// Collects sums and their numbers.
struct Book<'a> {
    published: &'a Published,
    values: Vec<Value>,
    items: Vec<AuditItem>,
}

/// One sum before it has its number.
struct Sum<'t> {
    subject: &'t str,
    locator: &'t str,
    sum: String,
    outcome: AuditOutcome,
    consequence: String,
    claims: &'t [&'t str],
}

impl<'a> Book<'a> {
    fn new(published: &'a Published) -> Self {
        let values = published
            .iter()
            .map(|(id, number)| {
                Value::new(
                    format!("published.{id}"),
                    number.value,
                    &number.unit,
                    "audit",
                    Evidence::Published,
                )
                .with_published(&number.printed)
            })
            .collect();
        Self {
            published,
            values,
            items: Vec::new(),
        }
    }

    fn value(&self, id: &str) -> Result<f64, PublishedError> {
        self.published.value(id)
    }

    fn interval(&self, id: &str) -> Result<Interval, PublishedError> {
        self.published.interval(id)
    }

    /// Records a number found and gives the mark-up that shows it.
    fn found(&mut self, name: &str, value: f64, unit: &str, evidence: Evidence) -> String {
        let id = format!("audit.{name}");
        let mark = format!("{{{{ v(\"{id}\") }}}}");
        self.values
            .push(Value::new(id, value, unit, "audit", evidence));
        mark
    }

    /// A number that follows from printed ones by arithmetic.
    fn sum(&mut self, name: &str, value: f64, unit: &str) -> String {
        self.found(name, value, unit, Evidence::Published)
    }

    /// A number that the paper's model gives with the printed parameters.
    fn computed(&mut self, name: &str, value: f64, unit: &str) -> String {
        self.found(name, value, unit, Evidence::Computed)
    }

    /// Records both ends of an interval and gives the mark-up `[lower, upper] unit`.
    fn range(&mut self, name: &str, interval: Interval, unit: &str) -> String {
        self.sum(&format!("{name}.lower"), interval.lower, unit);
        self.sum(&format!("{name}.upper"), interval.upper, unit);
        let shown_unit = if unit == "1" {
            String::new()
        } else {
            format!(" {}", report::printed_unit(unit))
        };
        format!(
            "\\[{{{{ n(\"audit.{name}.lower\", 5) }}}}, {{{{ n(\"audit.{name}.upper\", 5) }}}}\\]{shown_unit}"
        )
    }

    fn add(&mut self, sum: Sum<'_>) {
        self.items.push(AuditItem {
            id: format!("A{:02}", self.items.len() + 1),
            subject: sum.subject.to_owned(),
            locator: sum.locator.to_owned(),
            sum: typeset_prose(&sum.sum).into(),
            outcome: sum.outcome,
            consequence: typeset_prose(&sum.consequence).into(),
            claims: sum.claims.iter().map(|claim| (*claim).to_owned()).collect(),
        });
    }
}

/// The mark-up that shows a published number as printed.
fn shown(id: &str) -> String {
    format!("{{{{ published(\"published.{id}\") }}}}")
}

/// Holds or fails.
fn outcome(holds: bool) -> AuditOutcome {
    if holds {
        AuditOutcome::Holds
    } else {
        AuditOutcome::Fails
    }
}
