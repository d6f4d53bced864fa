# Everything happens through these targets; each does the set-up it needs, and redoes it only when its sources changed.
# Needed on the machine: Rust (see rust-version in Cargo.toml), Python 3.10 or newer, make.

PYTHON ?= python3
PYTEST_ARGS ?=
STRESS_ARGS ?=

VENV := .venv
BIN := $(VENV)/bin
STAMPS := $(VENV)/stamps
EXTENSION := python/rustchain/_rustchain.abi3.so
# The library of FMUs, by the names of shared libraries of the operating system.
SYSTEM := $(shell uname -s)
ENDING := $(if $(filter Linux,$(SYSTEM)),so,$(if $(filter Darwin,$(SYSTEM)),dylib,dll))
FMI_LIBRARY := python/rustchain/fmi/rustchain_fmi.$(ENDING)
# Command of cargo, the folder of all targets, and that of this target in it.
build-fmu = $(1) --release --locked --quiet --lib --features fmu --target-dir $(2) -- -C strip=symbols && \
	cp $(2)/$(3)release/$(if $(filter dll,$(ENDING)),,lib)rustchain.$(ENDING) $(FMI_LIBRARY)
RUST_SOURCES := $(shell find src -name '*.rs') Cargo.toml Cargo.lock
PIP_INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check

# maturin installs into this environment whatever else is active; one interpreter keeps cargo from rebuilding pyo3.
export VIRTUAL_ENV := $(CURDIR)/$(VENV)
export PYO3_PYTHON := $(CURDIR)/$(BIN)/python
unexport CONDA_PREFIX

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.NOTPARALLEL:
.PHONY: help venv build fmu demo docs check test test-rust test-python lint lint-text lint-rust lint-python bench bench-smoke practical features robustness work-precision validation-data stress dist clean

help: ## Show this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-15s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

# --- set-up

venv: $(STAMPS)/build-tools ## Make the virtual environment .venv with the build tool in it

build: $(EXTENSION) ## Build the extension (release) and install the package into .venv, editable

$(STAMPS)/venv:
	@command -v $(PYTHON) >/dev/null || { echo "error: no $(PYTHON) found. Install Python 3.10 or newer, or name one: make PYTHON=/path/to/python3" >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10))' || { echo "error: $$($(PYTHON) --version 2>&1) is too old; Python 3.10 or newer is needed. Name one: make PYTHON=/path/to/python3" >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { echo "error: $(PYTHON) cannot make virtual environments: its modules venv and ensurepip are missing. On Debian and Ubuntu: apt install python3-venv. Or name another: make PYTHON=/path/to/python3" >&2; exit 1; }
	@echo "==> making the virtual environment $(VENV)"
	@$(PYTHON) -m venv --clear $(VENV)
	@mkdir -p $(STAMPS)
	@$(PIP_INSTALL) --upgrade 'pip>=25.1'
	@touch $@

# The lists of tools are the dependency groups of pyproject.toml.
$(STAMPS)/%-tools: $(STAMPS)/venv pyproject.toml
	@echo "==> installing the $* tools into $(VENV)"
	@$(PIP_INSTALL) --group $*
	@touch $@

$(EXTENSION): $(STAMPS)/build-tools $(RUST_SOURCES)
	@command -v cargo >/dev/null || { echo "error: no cargo found. Install Rust: https://rustup.rs" >&2; exit 1; }
	@echo "==> building the extension (release) and installing rustchain into $(VENV)"
	@PIP_QUIET=1 $(BIN)/maturin develop --release --extras all
	@touch $@

fmu: $(FMI_LIBRARY) ## Build the library of FMUs, which export_fmu packs: no Python in it

# The dependencies are those of the extension; maturin has taken its copy of the library that this one replaces.
$(FMI_LIBRARY): $(RUST_SOURCES)
	@command -v cargo >/dev/null || { echo "error: no cargo found. Install Rust: https://rustup.rs" >&2; exit 1; }
	@echo "==> building the library of FMUs (release)"
	$(call build-fmu,cargo rustc,target)

# --- what it is for

demo: build ## Run the paper's drive for 2 s and draw its figures into demo/
	@mkdir -p demo
	@echo "==> rustchain run paper --duration 2 --out demo/paper.nc"
	@$(BIN)/rustchain run paper --duration 2 --out demo/paper.nc
	@echo "==> rustchain plot demo/paper.nc --out demo/figures"
	@$(BIN)/rustchain plot demo/paper.nc --out demo/figures
	@echo
	@echo "Done: built rustchain into $(VENV), ran the paper's drive for 2 s and drew its figures."
	@echo "  results   demo/paper.nc"
	@for figure in demo/figures/*; do echo "  figure    $$figure"; done
	@echo "  more      $(BIN)/rustchain --help"

check: lint-text lint-python $(STAMPS)/test-tools ## The quick tier: lints, unit tests of Rust, one run of each law, corrector and kind of scene
	cargo fmt --check
	cargo test --lib --test layering
	$(BIN)/python -m pytest -q tests/python/validation/test_every_kind.py tests/python/description/test_names.py tests/python/simulation/test_bad_calls.py

test: test-rust test-python ## Run all the tests, Rust and Python
	@echo
	@echo "Done: all tests passed."
	@echo "  Rust      cargo test: unit, integration and documentation tests of src/ and tests/"
	@echo "  Python    pytest tests/python: with the release build of the extension, in $(VENV)"

test-rust: ## cargo test
	@command -v cargo >/dev/null || { echo "error: no cargo found. Install Rust: https://rustup.rs" >&2; exit 1; }
	cargo test

test-python: build fmu $(STAMPS)/test-tools ## pytest on all cores; PYTEST_ARGS="-k name" chooses
	$(BIN)/python -m pytest -n auto $(PYTEST_ARGS)

stress: build $(STAMPS)/test-tools ## Every promise, its test, failures and worst figures; random scenes by STRESS_ARGS="--seeds 0:500"
	$(BIN)/python tests/stress/reliability.py $(STRESS_ARGS)

# --- lints

lint: lint-text lint-rust lint-python ## Formatting, lints, types and stubs; every warning is an error

lint-text:
	@! git grep -nIE --untracked '[[:space:]]+$$' -- ':!tests/data' || { echo "error: trailing whitespace in the lines above" >&2; exit 1; }

lint-rust: $(STAMPS)/venv
	cargo fmt --check
	cargo fmt --check --manifest-path benches/compiled_rhs/Cargo.toml
	cargo clippy --locked --all-targets -- -D warnings
	cargo clippy --locked --all-targets --features python,fmu -- -D warnings
	RUSTDOCFLAGS='-D warnings' cargo doc --locked --no-deps --quiet

lint-python: build $(STAMPS)/lint-tools
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python -m mypy.stubtest rustchain._rustchain --mypy-config-file pyproject.toml

# --- benchmarks: each prints its counts (evaluations, steps, contacts) beside the times

bench: build ## Measure everything; cargo bench --bench NAME measures one of benches/NAME.rs
	cargo bench --bench '*'
	$(BIN)/python benches/numpy_reference.py

bench-smoke: build reference-solvers ## Run every benchmark once, without measuring
	cargo bench --bench '*' -- --test
	$(BIN)/python benches/numpy_reference.py --test
	$(BIN)/python benches/robustness.py --test
	$(BIN)/python benches/practical.py --test
	$(BIN)/python benches/features.py --test
	$(BIN)/python benches/lanes_of_drives.py --test
	$(BIN)/python benches/ideal_drive.py --test
	$(BIN)/python benches/ideal_drive_peer.py --test
	$(BIN)/python benches/work_precision.py --test

practical: build ## Run practical scenes at two accuracies and write docs/performance/practical.md (three minutes)
	OMP_NUM_THREADS=1 $(BIN)/python benches/practical.py --write

features: build ## Run the published drive with every feature in turn, and sweeps, and write docs/performance/features.md (ten minutes)
	OMP_NUM_THREADS=1 $(BIN)/python benches/features.py --write

robustness: build ## Run scenes that are hard in different ways, 2 s each, and write docs/performance/robustness.md (six minutes; two exceed the limit of the balance, as known)
	$(BIN)/python benches/robustness.py --write

work-precision: build reference-solvers ## Measure run time against error beside other solvers and rewrite docs/performance/work-precision.md (45 minutes)
	OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python benches/work_precision.py

# Other integrators, and the right-hand side that they call.
.PHONY: reference-solvers
reference-solvers: $(STAMPS)/bench-tools
	cargo build --release --locked --quiet --manifest-path benches/compiled_rhs/Cargo.toml

# --- documentation

validation-data: build ## Compute what the validation pages read from a file: the comparison with Exudyn
	@$(PIP_INSTALL) --group peers
	PYTHONPATH=benches $(BIN)/python benches/exudyn_validation.py

docs: build $(STAMPS)/docs-tools ## The site, executed and checked, into docs/_build/html; works without network
	$(BIN)/python -m sphinx -W --keep-going -j auto -q docs docs/_build/html
	@echo "Done: docs/_build/html/index.html"

# --- release

# On Linux, linked against the C library of manylinux2014, so that the wheel runs on every distribution since 2014.
MANYLINUX := $(if $(filter Linux,$(SYSTEM)),--zig --compatibility manylinux2014)
HOST = $(shell rustc -vV | sed -n 's/^host: //p')

dist: $(STAMPS)/dist-tools ## Wheel and source archive into dist/
	@command -v cargo >/dev/null || { echo "error: no cargo found. Install Rust: https://rustup.rs" >&2; exit 1; }
	rm -rf dist
	$(if $(MANYLINUX),PATH="$(CURDIR)/$(BIN):$$PATH" $(call build-fmu,cargo-zigbuild rustc --target $(HOST).2.17,target/fmu,$(HOST)/),$(call build-fmu,cargo rustc,target))
	PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/maturin build --release --locked --out dist $(MANYLINUX)
	$(BIN)/maturin sdist --out dist
	$(if $(MANYLINUX),$(BIN)/auditwheel show dist/*.whl)

clean: ## Remove all that the other targets made
	rm -rf docs/_build docs/_examples docs/gallery docs/reference/generated docs/reference/_cli.md
	rm -rf target benches/compiled_rhs/target $(VENV) demo dist $(EXTENSION) $(FMI_LIBRARY) .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find python tests examples benches -name __pycache__ -type d -prune -exec rm -rf {} +
