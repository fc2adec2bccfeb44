//! What a search concluded, held against unseen runs until its names stand.
//!
//! Contests, fits to the whole record, answer and gains all follow from the names; whenever a name is taken back they are made anew,
//! together.

use crate::answer::Diagnosis;
use crate::assemble::assemble;
use crate::bench::Bench;
use crate::contests::contests;
use crate::equivalence::Contest;
use crate::floor::noise_floor;
use crate::gain::{self, Gains};
use crate::integrity::Integrity;
use crate::refusal::{refuse_beaten, take_all_back, take_one_back};
use crate::selection::{Selected, strict};
use crate::whole::Whole;

/// A name is plain where it saves so many times the deviance that it must be worth.
const PLAIN: f64 = 2.0;
/// A name is idle beside others where it saves less than this share of it: it was worth all of it when it came in.
const IDLE: f64 = 0.5;

/// The names of a search and all that follows from them.
pub(crate) struct Verdict<'a> {
    recorded: &'a Bench<'a>,
    searched: &'a Bench<'a>,
    integrity: &'a Integrity,
    pub(crate) selected: Selected,
    /// Each name against its rivals.
    pub(crate) contests: Vec<Contest>,
    /// The fits with all recorded samples.
    pub(crate) whole: Whole<'a>,
}

impl<'a> Verdict<'a> {
    /// The names of a search, held against their rivals.
    pub(crate) fn of(
        recorded: &'a Bench<'a>,
        searched: &'a Bench<'a>,
        mut selected: Selected,
        integrity: &'a Integrity,
    ) -> Self {
        let contests = held_against_rivals(searched, &mut selected);
        Self {
            whole: Whole::of(recorded, searched, &selected),
            recorded,
            searched,
            integrity,
            selected,
            contests,
        }
    }

    /// Nothing is named.
    pub(crate) fn take_all_back(&mut self) {
        take_all_back(self.searched, &mut self.selected);
        self.contests.clear();
        self.whole = Whole::of(self.recorded, self.searched, &self.selected);
    }

    /// The answer but for what folds and designed experiments add.
    pub(crate) fn answer(&self) -> Diagnosis {
        assemble(&self.whole, &self.selected, &self.contests, self.integrity)
    }

    /// Takes back what does not hold on runs that it has not seen: a surplus name first, then all. The gains of what is left, and why
    /// nothing is named where that is so.
    pub(crate) fn hold_against_unseen_runs(&mut self) -> (Option<Gains>, Option<String>) {
        let mut gains = self.gains();
        while let Some(k) = gains.as_ref().and_then(|gains| self.surplus(gains)) {
            let why = "on unseen runs it gains no more than scrambled ones";
            if take_one_back(self.searched, &mut self.selected, k, why).is_none() {
                break;
            }
            self.contests = held_against_rivals(self.searched, &mut self.selected);
            self.whole = Whole::of(self.recorded, self.searched, &self.selected);
            gains = self.gains();
        }
        let Some(against) = gains.as_ref().and_then(Gains::speak_against) else {
            return (gains, None);
        };
        let causes = self.selected.stand.fitted.ids(self.searched).join(", ");
        let taken = format!("on unseen runs the extension by {causes} {against}: it is not named");
        self.take_all_back();
        (gains.map(Gains::of_the_law), Some(taken))
    }

    /// The name that is surplus beside the others, if one is.
    fn surplus(&self, gains: &Gains) -> Option<usize> {
        let worth = -2.0 * strict(&self.selected.first);
        gains.surplus(|k| {
            let contest = self.contests.get(k);
            contest.is_some_and(|contest| contest.saved > PLAIN * worth)
        })
    }

    fn gains(&self) -> Option<Gains> {
        // Folds select by the force.
        let ties: Vec<Vec<usize>> = self.contests.iter().map(Contest::tied_in_force).collect();
        let Whole {
            bench,
            apart,
            extended,
            ..
        } = &self.whole;
        let floor = noise_floor(bench, &self.selected, &extended.prediction, *apart).rmse;
        gain::judge(self.searched, &self.whole, &self.selected, &ties, floor)
    }
}

/// The contests of all names once those are gone that came in for what others do by now; none where a name is beaten: then nothing is
/// named.
fn held_against_rivals(bench: &Bench<'_>, selected: &mut Selected) -> Vec<Contest> {
    let worth = -2.0 * strict(&selected.first);
    let mut contests = contests(bench, selected);
    while let Some(k) = idle(&contests, IDLE * worth) {
        let why = "once all was fitted it saves next to nothing";
        if take_one_back(bench, selected, k, why).is_none() {
            break;
        }
        contests = self::contests(bench, selected);
    }
    if refuse_beaten(bench, selected, &contests) {
        contests.clear();
    }
    contests
}

/// Of several names the one that saves least, where that is less than this.
fn idle(contests: &[Contest], least: f64) -> Option<usize> {
    let saved = contests.iter().map(|contest| contest.saved).enumerate();
    let (k, saved) = saved.min_by(|a, b| a.1.total_cmp(&b.1))?;
    (contests.len() > 1 && saved < least).then_some(k)
}
