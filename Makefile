# SPDX-License-Identifier: GPL-3.0-or-later
# `make demo` runs the main job, `make test` passes the tests (TESTS=files: only those); both set up what they need.
# Three rings of tests: `make check` within a minute, `make test`, and by night `make test-slow test-studies`.

# Compiled modules are kept even where the environment says otherwise: the tests start hundreds of processes.
export PYTHONDONTWRITEBYTECODE :=
# Programs in tools/ import each other.
export PYTHONSAFEPATH :=

.PHONY: coverage check arithmetic demo pictures docs evidence evidence-data notebooks test test-processors test-slow test-studies docs-check lint setup extension extension-all release test-blender-5 test-window test-window-5.2 test-peers test-report

# `make setup BLENDER=/path/to/blender`: the libraries for that Blender program's own Python instead.
ifeq ($(origin BLENDER),command line)
setup:
	@tools/set_up_blender.sh "$(BLENDER)"
else
setup:
	@tools/set_up.sh
endif

demo: setup
	@.venv/bin/w2w demo --out demo_output
	@echo "With your own clips, in a browser: .venv/bin/w2w serve"

# Every picture of README and documents but those of studies: `make test-window` first for Blender's window.
pictures: demo
	.venv/bin/python -m tools.make_pictures
	.venv/bin/python docs/make_garment_pictures.py
	.venv/bin/python docs/make_signals_figures.py

# Lint, and beside it the arithmetic: no Blender, no network trained, no adopted body.
check: setup
	@$(MAKE) --no-print-directory --jobs 2 lint arithmetic

arithmetic:
	.venv/bin/python -m pytest -q -n 2 --dist worksteal -m "not slow and not later" tests/core tests/drawing tests/test_house.py \
		tests/test_mirror.py --ignore=tests/core/adopt

BY_DAY = $(or $(TESTS),$(addprefix --ignore=,$(IN_BROWSER)) tests)
test: setup lint
	.venv/bin/python -m pytest -n 2 --dist worksteal -m "not slow" $(BY_DAY)

# Which lines of the core the quick tests never run; `pip install coverage` first, as CI does.
coverage: setup
	PIP_CONSTRAINT=constraints.txt .venv/bin/python -m pip install --quiet coverage
	.venv/bin/python -m coverage run --source blender_addon/w2w/core -m pytest -q -m "not slow and not later" tests/core --ignore=tests/core/adopt
	.venv/bin/python -m coverage report --skip-covered --sort cover | tail -n 40

# What compares bits, as on each kind of processor that this one can be: OpenBLAS rounds by its kind.
test-processors: setup
	@set -e; kinds=$$(.venv/bin/python -m tests.bits); for kind in $$kinds; do echo "=== as on $$kind"; \
		OPENBLAS_CORETYPE=$$kind .venv/bin/python -m pytest -n 2 --dist worksteal -q -m "bits and not slow" $(BY_DAY); done

# Data sets, protocols and the paper's studies have a suite of their own.
test-studies: setup
	.venv/bin/python -m pytest -n 3 --dist worksteal -m "not slow" packages/studies/tests

# The tests that take longest by themselves: networks trained, runs killed at drawn moments, whole trials.
test-slow: setup
	.venv/bin/python -m pytest -n 3 --dist worksteal -m slow --durations 12 --ignore=tests/gui tests packages/studies/tests

# The commands that figures in README and docs come from: the quick ones by `make docs-check QUICK=--quick`, all of
# them by night; fails where a document says something else. `make evidence` measures what was measured before the
# product's last commit, and writes it into the documents: hours; a stopped one carries on.
docs-check: setup evidence-data
	.venv/bin/python tools/docs_check.py $(QUICK)

evidence: setup evidence-data
	.venv/bin/python tools/docs_check.py --write

LIBRARIES = library/hdm05 library/bandai_namco imu/up_fall/up_fall
evidence-data:
	@for each in $(LIBRARIES); do archive="$${DATA:-../shared/data}/$$each.tar.xz"; \
		to=.cache/evidence/$$(basename $$each); [ ! -e "$$archive" ] || [ -e "$$to" ] || \
		{ mkdir -p "$$to.part" && tar -xJf "$$archive" -C "$$to.part" && mv "$$to.part" "$$to"; }; done

lint: setup
	.venv/bin/ruff check .
	.venv/bin/ruff format --check .
	.venv/bin/lint-imports
	.venv/bin/mypy

# The documents as a site, in dist/site; fails where a link is dead.
docs: setup
	NO_MKDOCS_2_WARNING=1 .venv/bin/mkdocs build --quiet

# The notebooks, run from top to bottom; what they show is kept in them.
notebooks: setup
	PIP_CONSTRAINT=constraints.txt .venv/bin/python -m pip install --quiet --editable ".[notebooks]"
	.venv/bin/python tools/run_notebooks.py

# All that a release has, in dist/release: zips, their index, wheel, sdist, site, notes, checksums.
release: setup
	.venv/bin/python tools/make_release.py $(PLATFORMS)

# What reads, plays and writes through Blender, again with another of its series;
# `make test-blender-5 MARK="slow or later"` runs those that take a second or more. Its warnings are no errors.
test-blender-5:
	@tools/set_up.sh .venv-blender-5 5.0.1
	.venv-blender-5/bin/python -m pytest -W default -n 2 --dist worksteal -m "$(or $(MARK),not slow and not later)" tests/scene tests/ui \
		tests/headless/test_bad_input.py $(addprefix tests/headless/commands/test_,run.py inspect.py)

# Files read by the programs they are for (OpenSim, gaitmap, the BIDS validator), in environments of their own,
# and packs for pose estimators as their loaders do.
test-peers: setup
	PYTHON=$(CURDIR)/.venv/bin/python tools/test_peers.sh

# A zip for each Python of Blender; `make extension BLENDER=/path/to/blender`: for that program's alone.
extension:
	@tools/set_up.sh
	.venv/bin/python tools/build_extension.py $(if $(filter command line,$(origin BLENDER)),--blender "$(BLENDER)")

# Zips for Windows and macOS, too.
extension-all: setup
	.venv/bin/python tools/build_extension.py --all

# In a real Blender 4.3, its window and its command line; fails where the window test cannot run at all. All of it,
# Run All, updates, Rigify and garments, too, by `make test-window WINDOW=tests/gui`, by night; pictures in
# .cache/blender-4.3.
WINDOW ?= $(addprefix tests/gui/test_,open_run.py program.py try_examples.py window.py zips.py)
WINDOW_REPORT = .cache/$(notdir $(W2W_BLENDER_SANDBOX))/window/report.json
test-window: export W2W_BLENDER_SANDBOX ?= $(CURDIR)/.sandbox/blender-4.3
test-window:
	tools/real_blender.sh
	$(MAKE) extension
	$(MAKE) extension BLENDER=tools/sandboxed_blender.sh
	rm -f $(WINDOW_REPORT)
	.venv/bin/python -m pytest --durations 12 $(WINDOW)
	test -s $(WINDOW_REPORT)

# The same in Blender 5.2 (Debian sid's, with Python 3.14) and with a zip for it.
test-window-5.2:
	W2W_DEBIAN=sid W2W_BLENDER_SANDBOX=$(CURDIR)/.sandbox/blender-5.2 $(MAKE) test-window

# The report and the web app in headless Chromium; fails where it cannot run.
IN_BROWSER = tests/report/test_report_in_browser.py tests/web/test_page_in_browser.py
test-report: setup
	tools/chromium.sh
	W2W_NEED_CHROMIUM=1 .venv/bin/python -m pytest $(IN_BROWSER)
