# `make demo`: a venv, the wheel, and the demonstration. `make test`: everything that must hold.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
WHEELS := target/wheels
SOURCES := $(shell find src python -name '*.rs' -o -name '*.py' -o -name '*.pyi' -o -path 'python/multum/data/*') Cargo.toml pyproject.toml

.PHONY: demo test lint rust-test python-test clean

demo: $(VENV)/.demo
	$(BIN)/multum demo

test: lint rust-test python-test
	@echo "make test: all checks passed"

lint: $(VENV)/.test
	@echo "== formatting and lints"
	cargo fmt --check
	cargo clippy --all-targets -- -D warnings
	PYO3_PYTHON=$(CURDIR)/$(BIN)/python cargo clippy --all-targets --features python -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --no-deps
	$(BIN)/ruff format --check python tests/python
	$(BIN)/ruff check python tests/python
	$(BIN)/mypy
	$(BIN)/python -m mypy.stubtest multum --allowlist tests/python/stubtest-allowlist.txt

rust-test:
	@echo "== Rust tests and doc tests"
	cargo test

python-test: $(VENV)/.test
	@echo "== Python tests"
	$(BIN)/python -m pytest

$(VENV)/.python:
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip 'maturin>=1.9,<2'
	touch $@

$(VENV)/.wheel: $(VENV)/.python $(SOURCES)
	@echo "== building the wheel"
	rm -rf $(WHEELS)
	$(BIN)/maturin build --release --interpreter $(BIN)/python --out $(WHEELS)
	touch $@

$(VENV)/.demo: $(VENV)/.wheel
	$(BIN)/python -m pip install --quiet --force-reinstall --no-deps $(WHEELS)/*.whl
	$(BIN)/python -m pip install --quiet "multum[demo] @ file://$$(ls $(CURDIR)/$(WHEELS)/*.whl)"
	touch $@

$(VENV)/.test: $(VENV)/.wheel
	$(BIN)/python -m pip install --quiet --force-reinstall --no-deps $(WHEELS)/*.whl
	$(BIN)/python -m pip install --quiet "multum[demo,test] @ file://$$(ls $(CURDIR)/$(WHEELS)/*.whl)"
	touch $@

clean:
	rm -rf $(VENV) target
