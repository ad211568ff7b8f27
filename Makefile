# Georibbon.  On a machine with python3 (3.11 or newer) and make, every target prepares what it
# needs by itself: a virtual environment in .venv with the locked requirements, and the system's
# libraries where it may install them.

PYTHON ?= python3
BIN := .venv/bin
RUN := .venv/.ready-to-run
TEST := .venv/.ready-to-test
CAD := .venv/.ready-for-cad
PEERS := .venv-peers/.ready
SOURCES := packaging/prepare.sh packaging/missing_libraries.py pyproject.toml

# The window's tests need a display; on Linux they get one of their own that nobody sees.
ifeq ($(shell uname),Linux)
SCREEN := xvfb-run --auto-servernum --server-args="-screen 0 1600x1200x24"
endif

PYTEST := $(BIN)/python -m pytest --dist loadfile --no-loadscope-reorder
# The tests that hold the core to its coverage; to trace the others too costs minutes.
CORE := tests/calibration tests/fitting tests/geometry tests/test_pass_settings.py \
	tests/test_reconstruction.py

.PHONY: help demo cad test benchmarks peers pictures translations lock clean
.DEFAULT_GOAL := help

help:
	@echo "make demo        capture a virtual object, reconstruct it; results in build/demo, shown in the window"
	@echo "make cad         the CAD kernel for STEP and IGES files as well (70 MB to download)"
	@echo "make test        style, types, import rules and all tests with their coverage"
	@echo "make benchmarks  figures of accuracy and speed; results in build/benchmarks"
	@echo "make peers       the same curves for Georibbon and for other programs, in .venv-peers"
	@echo "make translations  take up the program's texts into resources/translations, and tell what lacks a translation"
	@echo "make pictures    the manual's and the README's pictures anew, from the window itself, and the paper's figures"
	@echo "make lock        write packaging/*.lock anew (ARGS=--upgrade for newer releases)"
	@echo "make clean       remove build/ and caches (.venv and .venv-peers stay)"

$(RUN): $(SOURCES) packaging/requirements.lock packaging/requirements-build.lock
	@PYTHON="$(PYTHON)" sh packaging/prepare.sh run
	@touch $@

$(TEST): $(RUN) packaging/requirements-dev.lock
	@PYTHON="$(PYTHON)" sh packaging/prepare.sh test
	@touch $@

$(CAD): $(RUN) packaging/requirements-cad.lock
	@PYTHON="$(PYTHON)" sh packaging/prepare.sh cad
	@touch $@

cad: $(CAD)

demo: $(RUN)
	@echo "== The demonstration: a virtual capture of a car bonnet, reconstructed (a minute at most)"
	@$(BIN)/georibbon demo --output build/demo --window

test: $(TEST)
	@echo "== Style (ruff)"
	@$(BIN)/ruff check --no-cache .
	@$(BIN)/ruff format --check --no-cache .
	@echo "== Types (mypy, strict)"
	@$(BIN)/mypy
	@echo "== Which module may import which (import-linter)"
	@$(BIN)/lint-imports
	@mkdir -p build
	@echo "== Tests of the core (pytest, two at a time; coverage by line in build/coverage)"
	@COVERAGE_FILE=build/.coverage $(PYTEST) -n 2 --cov --cov-report= $(CORE)
	@COVERAGE_FILE=build/.coverage $(BIN)/python packaging/coverage_floor.py build/coverage
	@echo "== Tests of the window (pytest, two at a time: they share a display)"
	@$(SCREEN) $(PYTEST) -n 2 tests/gui
	@echo "== All other tests (pytest, four at a time: many wait for ports and processes)"
	@$(SCREEN) $(PYTEST) -n 4 --ignore=tests/gui $(addprefix --ignore=,$(CORE))

benchmarks: $(TEST)
	@mkdir -p build/benchmarks
	@for script in benchmarks/*.py; do \
		echo "== $$script"; \
		$(BIN)/python "$$script" || exit 1; \
	done

$(PEERS): $(SOURCES) packaging/requirements-peers.lock
	@PYTHON="$(PYTHON)" sh packaging/prepare.sh peers
	@touch $@

peers: $(PEERS)
	@.venv-peers/bin/python benchmarks/peers.py $(ARGS)

translations: $(TEST)
	@$(BIN)/python packaging/translations.py

pictures: $(TEST)
	@$(SCREEN) $(BIN)/python packaging/gallery/pictures.py
	@$(BIN)/python packaging/paper

lock: $(TEST)
	@sh packaging/lock.sh $(ARGS)

clean:
	rm -rf build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
