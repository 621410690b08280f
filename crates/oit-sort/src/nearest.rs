//! The names a mistyped one may have meant.

/// The candidates that resemble `word`, most alike first, at most three.
pub(crate) fn nearest(
    word: &str,
    candidates: impl IntoIterator<Item = &'static str>,
) -> Vec<&'static str> {
    let mut scored: Vec<(f64, &'static str)> = candidates
        .into_iter()
        .map(|name| (strsim::normalized_damerau_levenshtein(word, name), name))
        .filter(|&(likeness, _)| likeness >= 0.4)
        .collect();
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    scored.into_iter().take(3).map(|(_, name)| name).collect()
}

/// ` (did you mean a or b?)`, or nothing.
pub(crate) fn did_you_mean(nearest: &[&str]) -> String {
    if nearest.is_empty() {
        String::new()
    } else {
        format!(" (did you mean {}?)", nearest.join(" or "))
    }
}
