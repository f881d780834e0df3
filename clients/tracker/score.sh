#!/usr/bin/env bash
# A tracker in a process of its own: fed by multicast on this host, recorded, scored. Usage: score.sh [SCENE] [SECONDS] [FOLDER]
set -euo pipefail
scene=${1:-zurich} seconds=${2:-60} out=${3:-$(mktemp -d)}
seeds=${SEEDS:-seeds}
"$seeds" record --quiet --interface 127.0.0.1 --asterix 239.9.1.2:8601 "$out/theirs.pcapng" > "$out/record.json" & recorder=$!
python3 "$(dirname "$0")/tracker.py" --in 239.9.1.1:8600 --out 239.9.1.2:8601 --seconds 20 & tracker=$!
"$seeds" run "$scene" --duration "$seconds" --rate "${RATE:-1}" --no-viewer --interface 127.0.0.1 --record "$out/truth.pcapng" \
  --asterix 239.9.1.1:8600 --asterix-send sensors --asterix-cat 10 ${PORTS:-}
wait $tracker; kill -INT $recorder; wait $recorder
"$seeds" score --truth "$out/truth.sqlite" --tracks "$out/theirs.pcapng" --source 77/9 --json > "$out/score.json"
"$seeds" score --truth "$out/truth.sqlite" --tracks "$out/theirs.pcapng" --source 77/9 | head -20
