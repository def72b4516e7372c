#!/bin/sh
# Check the interpreter, then the shared libraries that the gmsh and VTK wheels expect from the system.
# Missing libraries are installed with apt when root or passwordless sudo allows it; otherwise the command to run is printed.
# Usage: prepare_machine.sh [PYTHON] [interpreter|chromium]
# With `interpreter` it checks that alone.
# With `chromium` it also tries to install the browser that the tests of pages use, and goes on where it may not.
set -eu

python=${1:-python3}
packages="libgl1 libglu1-mesa libegl1 libgl1-mesa-dri libxcursor1 libxft2 libxinerama1 libxfixes3 libgomp1"
install="apt-get install --yes --no-install-recommends $packages"

stop() {
    echo "wirewear: $1" >&2
    exit 1
}

missing_libraries() {
    "$python" - <<'PYTHON'
import ctypes

needed = """libGL.so.1 libGLU.so.1 libEGL.so.1 libOpenGL.so.0 libX11.so.6 libXrender.so.1 libXcursor.so.1 libXfixes.so.3
libXft.so.2 libXinerama.so.1 libgomp.so.1"""
for name in needed.split():
    try:
        ctypes.CDLL(name)
    except OSError:
        print(name)
PYTHON
}

command -v "$python" >/dev/null 2>&1 ||
    stop "no $python was found: install Python 3.11 or newer (on Debian 12: apt-get install python3 python3-venv)."
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11, 2))' ||
    stop "$python is $("$python" -V 2>&1), but 3.11.2 or newer is needed: run make with PYTHON=/path/to/python3.11."
"$python" -c 'import venv, ensurepip' 2>/dev/null ||
    stop "$python has no venv and ensurepip: install them (on Debian: apt-get install python3-venv)."

[ "${2:-}" != interpreter ] || exit 0

try_chromium() {
    for name in chromium chromium-browser google-chrome; do
        command -v "$name" >/dev/null 2>&1 && return
    done
    command -v apt-get >/dev/null 2>&1 && [ "$(id -u)" -eq 0 ] || return 0
    echo "wirewear: installing Chromium for the tests of pages"
    { apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install --yes --no-install-recommends -qq chromium; } \
        >/dev/null 2>&1 || echo "wirewear: Chromium could not be installed; the tests of pages are skipped." >&2
}

if [ "${2:-}" = chromium ]; then
    try_chromium
    exit 0
fi

missing=$(missing_libraries)
[ -n "$missing" ] || exit 0

list=$(echo "$missing" | tr '\n' ' ' | sed 's/ $//')
command -v apt-get >/dev/null 2>&1 ||
    stop "gmsh and VTK need the shared libraries $list: install them with this system's package manager (Debian calls them $packages)."
if [ "$(id -u)" -eq 0 ]; then
    as_root=""
elif command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null; then
    as_root="sudo -n"
else
    stop "gmsh and VTK need the shared libraries $list: run 'sudo apt-get update && sudo $install' (or the same as root), then make again."
fi

echo "wirewear: installing the shared libraries that gmsh and VTK need: $list"
$as_root apt-get update -qq || echo "wirewear: apt-get update failed; trying with the package lists there are." >&2
# shellcheck disable=SC2086
$as_root env DEBIAN_FRONTEND=noninteractive $install -qq >/dev/null ||
    stop "apt-get could not install $packages: see its message above, then run '$install' as root."
still=$(missing_libraries | tr '\n' ' ')
[ -z "$still" ] || stop "the shared libraries $still are still missing after '$install'."
