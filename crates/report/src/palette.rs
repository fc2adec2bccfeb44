//! The colours of the page in one place, each with its light and its dark form, and the two scales of maps.
//!
//! The inks follow Okabe and Ito's palette, which readers with any colour vision tell apart, darkened (light form) or
//! lightened (dark form) until each stands out from the ground by at least 3 to 1. Words reach 4.5 to 1. Both are tested.

use std::fmt::Write as _;

/// One colour: name of its variable, light form, dark form.
type Colour = (&'static str, &'static str, &'static str);

/// Ground, words and lines of the page.
const PAGE: [Colour; 10] = [
    ("ground", "#fcfbf8", "#15181b"),
    ("raised", "#ffffff", "#1c2024"),
    ("sunken", "#f3f1ea", "#22272c"),
    ("text", "#1f2328", "#e6e3dc"),
    ("quiet", "#565c63", "#a9aeb3"),
    ("hair", "#dedacf", "#343a40"),
    ("edge", "#8b8a84", "#777d83"),
    ("link", "#14508c", "#8fc1f0"),
    ("mark", "#fff3c4", "#4a3f12"),
    ("stamp", "#a3340b", "#ff9d72"),
];

/// Words and ground of the verdicts.
const VERDICTS: [Colour; 12] = [
    ("reproduced", "#14532d", "#9be0b3"),
    ("reproduced-g", "#dff0e4", "#16331f"),
    ("consistent", "#0b4a6b", "#9ad4f2"),
    ("consistent-g", "#ddeef7", "#10303f"),
    ("differs", "#6a4300", "#f5c873"),
    ("differs-g", "#fbecc8", "#3b2c0a"),
    ("contradicted", "#861a10", "#ffb3a6"),
    ("contradicted-g", "#fbe2de", "#451712"),
    ("not-testable", "#47367c", "#cdbff5"),
    ("not-testable-g", "#ebe7f6", "#2b2446"),
    ("not-run", "#4a4f54", "#c3c6c9"),
    ("not-run-g", "#ecebe6", "#2c3136"),
];

/// The inks of figures, `i8` for context.
const INKS: [Colour; 9] = [
    ("i0", "#0067a5", "#62b6ec"),
    ("i1", "#c04a00", "#ff9350"),
    ("i2", "#00795a", "#3ccda1"),
    ("i3", "#9a3f7a", "#ec9fd0"),
    ("i4", "#9a6a00", "#f0b83c"),
    ("i5", "#3b7fa8", "#a8dcf7"),
    ("i6", "#6f6b00", "#d8d04f"),
    ("i7", "#7a5230", "#d0a888"),
    ("i8", "#74797e", "#9aa0a6"),
];

/// Stops of the sequential scale of maps, equal in both forms.
const SEQUENTIAL: [[u8; 3]; 5] = [
    [0xfb, 0xf8, 0xe4],
    [0xa9, 0xd6, 0xbb],
    [0x3f, 0x97, 0xb4],
    [0x22, 0x52, 0x8b],
    [0x12, 0x1d, 0x3a],
];

/// Stops of the diverging scale of maps, equal in both forms.
const DIVERGING: [[u8; 3]; 5] = [
    [0x0a, 0x3f, 0x6f],
    [0x6f, 0xae, 0xd3],
    [0xf6, 0xf4, 0xee],
    [0xe8, 0x9b, 0x66],
    [0x7f, 0x28, 0x08],
];

/// Levels of a scale, counted from zero.
pub(crate) const LEVELS: u8 = 24;

fn level(stops: &[[u8; 3]; 5], level: u8) -> [u8; 3] {
    let place = f64::from(level.min(LEVELS)) / f64::from(LEVELS) * 4.0;
    let index = (0..4)
        .rfind(|&index| f64::from(index) <= place)
        .unwrap_or(0)
        .min(3);
    let share = place - f64::from(index);
    let (from, to) = (stops[index as usize], stops[index as usize + 1]);
    std::array::from_fn(|channel| {
        let mixed = f64::from(from[channel]) * (1.0 - share) + f64::from(to[channel]) * share;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // between two bytes
        let byte = mixed.round() as u8;
        byte
    })
}

/// Relative luminance (WCAG 2).
fn luminance(colour: [u8; 3]) -> f64 {
    let [r, g, b] = colour.map(|byte| {
        let share = f64::from(byte) / 255.0;
        if share <= 0.040_45 {
            share / 12.92
        } else {
            ((share + 0.055) / 1.055).powf(2.4)
        }
    });
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Contrast of two colours (WCAG 2), 1 to 21.
fn contrast(a: [u8; 3], b: [u8; 3]) -> f64 {
    let (a, b) = (luminance(a), luminance(b));
    (a.max(b) + 0.05) / (a.min(b) + 0.05)
}

/// Dark and pale words on the cells of maps.
const ON_PALE: [u8; 3] = [0, 0, 0];
const ON_DARK: [u8; 3] = [0xff, 0xff, 0xff];

/// Whether words on this level of a map must be pale.
pub(crate) fn needs_pale_words(diverging: bool, at: u8) -> bool {
    let colour = level(if diverging { &DIVERGING } else { &SEQUENTIAL }, at);
    contrast(colour, ON_DARK) > contrast(colour, ON_PALE)
}

fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// The rules that give the levels of maps their colours.
fn scales() -> String {
    let mut out = String::new();
    for at in 0..=LEVELS {
        let _ = write!(
            out,
            ".s{at}{{fill:{}}}.d{at}{{fill:{}}}",
            hex(level(&SEQUENTIAL, at)),
            hex(level(&DIVERGING, at))
        );
    }
    out
}

/// The variables of the page: each colour follows the reader's scheme.
pub(crate) fn for_page() -> String {
    let mut out = String::from(":root{");
    for (name, light, dark) in PAGE.iter().chain(&VERDICTS).chain(&INKS) {
        let _ = write!(out, "--{name}:light-dark({light},{dark});");
    }
    out.push('}');
    out + &scales()
}

/// The variables of a figure in a file of its own: the light form, with the scales where it is a map.
pub(crate) fn for_file(map: bool) -> String {
    let mut out = String::from("svg{");
    for (name, light, _) in PAGE.iter().chain(&INKS) {
        let _ = write!(out, "--{name}:{light};");
    }
    out.push('}');
    if map { out + &scales() } else { out }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(hex: &str) -> [u8; 3] {
        std::array::from_fn(|k| u8::from_str_radix(&hex[1 + 2 * k..3 + 2 * k], 16).unwrap())
    }

    fn of(name: &str) -> [[u8; 3]; 2] {
        let (_, light, dark) = PAGE
            .iter()
            .chain(&VERDICTS)
            .chain(&INKS)
            .find(|c| c.0 == name)
            .unwrap();
        [bytes(light), bytes(dark)]
    }

    fn assert_contrast(words: &str, ground: &str, least: f64) {
        for (form, (words_form, ground_form)) in of(words).into_iter().zip(of(ground)).enumerate() {
            let ratio = contrast(words_form, ground_form);
            assert!(
                ratio >= least,
                "{words} on {ground}, form {form}: {ratio:.2}"
            );
        }
    }

    #[test]
    fn black_on_white_is_21_to_1() {
        assert!((contrast([0; 3], [255; 3]) - 21.0).abs() < 1e-12);
    }

    #[test]
    fn words_stand_out_by_4_5() {
        for ground in ["ground", "raised", "sunken"] {
            for words in ["text", "quiet", "link", "stamp"] {
                assert_contrast(words, ground, 4.5);
            }
        }
        assert_contrast("text", "mark", 4.5);
        for verdict in [
            "reproduced",
            "consistent",
            "differs",
            "contradicted",
            "not-testable",
            "not-run",
        ] {
            assert_contrast(verdict, &format!("{verdict}-g"), 4.5);
            assert_contrast(verdict, "raised", 4.5);
            assert_contrast(verdict, "ground", 4.5);
        }
    }

    #[test]
    fn inks_and_edges_stand_out_by_3() {
        for ink in INKS.iter().map(|c| c.0).chain(["edge"]) {
            assert_contrast(ink, "ground", 3.0);
            assert_contrast(ink, "raised", 3.0);
        }
    }

    #[test]
    fn words_on_maps_can_be_read() {
        for at in 0..=LEVELS {
            for (diverging, stops) in [(false, &SEQUENTIAL), (true, &DIVERGING)] {
                let words = if needs_pale_words(diverging, at) {
                    ON_DARK
                } else {
                    ON_PALE
                };
                let ratio = contrast(words, level(stops, at));
                assert!(
                    ratio >= 4.5,
                    "level {at}, diverging {diverging}: {ratio:.2}"
                );
            }
        }
    }

    #[test]
    fn sequential_scale_darkens_steadily() {
        let lights: Vec<f64> = (0..=LEVELS)
            .map(|at| luminance(level(&SEQUENTIAL, at)))
            .collect();
        assert!(lights.windows(2).all(|pair| pair[1] < pair[0]));
    }
}
