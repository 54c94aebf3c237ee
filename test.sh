#!/bin/sh
# Everything that must hold: formatting, lints, tests (they build the C sample too).
set -eu
cd "$(dirname "$0")"
./setup.sh
cargo fmt --all --check
# The library alone: other packages switch on features of its dependencies.
cargo check --package brickgi --release
cargo clippy --workspace --all-targets --release -- -D warnings
exec cargo test --workspace --release "$@"
