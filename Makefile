# hydrofdi: everything that is done with this repository. `make` alone lists it.
#
# Needs Python 3.11 or newer, make and a network. All packages go into .venv, in the versions of
# constraints.txt; pip refuses a file whose hash is not listed there.

PYTHON ?= python3
BIN := $(if $(filter Windows_NT,$(OS)),.venv/Scripts,.venv/bin)
RESULT := results/table3

export PIP_DISABLE_PIP_VERSION_CHECK := 1
INSTALL = $(BIN)/python -m pip install --quiet --no-input
PYTEST = $(BIN)/pytest --numprocesses 3 --dist loadscope
CHECKED = $(INSTALL) --require-hashes --constraint constraints.txt

.DEFAULT_GOAL := help
.PHONY: help install table3 test test-long test-oldest test-all check bench bench-runner bench-monitor torture constraints docs release site clean

help:  ## list the targets
	@awk 'BEGIN {FS = ":.*## "} /^[a-z0-9-]+:.*## / {printf "  make %-12s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

install: .venv/installed-runtime  ## make .venv and install hydrofdi into it

table3: .venv/installed-runtime  ## run the study of the paper and print its Table 3
	$(BIN)/hydrofdi sweep configs/table3.yaml
	@$(BIN)/hydrofdi report $(RESULT) --out $(RESULT)/report
	@$(BIN)/hydrofdi report $(RESULT)

test: .venv/installed-test  ## run the tests but the long ones (minutes)
	$(PYTEST) -m "not long"

test-long: .venv/installed-test  ## run the long tests alone: solvers, Dask, a browser, kills at random moments
	$(PYTEST) -m long

test-oldest: .venv/installed-test  ## run what a processor may change as on the oldest one that is supported (x86-64-v2)
	$(BIN)/python -m tests.processors $(PYTEST) -m "not long" tests/goldens tests/identity tests/laws tests/simulation \
		tests/papers tests/studies tests/evaluation tests/detectors

test-all: test test-long  ## run all tests

check: .venv/installed-test  ## lint, format, types, layers and generated files
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/pytest tests/test_layers.py
	$(BIN)/python docs/generate_configuration.py --check

bench: .venv/installed-bench  ## measure kernel, sweep and start-up (two minutes; on a quiet machine)
	@$(BIN)/python benchmarks/kernel.py > results/bench.json
	@cat results/bench.json

bench-runner: .venv/installed-test  ## measure sweeps of 100,000 runs and of stored signals (about four minutes; quiet machine)
	$(BIN)/python benchmarks/runner.py

bench-monitor: .venv/installed-test  ## measure the monitor: times real time, latency, memory (two minutes; on a quiet machine)
	$(BIN)/python benchmarks/monitor.py

torture: .venv/installed-test  ## kill sweeps at random moments and compare the bits (minutes)
	$(BIN)/python -m tests.runner.torture

docs: .venv/installed-runtime  ## generate the schemas, the table of symbols, and the pictures of the README
	$(BIN)/python docs/generate_configuration.py
	$(BIN)/hydrofdi sweep configs/table3.yaml
	$(BIN)/hydrofdi report $(RESULT) --figure docs/images/phases.png
	$(BIN)/hydrofdi sweep configs/grid.yaml
	$(BIN)/hydrofdi report results/grid --figure results/grid/sensitivity.png
	cp results/grid/sensitivity.png docs/images/grid.png
	$(BIN)/hydrofdi report $(RESULT) --format markdown > $(RESULT)/table3.md
	$(BIN)/hydrofdi report $(RESULT) --format csv > $(RESULT)/table3.csv

site: .venv/installed-test  ## build the documentation into site/ (minutes; then seconds)
	$(BIN)/sphinx-build -W --keep-going -q -b html docs site
	@echo "built site/index.html"

release: .venv/installed-runtime  ## build wheel and sdist into dist/ and try each in a bare environment
	rm -rf dist .venv/release
	$(BIN)/python -m hatchling build --directory dist
	$(PYTHON) -m venv .venv/release
	.venv/release/bin/python -m pip install --quiet --require-hashes --requirement .venv/pip.txt
	.venv/release/bin/python -m pip install --quiet --require-hashes --constraint constraints.txt --requirement .venv/runtime.txt
	@for built in $$PWD/dist/*.whl $$PWD/dist/*.tar.gz; do \
		echo "trying $$built" && bin=$$PWD/.venv/release/bin && folder=$$(mktemp -d) && cd $$folder && \
		$$bin/python -m pip install --quiet --no-index --no-deps --no-build-isolation --force-reinstall $$built && \
		$$bin/hydrofdi --version && $$bin/hydrofdi sweep smoke && $$bin/hydrofdi report && \
		$$bin/hydrofdi measure smoke --indicators dwt > /dev/null && $$bin/hydrofdi init mine && $$bin/hydrofdi plan mine > /dev/null || exit 1; \
		cd - > /dev/null && rm -rf $$folder; \
	done
	@ls -l dist

constraints: .venv/made  ## resolve all dependencies anew into constraints.txt
	$(INSTALL) uv
	$(BIN)/python .ci/requirements.py runtime test docs bench dask > .venv/wanted.txt
	echo pip >> .venv/wanted.txt
	$(BIN)/uv pip compile .venv/wanted.txt --quiet --upgrade --universal --python-version 3.11 \
		--fork-strategy fewest --generate-hashes --no-header --no-annotate --no-emit-index-url \
		--no-emit-find-links --allow-unsafe --output-file .venv/resolved.txt
	sed 's/ ;[^\\]*\\$$/ \\/' .venv/resolved.txt > constraints.txt
	$(INSTALL) --dry-run --require-hashes --constraint constraints.txt --requirement .venv/wanted.txt

clean:  ## remove .venv and caches; results stay
	rm -rf site docs/_gallery docs/_notebooks jupyter_execute docs/reference/api docs/reference/commands docs/reference/configurations
	rm -rf .venv .mypy_cache .pytest_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

.venv/made: constraints.txt .ci/requirements.py
	@$(PYTHON) -c "import sys; sys.exit(sys.version_info < (3, 11) and 'hydrofdi needs Python 3.11 or newer, not ' + sys.version.split()[0])"
	$(PYTHON) -m venv .venv
	$(BIN)/python .ci/requirements.py pip > .venv/pip.txt
	$(INSTALL) --require-hashes --requirement .venv/pip.txt
	@touch $@

.venv/installed-runtime: .venv/made pyproject.toml
	$(BIN)/python .ci/requirements.py runtime > .venv/runtime.txt
	$(CHECKED) --requirement .venv/runtime.txt
	$(INSTALL) --no-deps --no-build-isolation --editable .
	$(BIN)/python -m compileall -q hydrofdi
	@touch $@

.venv/installed-test: .venv/installed-runtime
	$(BIN)/python .ci/requirements.py test docs > .venv/test.txt
	$(CHECKED) --requirement .venv/test.txt
	@touch $@

# numbalsoda is built from source and needs cmake and a Fortran compiler; the benchmark does without it.
.venv/installed-bench: .venv/installed-runtime
	$(BIN)/python .ci/requirements.py bench > .venv/bench.txt
	@$(CHECKED) --requirement .venv/bench.txt > .venv/bench.log 2>&1 \
		|| echo "numbalsoda is left out: it could not be built (see .venv/bench.log)"
	@touch $@
