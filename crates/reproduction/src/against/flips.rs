//! The values of an earlier report, judged by the present rules.

use std::collections::BTreeMap;

use report::{Value, Verdict};
use serde_json::Value as Json;

use crate::claims::Claim;
use crate::judgements::{Facts, judge};
use crate::published::{Published, PublishedError};

/// What decides verdicts besides the values.
#[derive(Clone, Copy)]
pub struct Rules<'a> {
    /// The claims with their tolerances.
    pub claims: &'a [Claim],
    /// The paper's numbers.
    pub published: &'a Published,
}

type Values = BTreeMap<String, Value>;
type Verdicts = BTreeMap<String, Verdict>;

impl Rules<'_> {
    fn verdicts(&self, values: &Values) -> Result<Verdicts, PublishedError> {
        let facts = Facts {
            published: self.published,
            values,
        };
        self.claims
            .iter()
            .map(|claim| Ok((claim.id.clone(), judge(claim, &facts)?.verdict)))
            .collect()
    }
}

/// Two sets of values under one set of rules.
pub(super) struct Judged<'a> {
    rules: &'a Rules<'a>,
    old: Values,
    new: Values,
    before: Verdicts,
    now: Verdicts,
}

impl<'a> Judged<'a> {
    pub(super) fn new(
        rules: &'a Rules<'a>,
        old: &Json,
        new: &Json,
    ) -> Result<Self, PublishedError> {
        let (old, new) = (values(old), values(new));
        Ok(Self {
            rules,
            before: rules.verdicts(&old)?,
            now: rules.verdicts(&new)?,
            old,
            new,
        })
    }

    /// Claims for which the old values ask for another verdict than the new ones, apart from those whose stored verdicts
    /// tell it already: claim, before, now.
    pub(super) fn by_values(
        &self,
        told: &[(String, String, String)],
    ) -> Vec<(String, String, String)> {
        let untold = |id: &String| told.iter().all(|(claim, ..)| claim != id);
        self.now
            .iter()
            .filter(|(id, now)| self.before.get(*id) != Some(now) && untold(id))
            .map(|(id, now)| {
                let before = self
                    .before
                    .get(id)
                    .map_or("absent", |verdict| verdict.word());
                (id.clone(), before.to_owned(), now.word().to_owned())
            })
            .collect()
    }

    /// Claims whose verdict changes where this one value is put back to what it was.
    pub(super) fn alone(&self, id: &str) -> Result<Vec<String>, PublishedError> {
        let mut values = self.new.clone();
        match self.old.get(id) {
            Some(value) => values.insert(id.to_owned(), value.clone()),
            None => values.remove(id),
        };
        let then = self.rules.verdicts(&values)?;
        Ok(self
            .now
            .iter()
            .filter(|(claim, now)| then.get(*claim) != Some(now))
            .map(|(claim, _)| claim.clone())
            .collect())
    }
}

/// The values of results by id. An interval that does not hold its own number is not its interval: the number counts.
fn values(results: &Json) -> Values {
    super::array(results, "values")
        .filter_map(|value| serde_json::from_value::<Value>(value.clone()).ok())
        .map(|mut value| {
            value.ci95 = value.ci95.filter(|[lower, upper]| {
                value.value.is_some_and(|x| (*lower..=*upper).contains(&x))
            });
            (value.id.clone(), value)
        })
        .collect()
}
