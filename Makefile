# Every target works on a fresh machine with Python 3.11+ and make: the virtual environment is built on first use.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
CLUSTER := .venv-cluster
SITE := import sysconfig; print(sysconfig.get_path('purelib'))
JOBS ?= 2
RUN ?= paper

.DEFAULT_GOAL := help
.PHONY: help install test test-cluster test-trainers peers torture lint style types arrows format docs reproduce ablation report ladder bench clean

help: ## list the targets
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## (.*)/  make \1\t\2/' | expand -t 22

$(VENV)/installed: requirements.lock setup.cfg pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "lawn-sb3 needs Python 3.11 or newer; '$(PYTHON)' is older. Try: make PYTHON=python3.11 $(MAKECMDGOALS)"; exit 2; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --requirement requirements.lock
	$(BIN)/python -m pip install --quiet --no-deps --no-build-isolation --editable .
	@touch $@

install: $(VENV)/installed ## build .venv from requirements.lock

test: install ## run all tests
	$(BIN)/python -m pytest -n 2 --dist worksteal

$(CLUSTER)/installed: $(VENV)/installed
	$(BIN)/python -m venv $(CLUSTER)
	echo "import site; site.addsitedir('$$($(BIN)/python -c "$(SITE)")')" > $$($(CLUSTER)/bin/python -c "$(SITE)")/beside.pth
	$(CLUSTER)/bin/python -m pip install --quiet --constraint requirements.lock ray==2.60.0
	@touch $@

test-cluster: $(CLUSTER)/installed ## install Ray beside .venv, and test trainings on a cluster of two nodes
	$(CLUSTER)/bin/python -m pytest -m cluster tests/experiment/backends

# What a trainer of another project needs besides this kit lies over .venv in an environment of its own.
TRAINERS := $(notdir $(basename $(wildcard tests/trainers/requirements/*.txt)))

.venvs/%/installed: tests/trainers/requirements/%.txt $(VENV)/installed
	$(BIN)/python -m venv --clear .venvs/$*
	echo "import site; site.addsitedir('$$($(BIN)/python -c "$(SITE)")')" > $$(.venvs/$*/bin/python -c "$(SITE)")/beside.pth
	.venvs/$*/bin/python -m pip install --quiet --no-deps --requirement $<
	@touch $@

test-trainers: install $(TRAINERS:%=.venvs/%/installed) ## run the examples of docs/trainers, each trainer in its own environment
	$(BIN)/python -m pytest tests/trainers

peers: install .venvs/benchmarl/installed .venvs/rllib/installed .venvs/skrl/installed ## train other projects' trainers beside ours
	$(BIN)/python -m tests.peers

torture: install ## kill runs at random, damage checkpoints and fill disks, hundreds of times (an hour)
	$(BIN)/python -m tests.torture

lint: style types arrows ## check style, types and the arrows between the folders: what pre-commit checks too

style: install
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: install
	$(BIN)/mypy

arrows: install
	$(BIN)/lint-imports --no-logo

format: install ## put the code into the house style
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

docs: install ## build the pages of docs/ into docs/_build; warnings and broken links are errors
	$(BIN)/sphinx-build -E -W --keep-going -q docs docs/_build

reproduce: install ## train and evaluate all of runs/paper.yaml, then write its report; RUN=NAME takes runs/NAME.yaml
	$(BIN)/lawn-sb3 reproduce runs/$(RUN).yaml --jobs $(JOBS)

ablation: install ## train and evaluate all of runs/ablation.yaml, then write its report
	$(BIN)/lawn-sb3 reproduce runs/ablation.yaml --jobs $(JOBS)

ladder: install ## train and evaluate all of runs/ladder.yaml: what a UAV must know
	$(BIN)/lawn-sb3 reproduce runs/ladder.yaml --jobs $(JOBS)

report: install ## rebuild tables, figures and verdicts from the results kept in runs/reference, without training
	$(BIN)/lawn-sb3 report runs/paper.yaml --runs runs/reference/paper

bench: install ## measure the speed of simulator, environment and training
	$(BIN)/lawn-sb3 bench

clean: ## remove the virtual environment and caches, keep runs
	rm -rf $(VENV) $(CLUSTER) .venvs build dist docs/_build docs/_made *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
