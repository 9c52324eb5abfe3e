# The same verbs for people and CI. Each one sets up what it needs.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
JOBS ?= 2
# Where PyTorch comes from; empty: as pip finds it, which on Linux is a build for CUDA with 5 GB of libraries.
# For the CPU: make setup TORCH_INDEX=https://download.pytorch.org/whl/cpu
TORCH_INDEX ?=
# Interpreters of `make test-pythons`: names or paths.
PYTHONS ?= python3.11 python3.12 python3.13
# One thread a process: torch and numpy gain nothing from more, and the tests run side by side.
export OMP_NUM_THREADS ?= 1

.PHONY: setup links train test test-slow test-pythons unit mutants lint type layers bench docs site examples notebooks viewer test-viewer pictures

setup: links $(STAMP)

# A link that arrived as a text file (unpacked ZIP): Python finds the folder without it, the checkers do not.
links:
	@for name in callbacks policies tuning; do \
		test -d hexwar_sb3/$$name || { rm -f hexwar_sb3/$$name; ln -s ../$$name hexwar_sb3/$$name; }; \
	done

$(STAMP): setup.cfg pyproject.toml constraints.txt
	@echo "installing packages into $(VENV): minutes, and 2 GB, or 6 GB with PyTorch for CUDA"
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(if $(TORCH_INDEX),$(BIN)/python -m pip install --quiet --no-deps -c constraints.txt --index-url $(TORCH_INDEX) torch)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e ".[dev]"
	touch $@

# A training alone takes two cores.
train: export OMP_NUM_THREADS = 2
train: setup
	$(BIN)/hexwar train --progress

test: lint type layers unit

unit: setup
	$(BIN)/python -m pytest -n $(JOBS) --dist loadgroup -m "not slow"

test-slow: lint type layers
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e ".[docs,ray]"
	$(BIN)/python -m pytest -n $(JOBS) --dist loadgroup

# The wheel, installed and tested under each Python, in build/; some minutes and, with PyTorch for CUDA, 5 GB each.
test-pythons:
	TORCH_INDEX=$(TORCH_INDEX) $(PYTHON) -m tests.pythons --jobs $(JOBS) $(PYTHONS)

# One change in the code at a time: do the tests see it? What they do not is in results/mutants.txt.
mutants: setup
	NUMBA_DISABLE_JIT=1 $(BIN)/python -m tests.mutate

lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

type: setup
	$(BIN)/mypy

layers: setup
	$(BIN)/lint-imports

bench: setup
	$(BIN)/hexwar bench

# The page that shows games and the one of `hexwar play`: hexwar_sb3/viewer/built/, of the sources in viewer/. Needs Node; nothing else here does.
viewer: viewer/node_modules/.installed
	cd viewer && npx tsc && npx vitest run && npm run --silent build

viewer/node_modules/.installed: viewer/package.json viewer/package-lock.json
	cd viewer && npm ci --no-audit --no-fund
	touch $@

# Built anew it is the same file, and in a browser it shows what the games say. Needs Chromium, too.
test-viewer: setup viewer
	git diff --exit-code hexwar_sb3/viewer/built
	SPEED=yes $(BIN)/python -m pytest -q -m browser tests/viewer tests/server

# The pictures of docs/watch.md, of games that are played for them and of a training; look at each of them.
RUN ?= runs/commander_1
pictures: setup viewer
	$(BIN)/python -m tests.viewer.pictures $(RUN)

# docs/features.md is the feature table of the code; the tables of docs/rules.md are its rule tables,
# and the server of `hexwar play` has all of it as a page.
docs: setup
	printf '# Features\n\nMade by `make docs` from the table in hexwar_sb3/tasks/features.py.\n\n' > docs/features.md
	$(BIN)/python -c "from hexwar_sb3.tasks.features import markdown; print(markdown(), end='')" >> docs/features.md
	$(BIN)/python -c "import pathlib; from hexwar_sb3.rules.page import filled; page = pathlib.Path('docs/rules.md'); page.write_text(filled(page.read_text('utf-8')), 'utf-8')"
	$(BIN)/python -m hexwar_sb3.server.rule_book docs/rules.md

# The guide, the notebooks as they were committed, and the public names, into site/; what is broken or undocumented ends it.
site: setup
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e ".[docs]"
	rm -rf site
	$(BIN)/python -m sphinx -q -E -W --keep-going -c docs -d build/doctrees . site

examples: setup
	$(BIN)/python -m pytest -q tests/examples

# Runs the notebooks and writes their outputs into them; `make examples` compares.
notebooks: setup
	$(BIN)/python -m tests.examples.notebooks
