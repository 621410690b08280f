# The commands of this project. `just --list` shows them; `just reproduce` and `just test` need
# nothing but Rust, and set the rest up themselves.

set shell := ["bash", "-euo", "pipefail", "-c"]
set ignore-comments

# Mesa's layers complain where it is not set, as on a server.
export XDG_RUNTIME_DIR := env("XDG_RUNTIME_DIR", "/tmp")

target := env("CARGO_TARGET_DIR", "target")
oit := target / "release/oit"
paper_figures := target / "figures/paper-figures"
analysis := target / "figures/analysis"
recorded := "experiments/recorded"

# List the recipes.
default:
    @just --list --unsorted

# Look for a Vulkan device; install Mesa's software one with apt where there is none.
setup:
    @./setup.sh

# Measure the quick profile of every experiment, verify every cell, draw the figures.
reproduce: setup build build-figures
    #!/usr/bin/env bash
    set -euo pipefail
    run=runs/$(date -u +%Y%m%dT%H%M%SZ)
    # A wrong or failed cell does not keep the others from being drawn, but the recipe fails in the end.
    status=0
    {{ oit }} sweep experiments/*.toml --profile quick --out "$run" || status=$?
    {{ analysis }} tables "$run" --out "$run/tables"
    {{ paper_figures }} --records {{ recorded }} --records "$run" --out paper_figures/out/local
    {{ paper_figures }} verdicts --records {{ recorded }} --records "$run"
    echo "Measurements: $run, as tables in $run/tables"
    echo "Figures:      paper_figures/out/local/index.md"
    exit "$status"

# All tests, the doc tests included.
test: setup
    # The figures need polars: a light profile, and its own build.
    cargo test --locked --profile figures -p analysis -p paper_figures
    cargo test --locked

# Run experiments: `just sweep experiments/sorts.toml --profile full --device vulkan:0`.
[positional-arguments]
sweep *ARGS: build
    @{{ oit }} sweep "$@"

# Check one sort, measure it against others, and write its page: `just compare network --against all`.
# With `--trace FILE.oitt` its CPU twin is compared on captured fragments; that needs no GPU.
[positional-arguments]
compare STRATEGY *ARGS: setup build build-figures
    #!/usr/bin/env bash
    set -euo pipefail
    run=runs/compare-$1-$(date -u +%Y%m%dT%H%M%SZ)
    {{ oit }} compare "$@" --out "$run"
    echo "Measurements: $run"
    # A trace leaves no run to draw: its page is among the measurements.
    if [ -e "$run/run.json" ]; then
        {{ paper_figures }} compare "$run" --sort "$1" --out "paper_figures/out/local/compare-$1"
        echo "Page:         paper_figures/out/local/compare-$1"
    fi

# Measure one view by exact and approximate techniques, and draw time against error and memory:
# `just pareto scenes/atrium.toml --view rbs-v2`.
[positional-arguments]
pareto SCENE *ARGS: setup build build-figures
    #!/usr/bin/env bash
    set -euo pipefail
    name=$(basename "$1" .toml)-$(date -u +%Y%m%dT%H%M%SZ)
    {{ oit }} pareto "$@" --out "runs/pareto-$name"
    {{ paper_figures }} --records "runs/pareto-$name" --out "paper_figures/out/local/pareto-$name" --only pareto
    echo "Measurements: runs/pareto-$name"
    echo "Chart:        paper_figures/out/local/pareto-$name"

# Name the cheapest technique that a scene needs: `just advise scenes/smoke.toml --max-error 2/255`.
[positional-arguments]
advise *ARGS: build
    @{{ oit }} advise "$@"

# Where methods fail: measure the stability experiments, and write a table of techniques and cases for
# each, with pictures of what broke. Arguments are those of `just sweep`:
# `just stability --profile full --device vulkan:0`.
[positional-arguments]
stability *ARGS: setup build build-figures
    #!/usr/bin/env bash
    set -euo pipefail
    run=runs/stability-$(date -u +%Y%m%dT%H%M%SZ)
    # That a cell is wrong or failed is what is asked here: it is drawn, and no error of the recipe's,
    # as long as there is a record.
    {{ oit }} sweep experiments/stability-*.toml --out "$run" "$@" || test -e "$run/stability-mesh/run.json"
    {{ paper_figures }} --records "$run" --out paper_figures/out/local/stability --only stability
    echo "Measurements: $run"
    echo "Tables:       paper_figures/out/local/stability"

# Draw the tracked figures from the recorded measurements alone.
figures: build-figures
    rm -rf paper_figures/out/recorded
    {{ paper_figures }} --records {{ recorded }} --out paper_figures/out/recorded

# Fail if the tracked figures are not, byte for byte, what the recorded measurements give.
check-figures: build-figures
    #!/usr/bin/env bash
    set -euo pipefail
    fresh=$(mktemp -d)
    trap 'rm -rf "$fresh"' EXIT
    {{ paper_figures }} --records {{ recorded }} --out "$fresh"
    if ! diff -rq paper_figures/out/recorded "$fresh"; then
        echo "The figures differ from the recorded measurements: run 'just figures'." >&2
        exit 1
    fi

# Each claim of the papers, and whether the recorded measurements bear it out.
claims: build-figures
    @{{ paper_figures }} verdicts --records {{ recorded }}

# Fetch the large models (the Stanford dragon) into an ignored folder.
assets:
    ./scenes/assets.sh

# Benchmarks of the CPU twins.
[positional-arguments]
bench *ARGS:
    cargo bench --locked "$@"

# Fail if generated text (tables in the documents, sorting networks) is not up to date.
check-generated:
    cargo run --locked --bin oit -- generate --check

# Format all code.
fmt:
    cargo fmt --all

# Formatting, clippy, dependencies (cargo-deny) and spelling (typos). Needs the last two installed.
lint:
    cargo fmt --all --check
    # One pass over everything: a check generates no code, so the figures need no profile of their own.
    cargo clippy --locked --workspace --all-targets -- -D warnings
    # Not its advisories: their database is fetched from GitHub, which not every machine may reach.
    cargo deny --locked --log-level error check bans licenses sources
    typos

[private]
build:
    cargo build --locked --release -p oit

[private]
build-figures:
    # Both packages, as in `test`: with one alone polars would have other features, and be built again.
    cargo build --locked --profile figures -p analysis -p paper_figures
