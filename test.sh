#!/bin/sh
# Everything that must hold: formatting, lints, tests (they build the C sample too).
set -eu
cd "$(dirname "$0")"
./setup.sh
# lavapipe keeps what it has compiled: without it each context takes ten seconds.
export MESA_SHADER_CACHE_DIR="${MESA_SHADER_CACHE_DIR:-$PWD/target/mesa_shader_cache}"
cargo fmt --all --check
# The library alone: other packages switch on features of its dependencies.
cargo check --package brickgi --release
cargo clippy --workspace --all-targets --release -- -D warnings
exec cargo test --workspace --release "$@"
