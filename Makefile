# make demo   first result      make check   lint, types, import contracts, dependencies, results
# make test   all but slow tests and pages; what is missing skips      make test-slow, test-kills   the slow ones
# make test-extras   installs the extras and runs their tests          make test-all    every test
# make bench  speed ratios
# make golden  what the solvers score against the committed results; make leaderboard writes and checks them (minutes)
# make core   the extension modules again, in place, with debug symbols     make sanitize   their tests under sanitizers
# make format   Python by ruff, C++ by clang-format
# make packages   all that the tests need
# make wheel-test   the built wheel in an empty environment, from another folder
# make browser   the leaderboard's pages in a real browser     make chromium  installs one, on Debian, as root
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := PIP_CONSTRAINT=$(CURDIR)/constraints.txt PIP_BUILD_CONSTRAINT=$(CURDIR)/constraints.txt $(BIN)/python -m pip
DEMO ?= out/demo
SITE ?= out/site
PLAYED ?= sim street
WORK := out/leaderboard/again
SEED = $(shell sed -n 's/.*"seed": *\([0-9]*\).*/\1/p' leaderboards/results/sim/field.json)
CPP := $(shell find cpp */cpp -name '*.?pp')
CORE := CMakeLists.txt $(CPP)
CMAKE := $(BIN)/cmake -G Ninja -D CMAKE_MAKE_PROGRAM=$(CURDIR)/$(BIN)/ninja -D Python_EXECUTABLE=$(CURDIR)/$(BIN)/python -D VBBENCH_WERROR=ON -S .
SANITIZED := $(patsubst %,tests/baselines/%.py,test_joint_map $(patsubst %,cascade/test_%,ego_motion people factors)) \
  $(patsubst %,tests/generators/%.py,test_social_force tiers/test_noise tiers/tracking/test_observing tiers/tracking/test_tracker tiers/test_field views/test_vehicle \
  views/test_looking footage/test_odometry_filter lifting/test_lift test_elementary) tests/renderers/test_raster.py tests/renderers/test_visibility.py
# Figures of many seeds, which run the same lines again
FIGURES := errors or later_frames or followed or half_a_minute or keep_the_heading
KILLS := tests/cli/test_kills.py tests/folders/test_work_folder.py
WORKERS := --numprocesses logical --maxprocesses 4
PARALLEL := $(WORKERS) --dist loadfile
QUICK := -m 'not slow' --ignore tests/browser $(PARALLEL)

.PHONY: demo test test-slow test-kills test-extras test-all check lint types contracts dependencies house results-check bench bench-summary golden leaderboard wheel-test site sequences packages browser chromium core sanitize format clean

demo: $(VENV)/.runtime
	rm -rf $(DEMO)
	$(BIN)/vbbench demo --out $(DEMO) --jobs 2

test: $(VENV)/.dev $(VENV)/.runtime
	$(BIN)/python -m pytest $(QUICK)

test-slow: $(VENV)/.dev
	$(BIN)/python -m pytest -m 'slow and not extra' $(PARALLEL) $(addprefix --ignore ,$(KILLS))

test-kills: $(VENV)/.extras
	$(BIN)/python -m pytest -m 'slow and not extra' $(WORKERS) --dist worksteal $(KILLS)

test-extras: $(VENV)/.extras
	$(BIN)/python -m pytest -m extra --no-skips

test-all: $(VENV)/.extras chromium site
	$(BIN)/python -m pytest

check: lint types contracts dependencies house results-check

lint: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/clang-format --dry-run -Werror $(CPP)

format: $(VENV)/.dev
	$(BIN)/ruff format .
	$(BIN)/clang-format -i $(CPP)

core: $(VENV)/.dev
	@mkdir -p build
	@$(CMAKE) -B build/core -D CMAKE_BUILD_TYPE=RelWithDebInfo -D VBBENCH_IN_PLACE=ON >build/core.log 2>&1 || { cat build/core.log; exit 1; }
	$(BIN)/cmake --build build/core
	@touch $(VENV)/.runtime

sanitize: $(VENV)/.dev
	$(CMAKE) -B build/sanitized -D CMAKE_BUILD_TYPE=Debug -D CMAKE_CXX_FLAGS_DEBUG='-O1 -g1' -D VBBENCH_SANITIZE=address,undefined
	$(BIN)/cmake --build build/sanitized
	ASAN_OPTIONS=detect_leaks=0 LD_PRELOAD="$$($${CXX:-c++} -print-file-name=libasan.so) $$($${CXX:-c++} -print-file-name=libstdc++.so)" $(BIN)/python -m tests.lib.sanitized build/sanitized -m 'not slow' -k 'not ($(FIGURES))' $(SANITIZED)

types: $(VENV)/.dev
	$(BIN)/mypy

contracts: $(VENV)/.dev
	$(BIN)/lint-imports

dependencies: $(VENV)/.dev
	$(BIN)/deptry .

house: $(VENV)/.dev
	$(BIN)/python docs/draw_house.py --check
	$(BIN)/python docs/budgets.py

results-check: $(VENV)/.dev
	$(BIN)/vbbench leaderboard check --work /dev/null

bench-summary: $(VENV)/.dev
	@$(BIN)/python -m benchmarks.bench_generation --summary
	@$(BIN)/python -m benchmarks.bench_rendering --sizes 320x240

bench: $(VENV)/.dev
	for file in benchmarks/bench_*.py; do $(BIN)/python -m benchmarks.$$(basename $$file .py) || exit 1; done

golden: $(VENV)/.dev
	$(BIN)/vbbench leaderboard rerun --jobs 2

leaderboard: $(VENV)/.dev
	$(BIN)/vbbench leaderboard rerun --jobs 2 --update
	$(BIN)/vbbench leaderboard check
	$(BIN)/python docs/write_board.py

wheel-test: $(VENV)/.dev
	PYTHON=$(BIN)/python sh tests/wheel_test.sh

site: $(VENV)/.docs
	$(BIN)/python docs/site/notebooks.py --check
	rm -rf $(SITE)
	$(BIN)/sphinx-build --quiet --fail-on-warning --keep-going -c docs/site -d out/doctrees docs $(SITE)
	$(BIN)/vbbench leaderboard build --out $(SITE)/leaderboard --docs ../index.html $$(test ! -d $(WORK) || echo --work $(WORK))
	$(BIN)/python docs/site/links.py $(SITE)

sequences: $(VENV)/.runtime
	$(BIN)/vbbench leaderboard rerun --split $(PLAYED) --tier field --seed $(SEED) --together --jobs 2

packages: $(VENV)/.extras $(VENV)/.docs chromium

browser: $(VENV)/.dev chromium site
	$(BIN)/python -m pytest tests/browser --no-skips --durations 5

chromium:
	@command -v chromium >/dev/null || command -v google-chrome >/dev/null \
	|| { test "$$(id -u)" = 0 && apt-get -qq update && DEBIAN_FRONTEND=noninteractive apt-get -qq install --yes --no-install-recommends chromium >/dev/null; } \
	|| echo 'no browser: install Debian'\''s package chromium for the tests of the pages' >&2

$(VENV)/bin/python:
	$(PYTHON) -m venv $(VENV)

$(VENV)/.installed: $(VENV)/bin/python pyproject.toml constraints.txt
	$(PIP) install --quiet --editable .
	touch $@

# Modules older than their sources are built again: by `make core` where its tools are, else by pip.
$(VENV)/.runtime: $(VENV)/.installed $(CORE)
	test -z "$$(find $(CORE) -newer $(VENV)/.installed)" || if test -e $(VENV)/.dev; then $(MAKE) core; else $(PIP) install --quiet --editable .; fi
	touch $@

# What is installed is asked for its extras by name: nothing is built again.
$(VENV)/.dev: $(VENV)/.installed
	$(PIP) install --quiet 'vbbench[dev]'
	touch $@

$(VENV)/.extras: $(VENV)/.dev
	$(PIP) install --quiet 'vbbench[dask,onnx,pyrender,robot,torch,viewer]' 'pysocialforce>=1.1.2'
	touch $@

$(VENV)/.docs: $(VENV)/.runtime
	$(PIP) install --quiet 'vbbench[docs]'
	touch $@

clean:
	rm -rf $(VENV) out dist build */vbbench_*/_core.*.so docs/tutorials/notebooks .mypy_cache .ruff_cache .pytest_cache .hypothesis
