//! What of a technique's name decides what it costs.

/// Sorts that leave fragments as they come.
const UNSORTED: [&str; 2] = ["passthrough", "unsorted"];

/// A technique, by what its cost depends on.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) enum Family {
    /// It captures, then resolves: the two are predicted alone, each from all that share it.
    Sorted {
        /// The layout.
        capture: String,
        /// The schedule, which decides what a capture counts and marks besides.
        schedule: String,
        /// All but the size of the array: pixels deeper than it cost what it holds.
        resolve: String,
        /// The most fragments of a pixel; `None`: as many as there are.
        most: Option<u32>,
    },
    /// It is predicted whole: a method, or one with a pool that is not all that is needed.
    Whole,
}

/// A coordinate's five parts and its options.
fn parts(technique: &str) -> Option<([&str; 5], Vec<&str>)> {
    let parts: Vec<&str> = technique.split('/').collect();
    let (first, options) = parts.split_first_chunk::<5>()?;
    Some((*first, options.to_vec()))
}

impl Family {
    pub(crate) fn of(technique: &str) -> Self {
        let Some(([capture, schedule, sort, stage, max], options)) = parts(technique) else {
            return Self::Whole;
        };
        if options.iter().any(|option| option.starts_with("pool")) {
            return Self::Whole;
        }
        let most = max.strip_prefix("max").and_then(|most| most.parse().ok());
        let mut resolve = format!("{capture}/{schedule}/{sort}/{stage}");
        for option in options {
            resolve = format!("{resolve}/{option}");
        }
        Self::Sorted { capture: capture.to_owned(), schedule: schedule.to_owned(), resolve, most }
    }

    /// Whether a pixel of so many fragments keeps all of them.
    pub(crate) fn holds(&self, peak: u32) -> bool {
        match self {
            Self::Sorted { most, .. } => most.is_none_or(|most| peak <= most),
            Self::Whole => true,
        }
    }
}

/// Whether a technique may be advised. Not those that compare depth alone, which have no one right
/// answer; not those in CUDA, whose copy of the fragments is not in their time; not what only times
/// another (`base-intervals`) or fetches a tuning's choice under a name that says nothing (`auto`).
#[must_use]
pub fn is_candidate(technique: &str) -> bool {
    let Some(([_, schedule, sort, stage, _], options)) = parts(technique) else {
        return !technique.contains('/') || technique.split('/').count() == 2;
    };
    let left_open = sort == "auto" || options.contains(&"intervals-optimal");
    !(left_open
        || options.contains(&"ties-depth")
        || stage == "cuda"
        || schedule == "base-intervals")
}

/// Whether it sorts nothing.
pub(crate) fn is_unsorted(technique: &str) -> bool {
    parts(technique).is_some_and(|([_, _, sort, ..], _)| UNSORTED.contains(&sort))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_comes_apart() {
        let name = "linked_list/bma-list/network+rbs/compute/max32/intervals4-12";
        let Family::Sorted { capture, schedule, resolve, most } = Family::of(name) else {
            panic!("{name}")
        };
        assert_eq!((&*capture, &*schedule), ("linked_list", "bma-list"));
        assert_eq!(resolve, "linked_list/bma-list/network+rbs/compute/intervals4-12");
        assert_eq!(most, Some(32));
        assert!(Family::of(name).holds(32) && !Family::of(name).holds(33));
        for whole in ["dual_peel", "hybrid/k8", "a/b/c/d/peak/pool50-drop"] {
            assert_eq!(Family::of(whole), Family::Whole);
        }
    }

    #[test]
    fn some_are_never_advised() {
        for name in ["a/bma-list/rbs/compute/peak", "weighted", "k_nearest/k4", "a/b/c/d/e/pool50"]
        {
            assert!(is_candidate(name), "{name}");
        }
        for name in [
            "a/base/rbs/compute/peak/ties-depth",
            "a/base/rbs/cuda/peak",
            "a/base-intervals/rbs/compute/peak",
            "a/bma-list/auto/compute/peak",
            "array-probe/local/compute/size8",
        ] {
            assert!(!is_candidate(name), "{name}");
        }
        assert!(is_unsorted("a/base/passthrough/compute/peak") && !is_unsorted("weighted"));
    }
}
