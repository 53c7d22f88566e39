# make demo: set up and run the main job · make test: set up and run the tests · make lint: the linters CI runs
# make nightly: ten minutes of flipped CAN bits
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
RUNS := $(VENV)/.runs
# where the environment forbids it to keep compiled modules, each of the many processes of the tests compiles all it imports
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo test vcan lint benchmark nightly clean

# what follows it is installed; Python compiles what it imports
define install
$(PYTHON) -m venv $(VENV)
$(BIN)/pip install --quiet --upgrade pip
$(BIN)/pip install --quiet --no-compile --editable
endef

$(STAMP): pyproject.toml
	$(install) '.[test]'
	touch $@ $(RUNS)

$(RUNS): pyproject.toml
	$(install) .
	touch $@

# exit code 3: inconclusive, mostly since the machine was too busy for real time
demo: $(RUNS)
	$(BIN)/bench run friction/e4_abs_dry_95 || { [ $$? -eq 3 ] && \
	echo "Inconclusive, as where a machine is too busy for real time. The same stop in virtual time:" && \
	$(BIN)/bench run friction/e4_abs_dry_95 --lockstep; }

test: $(STAMP)
	$(BIN)/pytest $(PYTEST_OPTIONS)

vcan: $(STAMP)
	ci/can_kernel $(BIN)/pytest tests/vcan $(PYTEST_OPTIONS)

lint: $(STAMP)
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/lint-imports

benchmark: $(STAMP)
	$(BIN)/python -m benchmarks.smoke

nightly: $(STAMP)
	$(BIN)/pytest -m nightly $(PYTEST_OPTIONS)
	$(BIN)/python -m benchmarks.can_escapes

clean:
	rm -rf $(VENV) .pytest_cache .mypy_cache .ruff_cache .import_linter_cache
