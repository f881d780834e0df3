#!/usr/bin/env bash
# Installs BlueSky 1.1.1, ZeroMQ, msgpack and the Python client of SEEDS into clients/bluesky/.venv.
set -euo pipefail
cd "$(dirname "$0")"
python3 -m venv .venv
.venv/bin/pip install --quiet bluesky-simulator==1.1.1 pyzmq msgpack ../python
