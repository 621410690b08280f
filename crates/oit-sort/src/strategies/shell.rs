//! Shell sort in a local array.

use crate::{End, SortSpec, SortStrategy, Store};
use oit_fragments::{Fragment, Ties};

/// Insertion sort among fragments that are a gap apart, for ever smaller gaps.
///
/// The gaps are those of the papers' own code (pknowles/oit): half of the fragments, then each the
/// one before divided by 2.2 (Gonnet and Baeza-Yates) and rounded, down to 1.
pub(crate) struct Shell;

impl SortStrategy for Shell {
    fn name(&self) -> &'static str {
        "shell"
    }

    fn summary(&self) -> &'static str {
        "Shell sort in a local array, each gap the one before divided by 2.2."
    }

    fn citation(&self) -> &'static str {
        "Shell 1959; Gonnet, Baeza-Yates 1991; Knowles, Leach, Zambetta 2013, Figure 9"
    }

    fn stores(&self) -> &'static [Store] {
        &[Store::Local]
    }

    fn blends_from(&self) -> End {
        End::Back
    }

    fn template(&self) -> &'static str {
        include_str!("shell.wgsl.j2")
    }

    fn sort(&self, spec: &SortSpec, fragments: &mut [Fragment], _: &mut Vec<Fragment>) {
        match spec.ties {
            Ties::Total => shell_sort(fragments, |a, b| Ties::Total.behind(a, b)),
            Ties::Depth => shell_sort(fragments, |a, b| Ties::Depth.behind(a, b)),
        }
    }
}

/// The gap after this one: a 2.2th of it, rounded; 0 after 1.
fn next_gap(gap: usize) -> usize {
    (10 * gap + 11) / 22
}

fn shell_sort(frags: &mut [Fragment], behind: impl Fn(Fragment, Fragment) -> bool) {
    let mut gap = frags.len() / 2;
    while gap > 0 {
        for j in gap..frags.len() {
            let key = frags[j];
            let mut i = j;
            while i >= gap && behind(frags[i - gap], key) {
                frags[i] = frags[i - gap];
                i -= gap;
            }
            frags[i] = key;
        }
        gap = next_gap(gap);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_end_with_one() {
        for n in 2..=4096usize {
            let gaps: Vec<_> =
                std::iter::successors(Some(n / 2), |&gap| Some(next_gap(gap))).take(20).collect();
            let ones = gaps.iter().filter(|&&gap| gap == 1).count();
            assert_eq!(ones, 1, "{n} fragments: {gaps:?}");
            assert_eq!(gaps.last(), Some(&0), "{n} fragments");
        }
        let of_256: Vec<_> = std::iter::successors(Some(128), |&gap| Some(next_gap(gap)))
            .take_while(|&gap| gap > 0)
            .collect();
        assert_eq!(of_256, [128, 58, 26, 12, 5, 2, 1]);
    }
}
