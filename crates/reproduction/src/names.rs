//! The nearest right name for one that is wrong.

/// The candidate nearest to `wrong` by Damerau-Levenshtein distance without regard to case, the first of equals; empty
/// without candidates.
#[must_use]
pub fn nearest<'a>(wrong: &str, candidates: impl IntoIterator<Item = &'a str>) -> &'a str {
    let wrong = wrong.to_lowercase();
    candidates
        .into_iter()
        .min_by_key(|candidate| strsim::damerau_levenshtein(&wrong, &candidate.to_lowercase()))
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn a_slip_of_the_finger_finds_its_name() {
        assert_eq!(
            nearest("idnetification", ["audit", "identification", "gait"]),
            "identification"
        );
        assert_eq!(nearest("c1", ["C01", "C12"]), "C01");
        assert_eq!(nearest("x", []), "");
    }
}
