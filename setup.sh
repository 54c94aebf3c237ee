#!/bin/sh
# Installs what the build and the tests need and the machine lacks: a C and a C++ compiler, the Vulkan loader and headers, a Vulkan
# driver and the validation layer. Does nothing where all of it is there. A GPU's own driver is not touched: Mesa's
# software driver (lavapipe) only stands beside it, and programs here prefer a GPU.
set -eu

missing=
need() { # package, command that succeeds where it is there
    package=$1
    shift
    "$@" >/dev/null 2>&1 || missing="$missing $package"
}

has_library() { /sbin/ldconfig -p | grep -qF "$1 "; }
has_file() { for file; do [ -e "$file" ] && return; done; return 1; }

data=/usr/share/vulkan
etc=/etc/vulkan
need gcc command -v cc
need g++ command -v c++
need pkg-config command -v pkg-config
need libvulkan1 has_library libvulkan.so.1
need libvulkan-dev has_file /usr/include/vulkan/vulkan_core.h /usr/local/include/vulkan/vulkan_core.h
need mesa-vulkan-drivers has_file $data/icd.d/*.json $etc/icd.d/*.json
need vulkan-validationlayers has_file $data/explicit_layer.d/VkLayer_khronos_validation.json \
    $etc/explicit_layer.d/VkLayer_khronos_validation.json

if ! command -v cargo >/dev/null 2>&1; then
    echo "setup: Rust is missing: install it from https://rustup.rs" >&2
    exit 1
fi
[ -z "$missing" ] && exit 0

if ! command -v apt-get >/dev/null 2>&1; then
    echo "setup: please install what Debian calls:$missing" >&2
    exit 1
fi
if [ "$(id -u)" = 0 ]; then
    root=
elif command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null; then
    root=sudo
else
    echo "setup: please run: sudo apt-get install --no-install-recommends$missing" >&2
    exit 1
fi
echo "setup: installing$missing" >&2
# shellcheck disable=SC2086 # the list is meant to be split
{
    $root apt-get update -qq
    $root env DEBIAN_FRONTEND=noninteractive apt-get install -qq -y --no-install-recommends $missing
} >&2
