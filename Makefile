# Each target makes .venv where there is none and installs what it needs, once. Nothing needs root.
SHELL := /bin/sh
unexport PYTHONDONTWRITEBYTECODE # without bytecode every worker of the tests would compile all modules again
.DEFAULT_GOAL := help
.PHONY: help demo test same mutants faults fuzz differential outdated bench peers lint docs clean

BIN := .venv/bin
INSTALL = $(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt
RECIPE := pyproject.toml constraints.txt
PYTEST_ARGS ?=
MAX ?= 30
INPUTS ?= 2000
FIRST ?= 0

help:
	@echo "make demo    the key claims of all five published systems, on one page"
	@echo "make test    the tests, without the slow sweeps"
	@echo "make same    what 81 commands compute, at BASE=COMMIT and in the working tree: every difference"
	@echo "make mutants changes of src that no test notices: FILES=\"src/...\" or what differs from BASE=COMMIT, MAX=30"
	@echo "make faults  forty known faults, each with the test that notices it: ONLY=PATTERN"
	@echo "make fuzz    changed files before every reader: INPUTS=2000, FIRST=0 for the number of the first"
	@echo "make differential random programs on every engine, needs gcc: INPUTS=2000, FIRST=0 for the seed of the first ten"
	@echo "make outdated newer releases of what is installed, and the advisories that the index knows"
	@echo "make bench   speed, beside C, plain Python and other libraries"
	@echo "make peers   other fuzzy toolboxes to be measured against, in an environment of their own, .peers"
	@echo "make lint    ruff, mypy, layers and circles of imports, words"
	@echo "make docs    the HTML documentation, in docs/_build/html"
	@echo "make clean   removes what the other targets made, .venv included"

demo: .venv/.core
	$(BIN)/leadscrew demo

test: .venv/.dev
	$(BIN)/python -m pytest -n auto --maxprocesses 8 -m "not slow" --costs $(PYTEST_ARGS)

# SAME=whole: also the five studies. SAME="whole numbers": and no differences of texts.
same: .venv/.dev
	@$(BIN)/python tests/same/same.py $(addprefix --,$(SAME)) $(BASE)

mutants: .venv/.mutants
	$(BIN)/python -m tests.mutants --max $(MAX) $(if $(BASE),--base $(BASE)) $(FILES)

faults: .venv/.dev
	$(BIN)/python -m tests.faults $(if $(ONLY),--only "$(ONLY)")

fuzz: .venv/.dev
	$(BIN)/python -m tests.fuzz --inputs $(INPUTS) --first $(FIRST)

differential: .venv/.dev
	$(BIN)/python -m tests.kernel.differential --programs $(INPUTS) --first $(FIRST)

outdated: .venv/.dev .audit/.made
	$(BIN)/python -m pip list --outdated
	.audit/bin/pip-audit --disable-pip --no-deps -r constraints.txt

bench: .venv/.bench
	$(BIN)/leadscrew bench

peers: .peers/.made

lint: .venv/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python -m tests.circles
	$(BIN)/python -m tests.words

docs: .venv/.docs
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs docs/_build/html
	@echo "open docs/_build/html/index.html"

clean:
	rm -rf .venv .peers .audit build dist docs/_build docs/studies/generated docs/reference/generated report .coverage .coverage.* \
	  .pytest_cache .ruff_cache .mypy_cache .import_linter_cache .hypothesis
	find src tests docs -name __pycache__ -type d -prune -exec rm -rf {} +

# ---- installing: a stamp in .venv for each set of extras
.venv/.core: $(RECIPE) | .venv/bin/pip
	@echo "Installing Leadscrew into .venv (once) ..."
	@$(INSTALL) -e .
	@touch $@

.venv/.dev: $(RECIPE) | .venv/bin/pip
	@echo "Installing Leadscrew and its test tools into .venv (once) ..."
	@$(INSTALL) -e ".[dev]"
	@touch $@ .venv/.core

.venv/.docs: $(RECIPE) | .venv/bin/pip
	@echo "Installing Leadscrew and its documentation tools into .venv (once) ..."
	@$(INSTALL) -e ".[dev,docs]"
	@touch $@ .venv/.core .venv/.dev

.venv/.bench: $(RECIPE) | .venv/bin/pip
	@echo "Installing Leadscrew and what it is measured against into .venv (once) ..."
	@$(INSTALL) -e ".[bench]"
	@touch $@ .venv/.core

.venv/.mutants: $(RECIPE) | .venv/bin/pip
	@echo "Installing Leadscrew and what makes mutants of it into .venv (once) ..."
	@$(INSTALL) -e ".[dev,mutants]"
	@touch $@ .venv/.core .venv/.dev

.venv/.verify: $(RECIPE) | .venv/bin/pip
	@echo "Installing Leadscrew and the FMU importers that judge its exports into .venv (once) ..."
	@$(INSTALL) -e ".[dev,verify]"
	@touch $@ .venv/.core .venv/.dev

.venv/bin/pip:
	@for python in $(PYTHON) python3 python3.14 python3.13 python3.12 python3.11; do \
	  if $$python -c 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then \
	    exec $$python -m venv .venv; \
	  fi; \
	done; \
	echo "Leadscrew needs Python 3.11 or newer with its venv module, and none was found; name one: make PYTHON=/path/to/python3" >&2; \
	exit 1

# Not in .venv: they are of other licences, and need an older NumPy.
.peers/.made: peers/requirements.txt | .venv/bin/pip
	@echo "Installing other fuzzy toolboxes into .peers (once) ..."
	@$(BIN)/python -m venv .peers
	@.peers/bin/python -m pip install --quiet --disable-pip-version-check -r peers/requirements.txt
	@touch $@

# Not in .venv, and always the newest: what knows of faults in what Leadscrew uses.
.audit/.made: | .venv/bin/pip
	@$(BIN)/python -m venv .audit
	@.audit/bin/python -m pip install --quiet --disable-pip-version-check pip-audit
	@touch $@
