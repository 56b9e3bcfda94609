# The house's front door. `make help` lists what there is; ARGS goes to the command behind a target:
#   make play ARGS="--audio song.wav --monitor 1 --fullscreen"
.DEFAULT_GOAL := help
.PHONY: help play test test-long test-bounds bench check check-fast format references docs kernels release archive studio soak \
  clean
BIN := .venv/bin
ARGS ?=
VERSION ?=

help: ## list these targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-11s %s\n", $$1, $$2 }' Makefile

play: ## install what is missing and start the default show (ARGS="--help": its options)
	@tools/setup.sh play
	@$(BIN)/live play $(ARGS)

test: ## install what the tests need too and run them (ARGS="tests/clock -x": some)
	@tools/setup.sh test
	@$(BIN)/python -m pytest $(ARGS)

test-long: ## the tests that `make test` leaves out: long ones, about what changes seldom
	@tools/setup.sh test
	@$(BIN)/python -m pytest -m long $(ARGS)

test-bounds: ## the tests with kernels that refuse to read or write beyond an array (compiled anew the first time)
	@tools/setup.sh test
	@NUMBA_BOUNDSCHECK=1 $(BIN)/python -m pytest $(ARGS)

bench: ## install what benches compare with and run them (ARGS="steering --json": one; ARGS=--list: their names)
	@tools/setup.sh bench
	@$(BIN)/live bench $(ARGS)

check: ## format, lint, types, layers, all tests: what a change has to pass
	@tools/setup.sh test
	$(BIN)/ruff format --check
	$(BIN)/ruff check
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python -m pytest -m "not soak" $(ARGS)

check-fast: ## within a minute: format, lint, types, layers, the tests of what is not committed (ARGS=COMMIT: since then)
	@tools/setup.sh test
	@$(BIN)/ruff format --check -q
	@$(BIN)/ruff check -q
	@$(BIN)/mypy
	@$(BIN)/python -m pytest -q -n 2 --budget 30 $$($(BIN)/python tools/changed_tests.py $(ARGS))

format: ## put every file into the project's form
	@tools/setup.sh test
	$(BIN)/ruff format
	$(BIN)/ruff check --fix

references: ## write the studio's forms anew
	@tools/setup.sh test
	@$(BIN)/python tools/write_studio_schema.py

docs: ## build the documentation into live/site/, for `live docs` and the packages
	@tools/setup.sh docs
	@rm -rf live/site
	@$(BIN)/python -m sphinx -q --fail-on-warning --keep-going -b html -d out/doctrees docs live/site
	@echo "live/site/index.html; live docs opens it"

kernels: ## build the wheel of compiled kernels for this Python and platform into dist/
	@tools/setup.sh test
	@$(BIN)/python tools/build_kernel_wheel.py

release: ## build a version into dist/: VERSION=0.2.0 (ARGS="--dry-run", or "--tag": commit and tag it; never pushes)
	@tools/setup.sh test
	@$(BIN)/python -m tools.release $(VERSION) $(ARGS)

archive: docs ## build an archive into dist/ for Linux without Python and network: all that a show needs, in one folder
	@$(BIN)/python -m tools.archive $(ARGS)

studio: ## build the studio's page anew from studio/ (needs Node; users need none)
	@cd studio && npm ci --ignore-scripts --no-audit --no-fund --silent && npx tsc --noEmit && node build.mjs

soak: ## some minutes of all that may happen to a show, and of chaos (ARGS="--hours 24 --seed 3": that instead)
	@tools/setup.sh test
	@$(BIN)/python -m pytest -m soak || { [ $$? -eq 5 ] && echo "no soak tests here"; }
ifeq ($(strip $(ARGS)),)
	@$(BIN)/live soak contemporary --minutes 10 --faults 6 --players 24
	@$(BIN)/live soak contemporary --chaos --virtual --minutes 30 --sites 12
	@$(BIN)/live soak first_show --chaos --minutes 2
else
	@$(BIN)/live soak $(ARGS)
endif

clean: ## remove .venv, caches and films made by `make play`
	rm -rf .venv .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache out live/site first-show.mp4
	find live tests bench tools -name __pycache__ -type d -prune -exec rm -rf {} +
