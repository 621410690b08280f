//! Advice on evidence that follows a law, so that the right answer is known. No number here was
//! measured.

use oit_advise::{
    Basis, Bounds, Candidate, ErrorBasis, Evidence, Measured, Metric, Reason, Told, View, advise,
    regret, trials,
};

const LISTS: &str = "linked_list/bma-list/network/compute/peak";
const ARRAYS: &str = "array3d/base/insertion/compute/peak";
const SHORT: &str = "linked_list/bma-list/network/compute/max8";
const UNSORTED: &str = "linked_list/base/passthrough/compute/peak";
const WEIGHTED: &str = "weighted";
const PEEL: &str = "dual_peel";

/// Pixels of some depths in a small frame.
fn view(scene: &str, depths: &[(usize, u64)]) -> View {
    let (width_px, height_px) = (100, 80);
    let deepest = depths.iter().map(|(depth, _)| *depth).max().unwrap_or(0);
    let mut histogram = vec![0; deepest + 1];
    for (depth, pixels) in depths {
        histogram[*depth] += pixels;
    }
    histogram[0] = 8000 - depths.iter().map(|(_, pixels)| pixels).sum::<u64>();
    let triangles = 10 * depths.iter().map(|(depth, _)| *depth as u64).sum::<u64>();
    View { scene: scene.into(), view: "v".into(), width_px, height_px, triangles, histogram }
}

fn scenes() -> Vec<View> {
    vec![
        view("a", &[(2, 3000), (6, 500), (12, 90)]),
        view("b", &[(4, 1000), (30, 200)]),
        view("c{n=1}", &[(1, 5000), (8, 2000), (16, 100)]),
        view("c{n=2}", &[(1, 500), (8, 5000), (20, 300)]),
        view("d", &[(3, 100), (10, 4000), (40, 1000)]),
    ]
}

/// Made-up costs: capture and resolve, in nanoseconds.
fn law(technique: &str, view: &View) -> (f64, Option<f64>) {
    let (fragments, covered) = (view.fragments() as f64, view.covered() as f64);
    let (pixels, triangles) = (view.pixels() as f64, view.triangles as f64);
    match technique {
        LISTS | UNSORTED => {
            let resolve = if technique == LISTS { 0.5 } else { 0.2 };
            (2000.0 + 3.0 * fragments + triangles, Some(5000.0 + resolve * fragments + covered))
        }
        // Of deeper pixels eight are read.
        SHORT => {
            let depths = (0_u64..).zip(&view.histogram);
            let held: u64 = depths.map(|(depth, pixels)| depth.min(8) * pixels).sum();
            (2000.0 + 3.0 * fragments + triangles, Some(5000.0 + 0.5 * held as f64 + covered))
        }
        ARRAYS => {
            (500.0 + 20.0 * pixels + 2.0 * fragments, Some(1000.0 + 0.4 * fragments + pixels))
        }
        WEIGHTED => (1000.0 + pixels + fragments, None),
        _ => (f64::from(view.peak()) * (1000.0 + triangles + 2.0 * fragments), None),
    }
}

fn measured(place: usize, technique: &str, view: &View) -> Measured {
    let (capture, resolve) = law(technique, view);
    let max_error = match technique {
        SHORT if view.peak() > 8 => 0.3,
        UNSORTED => 0.5,
        // The deeper, the worse.
        WEIGHTED => 0.001 * f64::from(view.peak()),
        _ => 0.0,
    };
    Measured {
        view: place,
        technique: technique.into(),
        total_ns: capture + resolve.unwrap_or(0.0),
        resolve_ns: resolve,
        max_error,
        rmse: max_error / 10.0,
        exact: max_error == 0.0,
        memory_bytes: 1000,
        ..Measured::default()
    }
}

const ALL: [&str; 6] = [LISTS, ARRAYS, SHORT, UNSORTED, WEIGHTED, PEEL];

fn evidence() -> Evidence {
    let views = scenes();
    let cells = views.iter().enumerate();
    let cells =
        cells.flat_map(|(place, view)| ALL.map(|technique| measured(place, technique, view)));
    let runs = vec!["run".to_owned(); views.len()];
    Evidence { cells: cells.collect(), runs, views, ..Evidence::default() }
}

fn candidates() -> Vec<Candidate> {
    let candidate = |technique: &str| Candidate {
        technique: technique.to_owned(),
        memory_bytes: Some(if technique == ARRAYS { 9000 } else { 1000 }),
        ..Candidate::default()
    };
    ALL.map(candidate).to_vec()
}

fn bounds(max_error: f64) -> Bounds {
    Bounds { max_error, ..Bounds::default() }
}

/// A view that none of the scenes has.
fn unseen() -> View {
    view("e", &[(2, 2000), (9, 1500), (20, 150)])
}

#[test]
fn what_follows_a_law_is_predicted_by_it() {
    let (evidence, view) = (evidence(), unseen());
    let advice = advise(&view, &evidence, &candidates(), &bounds(1.0));
    assert!(advice.ruled_out.is_empty(), "{:?}", advice.ruled_out);
    for choice in &advice.choices {
        let (capture, resolve) = law(&choice.technique, &view);
        let ns = capture + resolve.unwrap_or(0.0);
        // There are more features than views, of methods by far: what these do not tell apart is shared
        // out among features.
        let most = if resolve.is_some() { 0.05 } else { 0.5 };
        let off = (choice.time.ns / ns - 1.0).abs();
        assert!(off < most, "{}: {} for {ns}", choice.technique, choice.time.ns);
        let Basis::Fitted(parts) = &choice.time.basis else { panic!("{choice:?}") };
        assert!(parts.iter().all(|part| part.from.contains("views of a, b, c, d")), "{parts:?}");
        assert!(choice.time.cautious_ns() >= choice.time.ns);
    }
}

#[test]
fn the_bound_decides() {
    let (evidence, view) = (evidence(), unseen());
    let first = |max_error| {
        advise(&view, &evidence, &candidates(), &bounds(max_error)).choices[0].technique.clone()
    };
    // The truth of the made-up costs: weighted sums, then lists.
    assert_eq!(first(0.0), LISTS);
    assert_eq!(first(0.01), LISTS);
    assert_eq!(first(0.04), WEIGHTED);
    let advice = advise(&view, &evidence, &candidates(), &bounds(0.01));
    let reason = |technique: &str| {
        let found = advice.ruled_out.iter().find(|(name, _)| name == technique);
        found.map(|(_, reason)| reason.clone())
    };
    let Some(Reason::Error(worst)) = reason(WEIGHTED) else { panic!("{:?}", advice.ruled_out) };
    assert_eq!(worst.error, 0.04, "the worst of all views");
    assert_eq!(worst.basis, ErrorBasis::Worst { views: 5, scenes: 4 });
    assert!(matches!(reason(UNSORTED), Some(Reason::Error(_))));
}

#[test]
fn the_mean_square_is_another_bound() {
    let bounds = Bounds { max_error: 0.004, metric: Metric::Rmse, max_memory_bytes: None };
    let advice = advise(&unseen(), &evidence(), &candidates(), &bounds);
    assert_eq!(advice.choices[0].technique, WEIGHTED);
    assert_eq!(advice.choices[0].error.error, 0.004);
}

#[test]
fn an_approximation_is_never_exact() {
    let mut evidence = evidence();
    for cell in &mut evidence.cells {
        if cell.technique == WEIGHTED {
            (cell.max_error, cell.rmse, cell.exact) = (0.0, 0.0, false);
        }
    }
    let asked = advise(&unseen(), &evidence, &candidates(), &bounds(0.0));
    assert!(asked.choices.iter().all(|choice| choice.technique != WEIGHTED));
    // Nor where it was right on the very view.
    let seen = evidence.views[0].clone();
    let asked = advise(&seen, &evidence, &candidates(), &bounds(0.0));
    assert!(asked.choices.iter().all(|choice| choice.technique != WEIGHTED));
    let asked = advise(&seen, &evidence, &candidates(), &bounds(1e-9));
    assert_eq!(asked.choices[0].technique, WEIGHTED);
}

#[test]
fn deeper_than_measured_is_not_known() {
    let deep = view("e", &[(2, 2000), (41, 500)]);
    let advice = advise(&deep, &evidence(), &candidates(), &bounds(1.0));
    let unknown = |technique: &str| {
        advice.ruled_out.iter().any(|(name, reason)| {
            name == technique
                && matches!(reason, Reason::UnknownError(why) if why.contains("40 fragments"))
        })
    };
    assert!(unknown(WEIGHTED) && unknown(PEEL), "{:?}", advice.ruled_out);
    // What sorts all that there is needs no such proof.
    assert!(advice.choices.iter().any(|choice| choice.technique == LISTS));
    // Nor what the caller vouches for.
    let mut vouched = candidates();
    for candidate in &mut vouched {
        candidate.guaranteed = (candidate.technique == PEEL).then_some(0.0);
    }
    let advice = advise(&deep, &evidence(), &vouched, &bounds(0.0));
    let peel = advice.choices.iter().find(|choice| choice.technique == PEEL).unwrap();
    assert_eq!(peel.error.basis, ErrorBasis::Exact);
}

#[test]
fn resolves_at_depths_nobody_measured_are_not_known() {
    let far = view("e", &[(2, 2000), (100, 500)]);
    let mut candidates = candidates();
    candidates.retain(|candidate| candidate.technique == LISTS);
    let advice = advise(&far, &evidence(), &candidates, &bounds(0.0));
    let [(_, Reason::UnknownTime(why))] = advice.ruled_out.as_slice() else { panic!("{advice:?}") };
    assert!(why.contains("93 %"), "{why}");
    // A few such pixels are taken for others.
    let rim = view("e", &[(8, 5000), (100, 1)]);
    assert_eq!(advise(&rim, &evidence(), &candidates, &bounds(0.0)).choices.len(), 1);
    // A time from elsewhere takes its place.
    candidates[0].resolve = Some(Told { ns: 777.0, from: "a tuning".into(), off: Some(0.5) });
    let advice = advise(&far, &evidence(), &candidates, &bounds(0.0));
    let Basis::Fitted(parts) = &advice.choices[0].time.basis else { panic!("{advice:?}") };
    assert_eq!((parts[1].ns, parts[1].from.as_str()), (777.0, "a tuning"));
}

#[test]
fn what_was_measured_is_not_predicted() {
    let mut evidence = evidence();
    let seen = evidence.views[1].clone();
    // A measurement that follows no law, of a second run.
    evidence.views.push(seen.clone());
    evidence.runs.push("later".into());
    let place = evidence.views.len() - 1;
    let odd = Measured { total_ns: 123.0, ..measured(place, LISTS, &seen) };
    evidence.cells.push(odd);
    let advice = advise(&seen, &evidence, &candidates(), &bounds(0.0));
    assert_eq!((advice.choices[0].technique.as_str(), advice.choices[0].time.ns), (LISTS, 123.0));
    assert_eq!(advice.choices[0].time.basis, Basis::Measured { run: "later".into() });
    // Held out, it is predicted again.
    let others = evidence.without(|other| other.same_scene(&seen));
    let advice = advise(&seen, &others, &candidates(), &bounds(0.0));
    assert!(advice.choices.iter().all(|choice| matches!(choice.time.basis, Basis::Fitted(_))));
}

#[test]
fn memory_and_refusals_rule_out() {
    let mut candidates = candidates();
    candidates[0].refused = Some("it is too deep".into());
    candidates[2].memory_bytes = None;
    let bounds = Bounds { max_error: 1.0, max_memory_bytes: Some(5000), ..Bounds::default() };
    let advice = advise(&unseen(), &evidence(), &candidates, &bounds);
    let expected = [
        (LISTS.to_owned(), Reason::Refused("it is too deep".into())),
        (ARRAYS.to_owned(), Reason::Memory(9000)),
        (SHORT.to_owned(), Reason::UnknownMemory),
    ];
    assert_eq!(advice.ruled_out, expected);
}

#[test]
fn nothing_known_is_nothing_advised() {
    let empty = Evidence::default();
    let advice = advise(&unseen(), &empty, &candidates(), &bounds(1.0));
    assert!(advice.choices.is_empty() && advice.ruled_out.len() == ALL.len());
    assert!(trials(&empty, &[0.0]).is_empty() && regret(&[]).is_none());
    // A view without fragments, and one without pixels.
    for view in [view("e", &[]), View::default()] {
        let advice = advise(&view, &evidence(), &candidates(), &bounds(1.0));
        assert!(advice.choices.iter().all(|choice| choice.time.ns.is_finite()));
    }
}

#[test]
fn choices_among_lawful_costs_are_not_regretted() {
    let evidence = evidence();
    let all = trials(&evidence, &[0.0, 0.02, 1.0]);
    // On every view three are exact, and all six are off by no more than 1.
    assert_eq!(all.iter().filter(|trial| trial.max_error == 0.0).count(), 5);
    assert_eq!(all.iter().filter(|trial| trial.candidates == 6).count(), 5);
    let exact = regret(all.iter().filter(|trial| trial.max_error == 0.0)).unwrap();
    // Pixels as deep as on the deepest scene are on no other: neither times nor errors are known.
    let counts = (exact.trials, exact.without, exact.scenes, exact.broken);
    assert_eq!(counts, (5, 1, 3, 0));
    assert!(exact.mean < 1.02 && exact.any > 1.2, "{exact:?}");
    let deepest = all.iter().find(|trial| trial.scene == "d" && trial.max_error == 1.0).unwrap();
    assert!(deepest.choice.is_none() && deepest.best == WEIGHTED, "{deepest:?}");
}

#[test]
fn a_broken_bound_is_told() {
    let mut evidence = evidence();
    // Worse on one scene than on all others, which the others cannot tell.
    for cell in &mut evidence.cells {
        if cell.technique == WEIGHTED && cell.view == 0 {
            cell.max_error = 0.9;
        }
    }
    let all = trials(&evidence, &[0.05]);
    let broken = all.iter().find(|trial| trial.view == 0).unwrap();
    let choice = broken.choice.as_ref().unwrap();
    assert!(!choice.meets && choice.error == 0.9 && broken.regret().is_none(), "{broken:?}");
    assert_eq!(regret(&all).unwrap().broken, 1);
}

#[test]
fn a_models_corrections_are_of_mixed_depths() {
    let mut evidence = evidence();
    evidence.views.push(view("flat", &[(4, 8000)]));
    let place = evidence.views.len() - 1;
    evidence.cells.push(measured(place, LISTS, &evidence.views[place]));
    for cell in &mut evidence.cells {
        let by = if cell.view == place { 1.0 } else { 0.5 };
        cell.predicted_resolve_ns = cell.resolve_ns.map(|ns| ns * by);
    }
    let other = "linked_list/bma-list/rbs/compute/peak/intervals4-9";
    let (by, off, cells) = evidence.correction(other).unwrap();
    assert!((by - 2.0).abs() < 1e-9 && off < 1e-9, "{by} {off}");
    assert_eq!(cells, 10, "lists, whole and short, on five views");
    assert!(evidence.correction("linked_list/bma-stencil/rbs/fragment/peak").is_none());
}
