//! Plots over axes: lines with bands and regions, bars, maps.

use serde::{Deserialize, Serialize};

/// How an axis maps numbers to places.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Scale {
    /// Evenly.
    #[default]
    Linear,
    /// By decimal logarithm: values must be above zero, others are left out and counted in the description.
    Log,
}

/// One axis.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Axis {
    /// Quantity.
    pub label: String,
    /// Unit; empty or `1` is not shown.
    pub unit: String,
    /// Limits of the full view; taken from the data where absent.
    pub limits: Option<[f64; 2]>,
    /// Scale.
    pub scale: Scale,
}

impl Axis {
    /// A linear axis with limits from the data.
    pub fn new(label: &str, unit: &str) -> Self {
        Self {
            label: label.into(),
            unit: unit.into(),
            ..Self::default()
        }
    }

    /// The same with these limits in the full view.
    #[must_use]
    pub fn between(mut self, low: f64, high: f64) -> Self {
        self.limits = Some([low, high]);
        self
    }

    /// The same on a logarithmic scale.
    #[must_use]
    pub fn log(mut self) -> Self {
        self.scale = Scale::Log;
        self
    }
}

/// A colour with its marker shape and dash pattern. Use the same ink for the same thing all over the page: the named
/// constants fix what is usual.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Ink {
    /// One of eight colours, 0 to 7 (larger numbers wrap round).
    Slot(u8),
    /// Grey, for context and for what is not the point.
    Muted,
}

impl Ink {
    /// What was measured (or the stand-in for it).
    pub const DATA: Self = Self::Muted;
    /// Forward motion; the asymmetric brush.
    pub const FORWARD: Self = Self::Slot(0);
    /// Reverse motion; the brush mounted backwards.
    pub const REVERSE: Self = Self::Slot(1);
    /// The symmetric model.
    pub const SYMMETRIC: Self = Self::Slot(2);
    /// A published number.
    pub const PUBLISHED: Self = Self::Slot(3);
    /// The extended model.
    pub const EXTENDED: Self = Self::Slot(4);
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mark {
    /// A line.
    #[default]
    Line,
    /// Markers.
    Points,
    /// Both.
    LinePoints,
    /// Small dots for dense data.
    Dots,
}

/// One series.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Series {
    /// Name in the legend.
    pub label: String,
    /// Points (x, y) in drawing order. A point that is not finite breaks the line.
    pub points: Vec<[f64; 2]>,
    /// Intervals of y, one a point, drawn as bars; empty for none.
    pub intervals: Vec<[f64; 2]>,
    /// How it is drawn.
    pub mark: Mark,
    /// Colour, marker shape and dash.
    pub ink: Ink,
}

impl Series {
    /// A line.
    pub fn line(label: &str, ink: Ink, points: Vec<[f64; 2]>) -> Self {
        Self {
            label: label.into(),
            points,
            intervals: Vec::new(),
            mark: Mark::Line,
            ink,
        }
    }

    /// Markers.
    pub fn points(label: &str, ink: Ink, points: Vec<[f64; 2]>) -> Self {
        Self {
            mark: Mark::Points,
            ..Self::line(label, ink, points)
        }
    }

    /// Small dots for dense data.
    pub fn dots(label: &str, ink: Ink, points: Vec<[f64; 2]>) -> Self {
        Self {
            mark: Mark::Dots,
            ..Self::line(label, ink, points)
        }
    }

    /// The same with markers on the line or without.
    #[must_use]
    pub fn marked(mut self, mark: Mark) -> Self {
        self.mark = mark;
        self
    }

    /// The same with intervals.
    #[must_use]
    pub fn with_intervals(mut self, intervals: Vec<[f64; 2]>) -> Self {
        self.intervals = intervals;
        self
    }
}

/// A band between two curves over x: (x, low, high).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Band {
    /// Name in the legend: say what kind of band (95 % of runs, 95 % of the mean).
    pub label: String,
    /// (x, low, high) by increasing x.
    pub points: Vec<[f64; 3]>,
    /// Colour.
    pub ink: Ink,
}

/// A filled polygon.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Region {
    /// Name in the legend.
    pub label: String,
    /// Corners in order; closed by the renderer.
    pub corners: Vec<[f64; 2]>,
    /// Colour.
    pub ink: Ink,
}

/// A straight reference line over the whole plot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Rule {
    /// At this x, with a label.
    Vertical(f64, String),
    /// At this y, with a label.
    Horizontal(f64, String),
}

/// Lines, points, bands and regions over two axes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LinePlot {
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Filled polygons, drawn first.
    pub regions: Vec<Region>,
    /// Bands, drawn second.
    pub bands: Vec<Band>,
    /// Series, drawn in order.
    pub series: Vec<Series>,
    /// Reference lines.
    pub rules: Vec<Rule>,
    /// Words at points: (x, y, text).
    pub notes: Vec<(f64, f64, String)>,
    /// One unit of x is as long as one unit of y (force polygons).
    pub equal_aspect: bool,
}

impl LinePlot {
    /// A plot of series over two axes.
    pub fn new(x: Axis, y: Axis, series: Vec<Series>) -> Self {
        Self {
            x,
            y,
            series,
            ..Self::default()
        }
    }
}

/// One group of bars: one bar a category.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BarGroup {
    /// Name in the legend.
    pub label: String,
    /// One value a category; absent ones are left out.
    pub values: Vec<Option<f64>>,
    /// Intervals, one a category, or empty.
    pub intervals: Vec<Option<[f64; 2]>>,
    /// Colour.
    pub ink: Ink,
}

/// Bars by category.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BarPlot {
    /// Categories, from left to right.
    pub categories: Vec<String>,
    /// What the categories are.
    pub category_label: String,
    /// The value axis; zero is always in view.
    pub y: Axis,
    /// Groups side by side within a category.
    pub groups: Vec<BarGroup>,
    /// Horizontal reference lines.
    pub rules: Vec<Rule>,
}

/// A map or matrix of cells.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HeatMap {
    /// What runs across, with unit.
    pub x: Axis,
    /// What runs down, with unit.
    pub y: Axis,
    /// Labels of the columns.
    pub columns: Vec<String>,
    /// Labels of the rows, from top to bottom.
    pub rows: Vec<String>,
    /// `values[row][column]`; absent cells are hatched.
    pub values: Vec<Vec<Option<f64>>>,
    /// What the colour shows.
    pub quantity: String,
    /// Its unit.
    pub unit: String,
    /// Middle of a diverging scale; absent for a sequential one.
    pub centre: Option<f64>,
    /// Limits of the colour scale; taken from the data where absent.
    pub limits: Option<[f64; 2]>,
    /// Write the numbers into the cells.
    pub numbers: bool,
    /// Values whose level curve is drawn between cells, such as the published one.
    pub levels: Vec<(f64, String)>,
}
