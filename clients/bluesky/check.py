"""A real headless BlueSky beside a real run: `unshare -rn python check.py SEEDS SCENE FOLDER [OPTIONS]` (it listens on all interfaces: a namespace of its own).

Ours are mirrored, 100 of theirs come in, HOLD, RESET, a killed node and a killed server are survived; the digest is that of the run without
a bridge, and theirs are in truth where BlueSky had them. OPTIONS go to both runs (`--seed 7`). Prints one JSON object.
"""

import json
import math
import os
import signal
import sqlite3
import statistics
import subprocess
import sys
import time
from pathlib import Path

import entity_pdu
import seeds_client as seeds
from wire import Wire

HERE = Path(__file__).resolve().parent
THEIRS, SECONDS = 100, 110
PICTURE_S = 10.0


def wait(seconds, ask, poll=None):
    """The first true answer within `seconds`, else None."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        if poll:
            poll()
        found = ask()
        if found:
            return found
        time.sleep(0.02)
    return None


class Picture:
    """What BlueSky says that it has."""

    def __init__(self):
        self.wire, self.names, self.simt, self.came_s = Wire("127.0.0.1"), [], None, 0.0
        self.mine = set()

    def poll(self):
        for event in self.wire.poll(20):
            if event[0] == "ACDATA" and isinstance(event[2], dict):
                self.names, self.simt, self.came_s = list(event[2]["id"]), event[2]["simt"], time.monotonic()

    def whole(self):
        """All of ours are there."""
        return time.monotonic() - self.came_s < 1.0 and self.mine and self.mine <= {name.upper() for name in self.names}

    def node(self):
        return self.wire.nodes[-1] if self.wire.nodes else None


def bluesky(folder):
    return subprocess.Popen([sys.executable, "-m", "bluesky", "--headless", "--workdir", str(folder)],
                            stdout=open(folder / "bluesky.txt", "a"), stderr=subprocess.STDOUT, start_new_session=True)


def children(pid):
    text = subprocess.run(["ps", "-o", "pid=", "--ppid", str(pid)], capture_output=True, text=True).stdout
    return [int(word) for word in text.split()]


def create(picture, state):
    """Aircraft of theirs, on a grid well above the airport, of two types."""
    lines = []
    for n in range(THEIRS):
        lat, lon = state["reference_lat_deg"] + (n // 10 - 5) * 0.02, state["reference_lon_deg"] + (n % 10 - 5) * 0.03
        feet = (state["elevation_m"] + 1300.0) / 0.3048
        lines.append(f"CRE BS{n:03},{'A320' if n % 2 else 'B744'},{lat:.4f},{lon:.4f},{n * 37 % 360},{feet:.0f},220")
    picture.wire.command(picture.node(), ";".join(lines))


def ours(client, known=()):
    """Call signs of the run's own; those `known` where the run does not answer."""
    rows = attempt(lambda: client.last("truth")["truth"])
    return set(known) if rows is None else {row["callsign"].upper() for row in rows if row.get("ours") and row.get("callsign")}


def main():
    program, scene, folder, options = sys.argv[1], sys.argv[2], Path(sys.argv[3]), sys.argv[4:]
    subprocess.run(["ip", "link", "set", "lo", "up"], check=True)
    found = {}
    common = ["run", scene, "--duration", str(SECONDS), "--no-viewer", *options]
    alone = subprocess.run([program, *common, "--fast"], capture_output=True, text=True, check=True)
    alone = json.loads(alone.stdout.strip().splitlines()[-1])
    run = subprocess.Popen([program, *common, "--visitors", "--public=tcp/127.0.0.1:7448", "--record", str(folder / "run.pcapng")],
                           stdout=subprocess.PIPE, stderr=open(folder / "run.txt", "w"), text=True)
    server = bluesky(folder)
    picture, bridge = None, None
    try:
        picture = Picture()
        assert wait(60, picture.node, picture.poll), "no node of BlueSky"
        client = wait(60, lambda: attempt(seeds.connect))
        assert client, "no run"
        wait(30, lambda: client.state().phase == "RUNNING")
        state = client.last("state")
        bridge = subprocess.Popen([sys.executable, str(HERE / "bridge.py"), "--log", str(folder / "bluesky.jsonl"),
                                   "--elevation", str(state["elevation_m"]), "--dis", "127.255.255.255:3000"],
                                  stdout=subprocess.PIPE, stderr=open(folder / "bridge.txt", "w"), text=True)
        # Who leaves meanwhile is no longer asked for.
        polled = lambda: (picture.poll(), setattr(picture, "mine", ours(client, picture.mine)))
        found["whole"] = bool(wait(30, picture.whole, polled))
        found["ours"] = len(picture.mine)
        calm_from = time.time_ns() + 3_000_000_000
        settle(15, picture)
        found["mirror"] = mirrored(folder, calm_from)
        create(picture, state)
        found["theirs"] = bool(wait(20, lambda: outsiders(client) >= THEIRS, picture.poll))
        found["theirs_seen"] = outsiders(client)
        settle(8, picture)
        # Held: SEEDS owns time.
        picture.wire.command(picture.node(), "HOLD")
        settle(2.0, picture)
        held = picture.simt
        found["goes_on_after_hold"] = bool(wait(PICTURE_S, lambda: picture.simt > held + 1, picture.poll))
        picture.wire.command(picture.node(), "RESET")
        settle(1.0, picture)
        found["whole_after_reset"] = bool(wait(PICTURE_S, picture.whole, polled))
        found["theirs_after_reset"] = bool(wait(PICTURE_S, lambda: outsiders(client) == 0, picture.poll))
        # Somebody takes one of ours out there: it comes again.
        one = min(picture.mine)
        picture.wire.command(picture.node(), f"DEL {one}")
        wait(3, lambda: one not in {name.upper() for name in picture.names}, picture.poll)
        found["deleted_comes_again"] = bool(wait(PICTURE_S, picture.whole, polled))
        # The node is killed; the server starts another when asked to.
        before = picture.node()
        for pid in children(server.pid):
            os.kill(pid, signal.SIGKILL)
        wait(PICTURE_S, lambda: before not in picture.wire.nodes, picture.poll)
        picture.wire._out.send_multipart([before[:-1] + b"\x80" + b"ADDNODES" + picture.wire.own, b"\x01"])
        found["node_again"] = bool(wait(30, picture.node, picture.poll))
        found["whole_after_node"] = bool(wait(PICTURE_S, picture.whole, polled))
        # Server and all.
        os.killpg(server.pid, signal.SIGKILL)
        server.wait()
        settle(1.0, picture)
        server = bluesky(folder)
        picture.wire.close()
        picture = Picture()
        assert wait(60, picture.node, picture.poll), "no node of the second server"
        found["whole_after_server"] = bool(wait(PICTURE_S + 5, picture.whole, polled))
        client.close()
        found["summary"] = json.loads(run.communicate(timeout=SECONDS + 60)[0].strip().splitlines()[-1])
        found["run_code"] = run.returncode
        found["bridge"] = json.loads(bridge.communicate(timeout=20)[0].strip().splitlines()[-1])
        found["same_digest"] = found["summary"]["digest"] == alone["digest"]
        found["placed"] = placed(folder, state)
    finally:
        close(picture, bridge, server, run)
    print(json.dumps(found))


def close(picture, bridge, server, run):
    """Ends what is still there of a run beside BlueSky."""
    if picture:
        picture.wire.close()
    if bridge and bridge.poll() is None:
        bridge.kill()
    try:
        os.killpg(server.pid, signal.SIGKILL)
    except ProcessLookupError:
        pass
    if run.poll() is None:
        run.terminate()
        run.wait(20)


def placed(folder, state):
    """Seconds by which theirs are in truth before where BlueSky had them, and metres beside, by the run's clock as the bridge knew it: least, middle
    and most of the 95 in 100 nearest; and the types that they have there."""
    reference = state["reference_lat_deg"], state["reference_lon_deg"]
    origin, (east, north, _) = entity_pdu.ecef(*reference, 0.0), entity_pdu.axes(*reference)
    entries = [json.loads(line) for line in (folder / "bluesky.jsonl").read_text().splitlines()]
    entries = [entry for entry in entries if entry["topic"] == "ACDATA" and entry["our_ns"] is not None]
    offsets, told = [entry["our_ns"] / 1e9 - entry["body"]["simt"] for entry in entries], {}
    stands = [n for n in range(1, len(entries)) if entries[n]["body"]["simt"] <= entries[n - 1]["body"]["simt"]]
    stands = {m for n in stands for m in range(n - 1, n + 6)}  # held, or begun again: no place to hold against for a second
    for n, entry in enumerate(entries):
        if n in stands:
            continue
        # When it was so, not when it came: by the reports around it.
        at_s = entry["body"]["simt"] + statistics.median(offsets[max(0, n - 10):n + 11])
        columns = [entry["body"][key] for key in ("id", "lat", "lon", "alt", "gs", "trk")]
        for name, lat, lon, alt, gs, trk in zip(*columns):
            if name.startswith("BS"):
                at = [a - b for a, b in zip(entity_pdu.ecef(lat, lon, alt), origin)]
                x, y = (sum(a * b for a, b in zip(at, axis)) for axis in (east, north))
                told.setdefault(name, []).append((at_s, x, y, gs, math.radians(trk)))
    log = sqlite3.connect(f"file:{folder / 'run.sqlite'}?mode=ro", uri=True)
    before_s, beside_m, types = [], [], {}
    for name, kind, scan, x, y in log.execute("SELECT callsign, type, scan, x_m, y_m FROM truth WHERE ours = 0 ORDER BY scan"):
        types[name] = kind
        known = [t for t in told.get(name, []) if 0.0 <= scan - t[0] < 0.5]
        if known and told[name][0][0] < scan - 1.0:
            at, x0, y0, gs, trk = known[-1]
            before_s.append(((y - y0) * math.cos(trk) + (x - x0) * math.sin(trk)) / gs - (scan - at))
            beside_m.append((x - x0) * math.cos(trk) - (y - y0) * math.sin(trk))
    if not before_s:
        return None
    kinds = [sorted({types[name] for name in types if int(name[2:]) % 2 == odd}) for odd in (0, 1)]
    return {"before_s": spread(before_s), "beside_m": spread(beside_m), "of": len(before_s), "types": kinds}


def spread(values):
    values = sorted(values, key=abs)
    values = sorted(values[: max(1, len(values) * 95 // 100)])
    return [round(values[i], 3) for i in (0, len(values) // 2, -1)]


def attempt(call):
    try:
        return call()
    except Exception:
        return None


def settle(seconds, picture):
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        picture.poll()


def outsiders(client):
    rows = attempt(lambda: client.last("truth")["truth"]) or []
    return sum(not row.get("ours") for row in rows)


def mirrored(folder, from_ns):
    """Share of moves confirmed within half a second, of the time since `from_ns`, from what the bridge noted."""
    last, first = None, None
    for line in (folder / "bluesky.jsonl").read_text().splitlines():
        entry = attempt(lambda: json.loads(line))
        if entry and entry["topic"] == "stats":
            if entry["wall_ns"] < from_ns:
                first = entry["body"]
            last = entry["body"]
    if not (first and last):
        return None
    moves = last["moves"] - first["moves"]
    return {"moves": moves, "confirmed": last["confirmed"] - first["confirmed"], "late": last["late"] - first["late"], "latency_s": last["latency_s"]}


if __name__ == "__main__":
    main()
