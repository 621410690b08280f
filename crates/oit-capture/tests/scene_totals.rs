//! Our scenes have the fragments and the peaks that the papers give for theirs.

#[path = "../examples/scene_totals.rs"]
#[expect(dead_code, unreachable_pub, reason = "an example has a main and is a crate of its own")]
mod scene_totals;

use scene_totals::*;
use toml::Value;

/// How far a scene that stands for a paper's may be from it, in percent.
const TOLERANCE_PERCENT: f64 = 15.0;

/// How far triangles may be, in percent.
const TRIANGLES_PERCENT: f64 = 5.0;

#[test]
fn totals_and_peaks_are_the_papers() {
    let rows = rows().unwrap();
    println!("{}\n{}", totals_table(&rows), intervals_table(&rows));
    for (scene, views) in [("atrium", 4), ("powerplant", 4), ("smoke", 1)] {
        assert_eq!(rows.iter().filter(|row| row.published.scene == scene).count(), views);
    }
    for Row { published, triangles, histogram } in &rows {
        let within = |what: &str, ours: u64, papers: u64, percent: f64| {
            let difference = difference_percent(ours, papers);
            assert!(
                difference.abs() <= percent,
                "{published:?}: {ours} {what}, {difference:+.1} %"
            );
        };
        within("fragments", histogram.total(), published.fragments, TOLERANCE_PERCENT);
        if let Some(papers) = published.triangles {
            within("triangles", *triangles, papers, TRIANGLES_PERCENT);
        }
        if let Some(papers) = published.peak {
            within("deep", histogram.peak().into(), papers.into(), TOLERANCE_PERCENT);
        }
    }
    check_document(&rows);
}

/// docs/scenes.md has a row for every view, and its numbers are those of today, give or take what a
/// machine's sine may shift an edge by.
fn check_document(rows: &[Row]) {
    let document = std::fs::read_to_string(document()).unwrap();
    for Row { published: p, triangles, histogram } in rows {
        let name = format!("| `{}` | `{}` | {}x", p.scene, p.view, p.size_px[0]);
        let line = document.lines().find(|line| line.starts_with(&name));
        let cells: Vec<&str> = line.expect(&name).split('|').map(str::trim).collect();
        let millions: f64 = cells[6].trim_end_matches(" M").parse().unwrap();
        let counted = histogram.total() as f64 / 1e6;
        let peak: i64 = cells[9].parse().unwrap();
        let hint = "run the example `scene_totals` with `--write`";
        assert_eq!(cells[4], triangles.to_string(), "{hint}: {name}");
        assert!((millions - counted).abs() <= 0.01 + 0.001 * counted, "{hint}: {name} {counted}");
        assert!((peak - i64::from(histogram.peak())).abs() <= 1, "{hint}: {name} {histogram:?}");
    }
}

const ATRIUM_VIEWS: [&str; 4] = ["lfb", "rbs-v1", "rbs-v2", "bma"];

#[test]
fn the_atriums_depth_falls_from_shallow_to_deep() {
    let atrium = scene("atrium", &[]).unwrap();
    for view in ATRIUM_VIEWS {
        let histogram = histogram(&atrium, view, [960, 540]).unwrap();
        let pixels = 960.0 * 540.0;
        let empty = histogram.pixels_in(0, 0) as f64 / pixels;
        assert!(empty < 0.02, "{view}: {empty} of the pixels are empty");
        // No count is a spike, and each interval has more pixels than the next, per count.
        let most = *histogram.pixels.iter().max().unwrap() as f64 / pixels;
        assert!(most < 0.2, "{view}: {most} of the pixels have one count");
        let density =
            |low: u32, high: u32| histogram.pixels_in(low, high) as f64 / f64::from(high - low + 1);
        let densities = [density(1, 8), density(9, 16), density(17, 32), density(33, 64)];
        assert!(densities.is_sorted_by(|a, b| a > b), "{view}: {densities:?}");
        assert!(densities[0] * 8.0 > 0.5 * pixels, "{view}: {densities:?}");
    }
}

#[test]
fn the_smokes_depth_falls_from_shallow_to_deep() {
    let smoke = scene("smoke", &[]).unwrap();
    let histogram = histogram(&smoke, "bma", [840, 525]).unwrap();
    let pixels = 840.0 * 525.0;
    let empty = histogram.pixels_in(0, 0) as f64 / pixels;
    assert!((0.6..0.9).contains(&empty), "{empty} of the pixels are empty");
    let intervals = [[1, 8], [9, 16], [17, 32], [33, 64], [65, 128], [129, 256]];
    let densities = intervals
        .map(|[low, high]| histogram.pixels_in(low, high) as f64 / f64::from(high - low + 1));
    assert!(densities.is_sorted_by(|a, b| a > b), "{densities:?}");
    // Every interval that the paper has a speedup for in its Table 1 has pixels.
    assert!(densities.iter().all(|density| *density > 0.0), "{densities:?}");
}

#[test]
fn a_small_atrium_has_the_same_layers() {
    let full = scene("atrium", &[]).unwrap();
    let small = scene("atrium", &[("detail", Value::Float(0.1))]).unwrap();
    let share = small.mesh.triangle_count() as f64 / full.mesh.triangle_count() as f64;
    assert!((0.1..0.17).contains(&share), "{share}");
    for view in ATRIUM_VIEWS {
        let [full, small] =
            [&full, &small].map(|scene| histogram(scene, view, [480, 270]).unwrap());
        let ratio = small.total() as f64 / full.total() as f64;
        assert!((0.92..1.08).contains(&ratio), "{view}: {ratio}");
    }
}

const POWER_PLANT_VIEWS: [&str; 4] = ["bma", "rbs-v1", "rbs-v2", "rbs-v3"];

#[test]
fn the_power_plants_depth_falls_from_shallow_to_deep() {
    let plant = scene("powerplant", &[]).unwrap();
    for view in POWER_PLANT_VIEWS {
        let histogram = histogram(&plant, view, [960, 540]).unwrap();
        // Each interval has more pixels than the next, per count; `rbs-v2`, with 25 fragments a
        // pixel in all, has fewest of the shallowest.
        let density =
            |low: u32, high: u32| histogram.pixels_in(low, high) as f64 / f64::from(high - low + 1);
        let ends =
            if view == "rbs-v2" { &[17, 33, 65, 129, 513][..] } else { &[1, 17, 33, 65, 513] };
        let densities: Vec<f64> = ends.windows(2).map(|w| density(w[0], w[1] - 1)).collect();
        assert!(densities.is_sorted_by(|a, b| a > b), "{view}: {densities:?}");
        let shallow = histogram.pixels_in(0, 32) as f64 / (960.0 * 540.0);
        assert!(shallow > 0.85, "{view}: {shallow}");
        // Few are deep, and the deepest are there all the same.
        let deep = histogram.pixels_in(129, u32::MAX) as f64 / (960.0 * 540.0);
        assert!(deep < 0.02, "{view}: {deep}");
        assert!(histogram.peak() > 90, "{view}: {}", histogram.peak());
    }
}

#[test]
fn the_power_plant_has_the_same_layers_at_any_detail() {
    let detail = |value: f64| scene("powerplant", &[("detail", Value::Float(value))]).unwrap();
    let (small, usual, full) = (detail(0.001), detail(0.05), detail(1.0));
    let triangles = [&small, &usual, &full].map(|scene| scene.mesh.triangle_count() as u64);
    assert!((100_000..300_000).contains(&triangles[0]), "{triangles:?}");
    assert!((750_000..1_250_000).contains(&triangles[1]), "{triangles:?}");
    let difference = difference_percent(triangles[2], 12_701_147);
    assert!(difference.abs() <= TRIANGLES_PERCENT, "{triangles:?}");
    for view in POWER_PLANT_VIEWS {
        let [small, usual, full] =
            [&small, &usual, &full].map(|scene| histogram(scene, view, [960, 540]).unwrap());
        for other in [small, full] {
            let totals = difference_percent(other.total(), usual.total());
            assert!(totals.abs() < 2.0, "{view}: {totals:+.1} %");
            let peaks = difference_percent(other.peak().into(), usual.peak().into());
            assert!(peaks.abs() < 10.0, "{view}: {peaks:+.1} %");
        }
    }
}

#[test]
fn the_grid_gives_what_figures_20_11_and_20_12_ask_for() {
    let sizes = figure_20_11().unwrap();
    let layers = figure_20_12().unwrap();
    println!("{}\n{}", grid_table(&sizes), grid_table(&layers));
    for setting in sizes.iter().chain(&layers) {
        let difference = difference_percent(setting.fragments, setting.wanted);
        assert!(difference.abs() < 2.0, "{setting:?}: {difference:+.2} %");
        assert!(setting.size <= 1.0, "{setting:?}: beyond the view");
    }
    assert!(sizes.iter().all(|setting| setting.triangles == 10 * 20_000));
    assert!(layers.iter().all(|setting| (500..=1000).contains(&setting.triangles)), "{layers:?}");
}

#[test]
fn a_table_goes_where_its_name_stands() {
    let text = "a\n<!-- x -->\nold\n<!-- end -->\nb\n<!-- y -->\nkept\n<!-- end -->\n";
    let expected = "a\n<!-- x -->\nnew\n<!-- end -->\nb\n<!-- y -->\nkept\n<!-- end -->\n";
    assert_eq!(replaced(text, "x", "new\n").as_deref(), Some(expected));
    assert_eq!(replaced(text, "z", "new\n"), None);
}
