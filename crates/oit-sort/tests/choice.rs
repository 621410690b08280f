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
        assert_eq!(choice.parts()[0].strategy.name(), strategy.name());
        for store in strategy.stores() {
            let text = format!("{}-{}", strategy.name(), store.name());
            let choice: SortChoice = text.parse().unwrap();
            assert_eq!(choice.parts()[0].store, *store);
            let is_default = *store == strategy.stores()[0];
            let shown = if is_default { strategy.name() } else { &text };
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
fn a_part_is_chosen_up_to_its_bound() {
    let text = "insertion@16+merge-local@64+rbs";
    let choice: SortChoice = text.parse().unwrap();
    assert_eq!(choice.to_string(), "insertion@16+merge@64+rbs");
    assert_eq!(choice.to_string().parse::<SortChoice>().as_ref(), Ok(&choice));
    let name = |max_frags| choice.for_max_frags(max_frags).unwrap().0.name();
    let names = [8, 16, 17, 64, 65, 1024].map(name);
    assert_eq!(names, ["insertion", "insertion", "merge", "merge", "rbs", "rbs"]);
    // A strategy's own limit need not be said, and a lower one differs from it.
    let said: SortChoice = "network@64+rbs".parse().unwrap();
    assert_eq!(said.to_string(), "network+rbs");
    assert_eq!(said, "network+rbs".parse().unwrap());
    assert_ne!(said, "network@32+rbs".parse().unwrap());
    let bounded: SortChoice = "insertion@16".parse().unwrap();
    assert_eq!(
        bounded.for_max_frags(32).unwrap_err().to_string(),
        "sort insertion@16 cannot hold 32 fragments: insertion is chosen up to 16"
    );
    assert_eq!(SortChoice::from_parts(choice.parts().to_vec()), Ok(choice));
}

#[test]
fn auto_stands_alone_and_names_no_strategy() {
    let auto: SortChoice = "auto".parse().unwrap();
    assert!(auto.is_auto() && auto.parts().is_empty());
    assert_eq!(auto.to_string(), "auto");
    assert!(auto.for_max_frags(8).is_err());
    assert!(!SortChoice::all().contains(&auto));
    for text in ["auto+rbs", "rbs+auto", "auto@16", "auto-local"] {
        assert_eq!(text.parse::<SortChoice>(), Err(ChoiceError::Auto), "{text}");
    }
}

#[test]
fn workgroup_memory_holds_so_many_and_another_store_takes_over() {
    let choice: SortChoice = "insertion-workgroup+insertion-local".parse().unwrap();
    assert_eq!(choice.to_string(), "insertion-workgroup+insertion");
    let runs = |max_frags| choice.for_max_frags(max_frags).unwrap().1;
    assert_eq!((runs(8), runs(512)), (Store::Workgroup, Store::Workgroup));
    assert_eq!((runs(513), runs(4096)), (Store::Local, Store::Local));
    let choice: SortChoice = "merge-workgroup".parse().unwrap();
    assert_eq!(
        choice.for_max_frags(512).unwrap_err().to_string(),
        "sort merge-workgroup cannot hold 512 fragments: merge-workgroup holds 256"
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
    assert_eq!(message("network@65"), "sort network@65: network holds 64 fragments at most");
    for text in ["rbs@", "rbs@0", "rbs@x", "rbs@+8", "rbs@99999999999", "rbs@8@9"] {
        assert!(matches!(text.parse::<SortChoice>(), Err(ChoiceError::Most { .. })), "{text}");
    }
    // 512 fragments in workgroup memory, half of them with left runs beside them.
    assert_eq!(
        message("insertion-workgroup+merge-workgroup"),
        "sort \"merge-workgroup\" is never reached: \"insertion-workgroup\" before it already holds as \
         many fragments"
    );
    for text in [
        "insertion+rbs",
        "network+rs",
        "rs+rs",
        "merge@16+insertion@16",
        "rbs@64+network",
        "insertion+insertion-workgroup",
    ] {
        assert!(matches!(text.parse::<SortChoice>(), Err(ChoiceError::Unreachable { .. })));
    }
    assert_eq!(strategy("insert").err().unwrap().nearest[0], "insertion");
}
