//! The parts of the page about claims: verdict board, ledger, deviations, audit, changes, controls.

use minijinja::{Value, context};

use super::claim_links;
use super::engine::safe;
use crate::Prose;
use crate::prose::Lookup;
use crate::{
    AuditOutcome, ClaimRow, Deviation, Document, Drift, DriftRow, Error, Multiverse, Verdict,
    number,
};

/// Everything about claims that the page template needs.
pub(super) fn context(document: &Document, lookup: &Lookup<'_>) -> Result<Value, Error> {
    let claims = each(&document.claims, |claim| {
        claim_view(claim, document, lookup)
    })?;
    let deviations = each(&document.deviations, |item| {
        deviation(item, document, lookup)
    })?;
    let audit = each(&document.audit, |item| {
        let place = format!("audit {}", item.id);
        Ok(context! {
            id => &item.id,
            subject => &item.subject,
            locator => &item.locator,
            sum => safe(lookup.inline(&item.sum, &place)?),
            outcome => item.outcome.word(),
            symbol => item.outcome.symbol(),
            consequence => safe(lookup.paragraphs(&item.consequence, &place)?),
            claims => claim_links(&item.claims, lookup),
        })
    })?;
    let controls = each(&document.controls, |item| {
        Ok(context! {
            id => &item.id,
            mutation => safe(lookup.inline(&item.mutation, &format!("control {}", item.id))?),
            expected => claim_links(&item.expected, lookup),
            turned => claim_links(&item.turned, lookup),
            passed => item.passed(),
        })
    })?;
    let count = |outcome: AuditOutcome| {
        document
            .audit
            .iter()
            .filter(|item| item.outcome == outcome)
            .count()
    };
    Ok(context! {
        board => board(document),
        short => short(document, lookup)?,
        claims,
        deviations,
        audit,
        audit_counts => context! {
            holds => count(AuditOutcome::Holds),
            fails => count(AuditOutcome::Fails),
            open => count(AuditOutcome::Open),
        },
        controls,
        drift => document.drift.as_ref().map(|drift| drift_view(drift, lookup)),
    })
}

/// A view of each item, in order.
pub(super) fn each<T>(
    items: &[T],
    view: impl Fn(&T) -> Result<Value, Error>,
) -> Result<Vec<Value>, Error> {
    items.iter().map(view).collect()
}

/// All six verdicts with their claims; nothing at all where there is no ledger.
fn board(document: &Document) -> Vec<Value> {
    if document.claims.is_empty() {
        return Vec::new();
    }
    Verdict::ALL
        .iter()
        .map(|verdict| {
            let ids: Vec<String> = document
                .claims
                .iter()
                .filter(|claim| claim.verdict == *verdict)
                .map(|claim| claim.id.clone())
                .collect();
            context! {
                word => verdict.word(),
                class => verdict.class(),
                symbol => verdict.symbol(),
                meaning => verdict.meaning(),
                count => ids.len(),
                ids,
            }
        })
        .collect()
}

/// The claims on which something was decided, in a line each: what the paper contradicts, what differs, what is reproduced, and what would
/// settle those that are not.
fn short(document: &Document, lookup: &Lookup<'_>) -> Result<Vec<Value>, Error> {
    let told = [Verdict::Contradicted, Verdict::Differs, Verdict::Reproduced];
    let of = |verdict| move |claim: &&ClaimRow| claim.verdict == verdict;
    told.into_iter()
        .flat_map(|verdict| document.claims.iter().filter(of(verdict)))
        .map(|claim| {
            let inline = |text: &Prose| lookup.inline(text, &format!("claim {}", claim.id));
            let settles = deviation_of(document, claim).map(|item| inline(&item.settles));
            Ok(context! {
                id => &claim.id,
                verdict => verdict_view(claim.verdict),
                claim => safe(inline(&claim.claim)?),
                settles => settles.transpose()?.map(safe),
            })
        })
        .collect()
}

fn verdict_view(verdict: Verdict) -> Value {
    context! { word => verdict.word(), class => verdict.class(), symbol => verdict.symbol() }
}

fn claim_view(claim: &ClaimRow, document: &Document, lookup: &Lookup<'_>) -> Result<Value, Error> {
    let place = format!("claim {}", claim.id);
    let inline = |prose: &Prose| lookup.inline(prose, &place).map(safe);
    let optional = |prose: &Option<Prose>| prose.as_ref().map(inline).transpose();
    let values = each(&claim.values, |id| {
        let text = lookup.inline(&format!("{{{{ ci(\"{id}\") }}}}").into(), &place)?;
        Ok(context! { id, text => safe(text) })
    })?;
    let comparisons = each(&claim.comparisons, |item| {
        let (class, symbol, word) = match item.agrees {
            Some(true) => ("holds", "✓", "agrees"),
            Some(false) => ("fails", "≠", "differs"),
            None => ("open", "–", "not computed"),
        };
        Ok(context! {
            label => inline(&item.label)?,
            published => inline(&item.published)?,
            ours => inline(&item.ours)?,
            deviation => inline(&item.deviation)?,
            tolerance => inline(&item.tolerance)?,
            class, symbol, word,
        })
    })?;
    let deviates = deviation_of(document, claim);
    let figures: Vec<String> = claim
        .figures
        .iter()
        .map(|id| lookup.link(id, &figure_title(document, id)))
        .collect();
    Ok(context! {
        id => &claim.id,
        claim => inline(&claim.claim)?,
        locator => &claim.locator,
        quote => &claim.quote,
        published => inline(&claim.published)?,
        ours => inline(&claim.ours)?,
        comparisons,
        deviation => optional(&claim.deviation)?,
        tolerance => inline(&claim.tolerance)?,
        reason => inline(&claim.reason)?,
        flips_at => optional(&claim.flips_at)?,
        verdict => verdict_view(claim.verdict),
        evidence => claim.evidence.word(),
        account => safe(lookup.paragraphs(&claim.account, &place)?),
        values,
        figures => safe(figures.join(", ")),
        pinned_by => &claim.pinned_by,
        deviates => deviates.map(|item| Ok::<_, Error>(context! {
            cause => item.cause.words(),
            settles => inline(&item.settles)?,
        })).transpose()?,
        multiverse => claim.multiverse.as_ref().map(|m| multiverse(m, lookup, &place)).transpose()?,
    })
}

/// What is said of a claim that is not reproduced.
fn deviation_of<'d>(document: &'d Document, claim: &ClaimRow) -> Option<&'d Deviation> {
    document
        .deviations
        .iter()
        .find(|item| item.claim == claim.id)
}

/// The title of a figure or table, or its id where this page does not have it.
fn figure_title(document: &Document, id: &str) -> String {
    document
        .sections
        .iter()
        .flat_map(|section| &section.blocks)
        .find_map(|block| match block {
            crate::Block::Figure(figure) if figure.id == id => Some(figure.title.clone()),
            crate::Block::Table(table) if table.id == id => Some(table.title.clone()),
            _ => None,
        })
        .unwrap_or_else(|| id.to_string())
}

fn multiverse(multiverse: &Multiverse, lookup: &Lookup<'_>, place: &str) -> Result<Value, Error> {
    let counts: Vec<String> = Verdict::ALL
        .iter()
        .filter_map(|verdict| {
            let count = multiverse.verdicts.iter().filter(|v| *v == verdict).count();
            (count > 0).then(|| format!("{count} {}", verdict.word()))
        })
        .collect();
    // Marks that differ in the last choice alone stand together.
    let group = match multiverse.axes.as_slice() {
        [_, .., (_, last)] => last.len().max(1),
        _ => multiverse.verdicts.len().max(1),
    };
    let marks: Vec<Vec<Value>> = multiverse
        .verdicts
        .chunks(group)
        .map(|group| group.iter().map(|v| verdict_view(*v)).collect())
        .collect();
    let axes: Vec<(String, Vec<String>)> = multiverse.axes.clone();
    Ok(context! {
        holds => multiverse.holds,
        of => multiverse.of,
        without => multiverse.verdicts.iter().filter(|v| **v == Verdict::NotRun).count(),
        axes => minijinja::value::Serde(axes),
        marks,
        summary => format!("One mark a combination: {}", counts.join(", ")),
        account => safe(lookup.inline(&multiverse.account, place)?),
    })
}

fn deviation(item: &Deviation, document: &Document, lookup: &Lookup<'_>) -> Result<Value, Error> {
    let place = format!("deviation of {}", item.claim);
    let verdict = document
        .claims
        .iter()
        .find(|claim| claim.id == item.claim)
        .map_or(Verdict::NotRun, |claim| claim.verdict);
    Ok(context! {
        claim => &item.claim,
        link => safe(lookup.link(&item.claim, &item.claim)),
        verdict => verdict_view(verdict),
        cause => item.cause.words(),
        account => safe(lookup.paragraphs(&item.account, &place)?),
        settles => safe(lookup.paragraphs(&item.settles, &place)?),
    })
}

fn drift_view(drift: &Drift, lookup: &Lookup<'_>) -> Value {
    let rows: Vec<Value> = drift
        .rows
        .iter()
        .map(|row| drift_row(row, lookup))
        .collect();
    context! {
        against => &drift.against,
        old_identity => &drift.old_identity,
        unchanged => drift.unchanged,
        rows,
        verdicts => minijinja::value::Serde(&drift.verdicts),
        by_values => minijinja::value::Serde(&drift.by_values),
        platforms => minijinja::value::Serde(&drift.platforms),
        nothing => drift.nothing(),
    }
}

fn drift_row(row: &DriftRow, lookup: &Lookup<'_>) -> Value {
    let shown = |number: Option<f64>, absent: &str| {
        number.map_or_else(
            || absent.to_string(),
            |n| number::with_unit(&number::significant(n, 6), &row.unit),
        )
    };
    let difference = match (row.old, row.new) {
        (Some(old), Some(new)) => number::significant(new - old, 2),
        _ => "–".into(),
    };
    context! {
        id => &row.id,
        old => shown(row.old, "absent"),
        new => shown(row.new, "gone"),
        difference,
        used => row.tolerance_used_percent.map_or_else(|| "–".to_string(), |p| number::with_unit(&number::significant(p, 2), "percent")),
        class => row.class.word(),
        flips => if row.flips.is_empty() { safe("–".into()) } else { claim_links(&row.flips, lookup) },
    }
}
