//! From an author's plain sentence to a text: symbols written in ASCII become mathematics, straight quotes curl.

use super::literal;

/// ASCII names of the field's symbols and their LaTeX, longest first where one begins another.
const SYMBOLS: [(&str, &str); 16] = [
    ("theta_c_over_sigma", r"\theta_c/\sigma"),
    ("theta_s_over_sigma", r"\theta_s/\sigma"),
    ("theta_c/sigma", r"\theta_c/\sigma"),
    ("theta_s/sigma", r"\theta_s/\sigma"),
    ("cos^2 theta", r"\cos^2\theta"),
    ("cos^2", r"\cos^2"),
    ("theta0", r"\theta_0"),
    ("theta_c", r"\theta_c"),
    ("theta_s", r"\theta_s"),
    ("theta", r"\theta"),
    ("omega_sc", r"\omega_{sc}"),
    ("sigma0", r"\sigma_0"),
    ("sigma1", r"\sigma_1"),
    ("sigma2", r"\sigma_2"),
    ("sigma", r"\sigma"),
    ("mu", r"\mu"),
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
        let symbol = SYMBOLS.iter().find(|(name, _)| {
            rest.strip_prefix(name).is_some_and(|after| {
                let mut next = after.chars();
                let first = next.next();
                let joined = |c: char| c.is_alphanumeric() || c == '_';
                let dotted = first == Some('.') && next.next().is_some_and(joined);
                !joined(before) && before != '.' && !first.is_some_and(joined) && !dotted
            })
        });
        if let Some((name, latex)) = symbol {
            out.push_str(&format!("${latex}$"));
            rest = &rest[name.len()..];
            before = 'x';
            continue;
        }
        match character {
            '"' if before.is_whitespace() || matches!(before, '(' | '[') => out.push('“'),
            '"' => out.push('”'),
            '\'' if before.is_alphanumeric() => out.push('’'),
            other if plain => out.push_str(&literal(&other.to_string())),
            other => out.push(other),
        }
        before = character;
        rest = &rest[character.len_utf8()..];
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
