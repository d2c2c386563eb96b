PYTHON ?= $(if $(wildcard .venv/bin/python),.venv/bin/python,python3)
PILEGRASP ?= $(if $(wildcard .venv/bin/pilegrasp),.venv/bin/pilegrasp,pilegrasp)
SCENARIO ?= spheres_wall
SEED ?= 0

.DEFAULT_GOAL := help
.PHONY: help setup test lint types format table hands run screenshots doctor ci clean

help:  ## Show this list
	@grep -E '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 14

setup:  ## Make .venv and install the locked versions
	python3 -m venv .venv
	.venv/bin/pip install -c constraints.txt -e ".[dev]"

test:  ## Run the tests
	$(PYTHON) -m pytest -n 2

lint:  ## Check style and formatting
	$(PYTHON) -m ruff check .
	$(PYTHON) -m ruff format --check .

types:  ## Check the types
	$(PYTHON) -m mypy

format:  ## Repair style and formatting where that is safe
	$(PYTHON) -m ruff check --fix .
	$(PYTHON) -m ruff format .

table:  ## Print the table of scenario keys for docs/scenarios.md
	@$(PYTHON) tests/helpers/scenario_table.py

hands:  ## Write the hands' MJCF and README values from their robot.toml
	$(PYTHON) tests/helpers/hand_files.py

run:  ## Run one attempt: make run SCENARIO=spheres_corner SEED=3
	$(PILEGRASP) run $(SCENARIO) --seed $(SEED) --html $(SCENARIO).html

screenshots:  ## Take the pictures of docs/viewer.md
	$(PILEGRASP) sweep spheres_wall --vary support.kind=none,wall --seeds 0:3 --record all --out build/study
	$(PILEGRASP) report build/study
	mkdir -p docs/pictures
	$(PYTHON) docs/studies/screenshots.py build/study docs/pictures

doctor:  ## Check the installation
	$(PILEGRASP) doctor

ci:  ## Everything a change must pass, in a fresh environment
	.ci/run

clean:  ## Remove what tools and builds leave behind
	rm -rf build dist *.egg-info .pytest_cache .mypy_cache .ruff_cache
	find . -name __pycache__ -not -path './.venv/*' -prune -exec rm -rf {} +
