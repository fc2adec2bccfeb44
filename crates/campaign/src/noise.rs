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

/// Standard deviation of noise by third divided differences, which hardly know a motion, also where its instants are uneven. That of four
/// samples y at t is their sum with the weights
///
/// ```text
/// w_i = 1 / prod_(j != i) (t_i - t_j)
/// ```
///
/// and over the root of their squares' sum it has the spread of white noise. `fours`: instants and samples of four neighbours each.
pub fn of_third_differences<'a>(fours: impl Iterator<Item = (&'a [f64], &'a [f64])>) -> f64 {
    let thirds: Vec<f64> = fours.map(|(t, y)| third_difference(t, y)).collect();
    spread(&thirds)
}

fn third_difference(t: &[f64], y: &[f64]) -> f64 {
    let (mut sum, mut squares) = (0.0, 0.0);
    for (i, (here, y)) in t.iter().zip(y).enumerate() {
        let others = t.iter().enumerate().filter(|(j, _)| *j != i);
        let weight = others
            .map(|(_, there)| here - there)
            .product::<f64>()
            .recip();
        sum += weight * y;
        squares += weight * weight;
    }
    sum / squares.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A parabola at uneven instants has none, and of even ones the difference is y3 - 3 y2 + 3 y1 - y0 over the root of 20.
    #[test]
    fn a_parabola_has_no_third_difference() {
        let t = [0.0, 0.05, 0.08, 0.17];
        let parabola = t.map(|t| 0.3 - 2.0 * t + 7.0 * t * t);
        assert!(third_difference(&t, &parabola).abs() < 1e-14);
        let even = third_difference(&[0.0, 0.1, 0.2, 0.3], &[1.0, -2.0, 0.5, 4.0]);
        assert!((even.abs() - (4.0_f64 - 1.5 - 6.0 - 1.0).abs() / 20.0_f64.sqrt()).abs() < 1e-12);
    }
}
