# make bench   install, run the standard suite, write its results and report, and say where the report is
# make help    these lines
# make install  the package in editable form and what its commands and tests need, into .venv
# make checked  install, check the style and the types
# make quick   install, check the style and the types, run the tests that matter for most changes: a minute with kernels compiled
# make test    install, check the style and the types, run the tests but the slow ones
# make test-all  the same, and then the slow tests, which guard documents, recipes, builds, pages in a browser and the sandbox
# make test-peers  the outside solvers as in make peers, and the tests of their adapters and of engines; what is missing is skipped with its
#              reason. PEER_NAMES: the packages to install, all by default
# make coverage  lines of the package that the tests of make quick run, the least covered files first; COVERED: other tests.
#              Bodies of compiled kernels are left out: a tracer does not see them
# make timing  install, time the kernels with pytest-benchmark, a file in runs/timing-REVISION each time
# make peers   the outside solvers into an environment of their own, as far as they can be had; run the peers suite, report,
#              and put its tables into docs/peers.md
# make studies install, also the models of robots of other packages, run all studies and put their page and figures into docs/;
#              half an hour or more where nothing is computed yet. What is missing of the packages that a study
#              needs ends it before docs/ is touched
# make docs    the documentation as a site, docs/_build/html; its links are checked, and that it loads nothing from elsewhere
# make release  wheel and sdist into dist/, checked by twine and installed into an empty environment
# make placeholders  list what the owner fills in before a release; exit 1 while there is something
# make regress install, run the smoke suite and compare it with the committed baseline; COMPARE: more options of compare

PYTHON ?= python3
BIN := .venv/bin
REVISION := $(shell git describe --always --dirty --abbrev=12 2>/dev/null || echo unversioned)
PEERS := .venv-peers
PEER_NAMES ?= $(shell $(PYTHON) -c 'import tomllib; print(*tomllib.load(open("pyproject.toml", "rb"))["project"]["optional-dependencies"]["peers"])')
PEERS_RUN ?= runs/peers-$(REVISION)
RUN ?= runs/standard-$(REVISION)
STUDIES ?= runs/studies
TIMING ?= runs/timing-$(REVISION)

# Of one process each and without runs, browsers or installs: those are for make test.
QUICK := tests/problems --ignore=tests/problems/recorded --ignore=tests/problems/test_compiled.py \
	$(addprefix tests/solvers/test_,interface.py every_solver.py families.py lemke.py nsgs.py) \
	tests/facts/test_classics.py tests/problems/test_verify.py \
	tests/results/test_baselines.py tests/api tests/project/test_structure.py tests/project/test_documents.py
PYTEST = $(BIN)/python -m pytest --numprocesses=2 --dist=loadfile --no-loadscope-reorder

.PHONY: help bench quick test test-all test-peers coverage timing peers studies docs release placeholders regress install clean
install: .venv/installed

help:
	@sed -n 's/^# //p;/^$$/q' Makefile

.venv/installed: pyproject.toml constraints.txt
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or newer is needed")'
	$(PYTHON) -m venv .venv
	$(BIN)/pip install --quiet --constraint constraints.txt --editable '.[test]'
	touch $@

bench: install
	$(BIN)/frictionbench run standard --out $(RUN)
	$(BIN)/frictionbench report $(RUN)

quick: checked
	$(PYTEST) $(QUICK)

test: install
	$(MAKE) --jobs=2 --output-sync checked compiled-plane compiled-space
	$(PYTEST)

test-all: test .venv/documented
	$(PYTEST) -m slow

# Kernels that both processes of the tests would otherwise compile at the same time.
.PHONY: compiled-plane compiled-space
compiled-plane: install
	$(BIN)/frictionbench solve 'stack[blocks=2]' > /dev/null
	$(BIN)/python -c 'import frictionbench as fb; [fb.solve_many([fb.problem("stack")], spec) for spec in ("lemke", "nsgs", "interior_point", "hybrid")]'

compiled-space: install
	$(BIN)/frictionbench solve 'cubes[boxes=2]' > /dev/null
	$(BIN)/python -c 'import frictionbench as fb; [fb.solve_many([fb.problem("cubes")], spec) for spec in ("nsgs", "interior_point", "hybrid")]'

.PHONY: checked
checked: install
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

COVERED ?= $(QUICK)
coverage: install
	$(BIN)/pip install --quiet coverage
	$(BIN)/python -m coverage run -m pytest --numprocesses=0 $(COVERED)
	$(BIN)/python -m coverage report --sort=cover

timing: install
	mkdir -p $(TIMING)
	$(BIN)/python -m pytest tests/benchmarks --benchmark-only --override-ini addopts= --import-mode=importlib \
		--benchmark-json=$(TIMING)/$$(date +%Y%m%dT%H%M%S).json

$(PEERS)/installed: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(PEERS)
	$(PEERS)/bin/pip install --quiet --constraint constraints.txt --editable '.[test]'
	for peer in $(PEER_NAMES); do \
		timeout 600 $(PEERS)/bin/pip install --quiet $$peer || echo "$$peer cannot be had here; its solvers are skipped"; \
	done
	touch $@

test-peers: $(PEERS)/installed
	$(PEERS)/bin/python -m pytest --numprocesses=2 -rs tests/solvers/outside tests/tools/test_direct.py tests/problems/capture tests/tools/test_battery.py \
		tests/harness/cells/test_judgement.py

peers: $(PEERS)/installed
	@/usr/bin/python3 -c 'import siconos.numerics' 2>/dev/null || echo 'Siconos is missing: apt-get install python3-siconos (Debian); its solvers are skipped'
	$(PEERS)/bin/frictionbench run peers --out $(PEERS_RUN)
	$(PEERS)/bin/frictionbench report $(PEERS_RUN) --markdown
	$(PEERS)/bin/python -m tools.direct > $(PEERS_RUN)/direct.md
	sed -i -e '/^<!-- begin: make peers/,/^<!-- end/{//!d}' -e '/^<!-- begin: make peers/r $(PEERS_RUN)/report.md' \
		-e '/^<!-- begin: python -m tools.direct/,/^<!-- end/{//!d}' \
		-e '/^<!-- begin: python -m tools.direct/r $(PEERS_RUN)/direct.md' docs/peers.md

studies: install
	$(BIN)/pip install --quiet --constraint constraints.txt --editable '.[robots]'
	$(BIN)/pip install --quiet --no-deps dm_control==1.0.50 gymnasium-robotics==1.4.2
	$(BIN)/python -m studies all --out $(STUDIES)
	mkdir -p docs/studies
	cp $(STUDIES)/studies.md docs/
	cp $(STUDIES)/studies/*.svg docs/studies/

.venv/documented: .venv/installed
	$(BIN)/pip install --quiet --constraint constraints.txt --editable '.[docs]'
	touch $@

# Sphinx does not see that an extension has changed, and would keep its pages.
docs/_build/extended: $(wildcard docs/_ext/*.py)
	rm -rf docs/_build
	mkdir docs/_build
	touch $@

docs: .venv/documented docs/_build/extended
	$(BIN)/sphinx-build --quiet --fail-on-warning --keep-going docs docs/_build/html
	$(BIN)/python docs/_ext/check_site.py docs/_build/html

DIST := dist
release: install
	$(BIN)/pip install --quiet build twine
	rm -rf $(DIST)
	$(BIN)/python -m build --outdir $(DIST)
	$(BIN)/twine check --strict $(DIST)/*
	$(PYTHON) -m venv --clear .venv-empty
	.venv-empty/bin/pip install --quiet $(DIST)/*.whl
	cd $(DIST) && ../.venv-empty/bin/frictionbench solve 'stack[blocks=2,push=1]' --solver nsgs
	rm -rf .venv-empty

placeholders:
	@! grep -n 'TO FILL IN' CITATION.cff

regress: install
	$(BIN)/frictionbench run smoke --out runs/smoke-$(REVISION)
	$(BIN)/frictionbench compare results/baselines/smoke.tsv runs/smoke-$(REVISION) $(COMPARE)

clean:
	rm -rf .venv $(PEERS) docs/_build $(DIST) .venv-empty build *.egg-info
