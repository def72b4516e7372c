PYTHON   ?= python3
VENV     ?= .venv
STUDY    ?= studies/steel_wires/study.toml
FIDELITY ?= quick
OUTPUT   ?= runs/$(notdir $(patsubst %/,%,$(dir $(STUDY))))

BIN       := $(VENV)/bin
# The product alone, and with what its developers need besides.
INSTALLED := $(VENV)/.installed
DEVELOPED := $(VENV)/.developed
INSTALL   := sh tools/install.sh $(BIN)/python
# One process a core, each with its linear algebra on one thread; the tests of a file stay together for their fixtures,
# in the order that tests/conftest.py gives them.
PYTEST    := OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest --numprocesses $(shell nproc) --dist loadfile --no-loadscope-reorder
TESTS     := -m "not slow"
SOURCES   := $(wildcard geometry solvers wirewear studies tests tools)
COMPARE   := $(wildcard $(dir $(STUDY))compare.py)

# Compiled modules are kept also where the environment forbids it: every process would compile them again.
export PYTHONDONTWRITEBYTECODE :=

.DEFAULT_GOAL := help
.PHONY: help setup run atlas pictures test test-all test-fast lint style types bench clean

help:
	@echo "make setup      create $(VENV) and install wirewear with all that its developers need"
	@echo "make run        simulate the steel-wire test and draw it (STUDY=$(STUDY) FIDELITY=$(FIDELITY))"
	@echo "make atlas      published experiments beside their simulations (FIDELITY=$(FIDELITY)); goes on where it stopped"
	@echo "make pictures   every picture of the documentation, drawn again"
	@echo "make test       lint and the tests that every change runs; of the exam of the diagnosis only where its code has changed"
	@echo "make test-all   lint and all tests, also those that are slow"
	@echo "make test-fast  the tests that take less than a second"
	@echo "make lint       formatting, style and types"
	@echo "make bench      every studies/benchmarks/bench_*.py"
	@echo "make clean      remove caches (runs/ and $(VENV) stay)"

setup: $(DEVELOPED)

# The system's libraries come while the packages do. Packages are byte-compiled when they are first loaded: most never are.
$(INSTALLED): pyproject.toml constraints.txt tools/prepare_machine.sh tools/install.sh
	@sh tools/prepare_machine.sh "$(PYTHON)" interpreter
	@echo "wirewear: installing into $(VENV); this takes a minute"
	@sh tools/prepare_machine.sh "$(PYTHON)" & libraries=$$!; \
	{ test -x $(BIN)/pip || "$(PYTHON)" -m venv $(VENV); } && $(INSTALL) .; installed=$$?; wait $$libraries && exit $$installed
	@touch $@

$(DEVELOPED): $(INSTALLED)
	@echo "wirewear: installing what tests, types and the documentation need"
	@$(INSTALL) ".[dev]"
	@echo "wirewear: compiling the solver's inner loops"
	@$(BIN)/python tools/compile_ahead.py
	@touch $@

run: $(INSTALLED)
	$(BIN)/wirewear run $(STUDY) --fidelity $(FIDELITY) --output $(OUTPUT) --resume
	$(BIN)/wirewear show $(OUTPUT)$(if $(COMPARE), & shown=$$!; $(BIN)/python $(COMPARE) $(OUTPUT); compared=$$?; wait $$shown && exit $$compared)
	@echo "Results and pictures are in $(abspath $(OUTPUT))"

atlas: $(INSTALLED)
	$(BIN)/python -m studies.atlas --fidelity $(FIDELITY)

pictures: $(DEVELOPED)
	$(BIN)/python -m tools.pictures

# Pages are looked at in Chromium, where there is one: without it their tests are skipped, and say so. Types are checked
# while it is installed, and remembered as long as $(VENV) stays.
test: style
	@$(MAKE) --no-print-directory types & types=$$!; sh tools/prepare_machine.sh "$(PYTHON)" chromium; \
	$(PYTEST) $(TESTS); tested=$$?; wait $$types && exit $$tested

test-all: TESTS := --all
test-all: test
	$(BIN)/python -m tools.examined

test-fast: $(DEVELOPED)
	$(PYTEST) -m "not slow and not seconds"

lint: style types

style: $(DEVELOPED)
	$(BIN)/ruff format --check $(SOURCES)
	$(BIN)/ruff check $(SOURCES)

types: $(DEVELOPED)
	@# What mypy makes it keeps: looking for garbage is a fifth of its time.
	$(BIN)/python -c "import gc; gc.disable(); gc.enable = gc.disable; from mypy.__main__ import console_entry; console_entry()" \
		--cache-dir $(VENV)/mypy $(SOURCES)

bench: $(DEVELOPED)
	@set -e; for script in $(sort $(wildcard studies/benchmarks/bench_*.py)); do \
		echo "$$script"; $(BIN)/python -m "studies.benchmarks.$$(basename "$$script" .py)"; \
	done

clean:
	rm -rf build dist *.egg-info .mypy_cache .pytest_cache .ruff_cache .hypothesis
	find $(SOURCES) -name __pycache__ -type d -prune -exec rm -rf {} +
