"""SEEDS from Python: live tracks, plots and truth, commands, and finished runs as data frames.

    import seeds_client as seeds
    with seeds.connect() as run:              # a run started with --public
        print(run.state().phase)
        for scan in run.scans(limit=30):
            print(scan.time_s, [track.callsign for track in scan.tracks])
        run.freeze(); run.step(20); run.resume()

    log = seeds.open_log("run.sqlite")        # what `seeds run --record run.pcapng` leaves beside the recording
    log.errors().groupby("callsign").track_error_m.median()

Positions are metres east and north of the aerodrome reference point, angles degrees clockwise from north, times seconds of
simulated time. What is not known is None.
"""

from .live import Answer, Disconnected, Refused, Run, VersionMismatch, connect
from .log import Log, open_log
from .messages import Lag, Member, Plot, Scan, State, Track, Truth

__version__ = "0.1.0"
__all__ = [
    "Answer", "Disconnected", "Lag", "Log", "Member", "Plot", "Refused", "Run", "Scan", "State", "Track", "Truth",
    "VersionMismatch", "connect", "open_log",
]
