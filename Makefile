SCENARIO ?= spheres_wall
SEED ?= 0
PAGE ?= $(SCENARIO)-$(SEED).html
WORKERS ?= 2
MINUTES ?= 10
INPUTS ?= 250
BIN := .venv/bin

.DEFAULT_GOAL := help
.PHONY: help run test check lint types scripts format site schema table hands figures licences gallery screenshots fuzz matrix doctor ci clean

help:  ## Show this list
	@grep -E '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 14

# The library alone, in the versions that the tests ran with.
.venv/library: pyproject.toml constraints.txt
	python3 -m venv .venv
	$(BIN)/pip install --quiet --disable-pip-version-check -c constraints.txt -e .
	@touch $@

# The library and what the tests and checks need.
.venv/development: pyproject.toml constraints.txt
	python3 -m venv .venv
	$(BIN)/pip install --quiet --disable-pip-version-check -c constraints.txt -e ".[dev]"
	@touch .venv/library $@

run: .venv/library  ## Run one attempt and name its page: make run SCENARIO=spheres_corner SEED=3
	@$(BIN)/pilegrasp run $(SCENARIO) --seed $(SEED) --html $(PAGE)
	@echo "Open this page in a browser: file://$(CURDIR)/$(PAGE)"

test: .venv/development  ## Run every test
	$(BIN)/python -m pytest -n $(WORKERS) --dist worksteal

check: lint types  ## Check style and types, and run the tests that are not slow
	$(BIN)/python -m pytest -n $(WORKERS) --dist worksteal -m "not slow"

lint: .venv/development  ## Check style, formatting and spelling
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/codespell $$(git ls-files 2>/dev/null || echo .)

types: .venv/development scripts  ## Check the types
	$(BIN)/mypy

scripts:  ## Check the types of the pages' scripts, if tsc is installed (on Debian: apt-get install node-typescript)
	@if command -v tsc >/dev/null; then tsc -p viewer/browser; \
	elif [ "$$CI" = true ]; then echo "tsc is not installed"; exit 1; \
	else echo "tsc is not installed; the scripts of the pages are not checked"; fi

format: .venv/development  ## Repair style and formatting where that is safe
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

site: .venv/development  ## Build the documentation as a site with a search: open build/site/index.html
	NO_MKDOCS_2_WARNING=true $(BIN)/mkdocs build --quiet --strict -f docs/site/mkdocs.yml
	$(BIN)/python docs/site/check.py build/site

table: .venv/development  ## Print the table of scenario keys for docs/scenarios.md
	@$(BIN)/python tests/helpers/scenario_table.py

schema: .venv/development  ## Write the JSON schema of scenario files
	$(BIN)/pilegrasp show --schema > build.schema.json && mv build.schema.json scenarios/scenario.schema.json

hands: .venv/development  ## Write the hands' MJCF and README values from their robot.toml
	$(BIN)/python tests/helpers/hand_files.py

figures: .venv/development  ## Measure the numbers of docs/figures.toml again and write them into the pages
	$(BIN)/python docs/studies/figures.py

licences: .venv/development  ## Write the table of licences into docs/licences.md
	$(BIN)/python tests/helpers/licence_table.py

gallery: .venv/development  ## Run the attempts of docs/gallery.toml, take their pictures and write docs/gallery.md
	$(BIN)/python docs/studies/gallery.py

screenshots: .venv/development  ## Take the pictures of docs/viewer.md
	$(BIN)/pilegrasp sweep spheres_wall --vary support.kind=none,wall --seeds 0:3 --record all --out build/study
	$(BIN)/pilegrasp report build/study
	mkdir -p docs/pictures
	$(BIN)/python docs/studies/screenshots.py build/study docs/pictures

fuzz: .venv/development  ## Try to break it: damaged files, odd command lines, signals, bad servers; 10 minutes a kind
	$(BIN)/python tests/fuzz/table.py --minutes $(MINUTES) --inputs $(INPUTS) --seed $(SEED)

matrix: .venv/development  ## Test Python 3.11 and 3.13 with the lowest and the newest packages; writes the outcome into the notes
	$(BIN)/python tests/helpers/matrix.py

doctor: .venv/library  ## Check the installation
	$(BIN)/pilegrasp doctor

ci:  ## Everything a change must pass, from a bare Debian machine on
	.ci/run

clean:  ## Remove what tools and builds leave behind
	rm -rf build dist *.egg-info .pytest_cache .mypy_cache .ruff_cache
	find . -name __pycache__ -not -path './.venv/*' -prune -exec rm -rf {} +
