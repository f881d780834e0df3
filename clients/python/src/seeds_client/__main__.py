"""python -m seeds_client watch | tracks | export: a look at a run, its tracks as CSV, a finished run as Parquet."""

from __future__ import annotations

import argparse
import csv
import sys

from . import Disconnected, Refused, VersionMismatch, connect, open_log
from .live import DEFAULT_ENDPOINT


def watch(arguments: argparse.Namespace) -> None:
    with connect(arguments.endpoint, arguments.exercise) as run:
        for scan in run.scans(limit=arguments.scans):
            labels = " ".join(track.callsign or f"#{track.track}" for track in scan.tracks)
            print(f"{scan.utc}  {len(scan.tracks):3} tracks {len(scan.plots):4} plots  {labels}", flush=True)


def tracks(arguments: argparse.Namespace) -> None:
    writer = None
    with connect(arguments.endpoint, arguments.exercise) as run:
        for count, body in enumerate(run.messages("tracks"), start=1):
            for row in body["tracks"]:
                row = {"time_s": body["time_s"], **{name: row.get(name) for name in COLUMNS}}
                if writer is None:
                    writer = csv.DictWriter(sys.stdout, list(row))
                    writer.writeheader()
                writer.writerow(row)
            sys.stdout.flush()
            if count == arguments.scans:
                return


COLUMNS = [
    "track", "status", "type", "callsign", "x_m", "y_m", "lat_deg", "lon_deg", "vx_ms", "vy_ms", "speed_ms",
    "heading_deg", "altitude_m", "entity", "error_m",
]


def export(arguments: argparse.Namespace) -> None:
    with open_log(arguments.log) as log:
        for table, rows in log.to_parquet(arguments.folder).items():
            print(f"{table}: {rows} rows")


def main() -> int:
    parser = argparse.ArgumentParser(prog="seeds_client", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    for name, work in (("watch", watch), ("tracks", tracks)):
        live = commands.add_parser(name)
        live.add_argument("--endpoint", default=DEFAULT_ENDPOINT)
        live.add_argument("--exercise", type=int, default=1)
        live.add_argument("--scans", type=int, help="ends after so many")
        if name == "tracks":
            live.add_argument("--csv", action="store_true", help="the only form there is")
        live.set_defaults(work=work)
    finished = commands.add_parser("export", help="one Parquet file a table")
    finished.add_argument("log")
    finished.add_argument("folder")
    finished.set_defaults(work=export)
    arguments = parser.parse_args()
    try:
        arguments.work(arguments)
    except (Disconnected, Refused, VersionMismatch, ValueError, FileNotFoundError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except (KeyboardInterrupt, BrokenPipeError):
        pass
    return 0


if __name__ == "__main__":
    sys.exit(main())
