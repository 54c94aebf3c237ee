#!/bin/sh
# The main job: renders a scene, beside the same without indirect light and beside the truth.
# Options are brickgi-render's; with none it renders the scene that ships with the project.
set -eu
cd "$(dirname "$0")"
./setup.sh
exec cargo run --release -p brickgi-render -- "$@"
