# `make run` opens the window, `make test` runs every test; both set up what they need first.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
STAMP  := $(VENV)/.installed
# PyQt5 has no wheels for other Linux computers than x86-64; there the window uses Debian's.
SYSTEM_QT := $(if $(filter Linux-x86_64 Darwin-%,$(shell uname -s)-$(shell uname -m)),,--system-site-packages)

.PHONY: setup setup-ros2 setup-servo run test test-unit test-without-guests coverage mutants lint types pyright bench fuzz docs screenshots translations deb test-deb clean

setup: $(STAMP)

$(STAMP): pyproject.toml scripts/system-packages
	scripts/system-packages window
	$(BIN)/python -m pip --version >/dev/null 2>&1 || $(PYTHON) -m venv $(SYSTEM_QT) $(VENV)  # also one that was interrupted
	$(BIN)/python -m pip install -qq --disable-pip-version-check --upgrade pip
	$(BIN)/python -m pip install -qq --disable-pip-version-check --editable '.[dev]'
	$(BIN)/python -m compileall -q -j 0 grabbergui  # or the first start does it, or each: PYTHONDONTWRITEBYTECODE
	touch $@

# ROS 2 and our interface package, from ROS's own wheels; everything else works without.
setup-ros2: setup
	scripts/system-packages ros2
	$(BIN)/python -m grabbergui setup ros2 $(addprefix --also ,$(wildcard tests/support/servo/interfaces/*))

# TIAGo's kinematics and description, for servoing with it.
setup-servo: setup
	$(BIN)/python -m pip install -qq --disable-pip-version-check --editable '.[servo,faces]'

# Without a display the same window runs offscreen for a few seconds and saves a screenshot.
run: setup
	@if [ -n "$$DISPLAY$$WAYLAND_DISPLAY" ] || [ "$$(uname -s)" != Linux ]; then \
	    $(BIN)/grabbergui; \
	else \
	    $(BIN)/grabbergui gui --offscreen --duration 5 --screenshot grabbergui.png; \
	fi

# Benchmarks and the fuzzer run on Linux only; the package is checked for what else it may be installed on.
lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports --no-logo
	@$(MAKE) --no-print-directory --jobs=3 types types-win32 types-darwin  # beside each other: mypy uses one core

types:
	$(BIN)/mypy

types-%:
	$(BIN)/mypy --package grabbergui --platform $* --cache-dir .mypy_cache/$*

# The library's types as pyright sees them, which many editors use; mypy checks them in `make lint`.
pyright: setup
	$(BIN)/python -m pip install -qq --disable-pip-version-check "pyright[nodejs]"
	$(BIN)/pyright --project type_tests --pythonpath $(BIN)/python

# The tests of one package alone, of both tiers: make test PACKAGE=net/yarp; ROOM is the variable's older name.
PACKAGE ?= $(ROOM)
TESTS = $(or $(wildcard $(if $(PACKAGE),tests/unit/$(PACKAGE) tests/system/$(PACKAGE),tests)),$(error no tests of $(PACKAGE)))
test: setup
	scripts/system-packages tests
	$(BIN)/python tests/run_tests.py $(TESTS)

# The tests within one process: no sockets, no programs, no sleeping.
test-unit: setup
	$(BIN)/python tests/run_tests.py tests/unit/$(PACKAGE)

# Lint, types and tests of a copy without the guests' folders (docs/decisions/0021-servo-is-a-guest.md).
test-without-guests: setup
	scripts/test-without-guests

# Branch coverage of all tests, or of one package's: make coverage PACKAGE=core; the lines are in build/coverage.
coverage: setup
	$(BIN)/python -m pip install -qq --disable-pip-version-check pytest-cov
	QT_QPA_PLATFORM=offscreen $(BIN)/python -m pytest -n auto --dist worksteal --cov=grabbergui$(if $(PACKAGE),/$(PACKAGE)) \
	    --cov-branch --cov-report=term:skip-covered --cov-report=html:build/coverage $(TESTS)

# Mutation testing of the packages where an untested line hurts, or of one: make mutants PACKAGE=servo/gate
mutants: setup
	$(BIN)/python -m pip install -qq --disable-pip-version-check mutmut
	$(BIN)/python scripts/mutants $(PACKAGE)

# The screenshots in docs/, made by the program itself.
screenshots: setup
	for theme in light dark; do \
	    GRABBERGUI_INTERFACES=none $(BIN)/grabbergui gui --offscreen --theme $$theme --script scripts/screenshots.py || exit 1; \
	done
	for look in light: dark:-dark; do \
	    image=$${look#*:}.png; theme=$${look%%:*}; \
	    QT_QPA_PLATFORM=offscreen $(BIN)/python scripts/servo_screenshot.py $$theme docs/images/servo$$image && \
	    QT_QPA_PLATFORM=offscreen $(BIN)/grabbergui calibrate sim:board --seconds 20 --theme $$theme \
	        --screenshot docs/images/calibration$$image || exit 1; \
	done

# After a text has changed: resources/translations/*.ts anew, and the .qm that the program loads.
translations: setup
	scripts/translations

# The manual as a site, in build/site; warnings are errors.
docs: setup
	$(BIN)/python -m pip install -qq --disable-pip-version-check --editable '.[docs]'
	$(BIN)/python scripts/reference.py
	$(BIN)/mkdocs build --quiet

bench: setup
	scripts/system-packages tests benchmarks
	$(BIN)/python -m benchmarks

# Coverage-guided fuzzing of every parser, so long for each: make fuzz SECONDS=600
SECONDS ?= 60
fuzz: setup
	$(BIN)/python -m pip install -qq --disable-pip-version-check atheris
	$(BIN)/python -m fuzz --seconds $(SECONDS)

# A Debian package of the program with its own environment below /opt, for this machine's Debian or Ubuntu.
deb:
	scripts/debian-package

# Its installation, run and removal in a clean root; as root, takes minutes. Lintian, if it is installed.
test-deb: deb
	if command -v lintian >/dev/null; then lintian --suppress-tags dir-or-file-in-opt --fail-on error build/grabbergui_*.deb; fi
	scripts/debian-package-test build/grabbergui_*.deb

clean:
	rm -rf $(VENV) build dist ./*.egg-info .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis
