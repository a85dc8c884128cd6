# make demo   first result      make test   all tests      make check   lint, types, import contracts
# make bench  speed ratios      make results  docs/results.md anew (needs recordings, minutes)
# make golden  what the solvers score against the committed results; make golden-update writes them (minutes)
# make wheel-test   the built wheel in an empty environment, from another folder
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := PIP_CONSTRAINT=$(CURDIR)/constraints.txt PIP_BUILD_CONSTRAINT=$(CURDIR)/constraints.txt $(BIN)/python -m pip
DEMO ?= out/demo

.PHONY: demo test check lint types contracts bench results golden golden-update wheel-test clean

demo: $(VENV)/.runtime
	rm -rf $(DEMO)
	$(BIN)/vbbench demo --out $(DEMO) --jobs 2

test: $(VENV)/.dev
	$(BIN)/python -m pytest

check: lint types contracts

lint: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(VENV)/.dev
	$(BIN)/mypy

contracts: $(VENV)/.dev
	$(BIN)/lint-imports

bench: $(VENV)/.dev
	for file in benchmarks/bench_*.py; do $(BIN)/python -m benchmarks.$$(basename $$file .py) || exit 1; done

results: $(VENV)/.dev
	$(BIN)/python benchmarks/results_table.py

golden: $(VENV)/.dev
	$(BIN)/python -m vbbench_leaderboards.golden --jobs 2

golden-update: $(VENV)/.dev
	$(BIN)/python -m vbbench_leaderboards.golden --jobs 2 --update

wheel-test: $(VENV)/.dev
	PYTHON=$(BIN)/python sh tests/wheel_test.sh

$(VENV)/bin/python:
	$(PYTHON) -m venv $(VENV)

$(VENV)/.runtime: $(VENV)/bin/python pyproject.toml constraints.txt
	$(PIP) install --quiet --editable .
	touch $@

$(VENV)/.dev: $(VENV)/bin/python pyproject.toml constraints.txt
	$(PIP) install --quiet --editable '.[dev,dask]'
	touch $@ $(VENV)/.runtime

clean:
	rm -rf $(VENV) out dist .mypy_cache .ruff_cache .pytest_cache .hypothesis
