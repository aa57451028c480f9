# Everything from a fresh clone with only Python 3.11 or newer and make.
#   make book     the book, strictly: book/_build/html/index.html
#   make figures  the book, and each of its figures as PNG and SVG in build/figures/
#   make test     ruff, then the tests with the doctests of the package and of the README
#   make coverage the same tests, slower, and which lines of the package they leave out
#   make pages    looks at the built book in a browser (Debian: apt-get install chromium)
#   make bench    the benchmarks, each beside a peer or a bound
#   make lint     ruff only
#   make lock     requirements.lock anew from pyproject.toml, keeping what still fits (UPGRADE=--upgrade takes the newest)
#   make clean    removes what was made; the environment .venv too with `make distclean`
# The first call of any of them makes the environment; no later call needs the network.

PYTHON ?= python3
UV_VERSION := 0.13.9
UPGRADE ?=

# The matrices are small: threads inside one product only get in each other's way.
export OMP_NUM_THREADS ?= 1
export OPENBLAS_NUM_THREADS ?= 1

BIN := .venv/bin
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check
ENVIRONMENT := .venv/installed

.PHONY: book figures test coverage pages bench lint lock clean distclean environment
.DELETE_ON_ERROR:

# Every build starts from nothing, so that no warning hides in a page that was left as it was. Only executed cells are kept, in
# build/cache (see book/_ext).
book: $(ENVIRONMENT)
	rm -rf book/_build book/api
	$(BIN)/jupyter-book build book -n -W --keep-going
	@echo "Open book/_build/html/index.html"

# README.md shows the figure of the landing page
figures: book
	$(BIN)/python book/figures.py
	cp build/figures/fig-landing.png book/_static/

TESTS := $(BIN)/python -m pytest --numprocesses=auto --dist=loadfile

test: lint
	$(TESTS)

# Not in `test`: with every line followed the tests take up to twice the time.
coverage: lint
	$(TESTS) --cov --cov-report=term

pages: $(ENVIRONMENT)
	$(BIN)/python -m pytest --numprocesses=auto --maxprocesses=4 --dist=loadgroup tests/test_pages.py

bench: $(ENVIRONMENT)
	$(BIN)/python benchmarks/run.py

lint: $(ENVIRONMENT)
	$(BIN)/ruff check .

lock: $(BIN)/python
	$(PIP) "uv==$(UV_VERSION)"
	$(BIN)/uv pip compile pyproject.toml --all-extras --universal --python-version 3.11 --generate-hashes \
		--custom-compile-command "make lock" $(UPGRADE) --quiet --output-file requirements.lock

environment: $(ENVIRONMENT)

# uv installs the lock in seconds; where it cannot be had, pip does the same in a minute. Hashes are checked by both. The package
# itself is installed editable, by what the lock brought: nothing further is fetched.
$(ENVIRONMENT): pyproject.toml requirements.lock | $(BIN)/python
	{ $(PIP) "uv==$(UV_VERSION)" && $(BIN)/uv pip install --quiet --compile-bytecode --python $(BIN)/python --require-hashes -r requirements.lock; } \
		|| $(PIP) --require-hashes -r requirements.lock
	$(PIP) --no-index --no-deps --no-build-isolation --editable .
	touch $@

$(BIN)/python:
	@$(PYTHON) -c "import sys; sys.exit(sys.version_info < (3, 11) and 'fogkit needs Python 3.11 or newer: make PYTHON=python3.11')"
	$(PYTHON) -m venv .venv

clean:
	rm -rf build book/_build book/api .pytest_cache .ruff_cache .hypothesis .coverage
	find src tests benchmarks book -name __pycache__ -type d -prune -exec rm -rf {} +

distclean: clean
	rm -rf .venv
