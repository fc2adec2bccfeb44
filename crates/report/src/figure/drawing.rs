//! Drawings to scale: shapes in the units of the thing itself, y upward.

use serde::{Deserialize, Serialize};

use super::Ink;

/// One shape, in the drawing's unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// A line through points: its width in pixels.
    Line {
        /// Corners.
        points: Vec<[f64; 2]>,
        /// Colour.
        ink: Ink,
        /// Width on the page, px.
        width: f64,
        /// Dashed.
        dashed: bool,
    },
    /// A filled polygon.
    Area {
        /// Corners.
        points: Vec<[f64; 2]>,
        /// Colour.
        ink: Ink,
    },
    /// A circle.
    Circle {
        /// Centre.
        centre: [f64; 2],
        /// Radius in the drawing's unit.
        radius: f64,
        /// Colour.
        ink: Ink,
        /// Filled.
        filled: bool,
    },
    /// An arrow, such as a force (its length has a scale of its own: say so in the caption).
    Arrow {
        /// Tail.
        from: [f64; 2],
        /// Head.
        to: [f64; 2],
        /// Colour.
        ink: Ink,
    },
    /// A dimension line with ticks at both ends and its label beside it.
    Dimension {
        /// One end.
        from: [f64; 2],
        /// Other end.
        to: [f64; 2],
        /// Label, such as `h = 7.20 mm`.
        label: String,
    },
    /// An angle at a corner, from one direction to another (rad, counter-clockwise from x).
    Angle {
        /// Corner.
        at: [f64; 2],
        /// First direction, rad.
        from_rad: f64,
        /// Second direction, rad.
        to_rad: f64,
        /// Radius of the arc in the drawing's unit.
        radius: f64,
        /// Label.
        label: String,
    },
    /// Words; anchored in their middle.
    Label {
        /// Place.
        at: [f64; 2],
        /// Text.
        text: String,
        /// Colour.
        ink: Ink,
    },
}

/// A drawing to scale; a scale bar is added.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Drawing {
    /// Unit of the coordinates, for the scale bar.
    pub unit: String,
    /// Shapes, drawn in order.
    pub shapes: Vec<Shape>,
    /// Names for the legend: (ink, meaning).
    pub legend: Vec<(Ink, String)>,
    /// What is drawn, as a sentence, for readers who cannot see it.
    pub description: String,
}

/// One frame of an animation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// Time, s.
    pub time_s: f64,
    /// Shapes.
    pub shapes: Vec<Shape>,
}

/// A drawing that moves: frames one after the other, by style alone. In print, and for readers who want no motion,
/// the frames named in `still` are shown on top of each other.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Animation {
    /// Unit of the coordinates.
    pub unit: String,
    /// Shapes that stay.
    pub backdrop: Vec<Shape>,
    /// Frames, evenly spaced in time (24 or fewer keep the page small).
    pub frames: Vec<Frame>,
    /// Indices of frames shown when nothing moves.
    pub still: Vec<usize>,
    /// Seconds that one cycle takes on the page.
    pub cycle_s: f64,
    /// Names for the legend: (ink, meaning).
    pub legend: Vec<(Ink, String)>,
    /// What is drawn, as a sentence.
    pub description: String,
}

/// One bristle between body and substrate, to scale: its root at height `contact_height_mm` above the substrate, its
/// lean `lean_rad` at rest (dashed) and one line for each further state (label, ink, angle from the vertical in rad,
/// positive towards +x). Lines have the bristle's own length, so a contact point beyond the tip can be seen.
pub fn bristle(
    length_mm: f64,
    diameter_mm: f64,
    contact_height_mm: f64,
    lean_rad: f64,
    states: &[(&str, Ink, f64)],
) -> Drawing {
    let root = [0.0, contact_height_mm];
    // tip = root + length (sin angle, -cos angle)
    let tip = |angle: f64| {
        [
            length_mm * angle.sin(),
            contact_height_mm - length_mm * angle.cos(),
        ]
    };
    // contact point = root + h (tan angle, -1): where the bristle's line meets the substrate
    let contact = |angle: f64| [contact_height_mm * angle.tan(), 0.0];
    let half = 0.9 * length_mm;
    let mut shapes = vec![
        Shape::Area {
            points: vec![
                [-half, contact_height_mm],
                [half, contact_height_mm],
                [half, 1.12 * contact_height_mm],
                [-half, 1.12 * contact_height_mm],
            ],
            ink: Ink::Muted,
        },
        Shape::Line {
            points: vec![[-half, 0.0], [half, 0.0]],
            ink: Ink::Muted,
            width: 2.0,
            dashed: false,
        },
        Shape::Line {
            points: vec![root, tip(lean_rad)],
            ink: Ink::Muted,
            width: 1.5,
            dashed: true,
        },
        Shape::Dimension {
            from: [0.8 * half, 0.0],
            to: [0.8 * half, contact_height_mm],
            label: format!("h = {contact_height_mm:.2} mm"),
        },
    ];
    let mut legend = vec![(
        Ink::Muted,
        format!("at rest, lean {lean_rad:.3} rad").replace('-', "−"),
    )];
    for (label, ink, angle) in states {
        shapes.push(Shape::Line {
            points: vec![root, contact(*angle)],
            ink: *ink,
            width: 1.0,
            dashed: true,
        });
        shapes.push(Shape::Line {
            points: vec![root, tip(*angle)],
            ink: *ink,
            width: 3.0,
            dashed: false,
        });
        shapes.push(Shape::Circle {
            centre: contact(*angle),
            radius: 0.02 * length_mm,
            ink: *ink,
            filled: true,
        });
        legend.push((*ink, (*label).to_string()));
    }
    Drawing {
        unit: "mm".into(),
        shapes,
        legend,
        description: format!(
            "A bristle of {length_mm:.2} mm length and {diameter_mm:.2} mm diameter between a body and a substrate \
             {contact_height_mm:.2} mm below its root, leaning {lean_rad:.3} rad at rest; solid lines have the \
             bristle's length, dashed ones reach the substrate."
        ),
    }
}
