//! Numbers for readers: significant digits, intervals, units, a true minus sign. Nothing else in the page rounds.

/// Digits shown where nothing says how well a number is known.
const DEFAULT_DIGITS: u8 = 4;

/// Decimal exponent of a finite, non-zero number after rounding to `digits` significant digits.
fn exponent(number: f64, digits: u8) -> i32 {
    // The scientific form rounds correctly at every magnitude, so 9.9996 to four digits has exponent 1.
    let text = format!("{:.*e}", usize::from(digits.max(1)) - 1, number.abs());
    text.split_once('e')
        .and_then(|(_, exponent)| exponent.parse().ok())
        .unwrap_or(0)
}

/// The number with `decimals` places and a true minus sign; never "−0.0".
pub(crate) fn fixed(number: f64, decimals: usize) -> String {
    let text = format!("{number:.decimals$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| c == '0' || c == '.') => rest.into(),
        Some(rest) => format!("\u{2212}{rest}"),
        None => text,
    }
}

fn superscript(exponent: i32) -> String {
    exponent
        .to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '0' => '⁰',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            '4' => '⁴',
            '5' => '⁵',
            '6' => '⁶',
            '7' => '⁷',
            '8' => '⁸',
            _ => '⁹',
        })
        .collect()
}

/// The number to so many significant digits; very large and very small ones as a power of ten.
pub(crate) fn significant(number: f64, digits: u8) -> String {
    if !number.is_finite() {
        return "not finite".into();
    }
    if number == 0.0 {
        return "0".into();
    }
    let digits = digits.clamp(1, 17);
    let exponent = exponent(number, digits);
    if !(-4..6).contains(&exponent) {
        let mantissa = number / 10f64.powi(exponent);
        return format!(
            "{}\u{2009}×\u{2009}10{}",
            fixed(mantissa, usize::from(digits) - 1),
            superscript(exponent)
        );
    }
    let decimals = (i32::from(digits) - 1 - exponent).max(0);
    fixed(number, usize::try_from(decimals).unwrap_or(0))
}

/// The number without a stated precision: four significant digits, whole numbers below a million as they are.
pub(crate) fn plain(number: f64) -> String {
    if number.fract() == 0.0 && number.abs() < 1e6 {
        return fixed(number, 0);
    }
    significant(number, DEFAULT_DIGITS)
}

/// Significant digits of a number whose 95 % interval is known: the half width to two digits.
pub(crate) fn digits_of(number: f64, [low, high]: [f64; 2]) -> u8 {
    let half = 0.5 * (high - low).abs();
    let size = size(number, [low, high]);
    if half == 0.0 || !half.is_finite() || size == 0.0 {
        return DEFAULT_DIGITS;
    }
    let digits = exponent(size, 3) - exponent(half, 2) + 2;
    u8::try_from(digits.clamp(2, 8)).unwrap_or(DEFAULT_DIGITS)
}

/// What sets the place of the digits: the number, or the farther end of its interval where it is zero.
fn size(number: f64, [low, high]: [f64; 2]) -> f64 {
    if number == 0.0 {
        low.abs().max(high.abs())
    } else {
        number.abs()
    }
}

/// Value and interval with the same number of decimals: `1.640 [1.622, 1.658]`.
pub(crate) fn with_interval(number: f64, interval: [f64; 2]) -> String {
    let digits = digits_of(number, interval);
    let exponent = exponent(size(number, interval), digits);
    let [low, high] = interval;
    if !(-4..6).contains(&exponent) {
        return format!(
            "{} [{}, {}]",
            significant(number, digits),
            significant(low, digits),
            significant(high, digits)
        );
    }
    let decimals = usize::try_from((i32::from(digits) - 1 - exponent).max(0)).unwrap_or(0);
    // Zeros after the point would look like digits that are known.
    let placed = |number: f64| match fixed(number, decimals) {
        text if text.chars().all(|c| c == '0' || c == '.') => "0".to_owned(),
        text => text,
    };
    format!("{} [{}, {}]", placed(number), placed(low), placed(high))
}

/// A unit as printed: powers raised, `percent` as its sign, `1` as nothing.
pub fn unit(unit: &str) -> String {
    match unit {
        "" | "1" | "-" => String::new(),
        "percent" | "%" => "%".into(),
        "1/rad" => "rad⁻¹".into(),
        "1/m" => "m⁻¹".into(),
        "deg" => "°".into(),
        other => other
            .replace("^-1", "⁻¹")
            .replace("^2", "²")
            .replace("^3", "³")
            .replace('*', "\u{a0}"),
    }
}

/// Text and unit with a space that does not break.
pub fn with_unit(text: &str, raw_unit: &str) -> String {
    match unit(raw_unit).as_str() {
        "" => text.into(),
        "°" => format!("{text}°"),
        shown => format!("{text}\u{202f}{shown}"),
    }
}

/// A number for a data file: the shortest text that reads back as the same bits.
pub(crate) fn exact(number: f64) -> String {
    if number.is_finite() {
        format!("{number}")
    } else {
        String::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn significant_digits_and_powers() {
        assert_eq!(significant(1.6449, 4), "1.645");
        assert_eq!(
            significant(-0.000_012_34, 3),
            "\u{2212}1.23\u{2009}×\u{2009}10⁻⁵"
        );
        assert_eq!(significant(123_456.0, 3), "123456");
        assert_eq!(significant(9.9996, 4), "10.00");
        assert_eq!(significant(0.0, 4), "0");
        assert_eq!(significant(f64::NAN, 4), "not finite");
    }

    #[test]
    fn no_negative_zero() {
        assert_eq!(fixed(-0.04, 1), "0.0");
        assert_eq!(fixed(-0.06, 1), "\u{2212}0.1");
    }

    #[test]
    fn interval_decides_the_digits() {
        assert_eq!(
            with_interval(1.640_123, [1.622, 1.658]),
            "1.640 [1.622, 1.658]"
        );
        assert_eq!(with_interval(18.604, [18.1, 19.1]), "18.60 [18.10, 19.10]");
        assert_eq!(
            with_interval(0.0, [0.0, 0.000_412_6]),
            "0 [0, 0.00041]",
            "an estimate on its bound"
        );
        assert_eq!(with_interval(0.0, [0.0, 9.251]), "0 [0, 9.3]");
    }

    #[test]
    fn units() {
        assert_eq!(with_unit("2", "kg m^2"), "2\u{202f}kg m²");
        assert_eq!(with_unit("2", "1"), "2");
        assert_eq!(with_unit("2", "percent"), "2\u{202f}%");
    }
}
