# make run: set up, build the FMUs, run the experiment `scara`, print the report's path.
# make test: set up and run the tests. make figures: measure what is promised, over all seeds. make bench: how fast it is.
.PHONY: run build test figures bench lint clean
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready

run: build
	$(BIN)/fmuid run scara

build: $(READY)
	$(BIN)/fmuid build

test: $(READY)
	$(BIN)/python -m pytest -n 2 --dist loadgroup

figures: build
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m tests.figures

bench: build
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m tests.benchmarks

lint: $(READY)
	$(BIN)/ruff check pipeline tests
	$(BIN)/ruff format --check pipeline tests

# One stamp: set up again only when the dependencies change.
$(READY): pyproject.toml .ci/constraints.txt
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or newer is needed: make PYTHON=python3.11")'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c .ci/constraints.txt -e '.[test]'
	touch $@

clean:
	rm -rf $(VENV) build fmus/*.fmu
