# The commands of daily work; CI runs the same ones. Each sets the environment up first, as far as it needs it.
#
#   make setup          the environment a mission needs
#   make test           all tests but the slow ones      PYTEST_ARGS="tests/unit -k winch" runs some
#                                                      TEST_WITH="test learning": those that train too (torch);
#                                                      "test learning cluster": those on a Ray cluster too
#   make test-all       the slow ones too
#   make view           what shows missions (Rerun), for run_mission.py --view and view_mission.py
#   make lint           linter, formatter and type checker, check only; `make format` puts right what
#                                                      the first two can
#   make stubs          types of the messages for the type checker, after a change of a message
#   make bench          all benchmarks                   BENCH=engine runs one, BENCH_ARGS=--smoke a short run
#   make evaluate       policies on unseen scenarios     EVALUATE_ARGS="--mus 8 --policy PATH/policy.safetensors"
#   make cards          measures the shipped models anew and writes their cards, after a change of physics or control
#   make report-libraries  builds anew what a report carries (three.js, uPlot), by requirements/report; needs npm
#   make ros2cli        the stock ros2 command in .venv, fetched by git: .venv/bin/ros2 topic echo /mu3/thrust
#   make docs           the documentation site into site/, warnings are errors
#   make lock           pins all packages anew, after a change in requirements/
#   make clean          removes the environment and all that was built

PYTHON ?= python3
BENCH ?= engine mission contact net_contact graph scale
BENCH_ARGS ?=
EVALUATE_ARGS ?=
PYTEST_ARGS ?=
TEST_WITH ?= test

SETUP = $(PYTHON) -m bootstrap

.PHONY: setup view test test-all lint format stubs bench evaluate cards report-libraries ros2cli docs lock clean

setup:
	$(SETUP) mission

view:
	$(SETUP) view

test:
	$(SETUP) $(TEST_WITH) -- -m pytest $(PYTEST_ARGS)

test-all:
	$(SETUP) $(TEST_WITH) -- -m pytest -m "" $(PYTEST_ARGS)

lint:
	$(SETUP) lint -- -m ruff check .
	$(SETUP) lint -- -m ruff format --check .
	$(SETUP) lint -- -m mypy

format:
	$(SETUP) lint -- -m ruff check --fix .
	$(SETUP) lint -- -m ruff format .

stubs:
	$(SETUP) lint -- -m typings.make_stubs

bench:
	@set -e; for name in $(BENCH); do echo "benchmark $$name"; $(SETUP) bench -- -m benchmarks.$$name $(BENCH_ARGS); done

evaluate:
	$(SETUP) mission -- -m tethernet_bringup.cli evaluate policies $(EVALUATE_ARGS)

cards:
	$(SETUP) mission -- -m tethernet_bringup.cli models cards

report-libraries:
	$(SETUP) mission -- -m tethernet_bringup.report.libraries.renew

ros2cli:
	$(SETUP) ros2cli

docs:
	$(PYTHON) -m bootstrap.docs

lock:
	$(PYTHON) -m bootstrap.pins

clean:
	rm -rf .venv .venv.* ros2_ws/build ros2_ws/install ros2_ws/log site .pytest_cache .ruff_cache .mypy_cache
	find . -name __pycache__ -prune -exec rm -rf {} +
	find ros2_ws/src -name "*.egg-info" -prune -exec rm -rf {} +
