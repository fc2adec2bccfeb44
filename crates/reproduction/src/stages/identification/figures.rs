//! Figures of the stage.

use fitting::ProfilePoint;
use identification::PaperForm;
use report::Evidence;
use report::figure::{Axis, Figure, Ink, LinePlot, Provenance, Rule, Series};

use super::Identified;
use super::relative::{Curve, lines, ratio};
use crate::stages::friction_curves::{
    DIRECTIONS, coefficient_against_speed as speed_curve, force_against_time as time_curve,
    runs_in, speed_series,
};

pub(in crate::stages) fn stamped(evidence: Evidence, caption: &str) -> String {
    if evidence == Evidence::Synthetic {
        format!("{caption} Synthetic stand-in data.")
    } else {
        caption.to_owned()
    }
}

#[track_caller]
fn provenance(function: &str, one: &Identified) -> Provenance {
    let mut made = Provenance::here("identification", function);
    for (path, hash) in &one.campaign.input_hashes {
        made = made.with_input(format!("{}/{path}", one.campaign.name), hash.clone());
    }
    made
}

/// Fig. 5: three repeats a direction against time, with the fit.
pub(super) fn force_against_time(one: &Identified) -> Figure {
    let mut series = Vec::new();
    for (direction, word, ink) in DIRECTIONS {
        let runs = runs_in(&one.campaign, direction);
        for (repeat, &k) in runs.iter().enumerate() {
            let label = format!("{word}, repeat {}", repeat + 1);
            series.push(Series::line(
                &label,
                Ink::DATA,
                time_curve(&one.experiment, k, None),
            ));
        }
        if let Some(&first) = runs.first() {
            let line = time_curve(&one.experiment, first, Some(&one.found.predicted_n));
            series.push(Series::line(&format!("{word}, fit"), ink, line));
        }
    }
    let top = one.experiment.scales.force_n;
    Figure::new(
        "identified-force-time",
        "Friction force in a ramp, three repeats each way",
        stamped(
            one.evidence,
            "The brush bends, then slides; the two levels are the direction dependence.",
        ),
        one.evidence,
        LinePlot::new(
            Axis::new("time", "s"),
            Axis::new("friction force", "N"),
            series,
        ),
        provenance("force_against_time", one),
    )
    .with_paper("Fig. 5")
    .with_paper_limits(
        [0.0, 10.0],
        [0.0, 1.1 * top],
        "0 to 10 s: the ramp of the protocol; the force axis is ours",
    )
    .with_claims(&["C02", "C04"])
}

/// Fig. 6: mu against speed.
pub(super) fn coefficient_against_speed(one: &Identified) -> Figure {
    let series = speed_series(&one.campaign, &one.experiment, &one.found.predicted_n);
    Figure::new(
        "identified-mu-speed",
        "Coefficient of friction against speed, 2x2 brush on aluminium",
        stamped(
            one.evidence,
            "Fit of the asymmetric law with the lean free, against all repeats.",
        ),
        one.evidence,
        LinePlot::new(
            Axis::new("speed", "mm/s"),
            Axis::new("coefficient of friction", "1"),
            series,
        ),
        provenance("coefficient_against_speed", one),
    )
    .with_paper("Fig. 6")
    .with_paper_limits(
        [0.0, 60.0],
        [0.0, 1.2],
        "0 to 60 mm/s: the range of the protocol; the other axis is ours",
    )
    .with_claims(&["C01", "C02", "C09"])
}

/// Mean residual of the repeats against speed.
pub(super) fn residual(one: &Identified) -> Figure {
    let series = DIRECTIONS
        .iter()
        .flat_map(|(direction, word, ink)| {
            runs_in(&one.campaign, *direction)
                .into_iter()
                .enumerate()
                .map(move |(repeat, k)| {
                    let measured = speed_curve(&one.experiment, k, None);
                    let model = speed_curve(&one.experiment, k, Some(&one.found.predicted_n));
                    let points = measured
                        .iter()
                        .zip(&model)
                        .map(|(a, b)| [a[0], a[1] - b[1]])
                        .collect();
                    Series::line(&format!("{word}, repeat {}", repeat + 1), *ink, points)
                })
        })
        .collect();
    let mut plot = LinePlot::new(
        Axis::new("speed", "mm/s"),
        Axis::new("coefficient, record less fit", "1"),
        series,
    );
    if let Some(floor) = one.found.quality.floor_rmse {
        plot.rules = vec![
            Rule::Horizontal(floor, "scatter of the repeats".into()),
            Rule::Horizontal(-floor, String::new()),
        ];
    }
    Figure::new(
        "identified-residual",
        "What the fit leaves",
        stamped(one.evidence, "Each line is one run. A run that lies above or below as a whole has another gain than its repeats; wiggles common to all runs would be structure that the law misses or the plate repeats."),
        one.evidence,
        plot,
        provenance("residual", one),
    )
    .with_claims(&["C02"])
}

/// Root of the deviance against each parameter's distance from its estimate, by the profiles that gave the intervals. The
/// root of a parabola is a straight line, so what is drawn between the few points that were computed is nearly true.
pub(super) fn profiles(one: &Identified) -> Figure {
    let curves: Vec<Curve> = one
        .found
        .profiles
        .iter()
        .map(|(name, points)| {
            let best = one.found.value(name).unwrap_or(f64::NAN);
            let line = points
                .iter()
                .filter_map(|p| {
                    let distance = 100.0 * (ratio(p.value, best)? - 1.0);
                    Some([distance, p.deviance.max(0.0).sqrt()])
                })
                .collect();
            (name.clone(), line)
        })
        .collect();
    let (series, missing) = lines(curves);
    let mut plot = LinePlot::new(
        Axis::new("distance from the estimate", "%"),
        Axis::new("root of the loss of fit (twice the log-likelihood)", "1"),
        series,
    );
    plot.rules = vec![Rule::Horizontal(
        fitting::criteria::t_quantile(identification::LEVEL, f64::INFINITY),
        "95 %, noise known".into(),
    )];
    Figure::new(
        "identified-profiles",
        "Profile likelihood of every parameter",
        stamped(one.evidence, &format!("One parameter held, all others refitted. A narrow valley is a well-determined parameter. Each interval ends where its curve reaches the t quantile of its own degrees of freedom, at or above the line.{missing}")),
        one.evidence,
        plot,
        provenance("profiles", one),
    )
    .with_claims(&["C18"])
}

/// The scale ray: profiles of sigma, theta_c, theta_s over two decades, and of sigma0 for contrast.
pub(super) fn ray(one: &Identified, paper: &PaperForm) -> Figure {
    let curve = |points: &[ProfilePoint]| -> Vec<[f64; 2]> {
        let best = points
            .iter()
            .min_by(|a, b| a.deviance.total_cmp(&b.deviance))
            .map_or(1.0, |p| p.value);
        points
            .iter()
            .map(|p| [p.value / best, p.deviance.max(0.0)])
            .collect()
    };
    // On the ray every point is as good as any: factors count from the middle of the scan.
    let middle = |points: &[ProfilePoint]| -> Vec<[f64; 2]> {
        let centre = points[points.len() / 2].value;
        points
            .iter()
            .map(|p| [p.value / centre, p.deviance.max(0.0)])
            .collect()
    };
    let mut series: Vec<Series> = paper
        .profiles
        .iter()
        .enumerate()
        .map(|(k, (name, points))| {
            Series::line(name, Ink::Slot(k as u8), middle(points))
                .marked(report::figure::Mark::LinePoints)
        })
        .collect();
    series.push(Series::line(
        &paper.contrast.0,
        Ink::Slot(3),
        curve(&paper.contrast.1),
    ));
    Figure::new(
        "identified-ray",
        "The scale ray: three parameters that no record determines",
        stamped(one.evidence, "Profiles in the paper's own parameters. $\\sigma$, $\\theta_c$ and $\\theta_s$ can be multiplied by ten or divided by ten and the fit stays the same; $\\sigma_0$ moved by a few percent ruins it."),
        one.evidence,
        LinePlot::new(
            Axis::new("factor on the parameter", "1").log(),
            Axis::new("loss of fit (twice the log-likelihood)", "1"),
            series,
        ),
        provenance("in_paper_form", one),
    )
    .with_claims(&["C18"])
}

/// Singular values of the scaled sensitivities in both parametrisations.
pub(super) fn spectrum(one: &Identified, paper: &PaperForm) -> Figure {
    let points = |values: &[f64]| -> Vec<[f64; 2]> {
        let floor = values[0] * f64::EPSILON;
        values
            .iter()
            .enumerate()
            .map(|(k, s)| [(k + 1) as f64, s.max(floor)])
            .collect()
    };
    let mark = report::figure::Mark::LinePoints;
    let series = vec![
        Series::line(
            "paper's parameters",
            Ink::PUBLISHED,
            points(&paper.identifiability.singular_values),
        )
        .marked(mark),
        Series::line(
            "identifiable parameters",
            Ink::FORWARD,
            points(&one.found.identifiability.singular_values),
        )
        .marked(mark),
    ];
    Figure::new(
        "identified-spectrum",
        "Spectrum of the sensitivities",
        stamped(one.evidence, "Singular values of the whitened sensitivities, each parameter moved by its own size. In the paper's parameters the last one is zero to rounding: a direction in which nothing measurable changes."),
        one.evidence,
        LinePlot::new(
            Axis::new("place in the spectrum", ""),
            Axis::new("singular value", "1").log(),
            series,
        ),
        provenance("identifiability", one),
    )
    .with_claims(&["C18"])
}
