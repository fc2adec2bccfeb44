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

/// Roughness with a further number, and what it saves of -2 log likelihood beside an exponential one of one length.
pub(super) struct Further {
    pub(super) frame: Frame,
    pub(super) minimum: Minimum,
    pub(super) saved: f64,
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
        // Sizes that are likeliest without a wander can only save less.
        if without - near.value < WORTH_WANDER {
            return None;
        }
        let as_still = self.on_grid(&levelled, &still.point, spacing, NEAR);
        *evaluations += as_still.evaluations;
        let saved = as_still.value - near.value;
        if saved < WORTH_WANDER {
            return None;
        }
        let minimum = if search == Search::Near {
            near
        } else {
            let again = Search::Again(frame.sizes(&near.point));
            frame.search(criterion, near.point, again, evaluations)
        };
        Some(Further {
            frame,
            minimum,
            saved,
        })
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

    /// The further number that saves most beside `found`, if any is worth it.
    pub(super) fn further(
        &self,
        criterion: &Criterion<'_>,
        found: &Minimum,
        search: Search,
        evaluations: &mut usize,
    ) -> Option<Further> {
        let thorough = search.is_thorough();
        let plate = self.has_plate();
        let mut worth: Vec<Further> = Vec::new();
        if !self.has(More::Smoothing) {
            worth.extend(self.smoother(criterion, found, thorough, evaluations));
        }
        if plate && !self.has(More::PlateSmoothing) {
            worth.extend(self.smoother_plate(criterion, found, thorough, evaluations));
        }
        if plate && !self.has(More::PlateRatio) {
            worth.extend(self.two_lengths(criterion, found, thorough, evaluations));
        }
        let saved = |of: &Further| of.saved;
        (worth.into_iter()).max_by(|a, b| saved(a).total_cmp(&saved(b)))
    }

    /// Roughness that is smoother than exponential, where that is likelier than `plain`. Unless the search is thorough a smoothing
    /// counts only if it is seen at once.
    ///
    /// Shorter lengths have finer grids, and a finer grid alone is likelier: both sides are always compared on the same one.
    pub(super) fn smoother(
        &self,
        criterion: &Criterion<'_>,
        plain: &Minimum,
        thorough: bool,
        evaluations: &mut usize,
    ) -> Option<Further> {
        let smooth = self.clone().with(More::Smoothing);
        let probe = |&(smoothing, share): &(f64, f64)| {
            // Roughness is alike over l (1 + rho).
            let mut point = plain.point.clone();
            point[LENGTH] += (share / (1.0 + smoothing)).ln();
            point.push(smoothing.ln());
            (smooth.coarse(&point), point)
        };
        let probes = PROBES.iter().map(probe).collect();
        let (_, point) = smooth
            .likeliest(criterion, (self, plain), probes, evaluations)
            .filter(|(beyond, _)| thorough || *beyond < 0.0)?;
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
        let saves = |plain: f64| own < plain - WORTH_SMOOTHING;
        *evaluations += 2;
        if !saves(self.value(criterion, &plain.point, spacing)) {
            return None;
        }
        // Exponential roughness may have other sizes on this grid.
        let fine = self.near(criterion, &plain.point, spacing);
        *evaluations += fine.evaluations;
        let as_fine = fine.value;
        saves(as_fine).then_some(Further {
            frame: smooth,
            minimum: found,
            saved: as_fine - own,
        })
    }

    /// A smoothing of its own for the plate's roughness, where it is likelier than that of the runs': a plate that is known at the places of a
    /// grid only, or that was ground.
    pub(super) fn smoother_plate(
        &self,
        criterion: &Criterion<'_>,
        alike: &Minimum,
        thorough: bool,
        evaluations: &mut usize,
    ) -> Option<Further> {
        let apart = self.clone().with(More::PlateSmoothing);
        let probe = |&(smoothing, more): &(f64, f64)| {
            let mut point = alike.point.clone();
            point[PLATE] += more.ln();
            point.push(smoothing.ln());
            (apart.coarse(&point), point)
        };
        let probes = PLATE_PROBES.iter().map(probe).collect();
        let (_, start) = apart
            .likeliest(criterion, (self, alike), probes, evaluations)
            .filter(|(beyond, _)| thorough || *beyond < 0.0)?;
        let (minimum, saved) = apart.worth_more(
            criterion,
            (self, alike),
            &start,
            WORTH_SMOOTHER_PLATE,
            evaluations,
        )?;
        Some(Further {
            frame: apart,
            minimum,
            saved,
        })
    }

    /// What a search from `start` finds with a further number, and what that saves of -2 log likelihood beside `plain`, the minimum of a frame
    /// without it: each with sizes of its own on one grid. `None` where a coarse grid does not show half of `worth`, or the fine one less than it.
    fn worth_more(
        &self,
        criterion: &Criterion<'_>,
        (without, plain): (&Self, &Minimum),
        start: &[f64],
        worth: f64,
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
        let as_plain = without.near(criterion, &plain.point, spacing);
        *evaluations += as_plain.evaluations + 1;
        let saved = as_plain.value - self.value(criterion, &found.point, spacing);
        (saved >= worth).then_some((found, saved))
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
    pub(super) fn two_lengths(
        &self,
        criterion: &Criterion<'_>,
        one: &Minimum,
        thorough: bool,
        evaluations: &mut usize,
    ) -> Option<Further> {
        let apart = self.clone().with(More::PlateRatio);
        let probe = |&(ratio, moved): &(f64, f64)| {
            // What roughness does over short ways, its variance over its length, stays.
            let mut point = one.point.clone();
            point[LENGTH] += moved * ratio.ln();
            point[PRIVATE] += 0.5 * moved * ratio.ln();
            point[PLATE] += 0.5 * (1.0 + moved) * ratio.ln();
            point.push(ratio.ln());
            (apart.coarse(&point).min(self.coarse(&one.point)), point)
        };
        // Beside smoothing, which does much of what a second length would, a search is begun again for what is seen at once only.
        let smooth = self.has(More::Smoothing) || self.has(More::PlateSmoothing);
        let enough = match smooth && !thorough {
            true => 0.0,
            false => WORTH_SECOND_LENGTH,
        };
        let probes = RATIOS.iter().map(probe).collect();
        let (_, start) = apart
            .likeliest(criterion, (self, one), probes, evaluations)
            .filter(|(beyond, _)| *beyond < enough)?;
        let (minimum, saved) = apart.worth_more(
            criterion,
            (self, one),
            &start,
            WORTH_SECOND_LENGTH,
            evaluations,
        )?;
        (saved >= self.a_step_or_slope_saves(criterion, one, evaluations)).then_some(Further {
            frame: apart,
            minimum,
            saved,
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
        enough.then_some(Further {
            frame,
            minimum,
            saved,
        })
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
