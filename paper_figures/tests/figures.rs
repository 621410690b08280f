//! Figures of synthetic records: which are drawn, what is in them, and that they do not change.

mod synthetic;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use analysis::Tables;
use paper_figures::figures::{FIGURES, compare, compare_pages};
use paper_figures::{FigureError, Output, claims, generate, read};
use synthetic::{
    RBS_VIEWS, VIEWS, WRONG, approx, bma, compared, compile, flight, lfb, mechanism, peel, probe,
    rbs, spheres, stability, work, write_counts, write_rbs_views, write_run,
};

const DEVICE: &str = "test device";

fn one_device(root: &Path) -> Tables {
    let run = write_run(root, "run", DEVICE);
    write_counts(&run);
    lfb::write_runs(&root.join("lfb"), DEVICE);
    probe::write_run(&root.join("probe"), DEVICE);
    bma::write_run(root, DEVICE);
    flight::write_run(&root.join("flight"), DEVICE);
    mechanism::write_run(root, "mechanism", DEVICE, true);
    rbs::write_run(&root.join("rbs"), DEVICE);
    rbs::write_fragments(&root.join("rbs-fragments"), DEVICE);
    write_rbs_views(&root.join("rbs-views"), DEVICE);
    peel::write_run(&root.join("peel"), DEVICE);
    approx::write_run(&root.join("approx"), DEVICE);
    approx::write_many_scenes(&root.join("approx-scenes"), DEVICE);
    compile::write_run(&root.join("compiled"), DEVICE, false, Some("--cache=x"));
    compile::write_run(&root.join("cached"), DEVICE, true, Some("--cache=x"));
    stability::write_run(&root.join("stability"), DEVICE);
    spheres::write_run(&root.join("spheres"), DEVICE);
    work::write_run(&root.join("work"), DEVICE, true);
    read(&[root.to_owned()]).unwrap()
}

/// The records of the layered fragment buffer chapter's experiments alone.
fn chapter(root: &Path) -> Tables {
    lfb::write_runs(root, DEVICE);
    read(&[root.to_owned()]).unwrap()
}

/// The one output of a figure.
fn drawn(name: &str, tables: &Tables) -> Output {
    let figure = FIGURES.iter().find(|figure| figure.name() == name).unwrap();
    let mut outputs = figure.draw(tables).unwrap();
    assert_eq!(outputs.len(), 1, "{name}");
    outputs.remove(0)
}

/// The field of the one row of a table for programs where other columns have given values.
fn field(output: &Output, named: &[(&str, &str)], column: &str) -> String {
    let place = |name: &str| output.csv.columns.iter().position(|known| *known == name).unwrap();
    let mut rows = output.csv.rows.iter();
    let mut rows =
        rows.by_ref().filter(|row| named.iter().all(|(name, is)| row[place(name)] == *is));
    let row = rows.next().unwrap_or_else(|| panic!("{}: no row {named:?}", output.name));
    assert!(rows.next().is_none(), "{}: two rows {named:?}", output.name);
    row[place(column)].clone()
}

fn draw_all(tables: &Tables) -> Vec<Output> {
    FIGURES.iter().flat_map(|figure| figure.draw(tables).unwrap()).collect()
}

/// Every file of a folder.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries
        .map(|path| {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            (name, fs::read(&path).unwrap())
        })
        .collect()
}

#[test]
fn the_same_records_give_the_same_bytes() {
    let root = tempfile::tempdir().unwrap();
    let first = write_run(root.path(), "records/first", DEVICE);
    let second = write_run(root.path(), "records/second", "other test device");
    write_counts(&first);
    let (a, b) = (root.path().join("a"), root.path().join("b"));
    generate(&read(&[first.clone(), second.clone()]).unwrap(), &a, None).unwrap();
    // The order in which records are named is no part of them.
    generate(&read(&[second, first]).unwrap(), &b, None).unwrap();
    let (a, b) = (files(&a), files(&b));
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    for (name, bytes) in &a {
        assert!(b[name] == *bytes, "{name} differs");
    }
    for name in ["rbs-table-2", "rbs-table-3", "bma-figure-5-test-device-test"] {
        for extension in ["svg", "png", "csv", "md"] {
            assert!(a.contains_key(&format!("{name}.{extension}")), "{name}.{extension}");
        }
    }
    assert!(a.contains_key("pareto-planes-front-other-test-device-test.svg"));
}

#[test]
fn every_file_names_device_commit_and_command() {
    let root = tempfile::tempdir().unwrap();
    let tables = one_device(&root.path().join("records"));
    let out = root.path().join("out");
    generate(&tables, &out, None).unwrap();
    for (name, bytes) in files(&out) {
        // PNG text chunks are not compressed here, so all four kinds can be searched as bytes.
        let text = String::from_utf8_lossy(&bytes);
        for stamp in ["test device (test)", "0123456789ab", "oit sweep experiments/synthetic.toml"]
        {
            assert!(text.contains(stamp), "{name} lacks {stamp}");
        }
    }
}

#[test]
fn every_figure_is_drawn_and_indexed() {
    let root = tempfile::tempdir().unwrap();
    let tables = one_device(&root.path().join("records"));
    let out = root.path().join("out");
    let drawn = generate(&tables, &out, None).unwrap();
    let index = fs::read_to_string(out.join("index.md")).unwrap();
    for drawn in &drawn {
        assert!(!drawn.files.is_empty(), "{}", drawn.figure.name());
        for (name, _) in &drawn.files {
            assert!(index.contains(&format!("({name}.png)")), "{name}");
            assert!(out.join(format!("{name}.svg")).exists(), "{name}");
        }
    }
}

#[test]
fn what_records_lack_is_said_and_not_drawn() {
    let root = tempfile::tempdir().unwrap();
    let run = write_run(&root.path().join("records"), "run", DEVICE);
    // Only what was counted, before anything was verified.
    let events = fs::read_to_string(run.join("events.jsonl")).unwrap();
    let counted: String = events.split_inclusive('\n').take(VIEWS.len()).collect();
    fs::write(run.join("events.jsonl"), counted).unwrap();
    let tables = read(&[run]).unwrap();
    let out = root.path().join("out");
    let drawn = generate(&tables, &out, None).unwrap();
    let index = fs::read_to_string(out.join("index.md")).unwrap();
    for drawn in &drawn {
        assert!(drawn.files.is_empty(), "{}", drawn.figure.name());
    }
    assert_eq!(index.matches("Not drawn: the records hold no").count(), FIGURES.len());
    let verdicts = claims::verdicts(&tables).unwrap();
    assert!(verdicts.iter().all(|verdict| verdict.word() == "not tested"));
}

#[test]
fn no_text_lies_on_another() {
    let root = tempfile::tempdir().unwrap();
    let tables = one_device(root.path());
    let mut outputs = draw_all(&tables);
    outputs.extend(compare(&tables, "rbs").unwrap());
    let run = compared::write_run(&root.path().join("compared"), DEVICE);
    let pages = compare_pages(&read(&[run]).unwrap(), "network").unwrap();
    outputs.extend(pages.into_iter().map(|page| page.output));
    for output in outputs {
        let page = output.page().unwrap();
        let boxes = page.text_boxes().unwrap();
        for (index, (a, first)) in boxes.iter().enumerate() {
            assert!(
                a[0] >= 0.0 && a[1] >= 0.0 && a[2] <= page.width_px && a[3] <= page.height_px,
                "{}: {first} leaves the page",
                output.name
            );
            for (b, second) in &boxes[index + 1..] {
                let apart = a[2] <= b[0] || b[2] <= a[0] || a[3] <= b[1] || b[3] <= a[1];
                assert!(apart, "{}: {first} lies on {second}", output.name);
            }
        }
    }
}

#[test]
fn wrong_cells_are_never_charted_as_times() {
    let root = tempfile::tempdir().unwrap();
    let tables = one_device(root.path());
    for output in draw_all(&tables) {
        for row in &output.csv.rows {
            // Table 2 may name it, with its state and without a time.
            let named = row.iter().any(|field| field == WRONG);
            assert!(!named || row.iter().any(|field| field == "wrong"), "{}", output.name);
        }
        assert!(!output.tables.iter().any(|table| table.markdown().contains(WRONG)));
    }
}

#[test]
fn table_2_has_published_and_measured_times() {
    let root = tempfile::tempdir().unwrap();
    let tables = one_device(root.path());
    let output = drawn("rbs-table-2", &tables);
    let row = |technique: &str, view: &str, quantity: &str| -> Vec<String> {
        let rows = output.csv.rows.iter();
        let mut rows =
            rows.filter(|row| row[1] == technique && row[3] == view && row[4] == quantity);
        rows.next().unwrap().clone()
    };
    let measured = tables
        .results
        .iter()
        .find(|cell| {
            cell.name.technique == "linked_list/bma-stencil/rbs/fragment/peak/ties-depth"
                && cell.name.view == "back"
        })
        .unwrap();
    let resolve = measured.median_ms(analysis::RESOLVE).unwrap();
    let own = row("BMA-RBS-L", "planes Rev", "R");
    assert_eq!((own[5].as_str(), own[6].as_str()), ("61", format!("{resolve}").as_str()));
    let cuda = row("CUDA-IS", "planes Fwd", "T");
    assert_eq!((cuda[5].as_str(), cuda[6].as_str()), ("40", ""));
    let markdown = output.markdown();
    let line = markdown.lines().find(|line| line.starts_with("| CUDA-IS |")).unwrap();
    assert!(line.ends_with("| not measured yet |"), "{line}");
    assert!(markdown.contains("| linked_list/bma-list/network+rbs/compute/peak |"), "{markdown}");
}

#[test]
fn claims_are_decided_by_the_records() {
    let root = tempfile::tempdir().unwrap();
    let verdicts = claims::verdicts(&one_device(root.path())).unwrap();
    let verdict = |id: &str| verdicts.iter().find(|verdict| verdict.claim.id == id).unwrap();
    // In the synthetic records insertion sort takes far longer from the back, and bma always helps.
    assert_eq!(verdict("rbs-insertion-direction").word(), "holds");
    assert_eq!(verdict("rbs-bma-alone").word(), "holds");
    // Merge sort takes longer than insertion sort from the front, whatever the depth.
    assert_eq!(verdict("bma-merge-above-16").word(), "does not hold");
    assert_eq!(verdict("bma-insertion-to-16").word(), "holds");
    // The paper's own numbers, through the same rules.
    let published = verdict("rbs-direction-small").published.unwrap();
    assert!((published - 75.0 / 62.0).abs() < 1e-12);
    // But for the atrium's second view.
    assert_eq!(verdict("rbs-fastest-in-most").published, Some(8.0 / 9.0));
    let published = verdict("lfb-within-10-percent-dragon").published.unwrap();
    assert!((published - 20.10 / 22.07).abs() < 1e-12);
}

#[test]
fn the_chapter_s_claims_are_decided_by_its_experiments() {
    let root = tempfile::tempdir().unwrap();
    let verdicts = claims::verdicts(&chapter(root.path())).unwrap();
    let verdict = |id: &str| verdicts.iter().find(|verdict| verdict.claim.id == id).unwrap();
    let words = |word: &str| -> Vec<&str> {
        let of_chapter = verdicts.iter().filter(|verdict| verdict.claim.id.starts_with("lfb-"));
        let with = of_chapter.filter(|verdict| verdict.word() == word);
        with.map(|verdict| verdict.claim.id.as_str()).collect()
    };
    // What no experiment measures: merge sort on the meshes; and these views are small.
    let untested = ["lfb-insertion-for-the-scenes", "lfb-offsets-8-mb"];
    assert_eq!(words("not tested"), untested);
    // By the made-up costs a subgroup's increment is much cheaper.
    assert_eq!(words("does not hold"), ["lfb-atomics"]);
    let near = |id: &str, figure: f64| {
        let own = verdict(id).figure().unwrap();
        assert!((own - figure).abs() < 0.02 * figure, "{id}: {own}, not {figure}");
    };
    near("lfb-sorting-dominates", lfb::HALF_FROM);
    near("lfb-array-of-256", 5.0 / 1.5);
    near("lfb-offsets-over-heads", 8192.0 / (96.0 * 54.0));
    near("lfb-blend-counts", 1.25);
    // Three depths of one size, one of which is of the growing grid too.
    assert_eq!(verdict("lfb-linear-layers").detail().matches(' ').count(), 3);
    // Nothing of these scenes is in the other papers' rules.
    assert_eq!(verdict("rbs-bma-alone").word(), "not tested");
}

#[test]
fn table_20_1_has_published_and_measured_steps() {
    let root = tempfile::tempdir().unwrap();
    let tables = chapter(root.path());
    let output = drawn("lfb-table-20-1", &tables);
    let step = |step: &str, schedule: &str, stage: &str, column: &str| {
        let named = [("scene", "atrium"), ("layout", "linearized"), ("schedule", schedule)];
        let named = [&named[..], &[("shader_stage", stage), ("step", step)]].concat();
        field(&output, &named, column)
    };
    let ms =
        |name: &str| step(name, "base-stencil", "fragment", "median_ms").parse::<f64>().unwrap();
    assert_eq!(step("Sort in shader", "base-stencil", "fragment", "published_ms"), "43.68");
    // A difference has no interval of its own.
    assert_eq!(step("Sort in shader", "base", "compute", "low_ms"), "");
    let insertion = tables.results.iter().find(|cell| {
        cell.name.technique == "linearized/base-stencil/insertion/fragment/peak"
            && cell.name.scene == "atrium"
    });
    let resolve = insertion.unwrap().median_ms("resolve").unwrap();
    assert!((ms("Read & blend fragments") + ms("Sort in shader") - resolve).abs() < 1e-9);
    assert!(ms("Read & blend, no array") < ms("Read & blend fragments"));
    assert!(output.markdown().contains("| Atrium: atrium, lfb | 279095 | 100 | 17.5 | 0.08 |"));
}

#[test]
fn figures_20_11_and_20_12_tell_size_from_depth() {
    let root = tempfile::tempdir().unwrap();
    let tables = chapter(root.path());
    let growing = drawn("lfb-figure-20-11", &tables);
    assert!(growing.csv.rows.iter().all(|row| row[4] == "10"));
    let named = [
        ("resolve", "base-stencil/insertion/fragment"),
        ("layout", "array3d"),
        ("scene", "grid{size=0.5}"),
    ];
    assert!(field(&growing, &named, "r_squared").parse::<f64>().unwrap() > 0.999);
    let slope = field(&growing, &named, "slope_ns_per_fragment").parse::<f64>().unwrap();
    assert!((slope - (4.0 + 5.0 + 0.2 * 10.0)).abs() < 0.1, "{slope}");

    let deepening = drawn("lfb-figure-20-12", &tables);
    let share = |sort: &str, layers: &str| {
        let named = [("layout", "linearized"), ("shader_stage", "fragment"), ("sort", sort)];
        field(&deepening, &[&named[..], &[("layers", layers)]].concat(), "share_of_sorting")
    };
    assert_eq!(share("unsorted", "60"), "");
    let (at_40, at_60) = (share("insertion", "40"), share("insertion", "60"));
    assert!(at_40.parse::<f64>().unwrap() < 0.5 && at_60.parse::<f64>().unwrap() > 0.5);
    // Depths at another size are no line of resolve time against depth.
    let depths = FIGURES.iter().find(|figure| figure.name() == "sort-depths").unwrap();
    assert!(depths.draw(&tables).unwrap().is_empty());
}

/// The records of the backwards memory allocation paper's experiments alone.
fn allocation(root: &Path) -> Tables {
    read(&[bma::write_run(root, DEVICE)]).unwrap()
}

#[test]
fn tables_1_and_2_have_published_and_measured_numbers() {
    let root = tempfile::tempdir().unwrap();
    let tables = allocation(root.path());
    let speedups = drawn("bma-table-1", &tables);
    let of = |view: &str, interval: &str, column: &str| {
        let named = [("paper_view", view), ("interval", interval), ("shader_stage", "fragment")];
        field(&speedups, &named, column)
    };
    assert_eq!(of("Smoke", "64", "published_speedup"), "2.32");
    // The array of 256 costs 264, that of 64 costs 72.
    let own: f64 = of("Smoke", "64", "speedup").parse().unwrap();
    assert!((own - 264.0 / 72.0).abs() < 0.01, "{own}");
    assert!((of("Power Plant", "512", "speedup").parse::<f64>().unwrap() - 1.0).abs() < 1e-9);
    // Intervals without pixels have no row, here as in the paper.
    assert!(!speedups.csv.rows.iter().any(|row| row[1] == "Atrium" && row[7] == "128"));
    assert!(speedups.markdown().contains("| 128 | – | – | – | 1.68 |"), "{}", speedups.markdown());

    let times = drawn("bma-table-2", &tables);
    let of = |row: &str, max: &str, column: &str| {
        let named = [("paper_view", "Atrium"), ("shader_stage", "compute")];
        field(&times, &[&named[..], &[("row", row), ("max_alloc", max)]].concat(), column)
    };
    assert_eq!(of("OIT (ms)", "max128", "published"), "53.8");
    let (oit, bma) = (of("OIT (ms)", "max128", "median"), of("BMA-OIT (ms)", "max128", "median"));
    let ratio = oit.parse::<f64>().unwrap() / bma.parse::<f64>().unwrap();
    assert!((of("Speedup", "max128", "median").parse::<f64>().unwrap() - ratio).abs() < 1e-9);
    assert_eq!(of("Speedup", "max128", "published"), "1.42");
    assert!(times.markdown().contains("| Total Polys | 279178 | 13468 |"), "{}", times.markdown());
    let named = [("paper_view", "Power Plant"), ("shader_stage", "compute")];
    let named = [&named[..], &[("row", "Wrong pixels (%)"), ("max_alloc", "max256")]].concat();
    let wrong: f64 = field(&times, &named, "median").parse().unwrap();
    assert!((wrong - 100.0 * 22.0 / (96.0 * 54.0)).abs() < 1e-9);
}

#[test]
fn empty_intervals_cost_what_they_cost() {
    let root = tempfile::tempdir().unwrap();
    let output = drawn("bma-overhead", &allocation(root.path()));
    let ratio = |technique: &str, of: &str| {
        let named = [("paper_view", "Atrium"), ("technique", technique), ("of", of)];
        field(&output, &named, "ratio").parse::<f64>().unwrap()
    };
    assert!((ratio("OIT", "published, GTX 670") - 53.8 / 37.6).abs() < 1e-12);
    assert!(ratio("OIT", "ours, fragment") > 1.5 && ratio("BMA-OIT", "ours, fragment") < 1.01);
    // On the power plant the larger array is needed.
    assert!(!output.csv.rows.iter().any(|row| row[0] == "Power Plant"));
    assert!(output.notes[0].contains("151% and 176%"));
}

#[test]
fn sorts_are_compared_interval_by_interval() {
    let root = tempfile::tempdir().unwrap();
    let tables = allocation(root.path());
    let figure = FIGURES.iter().find(|figure| figure.name() == "bma-figure-9").unwrap();
    let outputs = figure.draw(&tables).unwrap();
    assert_eq!(outputs.len(), 3);
    let plant = outputs.iter().find(|output| output.name.contains("powerplant")).unwrap();
    let family = "linked_list, bma-stencil, fragment stage, depth order";
    let named = [("family", family), ("sort", "rbs"), ("interval", "32")];
    let ratio: f64 = field(plant, &named, "ratio").parse().unwrap();
    assert!((ratio - 0.5).abs() < 0.01, "{ratio}");
    // Parts of the resolve are no stages beside it.
    let layouts = FIGURES.iter().find(|figure| figure.name() == "lfb-layouts").unwrap();
    for output in layouts.draw(&tables).unwrap() {
        assert!(!output.csv.text().contains("resolve["), "{}", output.name);
    }
}

#[test]
fn arrays_too_small_are_shown_with_their_pictures() {
    let root = tempfile::tempdir().unwrap();
    let tables = allocation(root.path());
    let figure = FIGURES.iter().find(|figure| figure.name() == "bma-figure-6").unwrap();
    let outputs = figure.draw(&tables).unwrap();
    assert_eq!(outputs.len(), 4);
    let named = [("scene", "smoke"), ("max_frags", "32")];
    assert_eq!(field(&outputs[0], &named, "wrong_px"), "104");
    let smoke = outputs.iter().find(|output| output.name.contains("6-smoke")).unwrap();
    assert_eq!(field(smoke, &[("max_frags", "8")], "block_px"), "2");
    assert_eq!(smoke.csv.rows.len(), 3);
    // A file that is damaged is said to be, and no picture is made up for it.
    let cell = &tables.results.iter().find(|cell| cell.name.technique.ends_with("max8")).unwrap();
    let stem = bma::images(&root.path().join("bma"), &cell.name);
    fs::write(format!("{}.error.png", stem.display()), b"\x89PNG no more").unwrap();
    assert!(matches!(figure.draw(&tables), Err(FigureError::Sidecar { .. })));
    // Where none were kept, shares are drawn all the same.
    fs::remove_dir_all(root.path().join("bma").join("images")).unwrap();
    assert_eq!(figure.draw(&tables).unwrap().len(), 1);
}

#[test]
fn the_claims_of_backwards_memory_allocation_are_decided_by_its_experiments() {
    let root = tempfile::tempdir().unwrap();
    let verdicts = claims::verdicts(&allocation(root.path())).unwrap();
    let verdict = |id: &str| verdicts.iter().find(|verdict| verdict.claim.id == id).unwrap();
    assert_eq!(verdict("bma-up-to-3-scenes").word(), "holds");
    let published = verdict("bma-up-to-3-scenes").published.unwrap();
    assert!((published - 273.6 / 80.9).abs() < 1e-9);
    let published = verdict("bma-table-1-power-plant-32").published.unwrap();
    assert!((published - 3.78).abs() < 1e-9);
    assert_eq!(verdict("bma-stencil-255").word(), "holds");
    assert!(verdict("bma-stencil-255").detail().contains("255"));
    assert_eq!(verdict("bma-256-is-too-few").word(), "holds");
    assert_eq!(verdict("bma-too-small-32").figure(), Some(100.0 * 246.0 / (96.0 * 54.0)));
    assert_eq!(verdict("bma-enough-64").figure(), Some(0.0));
    assert_eq!(verdict("bma-oit-insertion-to-64").word(), "not tested");
    assert!(verdict("bma-oit-insertion-to-64").detail().contains("not measured yet"));
    assert_eq!(verdict("bma-figure-9-merge-64").word(), "does not hold");
    assert_eq!(verdict("bma-figure-9-shell-64").word(), "not tested");
    assert_eq!(verdict("target-grouping-atrium").word(), "holds");
    assert_eq!(verdict("target-empty-interval-smoke").word(), "holds");
    assert_eq!(verdict("target-bma-5").word(), "not tested");
    // Every rule that names a cell of the paper's tables finds the paper's own number there.
    let entries = verdicts.iter().filter(|verdict| verdict.claim.id.starts_with("bma-table-"));
    let mut count = 0;
    for entry in entries {
        let printed = entry.claim.sentence.rsplit(' ').next().unwrap().parse::<f64>().unwrap();
        let published = entry.published.unwrap();
        assert!((published - printed).abs() < 0.01, "{}: {published}", entry.claim.id);
        count += 1;
    }
    assert_eq!(count, 17 + 6);
}

#[test]
fn an_array_s_time_is_over_that_of_one_entry() {
    let root = tempfile::tempdir().unwrap();
    let tables = one_device(root.path());
    let output = drawn("bma-figure-3", &tables);
    let over = |form: &str, store: &str, stage: &str, entries: &str| {
        let line = [("form", form), ("store", store), ("shader_stage", stage)];
        let named = [&line[..], &[("entries", entries)]].concat();
        field(&output, &named, "over_size_1").parse::<f64>().unwrap()
    };
    assert_eq!(over("array-probe", "workgroup", "compute", "1"), 1.0);
    let deepest = over("array-probe", "workgroup", "compute", "32");
    assert!((deepest - probe::slowdown(32) as f64).abs() < 0.01, "{deepest}");
    assert!((over("array-probe-unset", "local", "fragment", "32") - 1.0).abs() < 0.01);
    // The probe is no technique, and in no figure of techniques.
    let others = draw_all(&tables).into_iter().filter(|other| other.name != output.name);
    for other in others {
        assert!(!other.csv.text().contains("array-probe"), "{}", other.name);
    }
    let verdicts = claims::verdicts(&tables).unwrap();
    let verdict = |id: &str| verdicts.iter().find(|verdict| verdict.claim.id == id).unwrap();
    assert_eq!(verdict("bma-local-memory-occupancy").word(), "does not hold");
    assert_eq!(verdict("bma-on-chip-memory-occupancy").word(), "holds");
}

#[test]
fn memory_is_recorded_and_derived() {
    let root = tempfile::tempdir().unwrap();
    let output = drawn("lfb-memory", &chapter(root.path()));
    let of = |layout: &str, column: &str| {
        field(&output, &[("scene", "dragon"), ("layout", layout)], column).parse::<f64>().unwrap()
    };
    let more = of("linked_list", "derived_lfb_bytes_at_16") - of("linked_list", "lfb_bytes");
    assert_eq!(more, 8.0 * of("linked_list", "pool_slots"));
    assert_eq!(of("linearized", "lfb_over_linearized"), 1.0);
    let list = of("linked_list", "lfb_bytes") / of("linearized", "lfb_bytes");
    assert_eq!(of("linked_list", "lfb_over_linearized"), list);
    assert!(output.csv.rows.iter().any(|row| row[6] == "interleaved_lists"));
}

#[test]
fn pools_too_small_are_in_their_own_figure_only() {
    let root = tempfile::tempdir().unwrap();
    let tables = chapter(root.path());
    let output = drawn("lfb-overflow", &tables);
    let of = |layout: &str, percent: &str, policy: &str, column: &str| {
        let named = [("layout", layout), ("pool_percent", percent), ("pool_policy", policy)];
        field(&output, &named, column)
    };
    assert_eq!(of("linked_list", "25", "drop", "repeat_differs_px"), "40");
    assert_eq!(of("linked_list", "25", "grow", "fragments_missing"), "0");
    assert_eq!(of("linked_list", "100", "grow", "over_whole"), "1");
    assert!(of("linked_list", "25", "grow", "over_whole").parse::<f64>().unwrap() > 1.2);
    // A layout that never grows is compared with itself where it has room.
    assert_eq!(of("array3d_nearest", "100", "drop", "over_whole"), "1");
    let markdown = output.markdown();
    assert!(markdown.contains("no: 40 px") && markdown.contains("**yes**"), "{markdown}");
    // The others may take counts from that run, and no times.
    let others = draw_all(&tables).into_iter().filter(|other| other.name != output.name);
    for other in others.filter(|other| !other.name.starts_with("bma-figure-5")) {
        assert!(!other.csv.text().contains("/pool"), "{}", other.name);
        // Advice goes by everything that was measured with room for all.
        let any_run = other.name.starts_with("advise-regret");
        let of_overflow = other.stamps.iter().any(|s| s.run.ends_with("overflow"));
        assert!(any_run || !of_overflow, "{}", other.name);
    }
}

/// A device whose limits the model knows. The records are made up all the same.
const KNOWN_DEVICE: &str = "NVIDIA H200 (test fixture)";

#[test]
fn registers_and_local_memory_are_drawn_against_array_size() {
    let root = tempfile::tempdir().unwrap();
    let run = mechanism::write_run(root.path(), "told", KNOWN_DEVICE, true);
    let output = drawn("mechanism-registers", &read(&[run]).unwrap());
    let of = |sort: &str, array: &str, column: &str| {
        field(&output, &[("sort", sort), ("array", array)], column)
    };
    assert_eq!(
        (of("insertion", "64", "registers"), of("rbs", "8", "registers")),
        ("128".into(), "32".into())
    );
    assert_eq!(
        (of("insertion", "16", "local_bytes"), of("rbs", "64", "local_bytes")),
        ("320".into(), "0".into())
    );
    assert_eq!(of("rbs", "8", "binary_bytes"), "3200");
    // What the driver does not tell is no number.
    assert_eq!(
        (of("rbs", "8", "workgroup_bytes"), of("rbs", "8", "occupancy")),
        (String::new(), String::new())
    );
    let fragments = f64::from(96 * 54 * 8);
    let per_fragment = of("insertion", "8", "ns_per_fragment").parse::<f64>().unwrap();
    assert!((per_fragment - 3000.0 / fragments).abs() < 1e-9, "{per_fragment}");
}

#[test]
fn predictions_stand_beside_what_was_measured() {
    let root = tempfile::tempdir().unwrap();
    let run = mechanism::write_run(root.path(), "told", KNOWN_DEVICE, true);
    let output = drawn("mechanism-occupancy", &read(&[run]).unwrap());
    assert_eq!(output.csv.rows.len(), 2 * mechanism::SIZES.len());
    for row in &output.csv.rows {
        let number = |place: usize| row[place].parse::<f64>().unwrap();
        let (predicted, measured) = (number(8), number(9));
        assert!((predicted / measured - 1.0).abs() < 1e-9, "{row:?}");
    }
    let named = [("sort", "rbs"), ("array", "64")];
    assert_eq!(field(&output, &named, "warps"), "16");
    assert_eq!(field(&output, &named, "predicted"), "4");
    let markdown = output.markdown();
    // The smallest arrays are no predictions.
    assert!(markdown.contains("Error of 6 predictions (all): median 0 %, worst 0 %"), "{markdown}");
    assert!(markdown.contains("rank correlation 1.00"), "{markdown}");
    // Of no change: times of 4/3, 2 and 4 are off by 1/4, 1/2 and 3/4.
    assert!(markdown.contains("of no change with the size: median 50 %, worst 75 %"), "{markdown}");
}

#[test]
fn where_nothing_is_told_or_known_the_figures_say_so() {
    let root = tempfile::tempdir().unwrap();
    let silent = mechanism::write_run(root.path(), "silent", KNOWN_DEVICE, false);
    let tables = read(&[silent]).unwrap();
    let (registers, occupancy) =
        (drawn("mechanism-registers", &tables), drawn("mechanism-occupancy", &tables));
    assert!(registers.markdown().contains("The driver tells nothing of its programs"));
    assert!(occupancy.markdown().contains("Nothing is predicted: the driver tells no registers"));
    for output in [&registers, &occupancy] {
        assert_eq!(field(output, &[("sort", "rbs"), ("array", "64")], "registers"), "");
        output.page().unwrap();
    }
    assert_eq!(field(&occupancy, &[("sort", "rbs"), ("array", "64")], "predicted"), "");
    let unknown = mechanism::write_run(root.path(), "unknown", DEVICE, true);
    let unknown = drawn("mechanism-occupancy", &read(&[unknown]).unwrap());
    let text = unknown.markdown();
    assert!(text.contains("what a processor of test device holds is not known here"), "{text}");
    unknown.page().unwrap();
}

#[test]
fn other_intervals_are_compared_with_powers_of_two() {
    let root = tempfile::tempdir().unwrap();
    let tables = one_device(root.path());
    let output = drawn("bma-intervals", &tables);
    assert_eq!(output.csv.rows.len(), VIEWS.len());
    let cell = [("scene", "planes"), ("view", "front"), ("shader_stage", "fragment")];
    let value = |column: &str| field(&output, &cell, column);
    assert_eq!((value("intervals"), value("bounds")), ("optimal".into(), "4-12-256".into()));
    assert_eq!(value("predicted_ratio"), "0.9");
    let ratio: f64 = value("ratio").parse().unwrap();
    let [ms, usual] = ["ms", "powers_of_two_ms"].map(|c| value(c).parse::<f64>().unwrap());
    assert!((ratio - ms / usual).abs() < 1e-9 && (0.9..1.1).contains(&ratio), "{ratio}");
    // They are no further cell of comparisons between sorts.
    for output in draw_all(&tables).iter().filter(|output| !output.name.starts_with("bma-int")) {
        assert!(!output.csv.text().contains("optimal"), "{}", output.name);
    }
}

#[test]
fn a_claim_without_its_records_is_not_tested() {
    let root = tempfile::tempdir().unwrap();
    let run = write_run(root.path(), "run", DEVICE);
    let path = run.join("run.json");
    let text = fs::read_to_string(&path).unwrap().replace("\"hairball\"", "\"other\"");
    fs::write(&path, text).unwrap();
    let verdicts = claims::verdicts(&read(&[run]).unwrap()).unwrap();
    let verdict = |id: &str| verdicts.iter().find(|verdict| verdict.claim.id == id).unwrap();
    let hairball = verdict("rbs-direction-small-hairball");
    assert_eq!(hairball.word(), "not tested");
    assert!(hairball.detail().contains("hairball, inside-front"), "{}", hairball.detail());
    assert_eq!(verdict("rbs-direction-small").word(), "holds");
}

#[test]
fn one_sort_is_compared_with_the_others() {
    let root = tempfile::tempdir().unwrap();
    let tables = one_device(root.path());
    let outputs = compare(&tables, "rbs").unwrap();
    // Those of all views of both papers; stacks are on its page.
    assert_eq!(outputs.len(), VIEWS.len() + RBS_VIEWS.len() + 3);
    let back = outputs.iter().find(|output| output.name.contains("planes-back")).unwrap();
    let columns = |row: &Vec<String>| (row[1].clone(), row[2].clone(), row[6].clone());
    let faster = ("rbs".to_owned(), "insertion".to_owned(), "faster".to_owned());
    assert!(back.csv.rows.iter().any(|row| columns(row) == faster));
    let error = compare(&tables, "bogo").err().unwrap();
    assert!(matches!(&error, FigureError::Unknown { known, .. } if known.contains("insertion")));
}

#[test]
fn only_what_is_named_is_drawn() {
    let root = tempfile::tempdir().unwrap();
    let tables = one_device(&root.path().join("records"));
    let out = root.path().join("out");
    generate(&tables, &out, Some("pareto-planes-front")).unwrap();
    let names: Vec<String> = files(&out).into_keys().collect();
    assert_eq!(names.len(), 4, "{names:?}");
    let error = generate(&tables, &out, Some("lfb-figure-99")).err().unwrap();
    assert!(error.to_string().contains("rbs-table-2"), "{error}");
}

fn refused(folders: &[PathBuf]) -> String {
    read(folders).unwrap_err().to_string()
}

#[test]
fn damaged_records_are_refused_with_their_place() {
    let root = tempfile::tempdir().unwrap();
    let run = write_run(root.path(), "run", DEVICE);
    let (events, json) = (run.join("events.jsonl"), run.join("run.json"));
    let (good_events, good_json) =
        (fs::read_to_string(&events).unwrap(), fs::read_to_string(&json).unwrap());

    fs::write(&events, good_events.replacen("{\"event\"", "{\"evnt\"", 1)).unwrap();
    assert!(refused(std::slice::from_ref(&run)).contains("events.jsonl:1:"));
    fs::write(
        &events,
        good_events.clone() + "{\"event\":\"failed\",\"cell\":9999999,\"reason\":\"\"}\n",
    )
    .unwrap();
    assert!(refused(std::slice::from_ref(&run)).contains("cell 9999999"));
    fs::write(&events, &good_events).unwrap();

    fs::write(&json, good_json.replacen("\"schema\": 1", "\"schema\": 99", 1)).unwrap();
    assert!(refused(std::slice::from_ref(&run)).contains("schema version 99"));
    fs::write(&json, &good_json).unwrap();

    assert!(refused(&[run.clone(), run.clone()]).contains("given twice"));
    let empty = root.path().join("empty");
    fs::create_dir(&empty).unwrap();
    assert!(refused(&[empty]).contains("no run folder"));
}

#[test]
fn damaged_counts_are_refused() {
    let root = tempfile::tempdir().unwrap();
    let run = write_run(root.path(), "run", DEVICE);
    let path = write_counts(&run);
    let tables = read(&[run]).unwrap();
    let draw = || {
        let figure = FIGURES.iter().find(|figure| figure.name() == "rbs-figure-5").unwrap();
        figure.draw(&tables).map(|outputs| outputs.len())
    };
    assert_eq!(draw().unwrap(), 1);
    oit_image::write_png16_gray(&path, 2, 2, &[1, 2, 3, 4]).unwrap();
    assert!(matches!(draw(), Err(FigureError::Sidecar { .. })));
    fs::write(&path, b"\x89PNG no more").unwrap();
    assert!(matches!(draw(), Err(FigureError::Sidecar { .. })));
}

/// What the documents show and point to is in the repository; that tracked figures are those of the
/// records is for `just check-figures`.
#[test]
fn links_of_the_documents_lead_somewhere() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let docs = fs::read_dir(root.join("docs")).unwrap().map(|entry| entry.unwrap().path());
    let pages = docs.filter(|path| path.extension().is_some_and(|ending| ending == "md"));
    let mut links = 0;
    for page in pages.chain([root.join("README.md")]) {
        let text = fs::read_to_string(&page).unwrap();
        for rest in text.split("](").skip(1) {
            let link = rest.split([')', '#']).next().unwrap();
            if !link.is_empty() && !link.starts_with("http") {
                let target = page.parent().unwrap().join(link);
                assert!(target.exists(), "{}: nothing at {link}", page.display());
                links += 1;
            }
        }
    }
    assert!(links > 5, "{links} links");
}

/// Ways of peeling have a line each; of a stack with exact and other ones a chart of time against error
/// is drawn as well, without the resolve that they do not have.
/// The records of ways of drawing spheres alone.
fn of_spheres(root: &Path) -> Tables {
    spheres::write_run(root, DEVICE);
    read(&[root.to_owned()]).unwrap()
}

#[test]
fn ways_of_drawing_spheres_stand_beside_the_thesis() {
    let root = tempfile::tempdir().unwrap();
    let figure = FIGURES.iter().find(|figure| figure.name() == "spheres-tables").unwrap();
    let tables = of_spheres(root.path());
    let outputs = figure.draw(&tables).unwrap();
    // By its name, which no file of it has.
    let drawn = generate(&tables, &root.path().join("out"), Some("spheres-tables")).unwrap();
    assert_eq!((drawn.len(), drawn[0].files.len()), (1, outputs.len()));
    let of = |name: &str| outputs.iter().find(|o| o.name.starts_with(name)).unwrap();
    // Each table once, whatever sizes of the virus there are, and none over another.
    assert_eq!(outputs.len(), 6);
    let stack = of("spheres-table-3-1-");
    let front = [("row", "per-fragment depth"), ("column", "front-to-back")];
    assert_eq!(field(stack, &front, "published"), "5.5");
    assert_eq!(field(stack, &front, "median"), "5.000002");
    let outputs_of = of("spheres-table-3-4-");
    let ms = |row: &str| field(outputs_of, &[("row", row)], "median").parse::<f64>().unwrap();
    assert!((ms("64 byte") / ms("4 byte") - 16.0).abs() < 0.01);
    assert_eq!(field(outputs_of, &[("row", "12 byte")], "verdict"), "approximate");
}

#[test]
fn claims_on_work_are_decided_by_what_was_counted() {
    let root = tempfile::tempdir().unwrap();
    let verdicts = claims::verdicts(&of_spheres(root.path())).unwrap();
    let verdict = |id: &str| verdicts.iter().find(|verdict| verdict.claim.id == id).unwrap();
    let figure = |id: &str| verdict(id).figure().unwrap_or_else(|| panic!("{:?}", verdict(id)));
    // An early test spares nine tenths, on both scenes of the claim's that are there.
    let once = verdict("spheres-once-a-pixel");
    assert_eq!((once.word(), once.figure()), ("does not hold", Some(0.1)));
    assert_eq!(figure("spheres-all-pass"), 1.0);
    // By another count of the same pass, and by pixels.
    assert_eq!(figure("spheres-larger-sets"), 200.0);
    assert_eq!(figure("spheres-tessellated-too-many"), 2.0);
    let pixels = f64::from(synthetic::WIDTH_PX * synthetic::HEIGHT_PX);
    let fragments = spheres::FRAGMENTS_OF_SPHERE as f64;
    assert_eq!(figure("spheres-stack-overdraw"), fragments * 10_000.0 / pixels);
    // The preprocessing dispatch and the pass that shades are other stages.
    let load = fragments / (fragments + 2.0 + 2.0 + 0.02);
    assert!((figure("spheres-fragment-load") - load).abs() < 1e-12);
    // Bytes over what could be written in the median time of the stage.
    let millions = |ns: f64| fragments * 64.0 * 1e6 / (spheres::ATTACHMENT_BYTES_PER_S * ns / 1e9);
    let bound = figure("spheres-output-units-bound");
    assert!((bound / millions(192_002.0) - 1.0).abs() < 1e-9, "{bound}");
    // Stages that are joined are added up sample by sample.
    let (all, four) = (192_002.0 + 2_000.0, 12_002.0 + 2_000.0);
    assert!((figure("spheres-output-with-shading") - all / four).abs() < 1e-12);
    // No view from inside, and the paper has no counts.
    assert_eq!(verdict("spheres-culling-inside").word(), "not tested");
    assert_eq!(verdict("spheres-overdraw").published, None);
}

#[test]
fn spheres_are_drawn_against_their_number_until_a_way_stops() {
    let root = tempfile::tempdir().unwrap();
    let output = drawn("spheres-scale", &of_spheres(root.path()));
    let of = |technique: &str, spheres: &str, column: &str| {
        field(&output, &[("technique", technique), ("spheres", spheres)], column)
    };
    let per_mesh = "spheres/per-mesh/geometry/per-center/sphere-depth/discard/bytes4";
    assert_eq!(of(per_mesh, "16000000", "reason"), "its list has no room");
    assert!(output.notes.iter().any(|note| note.contains("its list has no room")));
    assert_eq!(of(per_mesh, "1000000", "reason"), "");
    let ms = |n: &str| of("spheres/compute/bytes4", n, "total_ms").parse::<f64>().unwrap();
    assert!(ms("16000000") > ms("1000000"));
}

#[test]
fn peeling_is_drawn_against_the_number_of_layers() {
    let root = tempfile::tempdir().unwrap();
    peel::write_run(root.path(), DEVICE);
    let tables = read(&[root.path().to_owned()]).unwrap();
    let output = drawn("peel-passes", &tables);
    assert_eq!(output.csv.rows.len(), 9);
    let of = |method: &str, fragments: &str, column: &str| {
        field(&output, &[("method", method), ("fragments", fragments)], column)
    };
    assert_eq!(of("depth_peel", "16", "median_ns"), "1600002");
    assert_eq!(of("dual_peel", "16", "median_ns"), "800002");
    assert_eq!(of("dual_peel", "16", "verdict_is_exact"), "true");
    assert_eq!(of("dual_peel_forward11", "16", "max_error"), "0.5");
    let pareto = FIGURES.iter().find(|figure| figure.name() == "pareto").unwrap();
    let outputs = pareto.draw(&tables).unwrap();
    assert_eq!(outputs.len(), 3);
    let verdicts = claims::verdicts(&tables).unwrap();
    let said = |id: &str| verdicts.iter().find(|verdict| verdict.claim.id == id).unwrap();
    let twice = said("peel-two-layers-at-a-time").figure().unwrap();
    assert!((twice - 2.0).abs() < 1e-4, "{twice}");
    assert_eq!(said("peel-forward11-slower-in-series").word(), "does not hold");
    assert_eq!(said("peel-r11g11b10-below-32").figure(), Some(16.0));
    assert_eq!(said("peel-r11g11b10-below-32").word(), "does not hold");
    assert_eq!(said("peel-r11g11b10-beyond-32").word(), "holds");
    assert_eq!(said("peel-memory-bounded").figure(), Some(1.0));
    assert_eq!(said("peel-forward32-fine").word(), "not tested");
    let resolve = |output: &Output| field(output, &[("technique", "dual_peel")], "resolve_ms");
    assert!(outputs.iter().all(|output| resolve(output).is_empty()));
    // Without three depths there is nothing to draw a line through.
    let others = tempfile::tempdir().unwrap();
    lfb::write_runs(others.path(), DEVICE);
    let figure = FIGURES.iter().find(|figure| figure.name() == "peel-passes").unwrap();
    assert!(figure.draw(&read(&[others.path().to_owned()]).unwrap()).unwrap().is_empty());
}

/// Times to compile are of runs that say what cache they had: one that found it empty, and one that found
/// what was left there.
#[test]
fn programs_are_compiled_and_found_in_the_cache() {
    let root = tempfile::tempdir().unwrap();
    let figure = FIGURES.iter().find(|figure| figure.name() == "rbs-compile").unwrap();
    let draw = || figure.draw(&read(&[root.path().to_owned()]).unwrap()).unwrap();
    compile::write_run(&root.path().join("compiled"), DEVICE, false, Some("--cache"));
    // One run alone, or one whose caches are anyone's guess, is no comparison.
    compile::write_run(&root.path().join("guess"), DEVICE, true, None);
    assert!(draw().is_empty());
    compile::write_run(&root.path().join("cached"), DEVICE, true, Some("--cache=folder"));
    let output = draw().remove(0);
    assert_eq!(output.csv.rows.len(), 6);
    let of = |column: &str| field(&output, &[("sort", "rbs"), ("array", "32")], column);
    assert_eq!((of("compiled_ms"), of("cached_ms")), ("32".to_owned(), "0.32".to_owned()));
    assert_eq!((of("runs_compiled"), of("runs_cached")), ("1".to_owned(), "1".to_owned()));
    assert!(output.tables[0].rows.iter().all(|row| row[4].text == "100"));
    assert_eq!(output.stamps.len(), 2);
}

/// Of approximate methods all errors are told, alpha apart, and maps of them are drawn where pictures were
/// kept; claims on errors are decided by them.
#[test]
fn approximate_methods_are_told_by_their_errors() {
    let root = tempfile::tempdir().unwrap();
    approx::write_run(root.path(), DEVICE);
    let tables = read(&[root.path().to_owned()]).unwrap();
    let outputs = |name: &str| {
        let figure = FIGURES.iter().find(|figure| figure.name() == name).unwrap();
        figure.draw(&tables).unwrap()
    };
    let accuracy = outputs("approx-accuracy");
    assert_eq!(accuracy.len(), 3);
    let of =
        |technique: &str, column: &str| field(&accuracy[0], &[("technique", technique)], column);
    assert_eq!(
        (of("k_nearest/k8", "rmse"), of("k_nearest/k8", "ssim")),
        ("0.04".into(), "0.96".into())
    );
    let psnr: f64 = of("moments8", "psnr_db").parse().unwrap();
    assert!((psnr - 33.979_400_1).abs() < 1e-6, "{psnr}");
    assert_eq!(of("k_nearest/k8", "max_alpha_error"), "0.25");
    // What is left of an exact picture is rounding, and nothing to divide a signal by.
    let exact = "linked_list/bma-list/network+rbs/compute/peak";
    assert_eq!((of(exact, "rmse"), of(exact, "psnr_db")), ("0".into(), String::new()));
    let errors = outputs("approx-errors");
    assert_eq!(errors.len(), 1);
    assert!(errors[0].name.starts_with("approx-errors-atrium"));
    assert_eq!(errors[0].csv.rows.len(), 8);
    let verdicts = claims::verdicts(&tables).unwrap();
    let said = |id: &str| verdicts.iter().find(|verdict| verdict.claim.id == id).unwrap();
    for (id, word) in [
        ("approx-hybrid-beats-k-nearest", "holds"),
        ("approx-nearest-beat-first", "holds"),
        ("approx-stochastic-root", "holds"),
        ("approx-moments-8-beat-4", "does not hold"),
        ("approx-hybrid-alpha", "holds"),
        ("approx-weighted-opaque", "not tested"),
    ] {
        assert_eq!(said(id).word(), word, "{id}: {}", said(id).detail());
    }
    let exponent = said("approx-stochastic-root").figure().unwrap();
    assert!((exponent + 0.5).abs() < 1e-9, "{exponent}");
    // What is known is no quotation.
    let text = claims::markdown(&verdicts, &tables);
    assert!(text.contains("Known: More moments, less error. (M"));
    assert!(!text.contains("“More moments"));
}

/// Every word of the rule, from the record alone; pictures of what broke; and nothing of such a run in any
/// other figure.
#[test]
fn what_became_of_each_technique_in_each_case() {
    let root = tempfile::tempdir().unwrap();
    stability::write_run(&root.path().join("stability"), DEVICE);
    let tables = read(&[root.path().to_owned()]).unwrap();
    let figure = FIGURES.iter().find(|figure| figure.name() == "stability").unwrap();
    let outputs = figure.draw(&tables).unwrap();
    assert_eq!(outputs.len(), 2);
    let (table, breaks) = (&outputs[0], &outputs[1]);
    for (scene, view, technique, word) in stability::CELLS {
        if word.is_empty() {
            continue;
        }
        let named = [("scene", *scene), ("view", *view), ("cell", *technique)];
        assert_eq!(field(table, &named, "word"), *word, "{scene} {technique}");
    }
    // Frames of a path are one case, and its worst frame counts; pools are cases of their technique.
    let columns = &table.tables[0].columns;
    let cases = [
        "technique",
        "stack, count 8",
        "stack, count 8, pool 50 %, drops",
        "stack, count 8, shuffle 1",
        "stack, count 9000",
        "shells, drift, frames",
        "nonfinite, kind removed",
        "nonfinite, kind nan",
        "nonfinite, kind huge",
    ];
    assert_eq!(columns, &cases);
    let row = |name: &str| {
        let mut rows = table.tables[0].rows.iter();
        let row = rows.find(|row| row[0].text == name).unwrap_or_else(|| panic!("{name}"));
        row.iter().skip(1).map(|value| value.text.as_str()).collect::<Vec<_>>()
    };
    let sorted = row("linked_list/bma-list/insertion/compute");
    assert_eq!(sorted[..4], ["right", "varies 31 px", "right", "refused [1]"]);
    let weighted = row("weighted");
    assert_eq!((weighted[0], weighted[4]), ("off 20 px, 0.125", "flickers 7 px, 0.125"));
    assert_eq!(row("hybrid")[4], "steady 0.002");
    assert_eq!(row("depth_peel")[0], "broke [2]");
    assert_eq!(row("depth_peel")[3], "wrong 5 px, 0.750 [3]");
    let markdown = table.markdown();
    for reason in ["[1] 9000 fragments on one pixel.", "[2] the worker", "[3] 5 wrong pixels."] {
        assert!(markdown.contains(reason), "{reason}");
    }
    assert!(markdown.contains("**lost 6 px, 0.500**") && !markdown.contains("**off"));
    // Wrong, lost, not finite and varying: their pictures were kept.
    assert_eq!(breaks.csv.rows.len(), 4);
    for figure in FIGURES.iter().filter(|figure| figure.name() != "stability") {
        assert!(figure.draw(&tables).unwrap().is_empty(), "{}", figure.name());
    }
    // A right picture that is damaged is said to be.
    let images = root.path().join("stability").join("images");
    let right = fs::read_dir(&images).unwrap().map(|entry| entry.unwrap().path());
    let right = right.into_iter().find(|path| path.to_string_lossy().ends_with(".right.png"));
    fs::write(right.unwrap(), b"\x89PNG no more").unwrap();
    assert!(matches!(figure.draw(&tables), Err(FigureError::Sidecar { .. })));
    fs::remove_dir_all(images).unwrap();
    assert_eq!(figure.draw(&tables).unwrap().len(), 1);
}

#[test]
fn a_flight_is_drawn_frame_by_frame() {
    let root = tempfile::tempdir().unwrap();
    flight::write_run(&root.path().join("flight"), DEVICE);
    let tables = read(&[root.path().to_owned()]).unwrap();
    let seven = drawn("bma-figure-7", &tables);
    assert_eq!(seven.csv.rows.len(), 4 * 3);
    let base = "linked_list/base/insertion_merge64/fragment/max64/ties-depth";
    let at = |frame, column| field(&seven, &[("frame", frame), ("technique", base)], column);
    assert_eq!((at("0", "total_ms"), at("30", "resolve_ms")), ("20".to_owned(), "40".to_owned()));
    assert_eq!((at("20", "exact"), at("30", "exact")), ("false".to_owned(), "true".to_owned()));
    assert_eq!((at("20", "peak"), at("20", "px_65_128")), ("99".to_owned(), "5".to_owned()));
    assert_eq!((at("0", "px_1_8"), at("0", "px_33_64")), ("80".to_owned(), "80".to_owned()));
    assert!(seven.notes[1].contains("too small for some pixels of 1 of the frames"));
    // 10 over 7 on every frame.
    assert!(seven.markdown().contains("| 1.43 |"), "{}", seven.markdown());
    let eight = drawn("bma-figure-8", &tables);
    let deep = [("frame", "20"), ("from_fragments", "65")];
    assert_eq!(field(&eight, &deep, "pixels"), "5");

    // Frames are no views of other figures, and the claims that are of frames find them.
    let outputs = draw_all(&tables);
    assert_eq!(outputs.len(), 2, "{:?}", outputs.iter().map(|o| &o.name).collect::<Vec<_>>());
    let verdicts = claims::verdicts(&tables).unwrap();
    let said = |id: &str| verdicts.iter().find(|verdict| verdict.claim.id == id).unwrap().word();
    assert_eq!(said("bma-flythrough-in-all-views"), "holds");
    assert_eq!(said("bma-flythrough-factor"), "holds");
    for output in [seven, eight] {
        let page = output.page().unwrap();
        let boxes = page.text_boxes().unwrap();
        for (index, (a, first)) in boxes.iter().enumerate() {
            for (b, second) in &boxes[index + 1..] {
                let apart = a[2] <= b[0] || b[2] <= a[0] || a[3] <= b[1] || b[3] <= a[1];
                assert!(apart, "{}: {first} lies on {second}", output.name);
            }
        }
    }
}

/// The records of sorts at one depth alone.
fn depths(root: &Path) -> Tables {
    rbs::write_run(&root.join("rbs"), DEVICE);
    read(&[root.to_owned()]).unwrap()
}

#[test]
fn sorts_are_drawn_over_the_floor_of_their_layout() {
    let root = tempfile::tempdir().unwrap();
    let output = drawn("sort-deep", &depths(root.path()));
    let family = |capture: &str| format!("{capture}, bma-list, compute stage, total order");
    let of = |capture: &str, sort: &str, depth: &str| {
        let family = family(capture);
        let named = [("family", family.as_str()), ("sort", sort), ("fragments", depth)];
        field(&output, &named, "over_passthrough").parse::<f64>().unwrap()
    };
    assert!((of("linearized", "network_merge", "512") - (1.2 + 512.0 / 200.0)).abs() < 1e-3);
    assert!((of("interleaved", "network", "64") - 1.16).abs() < 1e-3);
    // The floor is no competitor, what sorts nothing is not exact, and the fastest is marked.
    assert!(
        !output.csv.rows.iter().any(|row| ["passthrough", "unsorted"].contains(&row[1].as_str()))
    );
    let markdown = output.markdown();
    assert!(markdown.contains("**2.32**") && !markdown.contains("**3.76**"), "{markdown}");
}

#[test]
fn merges_and_blocks_are_compared_with_the_paper_s() {
    let root = tempfile::tempdir().unwrap();
    let output = drawn("rbs-merge", &depths(root.path()));
    let of = |question: &str, sort: &str, depth: &str| {
        let family = "linearized, bma-list, compute stage, total order";
        let named =
            [("question", question), ("family", family), ("sort", sort), ("fragments", depth)];
        field(&output, &named, "over_rbs").parse::<f64>().unwrap()
    };
    let rbs = |n: f64| 1.5 + n / 30.0;
    let heap = (10.0 + 1024.0 / 45.0) / rbs(1024.0);
    assert!((of("merging blocks of 32", "rbs_heap", "1024") - heap).abs() < 1e-3);
    assert_eq!(of("merging blocks of 32", "rbs", "512"), 1.0);
    let eight = (1.5 + 256.0 / 12.0) / rbs(256.0);
    assert!((of("fragments of a block", "rbs8", "256") - eight).abs() < 1e-3);
    assert!(of("sorting the blocks", "network_merge32", "128") < 1.0);
    // One block is not merged.
    assert!(!output.csv.rows.iter().any(|row| row[4] == "32"));
}

#[test]
fn registers_stand_beside_times() {
    let root = tempfile::tempdir().unwrap();
    let output = drawn("rbs-registers", &depths(root.path()));
    assert_eq!(output.csv.rows.len(), 6 * 3);
    let of = |sort: &str, depth: &str, column: &str| {
        field(&output, &[("sort", sort), ("fragments", depth)], column)
    };
    assert_eq!(of("insertion", "16", "local_bytes"), "128");
    assert_eq!(of("rs", "32", "local_bytes"), "0");
    assert_eq!(of("rs_inner", "8", "binary_bytes"), "4000");
    assert_eq!(of("rs", "32", "compile_ms"), "64");
    let ns = of("rs", "16", "ns_per_fragment").parse::<f64>().unwrap();
    assert!((ns - 50_000.0 * 0.4 / f64::from(96 * 54)).abs() < 1e-3, "{ns}");
}

#[test]
fn fragments_of_128_bits_stand_beside_those_of_64() {
    let root = tempfile::tempdir().unwrap();
    rbs::write_fragments(&root.path().join("run"), DEVICE);
    let output = drawn("rbs-fragments", &read(&[root.path().to_owned()]).unwrap());
    assert_eq!(output.csv.rows.len(), 3 + 3 + 2);
    let of = |sort: &str, sorted: &str, column: &str| {
        field(&output, &[("sort", sort), ("sorted", sorted)], column)
    };
    assert_eq!(of("insertion", "128 bits, whole", "resolve_over_64_bits"), "3");
    assert_eq!(of("insertion", "128 bits, by index", "resolve_over_64_bits"), "1.5");
    assert_eq!(of("rbs", "128 bits, by index", "verdict"), "slower");
    assert_eq!(of("network", "128 bits, by index", "verdict"), "same");
    assert_eq!(of("rbs", "64 bits", "resolve_ms"), "0.2");
    assert_eq!(of("rbs", "64 bits", "resolve_over_64_bits"), "");
    let markdown = output.markdown();
    assert!(markdown.contains("0.50 (0.50 to 0.50)"), "{markdown}");
    assert!(markdown.contains("1.10 (1.10 to 1.10)"), "{markdown}");
}

#[test]
fn cuda_stands_beside_compute() {
    let root = tempfile::tempdir().unwrap();
    let output = drawn("cuda-resolve", &depths(root.path()));
    assert_eq!(output.csv.rows.len(), 2 * rbs::DEPTHS.len());
    let of =
        |sort: &str, column: &str| field(&output, &[("sort", sort), ("fragments", "64")], column);
    assert_eq!(of("insertion", "verdict"), "faster");
    assert!((of("rbs", "cuda_over_compute").parse::<f64>().unwrap() - 1.25).abs() < 1e-3);
}

#[test]
fn claims_on_depths_and_programs_are_decided() {
    let root = tempfile::tempdir().unwrap();
    let verdicts = claims::verdicts(&depths(root.path())).unwrap();
    let verdict = |id: &str| verdicts.iter().find(|verdict| verdict.claim.id == id).unwrap();
    for (id, word) in [
        ("rbs-listing-2", "holds"),
        ("rbs-listing-2-dynamic", "holds"),
        ("rbs-inner-fewer-instructions", "holds"),
        ("rbs-compile-time", "holds"),
        ("rbs-outer-unrolled", "holds"),
        ("rbs-blocks-of-32", "holds"),
        ("rbs-linear-search", "holds"),
        ("rbs-heap-for-large-k", "holds"),
        ("rbs-hierarchical-for-large-k", "does not hold"),
        ("rbs-one-pixel-many-threads", "holds"),
        ("target-depth-64-linearized", "holds"),
        ("target-depth-512-interleaved", "holds"),
        ("target-rbs-512-linearized", "holds"),
        ("target-rbs-scenes", "not tested"),
    ] {
        assert_eq!(verdict(id).word(), word, "{id}: {}", verdict(id).detail());
    }
    let said = verdict("target-depth-512-linearized").detail();
    assert!(said.contains("512 cooperative16 2.32"), "{said}");
    assert_eq!(verdict("rbs-listing-2-dynamic").figure(), Some(64.0));
}

#[test]
fn the_ledger_of_register_based_block_sort_finds_the_paper_s_numbers() {
    let root = tempfile::tempdir().unwrap();
    let verdicts = claims::verdicts(&depths(root.path())).unwrap();
    let mut count = 0;
    for entry in verdicts.iter().filter(|verdict| verdict.claim.id.starts_with("rbs-table-1-")) {
        let printed = entry.claim.sentence.rsplit(' ').next().unwrap().parse::<f64>().unwrap();
        let published = entry.published.unwrap();
        // Table 2 has rounded times, of which Table 1 was not made.
        assert!((published - printed).abs() < 0.1, "{}: {published}", entry.claim.id);
        count += 1;
    }
    assert_eq!(count, 40);
    let published = |id: &str| {
        let entry = verdicts.iter().find(|verdict| verdict.claim.id == id).unwrap();
        entry.published.unwrap_or_else(|| panic!("{id} has no figure of the paper"))
    };
    assert!((published("rbs-up-to-1.7") - 183.0 / 109.0).abs() < 1e-9);
    // The power plant's first view: 26 ms less 22 ms with counts and without.
    assert!(published("rbs-counts-cost") > 1.0 && published("rbs-capture-constant") < 1.25);
    assert!(published("rbs-fastest-overall") > 1.0 && published("rbs-best-case-cuda") > 1.0);
    assert_eq!(published("rbs-global-particularly"), 0.5);
}

/// The page's row that begins so, of all tables.
fn page_rows<'a>(markdown: &'a str, start: &str) -> Vec<&'a str> {
    markdown.lines().filter(|line| line.starts_with(start)).collect()
}

#[test]
fn one_sort_is_compared_on_one_page() {
    let root = tempfile::tempdir().unwrap();
    let run = compared::write_run(root.path(), DEVICE);
    let tables = read(&[run]).unwrap();
    let mut pages = compare_pages(&tables, "network").unwrap();
    assert_eq!(pages.len(), 1);
    let page = pages.remove(0);
    let text = &page.markdown;
    assert_eq!(page.output.name, "compare-network");
    for heading in [
        "What it is",
        "Correct or not",
        "Time per interval",
        "Registers, spill and size",
        "Time to compile",
        "Effect of the order of submission",
        "Whole frames",
    ] {
        assert!(text.contains(&format!("## {heading}\n")), "{heading}\n{text}");
    }
    assert!(text.contains("every list was sorted") && text.contains("a made-up citation"));
    // Its cells: 2 depths of 3 orders, and a scene.
    assert!(text.contains("the oracle: 7 exact."), "{text}");
    // It was made twice as fast as insertion, and as fast as rbs; the wrong one has no time.
    let insertion = page_rows(text, "| insertion | ")[0];
    assert_eq!(insertion.matches("**0.500 [0.500, 0.500] faster**").count(), 2, "{insertion}");
    let rbs = page_rows(text, "| rbs | ")[0];
    assert_eq!(rbs.matches("1.000 [1.000, 1.000] same").count(), 2, "{rbs}");
    assert!(page_rows(text, "| heap | ")[0].contains("wrong"), "{text}");
    // Of programs what is told, and of the others nothing.
    assert!(text.contains("| network | 20 / 0 / – / 2000 | 28 / 0 / – / 2800 |"), "{text}");
    assert!(text.contains("| insertion | – / – / – / – |"), "{text}");
    assert!(text.contains("| network | 2.00 | 2.00 (cache) |"), "{text}");
    // In reverse it takes three times as long.
    let reverse = page_rows(text, "| network | back to front |")[0];
    assert_eq!(reverse.matches("3.000 [3.000, 3.000] slower").count(), 2, "{reverse}");
    // The scene: half of the resolve, and less of the frame.
    let scene = page_rows(text, "| insertion | 0.200 | 1.20 |");
    assert!(scene.len() == 1 && scene[0].contains("0.917"), "{scene:?}\n{text}");
    assert!(text.contains("| network+rbs_hier | 0.100 | 1.10 |"), "{text}");
    page.write(root.path()).unwrap();
    let written = fs::read_to_string(root.path().join("compare-network.md")).unwrap();
    assert_eq!(written, *text);
    assert!(root.path().join("compare-network.svg").exists());
    let missing = compare_pages(&tables, "shell").err().unwrap();
    assert!(missing.to_string().contains("shell"), "{missing}");
    assert_eq!(compare(&tables, "network").unwrap().len(), 1);
}

#[test]
fn work_is_set_against_time_and_bandwidth() {
    let root = tempfile::tempdir().unwrap();
    work::write_run(&root.path().join("measured"), DEVICE, true);
    let output = drawn("work", &read(&[root.path().to_owned()]).unwrap());
    for (method, fragments) in work::METHODS {
        let of = |stage, column| field(&output, &[("technique", method), ("stage", stage)], column);
        assert_eq!(of("draw", "fragment_invocations"), fragments.to_string());
        let bytes = fragments * work::BYTES_PER_FRAGMENT;
        assert_eq!(of("draw", "attachment_bytes_at_most"), bytes.to_string());
        let share: f64 = of("draw", "share_of_bandwidth").parse().unwrap();
        let expected = bytes as f64 * 1e9 / work::DRAW_NS as f64 / work::BEST_BYTES_PER_S;
        assert!((share / expected - 1.0).abs() < 1e-9, "{share} {expected}");
        let of_attachments: f64 = of("draw", "share_of_attachment_bandwidth").parse().unwrap();
        assert!((of_attachments / share - 2.0).abs() < 1e-9, "measured at half");
        let per_fragment: f64 = of("draw", "ns_per_fragment").parse().unwrap();
        assert!((per_fragment - work::DRAW_NS as f64 / *fragments as f64).abs() < 1e-9);
        // The whole frame has the dispatch too, and its time.
        assert_eq!(of("total", "compute_invocations"), "512");
        let whole: f64 = of("total", "share_of_bandwidth").parse().unwrap();
        assert!(whole < share, "{whole} {share}");
        assert_eq!(of("resolve", "ns_per_fragment"), "");
    }
    // Without a measured bandwidth there is no share, and all else stays.
    let root = tempfile::tempdir().unwrap();
    work::write_run(&root.path().join("unmeasured"), DEVICE, false);
    let output = drawn("work", &read(&[root.path().to_owned()]).unwrap());
    let named = [("technique", "dual_peel"), ("stage", "draw")];
    assert_eq!(field(&output, &named, "share_of_bandwidth"), "");
    assert_eq!(field(&output, &named, "fragment_invocations"), "60000");
}
