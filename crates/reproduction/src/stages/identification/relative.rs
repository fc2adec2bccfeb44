//! Curves of parameters over a reference value, and what is said of those that have none.

use report::figure::{Ink, Mark, Series};

/// One curve: the parameter's name and its points.
pub(super) type Curve = (String, Vec<[f64; 2]>);

/// Value over reference, 1. `None` where that is no number: a parameter that is zero at the reference, as on a bound, has no
/// relative size.
pub(super) fn ratio(value: f64, reference: f64) -> Option<f64> {
    Some(value / reference).filter(|ratio| ratio.is_finite())
}

/// Lines through the points, a colour a place, and a sentence for the caption that names the curves without any point
/// (empty where all have some).
pub(super) fn lines(curves: Vec<Curve>) -> (Vec<Series>, String) {
    let mut series = Vec::new();
    let mut missing = Vec::new();
    for (k, (name, points)) in curves.into_iter().enumerate() {
        if points.is_empty() {
            missing.push(name);
        } else {
            series.push(Series::line(&name, Ink::Slot(k as u8), points).marked(Mark::LinePoints));
        }
    }
    let words = match missing.is_empty() {
        true => String::new(),
        false => format!(
            " No curve, being zero at the reference: {}.",
            missing.join(", ")
        ),
    };
    (series, words)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_zero_at_the_reference_has_no_ratio() {
        assert_eq!(ratio(3.0, 2.0), Some(1.5));
        assert_eq!(ratio(0.0, -2.0), Some(0.0));
        assert_eq!(ratio(3.0, 0.0), None);
        assert_eq!(ratio(0.0, 0.0), None);
        assert_eq!(ratio(1.0, f64::from_bits(1)), None, "beyond all numbers");
        assert_eq!(ratio(f64::NAN, 1.0), None);
    }

    #[test]
    fn a_scan_about_zero_leaves_its_curve_out_and_says_so() {
        let scan = |name: &str, values: [f64; 3]| -> Curve {
            let reference = values[1];
            let at = |(k, v): (usize, f64)| Some([k as f64, ratio(v, reference)?]);
            let points = values.into_iter().enumerate().filter_map(at).collect();
            (name.to_owned(), points)
        };
        let all = [
            scan("sigma0", [1.0, 2.0, 4.0]),
            scan("sigma2", [0.1, 0.0, 0.0]),
            scan("theta0", [-1.0, -2.0, 0.0]),
        ];
        let (series, words) = lines(all.to_vec());
        let drawn: Vec<(&str, Ink)> = series.iter().map(|s| (s.label.as_str(), s.ink)).collect();
        // Those that stay keep the colour of their place.
        assert_eq!(drawn, [("sigma0", Ink::Slot(0)), ("theta0", Ink::Slot(2))]);
        assert_eq!(series[0].points, [[0.0, 0.5], [1.0, 1.0], [2.0, 2.0]]);
        assert_eq!(series[1].points, [[0.0, 0.5], [1.0, 1.0], [2.0, 0.0]]);
        assert_eq!(words, " No curve, being zero at the reference: sigma2.");
        assert_eq!(lines(all[..1].to_vec()).1, "");
    }
}
