//! White noise of a recorded series, as its samples themselves show it.

/// Standard deviation by the median, as for normal noise: a few wild ones do not count.
pub fn spread(rest: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = rest.iter().map(|r| r.abs()).collect();
    let middle = sizes.len() / 2;
    if sizes.is_empty() {
        return 0.0;
    }
    1.4826 * *sizes.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Standard deviation of noise by third differences, which hardly know a motion: of white noise they have twenty times its variance.
/// `fours`: four neighbouring samples each.
pub fn of_third_differences<'a>(fours: impl Iterator<Item = &'a [f64]>) -> f64 {
    let thirds: Vec<f64> = fours
        .map(|y| y[3] - 3.0 * y[2] + 3.0 * y[1] - y[0])
        .collect();
    spread(&thirds) / 20.0_f64.sqrt()
}
