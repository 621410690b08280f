//! The sort coordinate of a technique: which strategy, in which store, for which interval.

use crate::nearest::{did_you_mean, nearest};
use crate::{STRATEGIES, SortStrategy, Store, UnknownStrategy, store_name, strategy};
use std::fmt;
use std::str::FromStr;

/// One strategy or several, written `name[-store][@most]` joined by `+`: an interval runs the first
/// of them that admits its `max_frags`. `network+rbs` sorts with `network` up to 64 fragments, which
/// is its limit, and with `rbs` above; `insertion@16+merge` with `insertion` up to 16.
///
/// Or `auto`: for every interval the strategy that was measured to be the fastest. It names none
/// until it is replaced by a choice that does ([`SortChoice::from_parts`]).
#[derive(Clone)]
pub struct SortChoice {
    /// Empty for `auto`.
    parts: Vec<SortPart>,
}

/// One strategy of a [`SortChoice`].
#[derive(Clone, Copy)]
pub struct SortPart {
    /// The strategy.
    pub strategy: &'static dyn SortStrategy,
    /// Where its array lives.
    pub store: Store,
    /// The largest `max_frags` that it is chosen for, where that is less than its own limit.
    pub most: Option<u32>,
}

/// The word for a choice that is left to what was measured.
pub const AUTO: &str = "auto";

impl SortPart {
    /// The largest `max_frags` it is run for; `None` if there is no limit.
    #[must_use]
    pub fn limit(&self) -> Option<u32> {
        self.most.or(self.strategy.limit_in(self.store))
    }

    /// Its strategy with its store: what a program is made of, whatever it is chosen for.
    #[must_use]
    pub fn alone(&self) -> Self {
        Self { most: None, ..*self }
    }

    /// `N` of `name@N`.
    fn parse_most(text: &str) -> Option<u32> {
        let digits = text.bytes().all(|byte| byte.is_ascii_digit());
        text.parse().ok().filter(|&most| digits && most > 0)
    }
}

impl FromStr for SortPart {
    type Err = ChoiceError;

    fn from_str(part: &str) -> Result<Self, ChoiceError> {
        let (part, most) = match part.split_once('@') {
            Some((part, most)) => (part, Some(most)),
            None => (part, None),
        };
        let (name, store) = match part.split_once('-') {
            Some((name, store)) => (name, Some(store)),
            None => (part, None),
        };
        if name == AUTO {
            return Err(ChoiceError::Auto);
        }
        let strategy = strategy(name)?;
        let stores = strategy.stores();
        let store = match store {
            None => stores[0],
            Some(word) => stores.iter().copied().find(|s| s.name() == word).ok_or_else(|| {
                let stores: Vec<_> = stores.iter().map(|s| s.name()).collect();
                ChoiceError::Store {
                    strategy: strategy.name(),
                    store: word.to_owned(),
                    nearest: nearest(word, stores.iter().copied()),
                    stores,
                }
            })?,
        };
        let Some(word) = most else { return Ok(Self { strategy, store, most: None }) };
        let bad = || ChoiceError::Most { strategy: strategy.name(), most: word.to_owned() };
        let most = Self::parse_most(word).ok_or_else(bad)?;
        match strategy.limit_in(store) {
            Some(limit) if most > limit => {
                Err(ChoiceError::BeyondLimit { strategy: strategy.name(), most, limit })
            }
            // What it holds anyway need not be said.
            limit => Ok(Self { strategy, store, most: Some(most).filter(|_| limit != Some(most)) }),
        }
    }
}

/// Canonical: a store is named only where it is not the strategy's first, a bound only where it is
/// below the strategy's own.
impl fmt::Display for SortPart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&store_name(self.strategy, self.store))?;
        match self.most {
            Some(most) => write!(f, "@{most}"),
            None => Ok(()),
        }
    }
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
    /// What stands after `@` is no number of fragments.
    #[error("sort {strategy}@{most}: write the most fragments it is to sort, as {strategy}@16")]
    Most {
        /// The strategy.
        strategy: &'static str,
        /// What stands there.
        most: String,
    },
    /// A part is chosen for more than its strategy holds.
    #[error("sort {strategy}@{most}: {strategy} holds {limit} fragments at most")]
    BeyondLimit {
        /// The strategy.
        strategy: &'static str,
        /// What it is chosen for.
        most: u32,
        /// What it holds.
        limit: u32,
    },
    /// `auto` as one part of several.
    #[error("sort \"auto\" is the choice for every interval: it stands alone")]
    Auto,
    /// A part that could never run.
    #[error("sort {part:?} is never reached: {before:?} before it already holds as many fragments")]
    Unreachable {
        /// The part that is never reached.
        part: String,
        /// The one before it.
        before: String,
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
            parts: vec![SortPart { strategy, store: strategy.stores()[0], most: None }],
        };
        STRATEGIES.iter().map(alone).collect()
    }

    /// The choice between these parts, the first that admits an interval running it.
    ///
    /// # Errors
    /// Where there is none ([`ChoiceError::Auto`]), or one is never reached.
    pub fn from_parts(parts: Vec<SortPart>) -> Result<Self, ChoiceError> {
        if parts.is_empty() {
            return Err(ChoiceError::Auto);
        }
        for pair in parts.windows(2) {
            let more = match (pair[0].limit(), pair[1].limit()) {
                (None, _) => false,
                (Some(_), None) => true,
                (Some(before), Some(this)) => this > before,
            };
            if !more {
                let name = |part: &SortPart| store_name(part.strategy, part.store);
                let (part, before) = (name(&pair[1]), name(&pair[0]));
                return Err(ChoiceError::Unreachable { part, before });
            }
        }
        Ok(Self { parts })
    }

    /// Whether it is `auto`, which names no strategy yet.
    #[must_use]
    pub fn is_auto(&self) -> bool {
        self.parts.is_empty()
    }

    /// Each strategy with its store and bound, in the order they are tried; none for `auto`.
    #[must_use]
    pub fn parts(&self) -> &[SortPart] {
        &self.parts
    }

    /// The strategy, and its store, for programs that hold up to `max_frags` fragments.
    ///
    /// # Errors
    /// Where all parts have lower limits; the error says which. For `auto`.
    pub fn for_max_frags(
        &self,
        max_frags: u32,
    ) -> Result<(&'static dyn SortStrategy, Store), SortLimit> {
        let admits = |part: &&SortPart| part.limit().is_none_or(|limit| max_frags <= limit);
        if let Some(part) = self.parts.iter().find(admits) {
            return Ok((part.strategy, part.store));
        }
        let limit = |part: &SortPart| {
            let name = store_name(part.strategy, part.store);
            match (part.most, part.limit()) {
                (Some(most), _) => Some(format!("{name} is chosen up to {most}")),
                (None, limit) => limit.map(|limit| format!("{name} holds {limit}")),
            }
        };
        let mut limits: Vec<String> = self.parts.iter().filter_map(limit).collect();
        if self.is_auto() {
            limits.push("no strategy was chosen for it".into());
        }
        Err(SortLimit { choice: self.to_string(), max_frags, limits: limits.join(", ") })
    }
}

impl FromStr for SortChoice {
    type Err = ChoiceError;

    fn from_str(text: &str) -> Result<Self, ChoiceError> {
        if text == AUTO {
            return Ok(Self { parts: Vec::new() });
        }
        Self::from_parts(text.split('+').map(str::parse).collect::<Result<_, _>>()?)
    }
}

/// Canonical, as its parts are.
impl fmt::Display for SortChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_auto() {
            return f.write_str(AUTO);
        }
        for (i, part) in self.parts.iter().enumerate() {
            write!(f, "{}{part}", if i > 0 { "+" } else { "" })?;
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
        let name = |part: &SortPart| (part.strategy.name(), part.store, part.most);
        self.parts.iter().map(name).eq(other.parts.iter().map(name))
    }
}

impl Eq for SortChoice {}
