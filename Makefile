# make demo    a venv, the wheel, and the demonstration in out/demo
# make test    everything that must hold
# make format  rustfmt and ruff
# make python  the venv with the wheel and all that tests need
# make neon    the kernels' tests for aarch64: needs its target, gcc-aarch64-linux-gnu and qemu-user
# make clean

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
WHEELS := target/wheels
SOURCES := $(shell find src -name '*.rs') $(shell find python -name '*.py' -o -name '*.pyi' -o -path '*/data/*') \
	Cargo.toml Cargo.lock pyproject.toml README.md

.PHONY: demo test format python neon lint rust-test python-test clean

demo: $(VENV)/.demo
	@echo "== demonstration"
	$(BIN)/multum demo -o out/demo

test: lint rust-test python-test
	@echo "== make test: all checks passed"

python: $(VENV)/.test

format: $(VENV)/.test
	cargo fmt
	$(BIN)/ruff format python tests/python examples/python
	$(BIN)/ruff check --fix python tests/python examples/python

lint: $(VENV)/.test
	@echo "== formatting, lints, documentation and types"
	cargo fmt --check
	cargo check --quiet --lib --no-default-features
	PYO3_PYTHON=$(CURDIR)/$(BIN)/python cargo clippy --all-targets --features python -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --no-deps
	$(BIN)/ruff format --check python tests/python examples/python
	$(BIN)/ruff check python tests/python examples/python
	$(BIN)/mypy
	$(BIN)/stubtest multum._multum --allowlist tests/python/stubtest-allowlist.txt --ignore-unused-allowlist

rust-test:
	@echo "== Rust tests, examples and doc tests (random cases from a fixed seed; without it: cargo test)"
	PROPTEST_RNG_SEED=20 cargo test --features simplify

neon:
	CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc \
	CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER="qemu-aarch64 -L /usr/aarch64-linux-gnu" \
		cargo test --target aarch64-unknown-linux-gnu --no-default-features --lib kernel::

python-test: $(VENV)/.test
	@echo "== Python tests"
	$(BIN)/python -m pytest

$(VENV)/.python:
	@echo "== virtual environment in $(VENV)"
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip 'maturin>=1.9,<2'
	touch $@

$(VENV)/.wheel: $(VENV)/.python $(SOURCES)
	@echo "== wheel in $(WHEELS) (the first build takes some minutes)"
	rm -rf $(WHEELS)
	$(BIN)/maturin build --release --interpreter $(BIN)/python --out $(WHEELS)
	touch $@

$(VENV)/.demo: $(VENV)/.wheel
	@echo "== multum and the packages of its demo"
	$(BIN)/python -m pip install --quiet --force-reinstall --no-deps $(WHEELS)/*.whl
	$(BIN)/python -m pip install --quiet "multum[demo] @ file://$$(ls $(CURDIR)/$(WHEELS)/*.whl)"
	touch $@

$(VENV)/.test: $(VENV)/.wheel
	@echo "== multum and the packages of its tests"
	$(BIN)/python -m pip install --quiet --force-reinstall --no-deps $(WHEELS)/*.whl
	$(BIN)/python -m pip install --quiet "multum[demo,test] @ file://$$(ls $(CURDIR)/$(WHEELS)/*.whl)"
	touch $@

clean:
	rm -rf $(VENV) target out
