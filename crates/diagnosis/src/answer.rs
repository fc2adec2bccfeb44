//! The answer: what the program says about a campaign, as it stands in the JSON (`bristle/diagnosis/1`).

use serde::{Deserialize, Serialize};

/// The strongest that applies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// Structure is left that no cause of the catalogue explains.
    Unexplained,
    /// The named causes fit equally well: the first finding's `equivalent` lists the others.
    Ambiguous,
    /// Every error beyond the noise has a named cause.
    Explained,
    /// No error beyond the noise.
    Consistent,
}

impl Status {
    /// The word in the JSON.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Unexplained => "unexplained",
            Self::Ambiguous => "ambiguous",
            Self::Explained => "explained",
            Self::Consistent => "consistent",
        }
    }
}

/// The noise below which nothing can be said.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NoiseFloor {
    /// Standard deviation within repeats, scatter between runs included.
    pub rmse: f64,
    /// Unit: `1` (a coefficient), `N` or `N m`.
    pub unit: String,
    /// `repeats`, or `model` where the campaign has none.
    pub source: String,
    /// Sensor noise (white), in N or N m.
    pub sensor: f64,
    /// Standard deviation of the force channel's wander, in N or N m; 0 where none is seen.
    pub wander: f64,
    /// Time over which the wander is correlated, s; none without it.
    pub wander_time_s: Option<f64>,
    /// Roughness private to a run, relative to the friction force.
    pub roughness_private: f64,
    /// Roughness fixed to the plate, relative to the friction force.
    pub roughness_plate: f64,
    /// Correlation length of the roughness, m or rad.
    pub roughness_length: f64,
    /// Length of the filter that the roughness has passed, as a share of that length: 0 is an exponential covariance.
    pub roughness_smoothing: f64,
    /// Correlation length of the roughness fixed to the plate over that of the private one.
    pub roughness_plate_ratio: f64,
    /// The smoothing of the roughness fixed to the plate where it has one of its own; 0: as the private one.
    pub roughness_plate_smoothing: f64,
    /// Scatter between runs, relative.
    pub scatter: f64,
    /// What could not be estimated and why; empty where all could.
    pub caveats: Vec<String>,
}

/// The law alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Baseline {
    /// Error of the fit to all runs, in the floor's unit.
    pub rmse: f64,
    /// Error on runs that were left out.
    pub held_out_rmse: Option<f64>,
    /// 1 - (floor/baseline)^2, not below zero.
    pub explainable_fraction: f64,
}

/// A parameter of a named cause.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Name, see the catalogue.
    pub name: String,
    /// Value in SI units.
    pub value: f64,
    /// 95 % interval, `None` where the data do not give one.
    pub ci95: Option<[f64; 2]>,
    /// Unit.
    pub unit: String,
}

/// What an extension brings on runs that it has not seen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gain {
    /// Pooled error over folds without the cause.
    pub held_out_rmse_before: f64,
    /// Pooled error over folds with it.
    pub held_out_rmse_after: f64,
    /// (before^2 - after^2) / (before^2 - floor^2), `None` where the denominator is within its uncertainty.
    pub explained_fraction: Option<f64>,
    /// 95 % interval, paired over runs, studentised.
    pub ci95: Option<[f64; 2]>,
    /// Share of the placebo extensions (scrambled signatures, as many parameters) that the gain exceeds.
    pub placebo_exceeded: Option<f64>,
}

/// A rival and what it loses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rival {
    /// Its id.
    pub cause: String,
    /// Its log-likelihood less that of the named cause, both fitted jointly with the law.
    pub delta: f64,
    /// Distance in standard deviations between what the two predict after refitting; `None` where it was not computed.
    pub separation: Option<f64>,
}

/// The evidence for a finding.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// Log-likelihood with the cause less that without it.
    pub delta_log_likelihood: f64,
    /// Standard deviations with the same tail probability, search over shapes paid for.
    pub z: f64,
    /// The nearest rivals.
    pub rivals: Vec<Rival>,
}

/// A named cause.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// Its id in the catalogue.
    pub cause: String,
    /// Its station in the chain.
    pub station: String,
    /// Causes that explain the campaign as well: the protocol cannot separate them from this one.
    pub equivalent: Vec<String>,
    /// Posterior weight of this cause with its equivalents among all that were compared, none of them included.
    pub probability: f64,
    /// Its parameters.
    pub parameters: Vec<Estimate>,
    /// What it brings when added last.
    pub gain: Option<Gain>,
    /// Why it is named.
    pub evidence: Evidence,
    /// The experiment that would separate it from its equivalents, `None` where it has none.
    pub experiment: Option<String>,
}

/// Where unexplained structure sits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// `position`, `time`, `speed`, `acceleration`, `load` or `force rate`.
    pub axis: String,
    /// Lower end.
    pub from: f64,
    /// Upper end.
    pub to: f64,
    /// Unit of both.
    pub unit: String,
    /// Names of the runs that show it.
    pub runs: Vec<String>,
}

impl Place {
    /// Whether it is one on the plate.
    pub(crate) fn is_on_plate(&self) -> bool {
        self.axis == "position"
    }
}

/// Structure that no cause explains.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Unexplained {
    /// Whether there is any.
    pub detected: bool,
    /// Where it sits.
    pub r#where: Option<Place>,
    /// Standard deviations with the same tail probability as the test that found it.
    #[serde(default)]
    pub z: f64,
}

/// Causes that the campaign's design cannot tell apart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Undecidable {
    /// Their ids.
    pub causes: Vec<String>,
    /// Why.
    pub because: String,
    /// The cheapest experiment that would.
    pub experiment: String,
}

/// How a law fits on its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LawFit {
    /// Its id.
    pub law: String,
    /// Error of the fit to all runs, in the floor's unit.
    pub rmse: f64,
    /// Corrected Akaike criterion less that of the best law, under the noise and the scatter between runs of the law that errs
    /// least (D10).
    pub delta_aicc: f64,
}

/// What could have hidden below the noise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hidden {
    /// The cause.
    pub cause: String,
    /// Its leading parameter.
    pub parameter: String,
    /// Size that would have been found with 90 % probability.
    pub size: Option<f64>,
    /// Unit of the size.
    pub unit: String,
}

/// Share of the explainable error that goes along an axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Share {
    /// `time`, `position`, `speed`, `order`, `load`, `direction` or `temperature`.
    pub axis: String,
    /// Share of the explainable part of the baseline's residual, 0 to 1.
    pub share: f64,
    /// Mean residual against the axis: centre of bin, mean, its standard error.
    pub profile: Vec<[f64; 3]>,
    /// Unit of the axis.
    pub unit: String,
}

/// The whole answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Diagnosis {
    /// `bristle/diagnosis/1`.
    pub schema: String,
    /// Name of the campaign.
    pub campaign: String,
    /// The law that was used.
    pub law: String,
    /// The strongest statement.
    pub status: Status,
    /// The noise.
    pub noise_floor: NoiseFloor,
    /// The law alone.
    pub baseline: Baseline,
    /// The named causes, strongest first.
    pub findings: Vec<Finding>,
    /// What no cause explains.
    pub unexplained: Unexplained,
    /// What this design cannot tell apart.
    pub undecidable: Vec<Undecidable>,
    /// All laws on the same data.
    pub laws: Vec<LawFit>,
    /// What could have hidden.
    pub hidden: Vec<Hidden>,
    /// Where the residual of the law alone lies.
    pub anatomy: Vec<Share>,
    /// Joint gain of all findings on runs left out.
    pub gain: Option<Gain>,
    /// Plain sentences a reader should not miss.
    pub notes: Vec<String>,
}

/// What a protocol could tell, before its forces are read (`bristle/design/1`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Design {
    /// `bristle/design/1`.
    pub schema: String,
    /// Name of the campaign.
    pub campaign: String,
    /// The law.
    pub law: String,
    /// The noise that was assumed.
    pub noise_floor: NoiseFloor,
    /// For each cause the size that the oracle's test would find with 90 % power; `None`: the law absorbs it.
    pub thresholds: Vec<Hidden>,
    /// For each pair the sine of the angle between their projected, whitened signatures, row by row in the order of
    /// `thresholds` (0: the same, 1: nothing in common); `None` where one is absorbed.
    pub isolability: Vec<Vec<Option<f64>>>,
    /// Causes that no size within its bounds tells apart.
    pub undecidable: Vec<Undecidable>,
}
