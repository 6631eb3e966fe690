# make bench   install, run the standard suite, write its results and report, and say where the report is
# make test    install, check the style and the types, run the tests
# make timing  install, time the kernels with pytest-benchmark
# make regress install, run the smoke suite and compare it with the committed baseline

PYTHON ?= python3
BIN := .venv/bin
REVISION := $(shell git describe --always --dirty --abbrev=12 2>/dev/null || echo unversioned)
RUN ?= runs/standard-$(REVISION)

.PHONY: bench test timing regress install clean
install: .venv/installed

.venv/installed: pyproject.toml constraints.txt
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or newer is needed")'
	$(PYTHON) -m venv .venv
	$(BIN)/pip install --quiet --constraint constraints.txt --editable '.[test]'
	touch $@

bench: install
	$(BIN)/frictionbench run standard --out $(RUN)
	$(BIN)/frictionbench report $(RUN)

test: install
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/python -m pytest

timing: install
	$(BIN)/python -m pytest tests/benchmarks --benchmark-only --override-ini addopts= --import-mode=importlib

regress: install
	$(BIN)/frictionbench run smoke --out runs/smoke-$(REVISION)
	$(BIN)/frictionbench compare results/baselines/smoke runs/smoke-$(REVISION)

clean:
	rm -rf .venv build *.egg-info
