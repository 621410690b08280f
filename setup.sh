#!/bin/sh
# Sees to it that there is a Vulkan device, if only Mesa's software one (lavapipe).
#
#   ./setup.sh          look for a device; install lavapipe with apt where there is none and it may
#   ./setup.sh --check  look only: status 0 if there is a device, 1 if not
#
# Without a device all of the project works on its CPU backend, so this is no error. Safe to run
# twice; uses no network where a device is found. `oit devices` then says what can really be used.
set -eu

# Debian keeps ldconfig where ordinary users do not look.
PATH=$PATH:/usr/sbin:/sbin
packages="mesa-vulkan-drivers libvulkan1"

# has_library NAME_OR_PATH FOLDER: can the dynamic linker load it? A relative path is meant from FOLDER.
has_library() {
    case $1 in
    /*) [ -e "$1" ] ;;
    */*) [ -e "$2/$1" ] ;;
    *) ldconfig -p 2>/dev/null | grep -qF "$1 " ;;
    esac
}

# has_gpu: is there a device node of a GPU (Mesa, NVIDIA, WSL)?
has_gpu() {
    for node in /dev/dri/renderD* /dev/nvidia[0-9]* /dev/dxg; do
        [ ! -e "$node" ] || return 0
    done
    return 1
}

# is_usable MANIFEST: a driver whose library is there, and whose GPU is there unless it needs none.
is_usable() {
    [ -f "$1" ] || return 1
    library=$(sed -n 's/.*"library_path"[^"]*"\([^"]*\)".*/\1/p' "$1" | head -n 1)
    [ -n "$library" ] && has_library "$library" "$(dirname "$1")" || return 1
    case $library in
    *libvulkan_lvp* | *libvk_swiftshader*) return 0 ;;
    *) has_gpu ;;
    esac
}

# Where the Vulkan loader looks for driver manifests, separated by colons.
# https://github.com/KhronosGroup/Vulkan-Loader/blob/main/docs/LoaderDriverInterface.md
named=${VK_DRIVER_FILES:-${VK_ICD_FILENAMES:-}}
data=${XDG_DATA_HOME:-${HOME:-}/.local/share}:${XDG_DATA_DIRS:-/usr/local/share:/usr/share}
config=${XDG_CONFIG_HOME:-${HOME:-}/.config}:${XDG_CONFIG_DIRS:-/etc/xdg}:/usr/local/etc:/etc

# find_driver: prints the first usable driver manifest; fails if there is none.
find_driver() {
    has_library libvulkan.so.1 . || return 1
    (
        IFS=:
        if [ -n "$named" ]; then
            # Files, or folders of files.
            for entry in $named; do
                for manifest in "$entry" "$entry"/*.json; do
                    if is_usable "$manifest"; then echo "$manifest" && exit 0; fi
                done
            done
            exit 1
        fi
        for folder in $config $data; do
            for manifest in "$folder"/vulkan/icd.d/*.json; do
                if is_usable "$manifest"; then echo "$manifest" && exit 0; fi
            done
        done
        exit 1
    )
}

# as_root COMMAND...: runs it as root without asking for a password, or fails.
as_root() {
    if [ "$(id -u)" = 0 ]; then
        "$@"
    else
        sudo -n "$@"
    fi
}

case ${1:-} in
"" | --check) ;;
*)
    echo "setup: unknown argument $1: --check is the only one" >&2
    exit 2
    ;;
esac

if driver=$(find_driver); then
    echo "setup: Vulkan driver found: $driver"
    exit 0
fi
if [ "${1:-}" = --check ]; then
    echo "setup: no usable Vulkan driver" >&2
    exit 1
fi
if [ -n "$named" ]; then
    echo "setup: VK_DRIVER_FILES or VK_ICD_FILENAMES names no usable driver ($named): the CPU backend is used. Unset it or correct it for Vulkan."
    exit 0
fi
if ! command -v apt-get >/dev/null; then
    echo "setup: no Vulkan device and no apt: the CPU backend is used. For Vulkan install your GPU's driver, or Mesa's lavapipe, and the Vulkan loader."
    exit 0
fi
if ! as_root true 2>/dev/null; then
    echo "setup: no Vulkan device: the CPU backend is used. For Vulkan: sudo apt-get install $packages"
    exit 0
fi

echo "setup: no Vulkan device: installing $packages"
# What apt says is of interest only when it fails. An update fails if any one of the sources does,
# which need not be the one that matters here.
log=$(mktemp)
trap 'rm -f "$log"' EXIT
as_root apt-get -q -o Acquire::Retries=3 update >"$log" 2>&1 || true
# shellcheck disable=SC2086 # several packages
if as_root env DEBIAN_FRONTEND=noninteractive apt-get -q -y -o Acquire::Retries=3 \
        install --no-install-recommends $packages >>"$log" 2>&1 &&
    driver=$(find_driver); then
    echo "setup: Vulkan driver installed: $driver"
else
    tail -n 5 "$log"
    echo "setup: that gave no Vulkan driver: the CPU backend is used. For Vulkan: sudo apt-get install $packages"
fi
