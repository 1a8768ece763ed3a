# Two commands do everything: `make studio` and `make test`.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

.PHONY: studio test quick lint types unit browser smoke benchmark latency screenshots gallery pretrain gait clean

studio: $(VENV)/.installed
	$(BIN)/tgpo-studio $(ARGS)

test: $(VENV)/.installed-dev lint types unit

# Everything that neither compiles a trainer nor opens a browser.
quick: $(VENV)/.installed-dev lint
	$(BIN)/pyright & types=$$!; $(BIN)/pytest -q -m "not slow" $(ARGS) && wait $$types

lint: $(VENV)/.installed-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(VENV)/.installed-dev
	$(BIN)/pyright

# A browser draws on the processor and has to keep up with the mouse: nothing runs beside it.
unit: $(VENV)/.installed-dev browser
	$(BIN)/pytest -m "not browser" --numprocesses 2 --dist loadfile
	$(BIN)/pytest -m browser

browser: $(VENV)/.installed-dev
	$(BIN)/python -m tests.tools.browser

# Every method trains for two epochs: that it works, not how well.
smoke: $(VENV)/.installed-dev
	out=$$(mktemp -d) && $(BIN)/tgpo-bench run smoke --out $$out && $(BIN)/tgpo-bench report $$out

benchmark: $(VENV)/.installed-dev
	$(BIN)/tgpo-bench $(ARGS)

latency: $(VENV)/.installed-dev browser
	$(BIN)/python -m tests.tools.page_latency $(ARGS)
	$(BIN)/python -m tests.tools.page_dragging

screenshots: $(VENV)/.installed-dev browser
	$(BIN)/python -m tests.tools.screenshots $(ARGS)

gallery: $(VENV)/.installed-dev
	$(BIN)/python -m tests.tools.gallery $(ARGS)

pretrain: $(VENV)/.installed
	$(BIN)/tgpo-studio --pretrain $(ARGS)

gait: $(VENV)/.installed
	$(BIN)/python -m envs.ant.gait_training $(ARGS)

$(VENV)/.installed: pyproject.toml requirements.lock | $(VENV)
	$(BIN)/pip install --quiet --constraint requirements.lock --editable .
	touch $@

$(VENV)/.installed-dev: pyproject.toml requirements.lock | $(VENV)
	$(BIN)/pip install --quiet --constraint requirements.lock --editable '.[dev]'
	touch $@ $(VENV)/.installed

# Debian keeps venv in a package of its own.
$(VENV):
	$(PYTHON) -m venv $@ || { rm -rf $@; test "$$(id -u)" = 0 && apt-get update -qq && \
	  apt-get install -y -qq python3-venv && $(PYTHON) -m venv $@; } || \
	  { rm -rf $@; echo "Python's venv module is missing: apt install python3-venv" >&2; exit 1; }
	$(BIN)/pip install --quiet --upgrade pip

clean:
	rm -rf $(VENV) build dist *.egg-info .pytest_cache .ruff_cache .hypothesis test-results
