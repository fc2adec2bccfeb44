//! Noise that further numbers describe better than an exponential roughness of one length beside a white sensor: a force channel that wanders,
//! roughness that is smoother, or a length of its own for that of the plate.

use rayon::prelude::*;

use super::estimate::Search;
use super::frame::{Frame, LENGTH, More, PLATE, PRIVATE, SENSOR};
use super::restricted::Criterion;
use super::search::{Minimum, NEAR};

/// Smoothings that are tried beside exponential roughness, and lengths over which the roughness is alike as shares of the one found
/// (exponential roughness makes up for what it lacks in smoothness by length).
const PROBES: [(f64, f64); 5] = [
    (0.02, 1.0),
    (0.15, 1.0),
    (0.6, 1.0),
    (0.6, 0.4),
    (0.6, 0.15),
];
/// Smoothings of the plate's roughness that are tried beside that of both, and by how much there is more of it then (what was alike had to
/// be little where the plate is smoother).
const PLATE_PROBES: [(f64, f64); 3] = [(0.3, 1.0), (0.7, 1.0), (0.7, 1.6)];
/// Smoothing beyond which a search may have ended because both lengths are nearly one, and what it begins from again.
const ALIKE: f64 = 0.6;
const APART: f64 = 0.1;
/// -2 log likelihood that the search from there must save. Of eight smooth fields one seems to be of two lengths by 8.
const WORTH_APART: f64 = 12.0;
/// -2 log likelihood beyond which the sizes without a further number, searched for on its grid, would not take back what it saves.
const SURE: f64 = 50.0;
/// -2 log likelihood that smoothing must save, or the roughness is taken as exponential.
const WORTH_SMOOTHING: f64 = 2.0;
/// The same where the plate has a smoothing of its own.
const WORTH_SMOOTHER_PLATE: f64 = 6.0;

/// Ratios of the two lengths that are tried beside one, and the power of them by which the private length moves.
const RATIOS: [(f64, f64); 4] = [(0.4, 0.0), (0.4, -0.5), (2.5, 0.0), (2.5, -0.5)];
/// -2 log likelihood that a second length must save.
const WORTH_SECOND_LENGTH: f64 = 6.0;
/// The same of one length that is longer than roughness mostly is.
const WORTH_LONGER: f64 = 2.0;

/// Times over which a force channel may wander, in its shortest, that are tried; and the size that is tried, as a share of the sensor's: so small
/// that -2 log likelihood changes as its slope says, for which all other sizes may stay.
const WANDER_TIMES: [f64; 4] = [2.0, 6.0, 20.0, 60.0];
const WANDER_SHARE: f64 = 0.25;
/// Sizes from which searches begin, as shares of the sensor's noise: one beside the roughness as it is, and a slow one in the stead of roughness
/// that has come to be long for want of a wander, with the share of its length that is left.
const WANDER_BEGUN: f64 = 0.6;
const WANDER_IN_STEAD: f64 = 1.2;
const LENGTH_LEFT: f64 = 0.2;
/// -2 log likelihood that a wander must save.
const WORTH_WANDER: f64 = 10.0;

/// Places of the plate at which a step is looked for.
const PLACES: usize = 60;

/// Noise with a further number.
pub(super) struct Further {
    pub(super) frame: Frame,
    pub(super) minimum: Minimum,
}

/// A further number where it is likeliest of all points at which it is tried.
struct Promising {
    more: More,
    /// With the number.
    frame: Frame,
    /// What -2 log likelihood is there beyond that without it.
    beyond: f64,
    point: Vec<f64>,
}

impl Frame {
    /// A force channel that wanders, where that is likelier than `still` with a level of its own for every run, for a zero that moves from run
    /// to run is no wander; coarse grids of the plate tell it as well as fine ones.
    pub(super) fn wandering(
        &self,
        criterion: &Criterion<'_>,
        still: &Minimum,
        search: Search,
        evaluations: &mut usize,
    ) -> Option<Further> {
        let (shortest, longest) = self.wander_times_s;
        if self.wanders || !(longest > shortest) {
            return None;
        }
        let frame = self.clone().wandering_if(true);
        let with_wander = |share: f64, time_s: f64| {
            let mut point = still.point.clone();
            let wander = [point[SENSOR] + share.ln(), time_s.ln()];
            point.splice(self.further_place()..self.further_place(), wander);
            point
        };
        let spacing = self.coarse(&still.point);
        let levelled = criterion.with_levels();
        let without = self.value(&levelled, &still.point, spacing);
        let times = WANDER_TIMES.map(|times| times * shortest);
        let probed: Vec<(f64, f64)> = (times.into_par_iter())
            .filter(|time_s| *time_s < longest)
            .map(|time_s| {
                let tried = with_wander(WANDER_SHARE, time_s);
                (frame.value(&levelled, &tried, spacing), time_s)
            })
            .collect();
        *evaluations += probed.len() + 1;
        let likeliest = probed.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        let (_, time_s) = likeliest.filter(|(value, _)| *value < without)?;
        let [.., slowest] = times;
        let mut in_stead = with_wander(WANDER_IN_STEAD, slowest.min(0.5 * longest));
        in_stead[LENGTH] += LENGTH_LEFT.ln();
        let starts = [with_wander(WANDER_BEGUN, time_s), in_stead];
        let near = starts.map(|start| frame.on_grid(&levelled, &start, spacing, NEAR));
        *evaluations += near.iter().map(|found| found.evaluations).sum::<usize>();
        let near = (near.into_iter()).min_by(|a, b| a.value.total_cmp(&b.value))?;
        let worth = |without: f64| without - near.value >= WORTH_WANDER;
        // Sizes that are likeliest without a wander can only save less.
        if !worth(without) {
            return None;
        }
        if without - near.value < SURE {
            let as_still = self.on_grid(&levelled, &still.point, spacing, NEAR);
            *evaluations += as_still.evaluations;
            if !worth(as_still.value) {
                return None;
            }
        }
        let minimum = if search == Search::Near {
            near
        } else {
            let again = Search::Again(frame.sizes(&near.point));
            frame.search(criterion, near.point, again, evaluations)
        };
        Some(Further { frame, minimum })
    }

    /// What -2 log likelihood is at each of these points beyond that of `plain`, the minimum of a frame without a further number, both on the
    /// given spacing of the plate's grid.
    fn beyond(
        &self,
        criterion: &Criterion<'_>,
        (without, plain): (&Self, &Minimum),
        points: &[(f64, Vec<f64>)],
        evaluations: &mut usize,
    ) -> Vec<f64> {
        let mut spacings: Vec<f64> = points.iter().map(|(spacing, _)| *spacing).collect();
        spacings.sort_by(f64::total_cmp);
        spacings.dedup();
        *evaluations += points.len() + spacings.len();
        let as_plain = |&spacing: &f64| without.value(criterion, &plain.point, spacing);
        let own = |(spacing, point): &(f64, Vec<f64>)| self.value(criterion, point, *spacing);
        let (plain, own): (Vec<f64>, Vec<f64>) = rayon::join(
            || spacings.par_iter().map(as_plain).collect(),
            || points.par_iter().map(own).collect(),
        );
        let at = |spacing| spacings.iter().position(|&s| s == spacing);
        (points.iter().zip(own))
            .map(|((spacing, _), own)| own - at(*spacing).map_or(f64::NAN, |k| plain[k]))
            .collect()
    }

    /// Of these points that which is likeliest beside `plain`, with what -2 log likelihood is beyond it there ([`Self::beyond`]).
    fn likeliest(
        &self,
        criterion: &Criterion<'_>,
        beside: (&Self, &Minimum),
        points: Vec<(f64, Vec<f64>)>,
        evaluations: &mut usize,
    ) -> Option<(f64, Vec<f64>)> {
        let beyond = self.beyond(criterion, beside, &points, evaluations);
        (beyond.into_iter().zip(points))
            .map(|(beyond, (_, point))| (beyond, point))
            .min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// A further number that is worth it beside `found`: that which promises most on coarse grids and keeps it. The others are asked beside it
    /// once it is taken.
    pub(super) fn further(
        &self,
        criterion: &Criterion<'_>,
        found: &Minimum,
        search: Search,
        evaluations: &mut usize,
    ) -> Option<Further> {
        let thorough = search.is_thorough();
        let kinds = [More::Smoothing, More::PlateSmoothing, More::PlateRatio].into_iter();
        let asked =
            kinds.filter(|&more| !self.has(more) && (self.has_plate() || more == More::Smoothing));
        let mut promising: Vec<Promising> = asked
            .filter_map(|more| self.promising(criterion, found, (more, thorough), evaluations))
            .collect();
        promising.sort_by(|a, b| a.beyond.total_cmp(&b.beyond));
        (promising.into_iter()).find_map(|promising| match promising.more {
            More::Smoothing => self.smoother(criterion, found, promising, thorough, evaluations),
            More::PlateSmoothing => self.smoother_plate(criterion, found, promising, evaluations),
            More::PlateRatio => self.two_lengths(criterion, found, promising, evaluations),
        })
    }

    /// Where a further number is likeliest beside `found`, unless it need not be searched for there. If the search is not thorough a smoothing
    /// counts only if it is seen at once.
    fn promising(
        &self,
        criterion: &Criterion<'_>,
        found: &Minimum,
        (more, thorough): (More, bool),
        evaluations: &mut usize,
    ) -> Option<Promising> {
        let frame = self.clone().with(more);
        let points = frame.probes(self, found, more);
        let (beyond, point) = frame.likeliest(criterion, (self, found), points, evaluations)?;
        // Beside smoothing, which does much of what a second length would, a search is begun again for what is seen at once only.
        let smooth = self.has(More::Smoothing) || self.has(More::PlateSmoothing);
        let enough = match more {
            More::PlateRatio if smooth && !thorough => 0.0,
            More::PlateRatio => WORTH_SECOND_LENGTH,
            _ if thorough => f64::INFINITY,
            _ => 0.0,
        };
        (beyond < enough).then_some(Promising {
            more,
            frame,
            beyond,
            point,
        })
    }

    /// Points at which a further number is tried beside `plain`, the minimum of a frame without it, each with the spacing of a grid.
    fn probes(&self, without: &Self, plain: &Minimum, more: More) -> Vec<(f64, Vec<f64>)> {
        let of = |change: &dyn Fn(&mut Vec<f64>)| {
            let mut point = plain.point.clone();
            change(&mut point);
            (self.coarse(&point), point)
        };
        match more {
            // Roughness is alike over l (1 + rho).
            More::Smoothing => (PROBES.iter())
                .map(|&(smoothing, share)| {
                    of(&|point| {
                        point[LENGTH] += (share / (1.0 + smoothing)).ln();
                        point.push(smoothing.ln());
                    })
                })
                .collect(),
            More::PlateSmoothing => (PLATE_PROBES.iter())
                .map(|&(smoothing, more)| {
                    of(&|point| {
                        point[PLATE] += more.ln();
                        point.push(smoothing.ln());
                    })
                })
                .collect(),
            // What roughness does over short ways, its variance over its length, stays.
            More::PlateRatio => (RATIOS.iter())
                .map(|&(ratio, moved)| {
                    of(&|point| {
                        point[LENGTH] += moved * ratio.ln();
                        point[PRIVATE] += 0.5 * moved * ratio.ln();
                        point[PLATE] += 0.5 * (1.0 + moved) * ratio.ln();
                        point.push(ratio.ln());
                    })
                })
                .map(|(spacing, point)| (spacing.min(without.coarse(&plain.point)), point))
                .collect(),
        }
    }

    /// Roughness that is smoother than exponential, where that is likelier than `plain`.
    ///
    /// Shorter lengths have finer grids, and a finer grid alone is likelier: both sides are always compared on the same one.
    fn smoother(
        &self,
        criterion: &Criterion<'_>,
        plain: &Minimum,
        Promising {
            frame: smooth,
            point,
            ..
        }: Promising,
        thorough: bool,
        evaluations: &mut usize,
    ) -> Option<Further> {
        let from = if thorough {
            let coarse = smooth.coarse(&point);
            let near = smooth.on_grid(criterion, &point, coarse, NEAR);
            *evaluations += near.evaluations + 1;
            // What is not seen there at all will not be worth its price on a finer grid.
            if near.value > self.value(criterion, &plain.point, coarse) - 0.5 * WORTH_SMOOTHING {
                return None;
            }
            smooth.apart(criterion, near, evaluations)
        } else {
            point
        };
        let again = Search::Again(smooth.sizes(&from));
        let found = smooth.search(criterion, from, again, evaluations);
        let spacing = smooth.spacing(&found.point);
        let own = smooth.value(criterion, &found.point, spacing);
        *evaluations += 1;
        let saved = self.saved(criterion, plain, (own, spacing), SURE, evaluations);
        (saved > WORTH_SMOOTHING).then_some(Further {
            frame: smooth,
            minimum: found,
        })
    }

    /// A smoothing of its own for the plate's roughness, where it is likelier than that of the runs': a plate that is known at the places of a
    /// grid only, or that was ground.
    fn smoother_plate(
        &self,
        criterion: &Criterion<'_>,
        alike: &Minimum,
        Promising {
            frame: apart,
            point: start,
            ..
        }: Promising,
        evaluations: &mut usize,
    ) -> Option<Further> {
        let (minimum, _) = apart.worth_more(
            criterion,
            (self, alike),
            &start,
            (WORTH_SMOOTHER_PLATE, SURE),
            evaluations,
        )?;
        Some(Further {
            frame: apart,
            minimum,
        })
    }

    /// What a search from `start` finds with a further number, and what that saves of -2 log likelihood beside `plain`, the minimum of a frame
    /// without it: each with sizes of its own on one grid. `None` where a coarse grid does not show half of `worth`, or the fine one less than it.
    fn worth_more(
        &self,
        criterion: &Criterion<'_>,
        (without, plain): (&Self, &Minimum),
        start: &[f64],
        (worth, sure): (f64, f64),
        evaluations: &mut usize,
    ) -> Option<(Minimum, f64)> {
        let coarse = self.coarse(start);
        let near = self.on_grid(criterion, start, coarse, NEAR);
        *evaluations += near.evaluations + 1;
        if near.value > without.value(criterion, &plain.point, coarse) - 0.5 * worth {
            return None;
        }
        let again = Search::Again(self.sizes(&near.point));
        let found = self.search(criterion, near.point, again, evaluations);
        let spacing = self.spacing(&found.point);
        let own = self.value(criterion, &found.point, spacing);
        *evaluations += 1;
        let saved = without.saved(criterion, plain, (own, spacing), sure, evaluations);
        (saved >= worth).then_some((found, saved))
    }

    /// By how much `own`, a value on a grid of this spacing, is less than the least without a further number: the sizes of `plain` may be others on
    /// that grid. Where they save more than is `sure` they are not searched for, and nothing else is asked than whether it is enough.
    fn saved(
        &self,
        criterion: &Criterion<'_>,
        plain: &Minimum,
        (own, spacing): (f64, f64),
        sure: f64,
        evaluations: &mut usize,
    ) -> f64 {
        *evaluations += 1;
        let at_most = self.value(criterion, &plain.point, spacing) - own;
        if at_most <= 0.0 || at_most > sure {
            return at_most;
        }
        let fine = self.near(criterion, &plain.point, spacing);
        *evaluations += fine.evaluations;
        fine.value - own
    }

    /// Where both lengths l and rho l have come to be nearly one: the likelier of that point and of what a search from lengths apart finds on
    /// the same grid. The covariance does not change when the two are exchanged, so no slope leads away from rho = 1, be it likely or not.
    fn apart(
        &self,
        criterion: &Criterion<'_>,
        alike: Minimum,
        evaluations: &mut usize,
    ) -> Vec<f64> {
        let smoothing = self.sizes(&alike.point).smoothing;
        if smoothing < ALIKE {
            return alike.point;
        }
        // Over short ways roughness does what rho l^2 says.
        let mut start = alike.point.clone();
        let Some(place) = self.place(More::Smoothing) else {
            return alike.point;
        };
        start[place] = APART.ln();
        start[LENGTH] += 0.5 * (smoothing / APART).ln();
        let coarse = self.coarse(&alike.point);
        let apart = self.near(criterion, &start, coarse);
        *evaluations += apart.evaluations + 1;
        if apart.value < self.value(criterion, &alike.point, coarse) - WORTH_APART {
            apart.point
        } else {
            alike.point
        }
    }

    /// A length of its own for the plate's roughness, where that is likelier than one length for both, and than one length beside a step of
    /// the plate. Both sides are compared on one grid.
    fn two_lengths(
        &self,
        criterion: &Criterion<'_>,
        one: &Minimum,
        Promising {
            frame: apart,
            point: start,
            ..
        }: Promising,
        evaluations: &mut usize,
    ) -> Option<Further> {
        let (minimum, saved) = apart.worth_more(
            criterion,
            (self, one),
            &start,
            (WORTH_SECOND_LENGTH, f64::INFINITY),
            evaluations,
        )?;
        (saved >= self.a_step_or_slope_saves(criterion, one, evaluations)).then_some(Further {
            frame: apart,
            minimum,
        })
    }

    /// Roughness longer than a twentieth of the plate, where runs go back and forth and it is likelier than a step of the plate.
    pub(super) fn longer(
        &self,
        criterion: &Criterion<'_>,
        one: &Minimum,
        evaluations: &mut usize,
    ) -> Option<Further> {
        let frame = self.reaching_further(&one.point)?;
        let spacing = self.spacing(&one.point);
        let minimum = frame.near(criterion, &one.point, spacing);
        *evaluations += minimum.evaluations;
        let saved = self.value(criterion, &one.point, spacing) - minimum.value;
        let enough =
            saved > WORTH_LONGER && saved > self.a_step_or_slope_saves(criterion, one, evaluations);
        enough.then_some(Further { frame, minimum })
    }

    /// What a step in friction at one place of the plate, or a slope along all of it, would save of -2 log likelihood beside roughness of one
    /// length, all that were looked for paid for: a field that is long because of one of these is no field.
    fn a_step_or_slope_saves(
        &self,
        criterion: &Criterion<'_>,
        one: &Minimum,
        evaluations: &mut usize,
    ) -> f64 {
        let sizes = self.sizes(&one.point);
        let spacing = self.spacing(&one.point);
        let courses = criterion.steps_and_slope(PLACES);
        let Some(scores) = criterion.scores(&courses, &sizes, spacing) else {
            return 0.0;
        };
        let likeliest = (0..scores.len()).max_by(|&a, &b| scores[a].total_cmp(&scores[b]));
        let Some(step) = likeliest.map(|k| courses.columns(k, 1).into_owned()) else {
            return 0.0;
        };
        // With the step in the mean the roughness is smaller: both change, and C of one mean is no measure for another (its
        // determinant is of other columns). So C falls by what the step takes from the squares at the new sizes, less what these cost without it.
        let beside = criterion.with_columns(&step);
        let found = self.near(&beside, &one.point, spacing);
        *evaluations += found.evaluations + 3;
        let new = self.sizes(&found.point);
        let taken = criterion.scores(&step, &new, spacing);
        let worse = criterion.value(&new, spacing) - criterion.value(&sizes, spacing);
        taken.map_or(0.0, |taken| {
            taken[0] - worse - 2.0 * (scores.len() as f64).ln()
        })
    }
}
