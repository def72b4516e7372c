#!/bin/sh
# Install wirewear and what it needs, in editable form, with the versions of constraints.txt.
# uv takes a sixth of pip's time. It does not know pip's settings: where these name an index, or uv fails, pip installs.
# Usage: install.sh PYTHON WHAT
# PYTHON is that of the virtual environment, WHAT is . or .[dev].
set -eu

# With -q, grep would close the pipe while pip writes to it.
if ! "$1" -m pip config list | grep index >/dev/null &&
    "$1" -m pip install -qq --no-compile --constraint constraints.txt uv &&
    "$1" -m uv pip install -qq --python "$1" --constraint constraints.txt --editable "$2"; then
    exit 0
fi
"$1" -m pip install -qq --no-compile --constraint constraints.txt --editable "$2"
