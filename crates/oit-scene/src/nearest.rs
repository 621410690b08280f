use strsim::damerau_levenshtein;

/// The valid words nearest to a misspelt one, best first; at most three, and none that is further
/// away than a third of its length (always two edits, so that short words have neighbours).
///
/// Use it for every message about an unknown name, so that all of them read alike.
pub fn nearest<'a>(word: &str, valid: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    let limit = (word.chars().count() / 3).max(2);
    let lower = word.to_lowercase();
    let mut near: Vec<(usize, &str)> = valid
        .into_iter()
        .map(|candidate| (damerau_levenshtein(&lower, &candidate.to_lowercase()), candidate))
        .filter(|(distance, candidate)| *distance <= limit && *distance < candidate.len())
        .collect();
    near.sort_unstable();
    near.dedup();
    near.into_iter().take(3).map(|(_, candidate)| candidate.to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn best_first_and_only_near_ones() {
        let valid = ["planes", "planes2", "grid", "hairball"];
        assert_eq!(nearest("plnes", valid), ["planes", "planes2"]);
        assert_eq!(nearest("Hair_ball", valid), ["hairball"]);
        assert!(nearest("teapot", valid).is_empty());
        assert!(nearest("", valid).is_empty());
    }
}
