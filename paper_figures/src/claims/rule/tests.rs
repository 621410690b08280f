//! Each kind of rule that rests on layouts and series: a case that holds, one that does not, and one
//! without evidence. Rules are read from TOML, as claims are.

use std::collections::BTreeMap;

use analysis::Ratio;

use super::*;
use crate::claims::evidence::Best;

/// Numbers by technique and scene, made up.
#[derive(Default)]
struct Made {
    times: BTreeMap<(&'static str, &'static str), f64>,
    memory: BTreeMap<(&'static str, &'static str), Memory>,
    ratios: Vec<f64>,
    wrong: BTreeMap<&'static str, f64>,
    errors: BTreeMap<(&'static str, &'static str), f64>,
    refused: BTreeMap<&'static str, Option<&'static str>>,
    programs: BTreeMap<&'static str, Vec<Told>>,
    best: BTreeMap<u64, f64>,
    /// Of the passes of one stage.
    work: Vec<(&'static str, WorkOf, f64)>,
    /// Along the one series: place, and figures by technique, whichever are asked for.
    series: Vec<(u64, Vec<(&'static str, f64)>)>,
}

impl Evidence for Made {
    fn time_ms(&self, technique: &str, (scene, _): &View, _: &str) -> Result<f64, String> {
        let found = self.times.iter().find(|((t, s), _)| *t == technique && s == scene);
        found.map(|(_, ms)| *ms).ok_or_else(|| format!("no {technique} on {scene}"))
    }

    fn memory(&self, technique: &str, (scene, _): &View) -> Result<Memory, String> {
        let found = self.memory.iter().find(|((t, s), _)| *t == technique && s == scene);
        found.map(|(_, memory)| *memory).ok_or_else(|| format!("no memory of {technique}"))
    }

    fn error(&self, technique: &str, (scene, _): &View, of: ErrorOf) -> Result<f64, String> {
        if of == ErrorOf::WrongPercent {
            return self.wrong.get(technique).copied().ok_or_else(|| format!("no {technique}"));
        }
        assert_eq!(of, ErrorOf::Rmse);
        let found = self.errors.iter().find(|((t, s), _)| *t == technique && s == scene);
        found.map(|(_, error)| *error).ok_or_else(|| format!("no {technique} on {scene}"))
    }

    fn refused(&self, technique: &str, _: &View) -> Result<Option<String>, String> {
        let state = self.refused.get(technique).ok_or_else(|| format!("no {technique}"))?;
        Ok(state.map(str::to_owned))
    }

    fn views(&self, _: &str) -> Vec<String> {
        Vec::new()
    }

    fn fragments(&self, _: &View) -> Result<u64, String> {
        Ok(25)
    }

    fn sorts(&self, ask: &SortQuestion) -> Result<Vec<Ratio>, String> {
        assert_eq!(ask.max, "max256");
        let ratio =
            |&ratio: &f64| Ratio { ratio, low: ratio, high: ratio, verdict: Comparison::Same };
        Ok(self.ratios.iter().map(ratio).collect())
    }

    fn programs(&self, technique: &str, _: &View) -> Result<Vec<Told>, String> {
        self.programs.get(technique).cloned().ok_or_else(|| format!("no {technique}"))
    }

    fn work(&self, ask: &WorkQuestion) -> Result<f64, String> {
        assert_eq!((ask.stage, ask.pass), ("draw", Some("draw: spheres")));
        let found = self.work.iter().find(|(t, of, _)| *t == ask.technique && *of == ask.of);
        found.map(|(.., count)| *count).ok_or_else(|| format!("no {}", ask.technique))
    }

    fn best(&self, ask: &BestQuestion) -> Result<Vec<Best>, String> {
        let best = |&depth: &u64| {
            let ratio = *self.best.get(&depth).ok_or_else(|| format!("no {depth}"))?;
            Ok(Best { depth, sort: "any".to_owned(), ratio })
        };
        ask.depths.iter().map(best).collect()
    }

    fn series(&self, ask: &SeriesQuestion) -> Result<Vec<SeriesPoint>, String> {
        let point = |(at, times): &(u64, Vec<(&str, f64)>)| {
            let time = |name: &&str| Some(times.iter().find(|(known, _)| known == name)?.1);
            let figures = ask.techniques.iter().map(time).collect::<Option<Vec<f64>>>()?;
            Some(SeriesPoint { at: *at, figures })
        };
        let points: Vec<SeriesPoint> = self.series.iter().filter_map(point).collect();
        if points.is_empty() { Err("no series".to_owned()) } else { Ok(points) }
    }
}

#[derive(Deserialize)]
struct File {
    rule: Rule,
}

fn finding(rule: &str, made: &Made) -> Result<Finding, String> {
    let file: File = toml::from_str(&format!("rule = {{ {rule} }}")).unwrap();
    file.rule.finding(made)
}

/// Whether a rule holds, and its figure to three decimals.
fn answer(rule: &str, made: &Made) -> (bool, f64) {
    let finding = finding(rule, made).unwrap();
    (finding.holds, (finding.figure * 1e3).round() / 1e3)
}

#[test]
fn bounds_are_what_they_say() {
    let bounds = Bounds { above: Some(1.0), at_least: None, at_most: Some(2.0) };
    assert!(!bounds.hold(1.0) && bounds.hold(1.5) && bounds.hold(2.0) && !bounds.hold(2.1));
    assert!(!bounds.hold(f64::NAN));
}

#[test]
fn views_are_combined() {
    let figures = [1.0, 2.0, 6.0];
    assert_eq!(Combine::Mean.of(&figures), 3.0);
    assert_eq!(Combine::Least.of(&figures), 1.0);
    assert_eq!(Combine::Greatest.of(&figures), 6.0);
}

fn memory(lfb_bytes: u64, slots: u64) -> Memory {
    let lfb_bytes_at_16 = Some(lfb_bytes + 8 * slots);
    let (all_bytes, pixels) = (lfb_bytes + 400, 1920 * 1080);
    Memory { all_bytes, lfb_bytes: Some(lfb_bytes), lfb_bytes_at_16, slots, pixels }
}

#[test]
fn memory_is_of_the_buffer_and_over_the_most() {
    let made = Made {
        memory: BTreeMap::from([
            (("list", "a"), memory(1600, 100)),
            (("line", "a"), memory(1200, 100)),
            (("array", "a"), memory(3200, 400)),
        ]),
        ..Made::default()
    };
    let rule = |own: &str, over: &str, of: &str, bounds: &str| {
        format!(
            "kind = 'memory', technique = '{own}', over = [{over}], of = '{of}', \
             views = [['a', 'front']], combine = 'mean', {bounds}"
        )
    };
    assert_eq!(answer(&rule("list", "'line'", "buffer", "at_most = 1.4"), &made), (true, 1.333));
    // 2400 over 2000.
    let at_16 = rule("list", "'line'", "buffer_at16", "at_least = 1.3");
    assert_eq!(answer(&at_16, &made), (false, 1.2));
    let most = rule("array", "'line', 'list'", "buffer", "above = 1.0");
    assert_eq!(answer(&most, &made), (true, 2.0));
    // 2000 over 1600.
    assert_eq!(answer(&rule("list", "'line'", "all", "at_most = 1.2"), &made), (false, 1.25));
    let missing = rule("array", "'line', 'pages'", "buffer", "above = 1.0");
    assert!(finding(&missing, &made).unwrap_err().contains("pages"));
    // An older record, that says nothing of its buffer.
    let old = Memory { lfb_bytes: None, ..memory(0, 100) };
    let made = Made { memory: BTreeMap::from([(("list", "a"), old)]), ..Made::default() };
    let unsaid = rule("list", "'list'", "buffer", "above = 1.0");
    assert!(finding(&unsaid, &made).unwrap_err().contains("does not say"));
}

#[test]
fn tables_are_what_the_pool_is_not() {
    let made = Made {
        // The chapter's: offsets padded to a power of two, and a head a pixel.
        memory: BTreeMap::from([
            (("line", "a"), memory((8 << 20) + 8 * 50, 50)),
            (("list", "a"), memory(4 * 1920 * 1080 + 12 * 50, 50)),
        ]),
        ..Made::default()
    };
    let over = "kind = 'tables', technique = ['line', 8], over = ['list', 12], \
                views = [['a', 'front']], above = 1.0, at_most = 2.0";
    assert_eq!(answer(over, &made), (true, 1.011));
    let size = |bounds: &str| {
        format!("kind = 'tables', technique = ['line', 8], views = [['a', 'front']], {bounds}")
    };
    assert_eq!(answer(&size("at_least = 7.5, at_most = 8.5"), &made), (true, 8.0));
    assert!(!answer(&size("at_most = 7.0"), &made).0);
    // Slots larger than the buffer are a wrong rule, not tables of less than nothing.
    let wrong =
        "kind = 'tables', technique = ['line', 800000], views = [['a', 'front']], above = 1.0";
    assert!(finding(wrong, &made).unwrap_err().contains("does not say"));
    assert!(finding(over, &Made::default()).is_err());
    // Another resolution says nothing of the chapter's megabytes.
    let small = Memory { pixels: 100, ..memory(800, 50) };
    let made = Made { memory: BTreeMap::from([(("line", "a"), small)]), ..Made::default() };
    assert!(finding(&size("at_least = 0.0"), &made).unwrap_err().contains("not 1920 x 1080"));
}

#[test]
fn a_contrast_is_of_two_speedups() {
    let times = [("own", "a", 1.0), ("other", "a", 3.0), ("own", "b", 2.0), ("other", "b", 3.0)];
    let times = times.map(|(technique, scene, ms)| ((technique, scene), ms));
    let made = Made { times: BTreeMap::from(times), ..Made::default() };
    let rule = |first: &str, second: &str| {
        format!(
            "kind = 'contrast', technique = 'own', over = 'other', stage = 'total', \
             views = [['{first}', 'front'], ['{second}', 'front']], above = 1.0"
        )
    };
    assert_eq!(answer(&rule("a", "b"), &made), (true, 2.0));
    assert_eq!(answer(&rule("b", "a"), &made), (false, 0.5));
    assert!(finding(&rule("a", "c"), &made).is_err());
}

fn series(names: [&'static str; 2], points: &[(u64, f64, f64)]) -> Made {
    let point = |&(at, a, b): &(u64, f64, f64)| (at, vec![(names[0], a), (names[1], b)]);
    Made { series: points.iter().map(point).collect(), ..Made::default() }
}

#[test]
fn a_line_is_as_straight_as_the_least_straight() {
    let made = series(["a", "b"], &[(10, 1.0, 1.0), (20, 2.0, 4.0), (30, 3.0, 3.0)]);
    let rule = |names: &str| {
        format!(
            "kind = 'linear', techniques = [{names}], view = ['grid', 'front'], varies = 'size', \
             stage = 'total', at_least = 0.99"
        )
    };
    assert_eq!(answer(&rule("'a'"), &made), (true, 1.0));
    // By hand: xy 2, xx 2, yy 14/3.
    assert_eq!(answer(&rule("'a', 'b'"), &made), (false, 0.429));
    assert!(finding(&rule("'a', 'c'"), &made).is_err());
    // Two points are no evidence.
    let short = series(["a", "b"], &[(10, 1.0, 1.0), (20, 2.0, 4.0)]);
    assert!(finding(&rule("'a'"), &short).is_err());
}

#[test]
fn a_speedup_is_taken_point_by_point() {
    let made = series(["a", "b"], &[(10, 1.0, 2.0), (20, 2.0, 3.0), (30, 4.0, 4.8)]);
    let rule = |own: &str, over: &str, combine: &str| {
        format!(
            "kind = 'series_speedup', technique = '{own}', over = ['{over}'], \
             view = ['grid', 'front'], varies = 'size', stage = 'total', combine = '{combine}', \
             above = 1.0"
        )
    };
    assert_eq!(answer(&rule("a", "b", "least"), &made), (true, 1.2));
    assert_eq!(answer(&rule("b", "a", "greatest"), &made), (false, 0.833));
    assert!(finding(&rule("a", "c", "least"), &made).is_err());
}

#[test]
fn sorting_dominates_from_a_depth_on() {
    let rule = |from: u64, until: u64| {
        format!(
            "kind = 'dominant', technique = 'a', floor = 'b', view = ['grid', 'front'], \
             varies = 'depth_at_same_total', from = {from}, until = {until}"
        )
    };
    // Shares of 0.2, 0.4, 0.6, 0.75.
    let points = [(10, 1.25, 1.0), (40, 5.0, 3.0), (60, 5.0, 2.0), (80, 4.0, 1.0)];
    let made = series(["a", "b"], &points);
    assert_eq!(answer(&rule(60, 20), &made), (true, 50.0));
    assert_eq!(answer(&rule(40, 20), &made), (false, 50.0));
    assert_eq!(answer(&rule(60, 60), &made), (false, 50.0));
    let never = series(["a", "b"], &[(10, 1.25, 1.0), (60, 1.25, 1.0), (80, 1.25, 1.0)]);
    assert_eq!(answer(&rule(60, 20), &never), (false, f64::INFINITY));
    // No point is deep enough to say.
    assert!(finding(&rule(100, 20), &made).unwrap_err().contains("no depth"));
    assert!(finding(&rule(60, 20), &Made::default()).is_err());
}

#[test]
fn views_are_like_a_series_by_their_fragments() {
    let rule = "kind = 'like_series', technique = 'a', view = ['grid', 'front'], varies = 'size', \
                stage = 'total', views = [['x', 'front'], ['y', 'front']], at_most = 2.0";
    // 25 fragments on the line: 2.5 ms.
    let mut made = series(["a", "b"], &[(10, 1.0, 1.0), (20, 2.0, 1.0), (30, 3.0, 1.0)]);
    assert!(finding(rule, &made).is_err());
    made.times = BTreeMap::from([(("a", "x"), 2.0), (("a", "y"), 3.0)]);
    assert_eq!(answer(rule, &made), (true, 1.25));
    made.times = BTreeMap::from([(("a", "x"), 1.0), (("a", "y"), 3.0)]);
    assert_eq!(answer(rule, &made), (false, 2.5));
}

#[test]
fn a_ratio_of_sorts_is_of_all_views() {
    let rule = "kind = 'sort_ratio', sort = 'unsorted', than = 'passthrough', \
                shader_stage = 'fragment', max = 'max256', scenes = ['stack'], combine = 'mean', \
                at_least = 3.0, at_most = 4.0";
    let made = |ratios: &[f64]| Made { ratios: ratios.to_vec(), ..Made::default() };
    assert_eq!(answer(rule, &made(&[3.0, 3.5])), (true, 3.25));
    assert_eq!(answer(rule, &made(&[1.0, 3.0])), (false, 2.0));
    assert!(finding(rule, &made(&[])).unwrap_err().contains("no view of stack"));
}

#[test]
fn what_a_stage_costs_is_repaid_by_what_another_saves() {
    let rule = r#"kind = "repaid", technique = "a", over = "b", cost = "group", saved = "resolve",
        views = [["x", "v"]], combine = "greatest", at_most = 0.1"#
        .replace('\n', " ");
    // The made-up evidence has one time for all stages: 1 spent, 20 - 1 saved.
    let mut made =
        Made { times: BTreeMap::from([(("a", "x"), 1.0), (("b", "x"), 20.0)]), ..Made::default() };
    assert_eq!(answer(&rule, &made), (true, 0.053));
    made.times.insert(("b", "x"), 3.0);
    assert_eq!(answer(&rule, &made), (false, 0.5));
    made.times.insert(("b", "x"), 1.0);
    assert_eq!(answer(&rule, &made), (false, f64::INFINITY));
    made.times.remove(&("b", "x"));
    assert!(finding(&rule, &made).unwrap_err().contains("no b"));
}

#[test]
fn wrong_pixels_are_counted() {
    let rule = r#"kind = "wrong_pixels", technique = "a", views = [["x", "v"]], combine = "mean", above = 0.0"#;
    let made = |percent| Made { wrong: BTreeMap::from([("a", percent)]), ..Made::default() };
    assert_eq!(answer(rule, &made(0.25)), (true, 0.25));
    assert_eq!(answer(rule, &made(0.0)), (false, 0.0));
    assert!(finding(rule, &Made::default()).is_err());
}

#[test]
fn a_limit_is_a_refusal_where_another_runs() {
    let rule = r#"kind = "refused", technique = "a", beside = "b", view = ["x", "v"]"#;
    let made = |a, b| Made { refused: BTreeMap::from([("a", a), ("b", b)]), ..Made::default() };
    assert_eq!(answer(rule, &made(Some("255 at most"), None)), (true, 1.0));
    assert_eq!(answer(rule, &made(None, None)), (false, 0.0));
    assert!(finding(rule, &made(Some("no"), Some("no"))).unwrap_err().contains("as well"));
    assert!(finding(rule, &Made::default()).is_err());
}

#[test]
fn a_technique_stands_among_others() {
    let times = [(("a", "s"), 2.0), (("b", "s"), 4.0), (("base", "s"), 8.0)];
    let made = Made { times: times.into(), ..Made::default() };
    let rule = |own: &str, other: &str| {
        format!(
            "kind = \"standing\", technique = \"{own}\", among = [\"{other}\"], baseline = \"base\", \
             stage = \"total\", views = [[\"s\", \"v\"]], combine = \"mean\", above = 1.0"
        )
    };
    assert_eq!(answer(&rule("a", "b"), &made), (true, 2.0));
    assert_eq!(answer(&rule("b", "a"), &made), (false, 0.5));
    assert!(finding(&rule("a", "c"), &made).is_err());
}

#[test]
fn programs_are_compared_by_what_is_told_of_them() {
    let told = |high, local: Option<f64>| Told { high, local_bytes: local, ..Told::default() };
    let programs = BTreeMap::from([
        ("registers", vec![told(16, Some(0.0)), told(64, Some(512.0))]),
        ("array", vec![told(16, Some(128.0)), told(64, Some(256.0))]),
        ("silent", vec![told(16, None)]),
    ]);
    let made = Made { programs, ..Made::default() };
    let rule = |technique: &str, more: &str| {
        format!(
            "kind = \"programs\", technique = \"{technique}\", of = \"local_bytes\", \
             views = [[\"s\", \"v\"]], combine = \"greatest\", at_most = 1.0, {more}"
        )
    };
    assert_eq!(answer(&rule("registers", "up_to = 32"), &made), (true, 0.0));
    assert_eq!(answer(&rule("registers", "over = \"array\""), &made), (false, 2.0));
    assert_eq!(answer(&rule("array", "over = \"registers\""), &made), (true, 0.5));
    for (technique, more) in [
        ("silent", "up_to = 32"),
        ("registers", "up_to = 8"),
        ("array", "over = \"registers\", up_to = 16"),
        ("none", "up_to = 32"),
    ] {
        assert!(finding(&rule(technique, more), &made).is_err(), "{technique} {more}");
    }
}

#[test]
fn the_worst_depth_of_the_best_sort_decides() {
    let made = Made { best: [(8, 0.5), (64, 1.5)].into(), ..Made::default() };
    let rule = |depths: &str| {
        format!(
            "kind = \"best_sort\", over = [\"passthrough\"], capture = \"linearized\", \
             shader_stage = \"compute\", depths = {depths}, at_most = 1.25"
        )
    };
    assert_eq!(answer(&rule("[8]"), &made), (true, 0.5));
    assert_eq!(answer(&rule("[8, 64]"), &made), (false, 1.5));
    assert!(finding(&rule("[8, 16]"), &made).is_err());
}

fn errors(errors: &[((&'static str, &'static str), f64)]) -> Made {
    Made { errors: errors.iter().copied().collect(), ..Made::default() }
}

#[test]
fn errors_are_compared_with_the_least() {
    let rule = |technique: &str, over: &str, bounds: &str| {
        format!(
            "kind = 'error', technique = '{technique}', over = [{over}], of = 'rmse', \
             views = [['x', 'v'], ['y', 'v']], combine = 'greatest', {bounds}"
        )
    };
    let made = errors(&[
        (("a", "x"), 0.1),
        (("a", "y"), 0.2),
        (("b", "x"), 0.4),
        (("b", "y"), 0.4),
        (("c", "x"), 0.5),
        (("c", "y"), 0.1),
        (("none", "x"), 0.0),
        (("none", "y"), 0.0),
    ]);
    assert_eq!(answer(&rule("a", "", "at_most = 0.2"), &made), (true, 0.2));
    assert_eq!(answer(&rule("a", "'b'", "at_most = 0.999"), &made), (true, 0.5));
    assert_eq!(answer(&rule("a", "'b', 'c'", "at_most = 0.999"), &made), (false, 2.0));
    // No error is less than any, and neither more nor less than none.
    assert_eq!(answer(&rule("none", "'a'", "at_most = 0.999"), &made), (true, 0.0));
    assert_eq!(answer(&rule("none", "'none'", "at_most = 0.999"), &made), (false, 1.0));
    assert_eq!(answer(&rule("a", "'none'", "at_most = 10.0"), &made), (false, f64::INFINITY));
    assert!(finding(&rule("a", "'d'", "at_most = 1.0"), &made).is_err());
    // Small errors are told as they are.
    let small = errors(&[(("a", "x"), 1e-5), (("a", "y"), 2e-5)]);
    let detail = finding(&rule("a", "", "at_most = 0.2"), &small).unwrap().detail;
    assert_eq!(detail, "x v 1e-5, y v 2e-5");
}

#[test]
fn an_error_on_one_view_is_compared_with_that_on_another() {
    let rule = "kind = 'error_contrast', technique = 'a', of = 'rmse', \
                views = [['x', 'v'], ['y', 'v']], at_least = 5.0";
    assert_eq!(answer(rule, &errors(&[(("a", "x"), 0.6), (("a", "y"), 0.1)])), (true, 6.0));
    assert_eq!(answer(rule, &errors(&[(("a", "x"), 0.1), (("a", "y"), 0.1)])), (false, 1.0));
    assert!(finding(rule, &errors(&[(("a", "x"), 0.1)])).is_err());
}

#[test]
fn an_error_follows_a_power_of_the_size() {
    let rule = "kind = 'error_exponent', sizes = [['a', 4.0], ['b', 16.0], ['c', 64.0]], of = 'rmse', \
                views = [['x', 'v']], combine = 'mean', at_least = -0.6, at_most = -0.4";
    let made = |sizes: [f64; 3]| {
        errors(&[(("a", "x"), sizes[0]), (("b", "x"), sizes[1]), (("c", "x"), sizes[2])])
    };
    assert_eq!(answer(rule, &made([0.4, 0.2, 0.1])), (true, -0.5));
    assert_eq!(answer(rule, &made([0.16, 0.04, 0.01])), (false, -1.0));
    assert!(finding(rule, &made([0.4, 0.2, 0.0])).unwrap_err().contains("logarithm"));
    // An error that stays is of no power.
    assert!(finding(rule, &made([0.4, 0.4, 0.4])).is_err());
    assert!(finding(rule, &errors(&[(("a", "x"), 0.1)])).is_err());
}

#[test]
fn a_picture_is_lost_from_a_place_on() {
    let rule = |beyond: f64, bounds: &str| {
        format!(
            "kind = 'lost_from', technique = 'a', of = 'rmse', beyond = {beyond:?}, \
             view = ['stack', 'front'], varies = 'depth', {bounds}"
        )
    };
    let made = series(["a", "b"], &[(2, 0.001, 1.0), (32, 0.003, 1.0), (64, 0.5, 1.0)]);
    assert_eq!(answer(&rule(0.004, "above = 30.0, at_most = 64.0"), &made), (true, 64.0));
    assert_eq!(answer(&rule(0.002, "above = 32.0"), &made), (false, 32.0));
    assert_eq!(answer(&rule(0.9, "above = 1e6"), &made), (true, f64::INFINITY));
    assert!(finding(&rule(0.9, "above = 1e6"), &Made::default()).is_err());
    let broken = series(["a", "b"], &[(2, f64::NAN, 1.0), (32, 0.0, 1.0), (64, 0.0, 1.0)]);
    assert_eq!(answer(&rule(0.9, "above = 30.0"), &broken), (false, 2.0));
}

#[test]
fn memory_grows_along_a_series() {
    let rule = |names: &str, combine: &str, bounds: &str| {
        format!(
            "kind = 'memory_growth', techniques = [{names}], view = ['stack', 'front'], \
             varies = 'depth', combine = '{combine}', {bounds}"
        )
    };
    let made = series(["a", "b"], &[(8, 100.0, 100.0), (32, 101.0, 200.0), (128, 105.0, 700.0)]);
    assert_eq!(answer(&rule("'a'", "greatest", "at_most = 1.1"), &made), (true, 1.05));
    assert_eq!(answer(&rule("'a', 'b'", "greatest", "at_most = 1.1"), &made), (false, 7.0));
    assert_eq!(answer(&rule("'b'", "least", "at_least = 2.0"), &made), (true, 7.0));
    assert!(finding(&rule("'c'", "least", "at_least = 2.0"), &made).is_err());
}

#[test]
fn work_is_counted_divided_and_compared() {
    let (fragments, primitives) = (WorkOf::FragmentInvocations, WorkOf::Primitives);
    let work = vec![
        ("a", fragments, 300.0),
        ("b", fragments, 400.0),
        ("a", primitives, 30.0),
        ("b", primitives, 10.0),
        ("none", fragments, 0.0),
    ];
    let made = Made { work, ..Made::default() };
    let rule = |rest: &str| {
        format!(
            "kind = 'work', of = 'fragment_invocations', stage = 'draw', pass = 'draw: spheres', \
             views = [['x', 'v']], combine = 'mean', {rest}"
        )
    };
    let over = "technique = 'a', over = 'b'";
    assert_eq!(answer(&rule(&format!("{over}, at_most = 0.8")), &made), (true, 0.75));
    assert_eq!(answer(&rule(&format!("{over}, above = 0.75")), &made), (false, 0.75));
    assert_eq!(answer(&rule("technique = 'a', at_least = 300.0"), &made), (true, 300.0));
    assert_eq!(
        answer(&rule("technique = 'a', per = 'primitives', at_most = 9.0"), &made),
        (false, 10.0)
    );
    // Each by its own: 10 over 40.
    let both = format!("{over}, per = 'primitives', at_most = 0.25");
    assert_eq!(answer(&rule(&both), &made), (true, 0.25));
    let missing = |rest: &str| finding(&rule(rest), &made).unwrap_err();
    assert_eq!(missing("technique = 'a', over = 'none', at_most = 1.0"), "none has none");
    assert_eq!(missing("technique = 'c', at_most = 1.0"), "no c");
    assert_eq!(missing("technique = 'none', per = 'primitives', at_most = 1.0"), "no none");
}
