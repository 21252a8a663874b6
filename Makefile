# Two commands for a new user: `make demo` and `make test`. Everything they need is set up by them.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
READY  := $(VENV)/ready
COMPILED := $(VENV)/compiled
LOADED := $(VENV)/tests-loaded

# Hundreds of processes are started by tests: each would compile our sources again.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo test test-long test-kernel lint types contracts check wheel wheel-installed wheel-extra lock bill clean

demo: $(COMPILED)
	$(BIN)/rigctl demo

test: $(COMPILED) $(LOADED)
	$(BIN)/python -m pytest -n 4 --dist worksteal

# Of the files that hold long tests alone: each process loads all that it is given. A process that
# is free takes the next file: none is left with minutes of tests that it cannot give away, and what
# the tests of a file share is made once.
test-long: $(COMPILED) $(LOADED)
	$(BIN)/python -m pytest -n 3 --dist loadfile --no-loadscope-reorder -m long $$(grep -rl --include='test_*.py' 'mark\.long' tests)

# Drivers on a real kernel, in a virtual machine; skipped with the reason where it cannot be had.
test-kernel: $(READY)
	$(BIN)/python -m pytest -m kernel tests/kernel

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(READY)
	$(BIN)/mypy

contracts: $(READY)
	$(BIN)/lint-imports
	$(BIN)/python packaging/imports.py

check: lint types contracts

$(READY): requirements.lock pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --no-compile --require-hashes -r requirements.lock
	# On all cores, where pip takes one. Packages hold templates that are no Python.
	-$(BIN)/python -m compileall -qq -j 0 $(VENV)/lib
	$(BIN)/python -m pip install --quiet --no-deps --no-build-isolation -e .
	touch $@

# Two processes, some 115 s, once: no first shot waits for the compiler.
$(COMPILED): $(READY)
	$(BIN)/rigctl precompile
	touch $@

# Python's own compilation of tests and sources, once: each of the processes that run the tests
# would do all of it by itself. What fails to load is said by the tests.
$(LOADED): $(READY)
	-$(BIN)/python -m pytest --collect-only --quiet > $@.log
	touch $@

# One wheel, into dist.
wheel: $(READY)
	rm -rf dist
	$(BIN)/python -m hatchling build -t wheel

# The wheel alone in an environment of its own, with what runs a rig.
wheel-installed:
	rm -rf out/wheel
	$(PYTHON) -m venv out/wheel
	out/wheel/bin/python -m pip install --quiet --no-compile --require-hashes -r requirements-run.lock
	out/wheel/bin/python -m pip install --quiet --no-deps dist/*.whl
	out/wheel/bin/rigctl --version
	out/wheel/bin/python packaging/notebook.py

# The wheel with an extra, from the index: EXTRA names it.
wheel-extra:
	rm -rf out/extra
	$(PYTHON) -m venv out/extra
	out/extra/bin/python -m pip install --quiet --find-links dist "rigctl[$(EXTRA)]"
	out/extra/bin/rigctl --version
	out/extra/bin/python packaging/notebook.py

# Hashes only: neither an index address nor a header that names one may enter a lock.
EXPORT := -m uv export --quiet --no-header --no-emit-project --no-annotate

# What runs a rig, and what develops it too.
lock:
	$(PYTHON) -m uv lock --quiet
	$(PYTHON) $(EXPORT) > requirements-run.lock
	$(PYTHON) $(EXPORT) --all-extras --no-extra benchmarks --no-extra genicam > requirements.lock

# Bill of materials of the packages that run a rig, in the form CycloneDX 1.5.
bill:
	mkdir -p out
	$(PYTHON) -m uv export --quiet --no-emit-project --format cyclonedx1.5 > out/packages.cdx.json

clean:
	rm -rf $(VENV) dist .pytest_cache .mypy_cache .ruff_cache
