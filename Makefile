# Needs Python >= 3.11, git and make. Everything is installed into .venv of this checkout.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin

# One cache of compiled code a checkout.
export NUMBA_CACHE_DIR := $(CURDIR)/.numba_cache
# Bytecode is kept, or each of the many processes of the tests would compile all modules that it imports.
unexport PYTHONDONTWRITEBYTECODE

.DEFAULT_GOAL := help
.NOTPARALLEL:
.PHONY: help demo lint warm forget test test-all fuzz speed chaos numbers table paper paper-quick study-pages validation site gallery meshes wheel try-wheel sdist hooks review clean

help:  ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "make %-10s %s\n", $$1, $$2}' Makefile

demo: $(VENV)/.installed  ## run the flexible nine-bar mechanism with clearance; results in out/demo
	$(BIN)/flexmb run nine-bar --speed 2pi --clearance 0.5mm --flexible --out out/demo
	@echo "Results in out/demo:"
	@ls -1 out/demo

lint: $(VENV)/.installed-dev
	$(BIN)/python -m ruff check .
	$(BIN)/python -m mypy

# Compilation uses one core and a half, so the source is checked meanwhile.  It takes a sixth less with fewer passes of
# LLVM, which change no bit of the golden runs; that code lies in a cache of its own, and is never what a user runs.
test: export NUMBA_OPT := 1
test: export NUMBA_LOOP_VECTORIZE := 0
test: export NUMBA_CACHE_DIR := $(CURDIR)/.numba_cache/quick
# Values beside a failed `assert` take a second
# a hundred files to prepare, so what failed runs once more with them.
test: $(VENV)/.installed-dev  ## checks of the source, and every test that is not slow
	$(BIN)/python tests/ship.py & $(MAKE) --no-print-directory lint && wait $$!
	$(BIN)/python -m pytest -n 2 --dist loadfile --durations=40 --assert=plain -m "not slow and not speed" \
	  || { $(BIN)/python -m pytest -n 0 --last-failed -m "not slow and not speed"; exit 1; }

test-all: forget warm lint  ## the same with the slow tests, on a fresh compilation cache
	$(BIN)/python -m pytest -n 2 --dist loadfile -m "not speed"

# Two processes that share a cache would compile everything twice, so all is compiled before them.
warm: $(VENV)/.installed-dev
	$(BIN)/python tests/ship.py

forget:
	rm -rf $(NUMBA_CACHE_DIR)

speed: $(VENV)/.installed-bench  ## timings, beside the peer's on the same models; docs/performance.md (wants a quiet machine)
	rm -rf out/speed
	$(BIN)/python -m pytest tests/speed -m "speed and not slow" -s; tested=$$?; \
	  $(BIN)/python docs/performance.py --only work-precision; $(BIN)/python docs/performance.py --collect; exit $$tested

chaos: $(VENV)/.installed  ## numbers and picture of docs/chaos.md: exponents and verdicts (half an hour)
	$(BIN)/python docs/chaos_table.py

# The special build is compiled once for each state of the code, in out/numbers; results in docs/numbers.json.
numbers: $(VENV)/.installed  ## numbers of docs/numbers.md: what thresholds and defaults do to results (three hours; goes on)
	$(BIN)/python docs/numbers_table.py

table: $(VENV)/.installed  ## numbers and pictures of docs/nine_bar.md, computed anew
	$(BIN)/python docs/nine_bar_table.py

fuzz: $(VENV)/.installed-dev  ## ten thousand random mechanisms, sound and damaged, and a hundred compared with themselves (three hours)
	$(BIN)/python tests/fuzz/fuzz.py --count 10000 --compare 100

# Hours on two cores (its own estimates add up to two), most of them for diagrams with exponents; goes on where it was.
# out/paper/times.md says what each run took. A look at everything within ten minutes: make paper-quick.
paper: $(VENV)/.installed  ## figures and tables of the study of the nine-bar mechanism; results in out/paper (two hours on two cores)
	$(BIN)/python examples/nine_bar_paper.py all --out out/paper

paper-quick: $(VENV)/.installed  ## a look at the whole study; results in out/paper-quick
	$(BIN)/python examples/nine_bar_paper.py --quick

study-pages: $(VENV)/.installed  ## every number of the pages on the nine-bar mechanism anew (eight hours of one core; goes on)
	$(BIN)/python docs/study_pages.py

validation: $(VENV)/.installed-dev  ## docs/validation.md: every problem of tests/literature beside its references
	$(BIN)/python docs/validation.py

# Warnings are errors; nothing in the pages is loaded from a network.
site: $(VENV)/.installed-docs  ## the documentation as a site, in out/site (a minute)
	$(BIN)/python -m sphinx -n -W --keep-going -q -b html -d out/site-cache docs out/site
	@echo "Open out/site/index.html"

gallery: $(VENV)/.installed  ## pictures and numbers of docs/gallery.md: every example runs (two minutes)
	$(BIN)/python docs/gallery_page.py

meshes: $(VENV)/.installed  ## write the meshes in meshes/ anew
	$(BIN)/python meshes/make_meshes.py --out meshes

# For this version of Python and of numba, on any x86-64 processor since 2013; elsewhere the wheel is a pure one.
wheel: $(VENV)/.installed-dev  ## a wheel in dist/ that carries compiled code: nothing is compiled where it is installed
	rm -rf build dist
	$(BIN)/python tests/ship.py build/shipment --wheel dist
	@ls -1 dist

try-wheel:  ## that wheel in a fresh environment: the first mechanism runs, and nothing is compiled
	rm -rf out/try
	$(PYTHON) -m venv out/try
	out/try/bin/python -m pip install --quiet dist/flexmb-*-cp*.whl
	cd out/try && env -u NUMBA_CACHE_DIR bin/python ../../tests/try_installed.py

sdist: $(VENV)/.installed-release  ## an archive of the sources in dist/, and the pure wheel that is built from it
	$(BIN)/python -m build --outdir dist

hooks: $(VENV)/.installed-release  ## hooks of git that check a commit
	$(BIN)/pre-commit install

review: $(VENV)/.installed-release  ## rules of a scientific package, form of CITATION.cff
	$(BIN)/sp-repo-review .
	$(BIN)/cffconvert --validate -i CITATION.cff

clean:  ## remove what was made: environment, caches, results
	rm -rf $(VENV) .numba_cache .pytest_cache .mypy_cache .ruff_cache .hypothesis build dist *.egg-info out
	find flexmb tests docs examples meshes -name __pycache__ -type d -prune -exec rm -rf {} +

# Stamps: an installation is repeated when pyproject.toml is newer.  Modules are byte-compiled when first imported: most
# of those of the dependencies never are.
$(VENV)/.created:
	@$(PYTHON) -c 'import sys; sys.version_info >= (3, 11) or sys.exit("flexmb needs Python >= 3.11, this is " \
	  + sys.version.split()[0] + ". Name another one: make PYTHON=python3.12 ...")'
	$(PYTHON) -m venv $(VENV)
	touch $@

# Groups of requirements (`--group`) are known to pip from 25.1 on, newer than that of many a Python.
INSTALL = $(BIN)/python -m pip install --quiet "pip>=25.1" && $(BIN)/python -m pip install --quiet --no-compile --editable

$(VENV)/.installed: pyproject.toml | $(VENV)/.created
	$(BIN)/python -m pip install --quiet --no-compile --editable .
	touch $@

# With the extras that have tests, so that none is left out.
$(VENV)/.installed-dev: pyproject.toml | $(VENV)/.created
	$(INSTALL) ".[sweep,film,fatigue,live]" --group dev
	touch $@ $(VENV)/.installed

$(VENV)/.installed-docs: pyproject.toml | $(VENV)/.created
	$(INSTALL) . --group docs
	touch $@ $(VENV)/.installed

$(VENV)/.installed-release: $(VENV)/.installed-dev
	$(INSTALL) . --group release
	touch $@

$(VENV)/.installed-bench: $(VENV)/.installed-dev
	$(INSTALL) . --group bench
	touch $@
