#!/usr/bin/env bash
# A tracker in a process of its own: fed by multicast on this host, recorded, scored from pcapng, bare blocks and IOSS. Usage: score.sh [SCENE] [SECONDS] [FOLDER]
set -euo pipefail
scene=${1:-zurich} seconds=${2:-60} out=${3:-$(mktemp -d)}
seeds=${SEEDS:-seeds} plots=${PLOTS:-239.9.1.1:8600} tracks=${TRACKS:-239.9.1.2:8601}
trap 'kill $(jobs -p) 2>/dev/null || true' EXIT
"$seeds" record --quiet --interface 127.0.0.1 --asterix "$tracks" "$out/theirs.pcapng" > "$out/record.json" & recorder=$!
python3 "$(dirname "$0")/tracker.py" --in "$plots" --out "$tracks" --seconds 20 & tracker=$!
"$seeds" run "$scene" --duration "$seconds" --rate "${RATE:-1}" --no-viewer --interface 127.0.0.1 --record "$out/truth.pcapng" \
  --asterix "$plots" --asterix-send sensors --asterix-cat 10 ${PORTS:-}
wait $tracker; kill -INT $recorder; wait $recorder
for form in pcapng ast ff; do
  [ $form = pcapng ] || "$seeds" asterix convert "$out/theirs.pcapng" "$out/theirs.$form"
  "$seeds" score --truth "$out/truth.sqlite" --tracks "$out/theirs.$form" --source 77/9 --scene "$scene" --json > "$out/score-$form.json"
done
"$seeds" score --truth "$out/truth.sqlite" --tracks "$out/theirs.pcapng" --source 77/9 | head -20
