//! Sort coordinates.

use oit_sort::{ChoiceError, STRATEGIES, SortChoice, Store, strategy};

#[test]
fn names_are_well_formed_and_unique() {
    for (i, strategy) in STRATEGIES.iter().enumerate() {
        let name = strategy.name();
        assert!(name.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'_'));
        assert!(STRATEGIES[..i].iter().all(|other| other.name() != name), "{name} twice");
        assert!(!strategy.summary().is_empty() && !strategy.citation().is_empty());
        assert!(!strategy.stores().is_empty() && strategy.limit() != Some(0));
    }
}

#[test]
fn every_strategy_alone_reads_back() {
    let all = SortChoice::all();
    assert_eq!(all.len(), STRATEGIES.len());
    for (choice, strategy) in all.iter().zip(STRATEGIES) {
        assert_eq!(choice.to_string().parse::<SortChoice>().as_ref(), Ok(choice));
        assert_eq!(choice.parts()[0].0.name(), strategy.name());
        for store in strategy.stores() {
            let text = format!("{}-{}", strategy.name(), store.name());
            let choice: SortChoice = text.parse().unwrap();
            assert_eq!(choice.parts()[0].1, *store);
            let shown = if *store == strategy.stores()[0] { strategy.name() } else { &text };
            assert_eq!(choice.to_string(), *shown);
        }
    }
}

#[test]
fn a_store_is_named_where_it_is_not_the_default() {
    for (text, shown) in [("rbs", "rbs"), ("rbs-local", "rbs"), ("rbs-global", "rbs-global")] {
        assert_eq!(text.parse::<SortChoice>().unwrap().to_string(), shown);
    }
    assert_eq!("rbs".parse::<SortChoice>(), "rbs-local".parse());
    assert_ne!("rbs".parse::<SortChoice>(), "rbs-global".parse());
}

#[test]
fn the_first_part_that_admits_an_interval_runs_it() {
    let choice: SortChoice = "network+rbs-local".parse().unwrap();
    assert_eq!(choice.to_string(), "network+rbs");
    for (max_frags, name) in [(8, "network"), (64, "network"), (65, "rbs"), (1024, "rbs")] {
        assert_eq!(choice.for_max_frags(max_frags).unwrap().0.name(), name);
    }
    assert_eq!(choice.for_max_frags(128).unwrap().1, Store::Local);
    assert_eq!(
        choice.for_max_frags(2048).unwrap_err().to_string(),
        "sort network+rbs cannot hold 2048 fragments: network holds 64, rbs holds 1024"
    );
}

#[test]
fn mistakes_are_named_with_what_was_meant() {
    let message = |text: &str| text.parse::<SortChoice>().unwrap_err().to_string();
    let mistyped = message("netwrok");
    assert!(mistyped.starts_with("unknown sort \"netwrok\" (did you mean network"));
    assert!(mistyped.contains("?); the sorts are passthrough, unsorted, insertion,"));
    assert!(message("").starts_with("unknown sort \"\"; the sorts are"));
    assert!(message("rbs+").starts_with("unknown sort \"\""));
    let store = message("rbs-locla");
    assert!(store.starts_with("sort \"rbs\" has no store \"locla\" (did you mean local"));
    assert!(store.ends_with("?); it has local, global"));
    for text in ["insertion+rbs", "network+rs", "rs+rs"] {
        assert!(matches!(text.parse::<SortChoice>(), Err(ChoiceError::Unreachable { .. })));
    }
    assert_eq!(strategy("insert").err().unwrap().nearest[0], "insertion");
}
