//! Negative controls: the ledger is fed with deliberate damage, and the claims that must turn do turn. A checker that
//! has never been red proves nothing.

use std::collections::BTreeMap;

use report::{NegativeControl, Value, typeset};

use crate::audit;
use crate::claims::Claim;
use crate::judgements::{Facts, judge};
use crate::published::{Published, PublishedError};

/// One damage.
enum Damage {
    /// A published number is printed differently.
    Printed(&'static str, &'static str),
    /// A value found is replaced.
    Found(&'static str, f64),
}

/// Damages, what they are in words, and the claims whose verdict must change.
const CONTROLS: [(Damage, &str, &[&str]); 9] = [
    (
        Damage::Printed("steady.mean", "0.7682"),
        "mean coefficient printed as 0.7682",
        &["C09"],
    ),
    (
        Damage::Printed("steady.forward", "1.2049"),
        "forward coefficient printed as 1.2049",
        &["C09", "C21"],
    ),
    (
        Damage::Printed("brush.count_3x3", "9"),
        "nine brushes counted in the 3x3 layout",
        &["C16"],
    ),
    (
        Damage::Printed("table2.nylon.sigma0", "2.90"),
        "sigma0 of nylon printed as 2.90",
        &["C06"],
    ),
    (
        Damage::Printed("protocol.travel", "400"),
        "a ramp of 400 mm on the 360 mm stage",
        &["C15"],
    ),
    (
        Damage::Found("materials.aluminium.difference", 0.0),
        "no direction dependence on aluminium",
        &["C05"],
    ),
    (
        Damage::Found("validation.brush-3x3.nrmse_forward", 0.5),
        "a prediction of the 3x3 that is off by half",
        &["C03"],
    ),
    (
        Damage::Found("gait.force_direction.asymmetric.largest", 0.0),
        "an asymmetric foot without forward force",
        &["C10"],
    ),
    (
        Damage::Found("audit.scale_ray.parameters", 7.0),
        "a law whose seven parameters all matter",
        &["C18"],
    ),
];

/// Runs the controls whose claims were all run.
///
/// # Errors
/// Where a published number is missing.
pub fn run(
    claims: &[Claim],
    published: &Published,
    values: &BTreeMap<String, Value>,
) -> Result<Vec<NegativeControl>, PublishedError> {
    let before = verdicts(claims, published, values)?;
    let mut controls = Vec::new();
    for (number, (damage, words, expected)) in (1..).zip(&CONTROLS) {
        let was_run = |id: &&str| {
            before
                .get(*id)
                .is_some_and(|verdict| *verdict != report::Verdict::NotRun)
        };
        if !expected.iter().all(was_run) {
            continue;
        }
        let (damaged, found) = inflict(damage, published, values)?;
        let after = verdicts(claims, &damaged, &found)?;
        controls.push(NegativeControl {
            id: format!("N{number}"),
            mutation: typeset(words).into(),
            expected: expected.iter().map(|id| (*id).to_owned()).collect(),
            turned: before
                .iter()
                .filter(|(id, verdict)| after[*id] != **verdict)
                .map(|(id, _)| id.clone())
                .collect(),
        });
    }
    Ok(controls)
}

/// Numbers and values after the damage; what the audit computes from published numbers is computed again.
fn inflict(
    damage: &Damage,
    published: &Published,
    values: &BTreeMap<String, Value>,
) -> Result<(Published, BTreeMap<String, Value>), PublishedError> {
    let mut found = values.clone();
    match damage {
        Damage::Printed(id, printed) => {
            let damaged = published.altered(id, printed)?;
            found.extend(audited(&damaged)?);
            Ok((damaged, found))
        }
        Damage::Found(id, number) => {
            if let Some(value) = found.get_mut(*id) {
                value.value = Some(*number);
                value.ci95 = None;
            }
            Ok((published.clone(), found))
        }
    }
}

/// What the audit finds in published numbers, by id.
///
/// # Errors
/// Where a published number is missing.
pub fn audited(published: &Published) -> Result<BTreeMap<String, Value>, PublishedError> {
    let values = audit::examine(published)?.values;
    Ok(values
        .into_iter()
        .map(|value| (value.id.clone(), value))
        .collect())
}

/// Verdicts by claim.
fn verdicts(
    claims: &[Claim],
    published: &Published,
    values: &BTreeMap<String, Value>,
) -> Result<BTreeMap<String, report::Verdict>, PublishedError> {
    let facts = Facts { published, values };
    claims
        .iter()
        .map(|claim| Ok((claim.id.clone(), judge(claim, &facts)?.verdict)))
        .collect()
}
