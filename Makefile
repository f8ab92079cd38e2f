# `make stand` and `make test` do all set-up themselves; everything lives in .venv.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# modules are compiled when they are imported first: most never are
INSTALL := $(BIN)/python -m pip install --disable-pip-version-check --no-compile -c constraints.txt
# Pinocchio's C++ headers and CMake files, 0.25 GB that nobody here compiles against
PREFIX := $(VENV)/lib/python3*/site-packages/cmeel.prefix
TRIM = rm -rf $(PREFIX)/include $(PREFIX)/share/cmake
# meshes of arms, hands and drones that no name of a robot leads to: standing needs none of them
ARMS := alex allegro_hand asr_twodof baxter borinot hextilt iris pr2 so_arm tiago tiago_pro xarm
# a crashed worker is not started again: with groups the rest would wait for it for ever
PYTEST := $(BIN)/python -m pytest -n 2 --dist loadgroup --max-worker-restart 0 -q
.DEFAULT_GOAL := help
.PHONY: help setup stand lint test quick test-all test-extras test-mujoco test-release bench docs course site clean

help: ## list the targets
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 14

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(0 if sys.version_info >= (3, 11) else "Surefoot needs Python 3.11 or newer, this is " + sys.version)'
	@echo "setting up: a virtual environment in $(VENV)"
	@$(PYTHON) -m venv $(VENV)

# What standing needs; what tests, plans, files and frameworks need comes with $(VENV)/.installed, stamps of their own.
$(VENV)/.stand: pyproject.toml constraints.txt | $(BIN)/python
	@echo "setting up: downloading and installing what standing needs (extras robot, sim, viz: 1.2 GB on disk)"
	@$(INSTALL) -e '.[robot,sim,viz]'
	@$(TRIM) $(foreach name,$(ARMS),$(PREFIX)/share/example-robot-data/robots/$(name)_description)
	@touch $@

$(VENV)/.installed: pyproject.toml constraints.txt | $(BIN)/python
	@echo "setting up: downloading and installing everything (extras all, dev: 3 GB on disk)"
	@$(INSTALL) -e '.[all,dev]'
	@$(TRIM)
	@touch $@ $(VENV)/.stand

setup: $(VENV)/.installed ## make the whole virtual environment: what `make test` needs

stand: $(VENV)/.stand ## the main job: a simulated Go2 stands on its contact forces
	$(BIN)/surefoot stand go2 --out runs

lint: setup ## ruff, mypy strict, import-linter
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

test: setup ## lint beside every test that is not long: minutes
	@$(MAKE) --no-print-directory -j2 lint quick

# what `make test` runs beside lint, whose type checker has one thread
quick: setup
	$(PYTEST) -m "not long"

test-all: test ## what `make test` runs, then the long tests: hunts, long walks, whole pages
	$(PYTEST) -m long

test-extras: setup ## install the large extras (torch, mjx, gymnasium, ray, dask: gigabytes) and run their tests
	$(INSTALL) --quiet -e '.[torch,mjx,gym,scale]'
	$(BIN)/python -m pytest -q tests/contact/batch tests/worlds/sweep tests/worlds/training tests/records/audit/batch tests/worlds/experiments/test_engines.py tests/benchmarks/test_batch_bench.py

OLD_MUJOCO := 3.11.0
test-mujoco: setup ## the tests of MuJoCo's loops and worlds with the oldest MuJoCo that is supported
	$(BIN)/python -m pip install --disable-pip-version-check --quiet --no-deps --target $(VENV)/mujoco-$(OLD_MUJOCO) mujoco==$(OLD_MUJOCO)
	PYTHONPATH=$(CURDIR)/$(VENV)/mujoco-$(OLD_MUJOCO) $(PYTEST) -m "not long" tests/worlds/mujoco

test-release: setup ## build the wheel and install it with every extra in clean environments (gigabytes)
	SUREFOOT_RELEASE=1 $(BIN)/python -m pytest -q tests/test_release.py

# QUICK=--quick takes a small sample and leaves the docs' tables as they are
bench: setup ## every benchmark, one after the other; sets the docs' measured tables anew
	$(if $(QUICK),,$(BIN)/python -m docs.tables)
	$(BIN)/surefoot bench forces $(QUICK)
	$(BIN)/surefoot bench statics $(QUICK)
	$(BIN)/surefoot bench contact $(QUICK) --out runs
	$(BIN)/surefoot bench contact --scale large $(QUICK) --out runs
	$(BIN)/surefoot bench contact --sequences $(QUICK) --out runs
	$(BIN)/surefoot bench walk $(QUICK)
	$(BIN)/surefoot bench faults $(QUICK) --out runs

docs: setup ## the documentation site in docs/build/html: every page run, every link and shown command checked
	$(INSTALL) --quiet -e '.[docs]'
	$(BIN)/python docs/check.py
	@$(MAKE) --no-print-directory -j2 course site

# what `make docs` does at once: each has stretches on one core
course: setup
	$(BIN)/python -m docs.course --check --jobs 2

site: setup
	$(BIN)/python -m docs.site

clean: ## remove caches and the virtual environment
	rm -rf $(VENV) .mypy_cache .ruff_cache .pytest_cache .hypothesis docs/build
