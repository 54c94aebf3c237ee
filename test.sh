#!/bin/sh
# Everything that must hold: formatting, lints, tests (they build the C sample too).
set -eu
cd "$(dirname "$0")"
./setup.sh
cargo fmt --all --check
cargo clippy --workspace --all-targets --release -- -D warnings
exec cargo test --workspace --release "$@"
