//! Figures: what is drawn, and everything that a reader needs to check it.
//!
//! A [`Figure`] is the card (title, caption, provenance, claims), its [`Plot`] the drawing. Colours are named by
//! [`Ink`], never by value: the page maps them to a palette that is safe for colour-blind readers and has a light and
//! a dark form, and every ink comes with its own marker shape and dash pattern.

pub(crate) mod data;
pub(crate) mod describe;
pub(crate) mod draw;
mod drawing;
mod plot;

use std::collections::BTreeMap;
use std::panic::Location;

use serde::{Deserialize, Serialize};

pub use drawing::{Animation, Drawing, Frame, Shape, bristle};
pub use plot::{
    Axis, Band, BarGroup, BarPlot, HeatMap, Ink, LinePlot, Mark, Region, Rule, Scale, Series,
};

use crate::{Error, Evidence, Prose, palette};

/// A figure card.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// Id, unique on the page: its address, and the name of its files.
    pub id: String,
    /// Heading of the card: what it shows, in a few words.
    pub title: String,
    /// What to see in it.
    pub caption: Prose,
    /// What it rests on; `synthetic` is stamped on the drawing.
    pub evidence: Evidence,
    /// Counterpart in the paper, such as `Fig. 6`.
    pub paper: Option<String>,
    /// Limits of the paper's axes: shown first, with a switch to the full data.
    pub paper_limits: Option<Limits>,
    /// The drawing.
    pub plot: Plot,
    /// Who made it, from what.
    pub provenance: Provenance,
    /// Claims that use it.
    pub claims: Vec<String>,
}

impl Figure {
    /// A card with the parts that every figure has; add the rest by assignment or with the `with_` methods.
    pub fn new(
        id: &str,
        title: &str,
        caption: impl Into<Prose>,
        evidence: Evidence,
        plot: impl Into<Plot>,
        provenance: Provenance,
    ) -> Self {
        Self {
            id: id.into(),
            title: title.into(),
            caption: caption.into(),
            evidence,
            paper: None,
            paper_limits: None,
            plot: plot.into(),
            provenance,
            claims: Vec::new(),
        }
    }

    /// The same as counterpart of a figure of the paper, such as `Fig. 6`.
    #[must_use]
    pub fn with_paper(mut self, figure: &str) -> Self {
        self.paper = Some(figure.into());
        self
    }

    /// The same on the paper's axes first; `source` says where the paper gives the limits.
    #[must_use]
    pub fn with_paper_limits(mut self, x: [f64; 2], y: [f64; 2], source: &str) -> Self {
        self.paper_limits = Some(Limits {
            x,
            y,
            source: source.into(),
        });
        self
    }

    /// The same, used by these claims.
    #[must_use]
    pub fn with_claims(mut self, claims: &[&str]) -> Self {
        self.claims = claims.iter().map(|claim| (*claim).to_string()).collect();
        self
    }
}

/// Limits of axes as in the paper.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// Horizontal axis.
    pub x: [f64; 2],
    /// Vertical axis.
    pub y: [f64; 2],
    /// Where the paper gives them (`stated range of the protocol`, `axis of Fig. 6 as described in section 2.3`).
    pub source: String,
}

/// Who made a figure or table, from what.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Stage.
    pub stage: String,
    /// Function that put the numbers there.
    pub function: String,
    /// Source file, relative to the repository.
    pub file: String,
    /// Line.
    pub line: u32,
    /// Inputs with their hashes.
    pub inputs: BTreeMap<String, String>,
    /// Parameters that differ from the baseline, and only those.
    pub parameters: BTreeMap<String, String>,
    /// Seed, where randomness took part.
    pub seed: Option<u64>,
}

impl Provenance {
    /// File and line of the caller, with the stage and the function as named.
    #[track_caller]
    pub fn here(stage: &str, function: &str) -> Self {
        let place = Location::caller();
        Self {
            stage: stage.into(),
            function: function.into(),
            file: place.file().replace('\\', "/"),
            line: place.line(),
            ..Self::default()
        }
    }

    /// The same with an input and its hash.
    #[must_use]
    pub fn with_input(mut self, path: impl Into<String>, hash: impl Into<String>) -> Self {
        self.inputs.insert(path.into(), hash.into());
        self
    }

    /// The same with a parameter that differs from the baseline.
    #[must_use]
    pub fn with_parameter(mut self, name: impl Into<String>, value: impl Into<String>) -> Self {
        self.parameters.insert(name.into(), value.into());
        self
    }
}

/// What a card shows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Plot {
    /// Lines, points, bands, regions over two axes.
    Lines(LinePlot),
    /// Bars by category.
    Bars(BarPlot),
    /// A map or matrix of cells.
    Heat(HeatMap),
    /// A drawing to scale.
    Drawing(Drawing),
    /// A drawing that moves (and stands still in print).
    Animation(Animation),
}

impl From<LinePlot> for Plot {
    fn from(plot: LinePlot) -> Self {
        Self::Lines(plot)
    }
}

impl From<BarPlot> for Plot {
    fn from(plot: BarPlot) -> Self {
        Self::Bars(plot)
    }
}

impl From<HeatMap> for Plot {
    fn from(plot: HeatMap) -> Self {
        Self::Heat(plot)
    }
}

impl From<Drawing> for Plot {
    fn from(plot: Drawing) -> Self {
        Self::Drawing(plot)
    }
}

impl From<Animation> for Plot {
    fn from(plot: Animation) -> Self {
        Self::Animation(plot)
    }
}

/// The rules by which a drawing gets its colours, strokes and fonts.
pub(crate) const STYLE: &str = include_str!("../../../../report/figure.css");

/// The figure as an SVG file of its own, with everything in view and the light palette.
///
/// # Errors
/// [`Error::Figure`] where there is nothing finite to draw, or lengths differ.
pub fn svg_file(figure: &Figure) -> Result<String, Error> {
    let svg = draw::svg(figure, draw::View::Full, &describe::describe(figure))?;
    Ok(draw::standalone(
        &svg,
        &format!(
            "{}{STYLE}",
            palette::for_file(matches!(figure.plot, Plot::Heat(_)))
        ),
    ))
}

/// The data behind the figure as CSV, every number exact; `None` for drawings.
pub fn csv_file(figure: &Figure) -> Option<String> {
    let data = data::of(figure);
    (!data.rows.is_empty()).then(|| data.csv(None))
}
