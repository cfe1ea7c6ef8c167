# Every command that README names. A person and CI run the same words.
PYTHON ?= python3
BIN := .venv/bin
export PYTHONDONTWRITEBYTECODE :=
export MPLBACKEND ?= Agg
# The real flights: a folder here, else fetched by address and hash into the user's cache.
ifneq ($(wildcard ../shared/data/README.md),)
export UAVLAB_DATA ?= $(abspath ../shared/data)
endif

.PHONY: help setup demo test test-fast check lint format types imports spell labs lab book ship bench reproduce golden lock clean

help:  ## what there is to run
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## /\1|/' | column -t -s '|'

setup: .venv/.ready  ## the locked environment in .venv, and Debian's bubblewrap and chromium

.venv/.ready: requirements.lock pyproject.toml .ci/setup
	@.ci/setup "$(PYTHON)"
	@touch $@

demo: setup  ## the main job: two labs from source to grade, and a 3D replay
	$(BIN)/python -m grader.demo

test: setup lint types imports spell  ## everything that must hold; CI runs this
	$(BIN)/python -m pytest -n auto --dist loadfile --no-loadscope-reorder

test-fast: setup  ## the tests of under a minute
	$(BIN)/python -m pytest -m "not slow and not lab" -n auto --dist loadfile --no-loadscope-reorder

check: test  ## the same as test: lint, types, imports, spelling, tests

lint: setup
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .

format: setup  ## format the code and mend what ruff can
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

types: setup
	$(BIN)/pyright

imports: setup
	$(BIN)/lint-imports

spell: setup
	$(BIN)/codespell

labs: setup  ## build the instructor's and the students' notebooks into build/course
	$(BIN)/python -m grader.build

LAB ?= dynamics
lab: setup labs  ## open JupyterLab on a student's lab: make lab LAB=mpc
	$(BIN)/python -m grader.build --open $(LAB)

book: setup  ## build the book into build/book
	$(BIN)/python -m grader.build --book

ship: setup  ## the two wheels and the student archive in dist/
	$(BIN)/python -m grader.ship

bench: build/bench/.ready  ## side by side with RotorPy, MuJoCo, filterpy and ahrs, as ratios from one run
	build/bench/bin/python -m benchmarks

build/bench/.ready: .venv/.ready benchmarks/requirements.lock
	$(PYTHON) -m venv build/bench
	$(BIN)/uv pip install -q --python build/bench/bin/python --no-deps --require-hashes -r benchmarks/requirements.lock
	@touch $@

lock:  ## resolve the dependencies again into requirements.lock and benchmarks/requirements.lock
	$(BIN)/uv pip compile -q --universal --generate-hashes --no-emit-index-url --no-annotate --no-header \
	  --group grader --group test --group check --group book --group lab pyproject.toml -o requirements.lock
	$(BIN)/uv pip compile -q --universal --generate-hashes --no-emit-index-url --no-annotate --no-header \
	  -c requirements.lock --group bench pyproject.toml -o benchmarks/requirements.lock

reproduce: setup  ## fly every published experiment again, into book/reproductions
	-$(BIN)/uavlab reproduce --all --jobs 2 --out book/reproductions

golden: setup  ## write the golden flights anew; read the difference
	$(BIN)/python -m tests.flight.test_golden

clean:  ## remove what was built (not the environment)
	rm -rf build dist book/_build book/labs
