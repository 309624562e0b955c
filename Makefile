# `make help` lists the targets.
.DEFAULT_GOAL := help
.PHONY: help demo check install bags report ros1 ros2 web wyoming training docs test coverage fixtures promises constraints
.PHONY: benchmark clean lowest hour types counted

# One process waits for most of its time: of the tests that need real seconds.
SIDE_BY_SIDE = --dist loadfile --max-worker-restart 0 -n $$(($(shell getconf _NPROCESSORS_ONLN) + 1))
# Of what decides how a robot moves every line is tested. To count all lines takes half as long again: `make coverage`.
COUNTED = --cov=voz.control --cov-report=term-missing --cov-fail-under=100 tests/control
PURE = tests/robot/simulation tests/language tests/apps/evaluation tests/audio \
	$(filter-out tests/test_first_hour.py tests/test_examples.py,$(wildcard tests/test_*.py))

# Containers often set it: then every process of the tests would compile voz anew.
unexport PYTHONDONTWRITEBYTECODE

help: ## Show this list
	@sed -n 's/^\([a-z0-9]*\):.*## /\1\t/p' $(MAKEFILE_LIST) | expand -t 12

demo: ## Install what is missing, then drive a console and a simulated robot by a recording
	@sh tools/install.sh demo
	@sh tools/demo.sh

install: ## Install voz into .venv, with the system packages it needs
	@sh tools/install.sh

bags: ## Install what --bag and --replay need
	@sh tools/install.sh bags

report: ## Install what `voz eval` and pictures need
	@sh tools/install.sh report

ros2: ## Install what --robot ros2 needs; no ROS
	@sh tools/install.sh ros2

web: ## Install what --web needs: the operator page
	@sh tools/install.sh web

wyoming: ## Install what `voz serve` and `voz run --wyoming` need
	@sh tools/install.sh wyoming

ros1: ## Install voz for ROS 1 into .venv-ros1, with the system packages of ROS 1
	@sh tools/install.sh ros1

training: ## Install what teaches the network: PyTorch, into .venv-training
	@sh tools/install.sh training

docs: ## Build the documents, with the reference made from the program, into site/
	@sh tools/install.sh docs
	.venv/bin/python tools/make_reference.py
	NO_MKDOCS_2_WARNING=1 .venv/bin/mkdocs build

check: ## Check style and types, and run the tests of what is pure or quick, in a minute
	@sh tools/install.sh tests
	.venv/bin/ruff check .
	.venv/bin/ruff format --check .
	.venv/bin/mypy
	.venv/bin/python -m pytest -q $(SIDE_BY_SIDE) -m "not slow and not realtime" tests/control $(PURE)

test: ## Install what the tests need, then check style and types and run all tests
	@sh tools/install.sh tests
	.venv/bin/ruff check .
	.venv/bin/ruff format --check .
	@$(MAKE) --no-print-directory --jobs 2 --output-sync types counted
	.venv/bin/python -m pytest -q $(SIDE_BY_SIDE) --ignore=tests/control

types:
	.venv/bin/mypy
	.venv/bin/mypy benchmarks
	.venv/bin/mypy tools
	.venv/bin/mypy examples

counted:
	.venv/bin/python -m pytest -q $(SIDE_BY_SIDE) $(COUNTED)

# The first numpy that is allowed loads more of itself than later ones. docopt has no wheel.
lowest: ## Run the quick tests with the lowest versions of packages that pyproject.toml allows
	@sh tools/install.sh tests
	[ -x .venv-lowest/bin/uv ] || python3 -m venv .venv-lowest
	.venv-lowest/bin/python -m pip install --quiet --disable-pip-version-check uv
	.venv-lowest/bin/uv pip install --quiet --python .venv-lowest/bin/python --resolution lowest-direct \
		--only-binary :all: --no-binary voz-robot --no-binary docopt --editable ".[dev]"
	.venv-lowest/bin/python -m pytest -q -W default -m "not slow and not realtime" tests/control $(PURE) \
		--deselect tests/audio/test_levels.py::test_to_understand_a_recording_loads_neither_masked_arrays_nor_openssl

hour: ## Type what README and the lesson show in a fresh clone, and time each step
	python3 tools/first_hour.py

coverage: ## Run all tests and show which lines and branches of voz/ they do not reach
	@sh tools/install.sh tests
	.venv/bin/python -m pytest -q $(SIDE_BY_SIDE) --cov --cov-report=term-missing

fixtures: ## Make the recordings of audio_fixtures/ anew
	@sh tools/install.sh tests
	.venv/bin/python tools/make_fixtures.py

promises: ## Write the tables of docs/promises.md anew, from the tests that prove them
	@sh tools/install.sh tests
	.venv/bin/python tools/make_promises.py

constraints: ## Write the versions that are installed and tested into constraints.txt
	@sh tools/install.sh tests
	.venv/bin/python tools/make_constraints.py

benchmark: install ## Print the figures of docs/figures.md on what it costs
	.venv/bin/python benchmarks/decode.py
	.venv/bin/python benchmarks/build_lm.py

clean: ## Remove what was installed and made here; system packages stay
	rm -rf .venv .venv-lowest .venv-rclpy .venv-ros1 .venv-training tests/*/node_modules demo demo.png build dist site docs/reference
	rm -rf .mypy_cache .pytest_cache .ruff_cache .hypothesis .coverage
