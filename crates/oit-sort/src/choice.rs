//! The sort coordinate of a technique: which strategy, in which store, for which interval.

use crate::nearest::{did_you_mean, nearest};
use crate::{STRATEGIES, SortStrategy, Store, UnknownStrategy, strategy};
use std::fmt;
use std::str::FromStr;

/// One strategy or several, written `name[-store]` joined by `+`: an interval runs the first of
/// them whose limit admits its `max_frags`. `network+rbs` sorts with `network` up to 64 fragments
/// and with `rbs` above.
#[derive(Clone)]
pub struct SortChoice {
    parts: Vec<(&'static dyn SortStrategy, Store)>,
}

/// Why a text is no sort coordinate.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum ChoiceError {
    /// No strategy has this name.
    #[error(transparent)]
    Strategy(#[from] UnknownStrategy),
    /// The strategy has no such store.
    #[error("sort {strategy:?} has no store {store:?}{}; it has {}", did_you_mean(nearest), stores.join(", "))]
    Store {
        /// The strategy.
        strategy: &'static str,
        /// The store asked for.
        store: String,
        /// Its stores that are spelled alike.
        nearest: Vec<&'static str>,
        /// All its stores.
        stores: Vec<&'static str>,
    },
    /// A part that could never run.
    #[error("sort {part:?} is never reached: {before:?} before it already holds as many fragments")]
    Unreachable {
        /// The part that is never reached.
        part: &'static str,
        /// The one before it.
        before: &'static str,
    },
}

/// No part of a choice holds as many fragments as asked for.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("sort {choice} cannot hold {max_frags} fragments: {limits}")]
pub struct SortLimit {
    /// The whole choice.
    pub choice: String,
    /// Fragments asked for.
    pub max_frags: u32,
    /// Each part's limit, in words.
    pub limits: String,
}

impl SortChoice {
    /// Every strategy alone, in its default store: what the value `all` of a sort axis stands for.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let alone = |&strategy: &&'static dyn SortStrategy| Self {
            parts: vec![(strategy, strategy.stores()[0])],
        };
        STRATEGIES.iter().map(alone).collect()
    }

    /// Each strategy with its store, in the order they are tried.
    #[must_use]
    pub fn parts(&self) -> &[(&'static dyn SortStrategy, Store)] {
        &self.parts
    }

    /// The strategy, and its store, for programs that hold up to `max_frags` fragments.
    ///
    /// # Errors
    /// Where all parts have lower limits; the error says which.
    pub fn for_max_frags(
        &self,
        max_frags: u32,
    ) -> Result<(&'static dyn SortStrategy, Store), SortLimit> {
        let admits = |part: &&(&'static dyn SortStrategy, Store)| {
            part.0.limit().is_none_or(|limit| max_frags <= limit)
        };
        self.parts.iter().find(admits).copied().ok_or_else(|| {
            let limit = |&(strategy, _): &(&'static dyn SortStrategy, Store)| {
                strategy.limit().map(|limit| format!("{} holds {limit}", strategy.name()))
            };
            let limits: Vec<String> = self.parts.iter().filter_map(limit).collect();
            SortLimit { choice: self.to_string(), max_frags, limits: limits.join(", ") }
        })
    }
}

impl FromStr for SortChoice {
    type Err = ChoiceError;

    fn from_str(text: &str) -> Result<Self, ChoiceError> {
        let mut parts: Vec<(&'static dyn SortStrategy, Store)> = Vec::new();
        for part in text.split('+') {
            let (name, store) = match part.split_once('-') {
                Some((name, store)) => (name, Some(store)),
                None => (part, None),
            };
            let strategy = strategy(name)?;
            let stores = strategy.stores();
            let store = match store {
                None => stores[0],
                Some(word) => {
                    stores.iter().copied().find(|s| s.name() == word).ok_or_else(|| {
                        let stores: Vec<_> = stores.iter().map(|s| s.name()).collect();
                        ChoiceError::Store {
                            strategy: strategy.name(),
                            store: word.to_owned(),
                            nearest: nearest(word, stores.iter().copied()),
                            stores,
                        }
                    })?
                }
            };
            if let Some((before, _)) = parts.last() {
                let more = match (before.limit(), strategy.limit()) {
                    (None, _) => false,
                    (Some(_), None) => true,
                    (Some(before), Some(this)) => this > before,
                };
                if !more {
                    let (part, before) = (strategy.name(), before.name());
                    return Err(ChoiceError::Unreachable { part, before });
                }
            }
            parts.push((strategy, store));
        }
        Ok(Self { parts })
    }
}

/// Canonical: a store is named only where it is not the strategy's default.
impl fmt::Display for SortChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, (strategy, store)) in self.parts.iter().enumerate() {
            if i > 0 {
                f.write_str("+")?;
            }
            f.write_str(strategy.name())?;
            if *store != strategy.stores()[0] {
                write!(f, "-{}", store.name())?;
            }
        }
        Ok(())
    }
}

impl fmt::Debug for SortChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SortChoice({self})")
    }
}

impl PartialEq for SortChoice {
    fn eq(&self, other: &Self) -> bool {
        let name = |part: &(&'static dyn SortStrategy, Store)| (part.0.name(), part.1);
        self.parts.iter().map(name).eq(other.parts.iter().map(name))
    }
}

impl Eq for SortChoice {}
