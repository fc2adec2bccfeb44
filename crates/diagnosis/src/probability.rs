//! Posterior weight of a named set among all causes that were compared, "none of these" included.
//!
//! Prior: half for no cause at all, half shared equally by the causes compared. Evidence by Schwarz's approximation,
//! log m = log L - (k/2) log(1 + 2 delta), k parameters whose information grows with the effect's own log-likelihood
//! gain delta: an effect that is just visible pays little more than Akaike's price, a large one its prior's width.

use crate::bench::Bench;
use crate::equivalence::Contest;
use crate::tail::log_sum;

/// Weight of the cause `own` with its equivalents.
pub(crate) fn weight_of_set(
    bench: &Bench<'_>,
    contest: &Contest,
    own: usize,
    equivalent: &[String],
) -> f64 {
    let evidence = |cause: usize, saved: f64| -> f64 {
        let k = bench.catalogue[cause].parameters().len() as f64;
        let delta = 0.5 * saved;
        delta - 0.5 * k * (1.0 + 2.0 * delta.max(0.0)).ln()
    };
    let compared = (contest.opponents.len() + 1) as f64;
    let prior = (0.5 / compared).ln();
    let mut named = prior + evidence(own, contest.saved);
    let mut others = 0.5_f64.ln();
    for opponent in &contest.opponents {
        let excess = if opponent.excess_deviance.is_finite() {
            opponent.excess_deviance
        } else {
            opponent.separation * opponent.separation
        };
        let weight = prior + evidence(opponent.cause, contest.saved - excess);
        let id = bench.catalogue[opponent.cause].id();
        if equivalent.iter().any(|e| e == id) {
            named = log_sum(named, weight);
        } else {
            others = log_sum(others, weight);
        }
    }
    (named - log_sum(named, others)).exp()
}
