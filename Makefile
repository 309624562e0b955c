# `make help` lists the targets.
.DEFAULT_GOAL := help
.PHONY: help demo install test fixtures benchmark clean

help: ## Show this list
	@sed -n 's/^\([a-z]*\):.*## /\1\t/p' $(MAKEFILE_LIST) | expand -t 12

demo: install ## Install what is missing, then drive a console robot by a recording
	@sh tools/demo.sh

install: ## Install voz into .venv, with the system packages it needs
	@sh tools/install.sh

test: ## Install what the tests need, then check style and types and run all tests
	@sh tools/install.sh tests
	.venv/bin/ruff check .
	.venv/bin/ruff format --check .
	.venv/bin/mypy
	.venv/bin/python -m pytest -q

fixtures: ## Make the recordings of audio_fixtures/ anew
	@sh tools/install.sh tests
	.venv/bin/python tools/make_fixtures.py

benchmark: install ## Print the figures that the README quotes
	.venv/bin/python benchmarks/decode.py
	.venv/bin/python benchmarks/build_lm.py

clean: ## Remove what was installed and made here; system packages stay
	rm -rf .venv .venv-rclpy demo build dist .mypy_cache .pytest_cache .ruff_cache .hypothesis
