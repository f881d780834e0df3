#!/usr/bin/env bash
# Makes a virtual environment beside this script with the client and all that its tests use. Usage: install.sh [FOLDER]
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
venv=${1:-$here/.venv}
python3 -m venv "$venv"
"$venv/bin/pip" install --quiet "setuptools>=61" wheel jsonschema
"$venv/bin/pip" install --quiet --no-build-isolation "$here[frames,notebook]"
echo "$venv/bin/python"
