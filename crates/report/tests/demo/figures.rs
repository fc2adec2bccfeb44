//! Figures of every kind, from made-up numbers.

use report::Evidence;
use report::figure::{
    Animation, Axis, Band, BarGroup, BarPlot, Drawing, Figure, Frame, HeatMap, Ink, LinePlot, Mark,
    Provenance, Region, Rule, Series, Shape, bristle,
};

use super::HOSTILE;

fn line(count: u32, f: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
    (0..count)
        .map(|k| {
            let x = 60.0 * f64::from(k) / f64::from(count - 1);
            [x, f(x)]
        })
        .collect()
}

fn forward(x: f64) -> f64 {
    0.9 * (1.0 - (-x / 4.0).exp()) + 0.04 * (-x / 20.0).exp()
}

fn reverse(x: f64) -> f64 {
    0.43 * (1.0 - (-x / 3.0).exp())
}

fn wiggle(x: f64) -> f64 {
    0.012 * (17.0 * x).sin() + 0.009 * (41.3 * x).cos()
}

pub fn provenance() -> Provenance {
    Provenance::here("validation", "curves")
        .with_input(HOSTILE, "blake3:0123456789abcdef")
        .with_parameter("theta0", "-0.278 rad")
}

pub fn curves() -> Figure {
    let plot = LinePlot {
        bands: vec![Band {
            label: "95 % of runs".into(),
            points: line(80, forward)
                .iter()
                .map(|p| [p[0], p[1] - 0.04, p[1] + 0.04])
                .collect(),
            ink: Ink::FORWARD,
        }],
        rules: vec![Rule::Horizontal(0.6682, "symmetric".into())],
        notes: vec![(30.0, 0.9049, "plateau".into())],
        ..LinePlot::new(
            Axis::new("speed", "mm/s"),
            Axis::new("coefficient of friction", "1"),
            vec![
                Series::dots(
                    "forward, three runs",
                    Ink::DATA,
                    line(1800, |x| forward(x) + wiggle(x)),
                ),
                Series::dots(
                    "reverse, three runs",
                    Ink::DATA,
                    line(1800, |x| reverse(x) + wiggle(x)),
                ),
                Series::line("model, forward", Ink::FORWARD, line(400, forward)),
                Series::line("model, reverse", Ink::REVERSE, line(400, reverse)),
            ],
        )
    };
    Figure::new(
        "fig-curves",
        "Friction against speed, both directions",
        "The model ({{ v(\"demo.steady_forward\") }} forward) through the runs of one made-up campaign.",
        Evidence::Synthetic,
        plot,
        provenance(),
    )
    .with_paper("Fig. 6")
    .with_paper_limits([0.0, 60.0], [0.0, 1.0], "range of the stated protocol")
    .with_claims(&["C02", "C09"])
}

pub fn scatter() -> Figure {
    let ratio = Series::points(
        "ratio",
        Ink::Slot(2),
        vec![[1e-2, 0.4], [1e-1, 0.7], [1.0, 1.1], [10.0, 2.2]],
    )
    .with_intervals(vec![[0.3, 0.5], [0.6, 0.8], [1.0, 1.2], [1.9, 2.6]])
    .marked(Mark::LinePoints);
    Figure::new(
        "fig-scatter",
        "A ratio over four decades",
        "Bars are 95 % intervals.",
        Evidence::Computed,
        LinePlot::new(
            Axis::new("weight", "1").log(),
            Axis::new("ratio", "1").log(),
            vec![ratio],
        ),
        Provenance::here("gait", "sweep"),
    )
}

pub fn gains() -> Figure {
    let group = |label: &str, ink, values: [f64; 3]| BarGroup {
        label: label.into(),
        values: values.iter().map(|v| Some(*v)).collect(),
        intervals: values.iter().map(|v| Some([v - 0.7, v + 0.7])).collect(),
        ink,
    };
    let plot = BarPlot {
        categories: vec!["−5°".into(), "0°".into(), "5°".into()],
        category_label: "pitch".into(),
        y: Axis::new("gain", "percent"),
        groups: vec![
            group("ours", Ink::FORWARD, [12.7, 18.6, 17.0]),
            group("published", Ink::PUBLISHED, [12.61, 18.79, 17.52]),
        ],
        rules: vec![],
    };
    Figure::new(
        "fig-gains",
        "Gain of the forward force",
        "By pitch.",
        Evidence::Computed,
        plot,
        Provenance::here("envelope", "gains"),
    )
    .with_claims(&["C12"])
}

pub fn map() -> Figure {
    let (rows, columns) = (6, 8);
    let values = (0..rows)
        .map(|r| {
            (0..columns)
                .map(|c| (r != 2 || c != 3).then(|| f64::from(r * c) - 12.0))
                .collect()
        })
        .collect();
    let plot = HeatMap {
        x: Axis::new("stiffness", "N/m"),
        y: Axis::new("damping", "s/m"),
        columns: (0..columns).map(|c| format!("{}e4", c + 1)).collect(),
        rows: (0..rows)
            .map(|r| format!("{}", 0.5 * f64::from(r)))
            .collect(),
        values,
        quantity: "gain".into(),
        unit: "percent".into(),
        centre: Some(0.0),
        numbers: true,
        levels: vec![(10.0, "10 %".into())],
        ..HeatMap::default()
    };
    Figure::new(
        "fig-map",
        "Gain over contact stiffness and damping",
        "One cell does not converge.",
        Evidence::Computed,
        plot,
        Provenance::here("gait", "map"),
    )
}

pub fn polygon() -> Figure {
    let region = |label: &str, ink, reach: f64| Region {
        label: label.into(),
        corners: vec![
            [0.0, 0.0],
            [reach, 1.1],
            [0.3, 1.9],
            [-0.8, 1.6],
            [-0.5, 0.9],
        ],
        ink,
    };
    let plot = LinePlot {
        x: Axis::new("forward force", "1"),
        y: Axis::new("vertical force", "1"),
        regions: vec![
            region("asymmetric", Ink::FORWARD, 0.98),
            region("symmetric", Ink::SYMMETRIC, 0.75),
        ],
        equal_aspect: true,
        ..LinePlot::default()
    };
    Figure::new(
        "fig-polygon",
        "Force envelope",
        "Normalised by the weight.",
        Evidence::Computed,
        plot,
        Provenance::here("envelope", "polygon"),
    )
    .with_paper("Fig. 13")
}

fn legs(phase: f64) -> Vec<Shape> {
    let hip = [0.0, 0.55 + 0.02 * (2.0 * phase).cos()];
    [0.0, std::f64::consts::PI]
        .into_iter()
        .enumerate()
        .map(|(leg, offset)| {
            let swing = 0.5 * (phase + offset).sin();
            let knee = [hip[0] + 0.3 * swing, hip[1] - 0.28];
            let foot = [knee[0] + 0.2 * swing - 0.1, knee[1] - 0.26];
            Shape::Line {
                points: vec![hip, knee, foot],
                ink: Ink::Slot(u8::try_from(leg).unwrap_or(0)),
                width: 4.0,
                dashed: false,
            }
        })
        .collect()
}

pub fn stride() -> Figure {
    let animation = Animation {
        unit: "m".into(),
        backdrop: vec![Shape::Line {
            points: vec![[-0.8, 0.0], [0.8, 0.0]],
            ink: Ink::Muted,
            width: 1.5,
            dashed: false,
        }],
        frames: (0..16)
            .map(|k| Frame {
                time_s: 0.02 * f64::from(k),
                shapes: legs(std::f64::consts::TAU * f64::from(k) / 16.0),
            })
            .collect(),
        still: vec![0, 5, 10],
        cycle_s: 2.0,
        legend: vec![
            (Ink::Slot(0), "front leg".into()),
            (Ink::Slot(1), "rear leg".into()),
        ],
        description: "Two legs swing.".into(),
    };
    Figure::new(
        "fig-stride",
        "One stride",
        "Slowed down.",
        Evidence::Computed,
        animation,
        Provenance::here("gait", "stride"),
    )
}

pub fn drawing() -> Figure {
    let drawing: Drawing = bristle(
        7.2,
        0.1,
        7.2,
        -0.278,
        &[
            ("forward", Ink::FORWARD, 0.278),
            ("reverse", Ink::REVERSE, -0.8),
        ],
    );
    Figure::new(
        "fig-bristle",
        "The bristle to scale",
        "Solid lines have the bristle’s own length.",
        Evidence::Published,
        drawing,
        Provenance::here("validation", "bristle"),
    )
    .with_paper("Fig. 2")
}
