//! The law alone, fitted from many starts.

use fitting::noise::{Context, Sizes, Whitener};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use rig::{Model, Paths};

use crate::bench::{Bench, Fitted};
use crate::starts::ranked;
use crate::subset::Subset;

/// Starts of the law that are fitted, and steps of each: the nearest of all that are looked at, then the better of those that ended
/// apart from one another.
const LAW_ROUNDS: [(usize, u64); 3] = [(12, 4), (6, 8), (3, 60)];
/// Starts that are fitted beside them under a noise without scatter between runs, and steps of each.
const FITS_WITHOUT_SCATTER: (usize, u64) = (4, 8);
/// Starts spread about the typical sizes, beside those that the record suggests.
const STARTS_SPREAD: usize = 32;

/// Law parameters spread about their typical sizes, a factor of four each way, both signs where bounds allow.
fn spread_about(model: &Model) -> Vec<Vec<f64>> {
    let specs = &model.parameters()[..model.law_parameters()];
    let (low, high): (Vec<f64>, Vec<f64>) = specs
        .iter()
        .map(|s| {
            let wide = 4.0 * s.typical.abs();
            if s.lower >= 0.0 {
                ((s.typical / 4.0).max(s.lower), wide.min(s.upper))
            } else {
                ((-wide).max(s.lower), wide.min(s.upper))
            }
        })
        .unzip();
    fitting::spread_starts(&low, &high, STARTS_SPREAD)
}

impl Bench<'_> {
    /// Law parameters from which fits may start: what the record suggests, and a spread about typical sizes (or the model
    /// file's alone).
    pub(crate) fn law_starts(&self, model: &Model) -> Vec<Vec<f64>> {
        match &self.prior {
            Some(prior) => vec![prior.values.clone()],
            None => {
                let features = identification::features(self.campaign);
                let mut starts =
                    identification::starts(self.law, &features, self.experiment.height_m, None);
                starts.extend(spread_about(model));
                starts
            }
        }
    }

    /// Starts of a law that does nearly without a stretch before sliding: where something else on the rig is elastic, the record
    /// shows that instead.
    pub(crate) fn stiff_law_starts(&self) -> Vec<Vec<f64>> {
        /// Share of the stretch that is left to the contact.
        const LEFT: f64 = 0.1;
        if self.prior.is_some() {
            return Vec::new();
        }
        let mut features = identification::features(self.campaign);
        features.half_way *= LEFT;
        identification::starts(self.law, &features, self.experiment.height_m, None)
    }

    /// The law alone, from the starts that the record suggests (or from the model file). Where rough fits stay above `hopeless`
    /// (in units of their cost) the best of them is the answer.
    pub(crate) fn law_fit(&self, subset: &Subset, sizes: &Sizes, hopeless: f64) -> Option<Fitted> {
        let model = self.model(&[])?;
        let starts = self.law_starts(&model);
        self.law_fit_from(subset, sizes, hopeless, &starts)
    }

    /// The same from these starts: all are looked at, the nearest are fitted.
    fn law_fit_from(
        &self,
        subset: &Subset,
        sizes: &Sizes,
        hopeless: f64,
        starts: &[Vec<f64>],
    ) -> Option<Fitted> {
        let scale = self.crude_scale();
        let context = subset.context(self, &scale);
        let whitener = Whitener::new(&context, sizes);
        let model = self.model(&[])?;
        let wholes: Vec<Vec<f64>> = starts
            .iter()
            .map(|start| model.at_null(start, &self.experiment))
            .collect();
        let healthy = self.healthy_noise(&context);
        let ranked = ranked(self, subset, &healthy, &model, wholes, Paths::NONE);
        let mut from: Vec<Vec<f64>> = ranked.into_iter().map(|(_, whole)| whole).collect();
        let without_scatter = self.without_scatter(subset, &healthy, &from);
        let mut best: Option<Fitted> = None;
        for (round, (most, steps)) in LAW_ROUNDS.into_iter().enumerate() {
            if round + 1 == LAW_ROUNDS.len() && best.as_ref().is_some_and(|b| b.cost > hopeless) {
                break;
            }
            from.truncate(most);
            if round == 1 {
                from.extend_from_slice(&without_scatter);
            }
            let fits: Vec<Option<Fitted>> = from
                .par_iter()
                .map(|start| self.fit(subset, &[], start, &whitener, None, steps))
                .collect();
            let mut fits: Vec<Fitted> = fits.into_iter().flatten().collect();
            fits.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            let fits = self.apart(subset, &whitener, fits);
            from = fits.iter().map(|fit| fit.parameters.clone()).collect();
            best = fits.into_iter().next();
        }
        best
    }

    /// Whitening by the noise of a healthy rig: no residual has been looked at. The record itself stands for its friction, so a gain free for each
    /// run would forgive a law without any friction; roughness along the run does not.
    pub(crate) fn healthy_noise(&self, context: &Context) -> Whitener {
        let sizes = Sizes {
            scatter: 0.0,
            ..self.first_sizes()
        };
        Whitener::new(context, &sizes)
    }

    /// Rough fits of the law from the first of these starts under a noise without scatter between runs: beside scatter no friction at all is a
    /// fit of its own (each run is off by a gain of all that it has), and starts whose curve is far from the record's are drawn to it.
    fn without_scatter(
        &self,
        subset: &Subset,
        healthy: &Whitener,
        starts: &[Vec<f64>],
    ) -> Vec<Vec<f64>> {
        let (most, steps) = FITS_WITHOUT_SCATTER;
        let fits: Vec<Option<Fitted>> = starts
            .par_iter()
            .take(most)
            .map(|start| self.fit(subset, &[], start, healthy, None, steps))
            .collect();
        let mut fits: Vec<Fitted> = fits.into_iter().flatten().collect();
        fits.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let fits = self.apart(subset, healthy, fits);
        fits.into_iter().map(|fit| fit.parameters).collect()
    }

    /// Fits, best first, without those that have come to where a better one is.
    fn apart(&self, subset: &Subset, whitener: &Whitener, fits: Vec<Fitted>) -> Vec<Fitted> {
        /// Share of a fit's own cost.
        const SAME: f64 = 1e-3;
        if fits.is_empty() {
            return fits;
        }
        let columns: Vec<DVector<f64>> = fits
            .iter()
            .map(|fit| subset.gather(&fit.prediction))
            .collect();
        let white = whitener.whiten_columns(&DMatrix::from_columns(&columns));
        let distance = |a: usize, b: usize| (white.column(a) - white.column(b)).norm_squared();
        let mut kept: Vec<usize> = Vec::new();
        for k in 0..fits.len() {
            if kept
                .iter()
                .all(|&better| distance(better, k) > SAME * fits[k].cost)
            {
                kept.push(k);
            }
        }
        let all = fits.into_iter().enumerate();
        all.filter(|(k, _)| kept.contains(k))
            .map(|(_, fit)| fit)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Options;
    use crate::prepare::{self, stand_in};

    /// Nearly all starts have next to no friction, and noise that multiplies the record forgives that for little more than the gain of each
    /// run. The one start that has some, though it grows with the speed where the record's is level, is fitted all the same.
    #[test]
    fn no_friction_is_no_fit() {
        let campaign = stand_in("brush-2x2-aluminium");
        let bench = prepare::bench(&campaign, &Options::default()).expect("a bench");
        let (subset, sizes) = (Subset::all(&bench), bench.first_sizes());
        let model = bench.model(&[]).expect("a model");
        let from_all = bench.law_fit(&subset, &sizes, f64::INFINITY);
        let right = from_all.expect("a fit");
        let law = &right.parameters[..model.law_parameters()];
        let at = |name| model.parameters().iter().position(|p| p.name == name);
        let [sigma0, sigma1, sigma2] =
            ["sigma0", "sigma1", "sigma2"].map(|name| at(name).expect("its parameter"));
        let scaled = |share: f64| {
            let all = law.iter().enumerate();
            let friction = |k| [sigma0, sigma1, sigma2].contains(&k);
            all.map(|(k, p)| if friction(k) { share * p } else { *p })
                .collect::<Vec<f64>>()
        };
        // at the lower bounds of levels and damping little is left that a step could follow
        let none: Vec<f64> = (model.parameters().iter().zip(law))
            .map(|(spec, &p)| if spec.lower >= 0.0 { spec.lower } else { p })
            .collect();
        let mut starts = vec![none; 20];
        let mut growing = scaled(0.1);
        let scales = &bench.experiment.scales;
        let rate = scales.speed_m_s / scales.height_m.expect("a brush");
        growing[sigma2] = 1.5 * scales.friction / rate;
        starts.push(growing);
        let fit = bench.law_fit_from(&subset, &sizes, f64::INFINITY, &starts);
        let cost = fit.expect("a fit").cost;
        assert!(cost < 1.001 * right.cost, "{cost} for {}", right.cost);
    }
}
