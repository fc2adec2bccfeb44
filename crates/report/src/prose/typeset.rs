//! From an author's plain sentence to a text: symbols written in ASCII become mathematics, straight quotes curl.

use super::literal;

/// ASCII names of the field's symbols and their forms in LaTeX and in plain Unicode, longest first where one begins another.
const SYMBOLS: [(&str, &str, &str); 16] = [
    ("theta_c_over_sigma", r"\theta_c/\sigma", "θc/σ"),
    ("theta_s_over_sigma", r"\theta_s/\sigma", "θs/σ"),
    ("theta_c/sigma", r"\theta_c/\sigma", "θc/σ"),
    ("theta_s/sigma", r"\theta_s/\sigma", "θs/σ"),
    ("cos^2 theta", r"\cos^2\theta", "cos²θ"),
    ("cos^2", r"\cos^2", "cos²"),
    ("theta0", r"\theta_0", "θ₀"),
    ("theta_c", r"\theta_c", "θc"),
    ("theta_s", r"\theta_s", "θs"),
    ("theta", r"\theta", "θ"),
    ("omega_sc", r"\omega_{sc}", "ωsc"),
    ("sigma0", r"\sigma_0", "σ₀"),
    ("sigma1", r"\sigma_1", "σ₁"),
    ("sigma2", r"\sigma_2", "σ₂"),
    ("sigma", r"\sigma", "σ"),
    ("mu", r"\mu", "μ"),
];

/// A plain sentence of the author's as mark-up. What stands in backticks, between dollar signs or in placeholders is
/// left alone; with `plain`, everything else is made harmless as [`literal`] does, else mark-up is kept.
fn set(text: &str, plain: bool) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    let mut before = ' ';
    while let Some(character) = rest.chars().next() {
        if let Some(kept) = kept(rest).filter(|_| !plain) {
            out.push_str(kept);
            rest = &rest[kept.len()..];
            before = 'x';
            continue;
        }
        if let Some((name, latex, _)) = symbol(rest, before) {
            out.push_str(&format!("${latex}$"));
            rest = &rest[name.len()..];
            before = 'x';
            continue;
        }
        match character {
            '"' if before.is_whitespace() || matches!(before, '(' | '[') => out.push('“'),
            '"' => out.push('”'),
            '\'' if before.is_alphanumeric() => out.push('’'),
            '-' if minus(rest, before) => out.push('\u{2212}'),
            other if plain => out.push_str(&literal(&other.to_string())),
            other => out.push(other),
        }
        before = character;
        rest = &rest[character.len_utf8()..];
    }
    out
}

/// Whether a hyphen stands for the sign of a number: one that begins a word and is followed by a digit.
fn minus(text: &str, before: char) -> bool {
    (before.is_whitespace() || matches!(before, '(' | '['))
        && text[1..].starts_with(|c: char| c.is_ascii_digit())
}

/// The symbol whose name starts the text and is a word of its own there.
fn symbol(text: &str, before: char) -> Option<&'static (&'static str, &'static str, &'static str)> {
    let joined = |c: char| c.is_alphanumeric() || c == '_';
    if joined(before) || before == '.' {
        return None;
    }
    SYMBOLS.iter().find(|(name, ..)| {
        text.strip_prefix(name).is_some_and(|after| {
            let mut next = after.chars();
            let first = next.next();
            let dotted = first == Some('.') && next.next().is_some_and(joined);
            !first.is_some_and(joined) && !dotted
        })
    })
}

/// Symbols of a label as Unicode letters, for drawings, whose words hold no mathematics.
pub(crate) fn letters(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    let mut before = ' ';
    while let Some(character) = rest.chars().next() {
        if let Some((name, _, letters)) = symbol(rest, before) {
            out.push_str(letters);
            rest = &rest[name.len()..];
            before = 'x';
        } else {
            out.push(character);
            before = character;
            rest = &rest[character.len_utf8()..];
        }
    }
    out
}

/// Code, mathematics or a placeholder at the start of the text, with its marks.
fn kept(text: &str) -> Option<&str> {
    let until = |open: &str, close: &str| {
        let after = text.strip_prefix(open)?;
        let end = after.find(close)?;
        Some(&text[..open.len() + end + close.len()])
    };
    until("{{", "}}")
        .or_else(|| until("`", "`"))
        .or_else(|| until("$", "$"))
}

/// A plain sentence of the author's, without mark-up, as a text: symbols become mathematics, quotes curl, and nothing
/// else in it has a meaning.
pub fn typeset(text: &str) -> String {
    set(text, true)
}

/// The same for a sentence with mark-up, which is kept.
pub fn typeset_prose(text: &str) -> String {
    set(text, false)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symbols_become_mathematics() {
        assert_eq!(
            typeset("aluminium theta_c_over_sigma and sigma0."),
            r"aluminium $\theta_c/\sigma$ and $\sigma_0$."
        );
        assert_eq!(
            typeset("cos^2 theta is 0.72; the mean |mu|"),
            r"$\cos^2\theta$ is 0.72; the mean |$\mu$|"
        );
        assert_eq!(typeset("much, sigma_x, mu0"), "much, sigma_x, mu0");
    }

    #[test]
    fn labels_get_letters() {
        assert_eq!(
            letters("theta_c_over_sigma, sigma0 (omega_sc)"),
            "θc/σ, σ₀ (ωsc)"
        );
        assert_eq!(letters("thetas"), "thetas");
    }

    #[test]
    fn quotes_curl() {
        assert_eq!(
            typeset("\"agree\", by eye; the encoder's"),
            "“agree”, by eye; the encoder’s"
        );
    }

    #[test]
    fn marks_are_harmless_or_kept() {
        assert_eq!(
            typeset("a *b* {{ v(\"x\") }}"),
            "a \\*b\\* \\{\\{ v(“x”) \\}\\}"
        );
        let kept = "*b* {{ v(\"a.sigma0\") }} `sigma0` $\\sigma$";
        assert_eq!(typeset_prose(kept), kept);
        assert_eq!(
            typeset_prose("see identification.aluminium.sigma0"),
            "see identification.aluminium.sigma0"
        );
    }
}
