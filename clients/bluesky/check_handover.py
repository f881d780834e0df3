"""Aircraft change hands between a run and a real headless BlueSky: `unshare -rn python check_handover.py SEEDS AIRPORT.apt.dat FOLDER [SECONDS [FAULT]]`.

BlueSky's fly a final, are given, land and taxi to their stands; departures of the run are let go and flown on. Judged by the run's own database:
one row of truth a scan, one track, no jump. FAULT is what befalls BlueSky in the very moment in which the first is asked for: reset, node
(killed, another is asked for) or server (killed, started again). Prints one JSON object; exit code 1 if something in it is `broken`.
"""

import json
import math
import os
import signal
import sqlite3
import subprocess
import sys
from pathlib import Path

import seeds_client as seeds
from check import HERE, Picture, attempt, bluesky, children, close, ours, settle, wait

SECONDS = 600
SCENE = """[run]
title = "handover"
seed = 12
duration_s = {seconds}
[airport]
layout = "{airport}"
[[traffic]]
kind = "generated"
profile = "even"
arrivals_per_h = 2
departures_per_h = 60
[[traffic]]
kind = "handover"
[[sensor]]
kind = "adsb"
name = "adsb"
"""


def finals(airport):
    """Thresholds (degrees) and directions of the runway ends of an apt.dat."""
    for line in airport.read_text(errors="replace").splitlines():
        words = line.split()
        if words[:1] == ["100"] and len(words) >= 26:
            ends = [(words[8], float(words[9]), float(words[10])), (words[17], float(words[18]), float(words[19]))]
            for (name, lat, lon), (_, lat2, lon2) in (ends, ends[::-1]):
                north, east = (lat2 - lat) * 111_194.9, (lon2 - lon) * 111_194.9 * math.cos(math.radians(lat))
                yield name, lat, lon, math.atan2(east, north)


def behind(lat, lon, course, metres, aside=0.0):
    north = -metres * math.cos(course) - aside * math.sin(course)
    east = -metres * math.sin(course) + aside * math.cos(course)
    return lat + north / 111_194.9, lon + east / (111_194.9 * math.cos(math.radians(lat)))


def judged(log, name):
    """What the database says of a call sign."""
    rows = log.execute(
        "SELECT scan, x_m, y_m, altitude_m, vx_ms, vy_ms, ours, vz_ms FROM truth WHERE callsign = ? ORDER BY scan", (name,)).fetchall()
    scans = [row[0] for row in rows]
    worst_m = worst_mps = 0.0
    changes = []
    for a, b in zip(rows, rows[1:]):
        if b[0] == a[0] + 1:
            mean = [(a[4] + b[4]) / 2, (a[5] + b[5]) / 2]
            worst_m = max(worst_m, math.hypot(b[1] - a[1] - mean[0], b[2] - a[2] - mean[1]))
            worst_mps = max(worst_mps, math.hypot(b[4] - a[4], b[5] - a[5]))
        if a[6] != b[6]:
            changes.append({"scan": b[0], "ours": bool(b[6]), "beside_m": round(math.hypot(b[1] - a[1] - (a[4] + b[4]) / 2, b[2] - a[2] - (a[5] + b[5]) / 2), 2),
                            "height_m": round(b[3] - a[3] - (a[7] + b[7]) / 2, 2), "speed_mps": round(math.hypot(b[4] - a[4], b[5] - a[5]), 2)})
    return {"rows": len(rows), "twice": len(scans) - len(set(scans)), "missing": scans[-1] - scans[0] + 1 - len(set(scans)) if scans else None,
            "worst_m": round(worst_m, 2), "worst_mps": round(worst_mps, 2), "changes": changes}


def main():
    program, airport, folder = sys.argv[1], Path(sys.argv[2]).resolve(), Path(sys.argv[3])
    seconds = int(sys.argv[4]) if len(sys.argv) > 4 else SECONDS
    fault = sys.argv[5] if len(sys.argv) > 5 else None
    subprocess.run(["ip", "link", "set", "lo", "up"], check=True)
    scene = folder / "handover.toml"
    scene.write_text(SCENE.format(seconds=seconds, airport=airport))
    found = {"airport": airport.name}
    run = subprocess.Popen([program, "run", str(scene), "--no-viewer", "--visitors", "--public=tcp/127.0.0.1:7448", "--record", str(folder / "run.pcapng")],
                           stdout=subprocess.PIPE, stderr=open(folder / "run.txt", "w"), text=True)
    server, picture, bridge = bluesky(folder), None, None
    try:
        picture = Picture()
        assert wait(60, picture.node, picture.poll), "no node of BlueSky"
        client = wait(60, lambda: attempt(seeds.connect))
        assert client, "no run"
        wait(30, lambda: client.state().phase == "RUNNING")
        state = client.last("state")
        elevation = state["elevation_m"]
        bridge = subprocess.Popen([sys.executable, str(HERE / "bridge.py"), "--handover", "--log", str(folder / "bluesky.jsonl"),
                                   "--elevation", str(elevation), "--dis", "127.255.255.255:3000"],
                                  stdout=subprocess.PIPE, stderr=open(folder / "bridge.txt", "w"), text=True)
        # Which way is landed: as the flight list says.
        lands = {row.get("runway") for row in client.last("flights")["flights"] if row.get("movement") == "arrival"}
        end = next((f for f in finals(airport) if f[0] in lands), None) or next(finals(airport))
        found["runway"] = end[0]
        settle(5, picture)
        for n, (metres, aside) in enumerate([(13_000, 60.0), (25_000, -150.0)]):
            lat, lon = behind(*end[1:], metres, aside)
            feet = (elevation + 15 + 0.0524 * metres) / 0.3048
            course = math.degrees(end[3]) % 360
            name = f"BSK{n + 1}"
            picture.wire.command(picture.node(), f"CRE {name},A320,{lat:.7f},{lon:.7f},{course:.2f},{feet:.0f},150")
            picture.wire.command(picture.node(), f"ALT {name},0,760;SPD {name},150")
        if fault:
            assert wait(300, lambda: asked_for(folder), picture.poll), "nobody is asked for"
            server, picture = befalls(fault, folder, server, picture)
            found["whole_after_fault"] = bool(wait(15, picture.whole, lambda: (picture.poll(), setattr(picture, "mine", ours(client, picture.mine)))))
        code = wait(seconds + 120, lambda: run.poll() is not None, picture.poll)
        assert code, "the run does not end"
        found["bridge"] = json.loads(bridge.communicate(timeout=20)[0].strip().splitlines()[-1])
        found["summary"] = json.loads(run.communicate(timeout=60)[0].strip().splitlines()[-1])
        found["run_code"] = run.returncode
    finally:
        close(picture, bridge, server, run)
    log = sqlite3.connect(f"file:{folder / 'run.sqlite'}?mode=ro", uri=True)
    asked = log.execute("SELECT callsign, action, refused FROM inputs ORDER BY number").fetchall()
    found["asked"] = asked
    done = {callsign for callsign, _, refused in asked if not refused}
    found["judged"] = {name: judged(log, name) for name in sorted(done)}
    found["landed"] = dict(log.execute("SELECT callsign, aldt_ns / 1000000000 FROM movements WHERE callsign LIKE 'BSK%'").fetchall())
    found["tracks"] = {name: [t for t, in log.execute(
        "SELECT DISTINCT track FROM truth WHERE callsign = ? AND track IS NOT NULL", (name,))] for name in sorted(done)}
    found["broken"] = broken(found)
    print(json.dumps(found))
    sys.exit(1 if found["broken"] else 0)


def asked_for(folder):
    return any('"give_asked"' in line for line in (folder / "bluesky.jsonl").read_text().splitlines())


def befalls(fault, folder, server, picture):
    """What befalls BlueSky: the server and the picture that are there then."""
    if fault == "reset":
        picture.wire.command(picture.node(), "RESET")
    elif fault == "node":
        before = picture.node()
        for pid in children(server.pid):
            os.kill(pid, signal.SIGKILL)
        wait(10, lambda: before not in picture.wire.nodes, picture.poll)
        picture.wire._out.send_multipart([before[:-1] + b"\x80" + b"ADDNODES" + picture.wire.own, b"\x01"])
    elif fault == "server":
        os.killpg(server.pid, signal.SIGKILL)
        server.wait()
        server = bluesky(folder)
        picture.wire.close()
        picture = Picture()
    else:
        raise SystemExit(f"check_handover: {fault} is not a fault: reset, node or server")
    assert wait(60, picture.node, picture.poll), "no node after the fault"
    return server, picture


def broken(found):
    """What is not as it has to be: truth without gap or overlap, jumps of 5 m and 3 m/s at most, one track, a run without a fault."""
    words = []
    for name, of in found["judged"].items():
        if of["twice"] or of["missing"]:
            words.append(f"{name}: {of['twice']} scans twice, {of['missing']} missing")
        words += [f"{name}: {change}" for change in of["changes"] if change["beside_m"] > 5.0 or change["speed_mps"] > 3.0]
        if not of["changes"]:
            words.append(f"{name} did not change hands")
        if len(found["tracks"][name]) != 1:
            words.append(f"{name}: tracks {found['tracks'][name]}")
    if not found.get("whole_after_fault", True):
        words.append("the picture is not whole within 15 s of the fault")
    if not found["judged"]:
        words.append("nobody changed hands")
    if found["run_code"] != 0 or found["summary"]["faults"]:
        words.append(f"run: {found['run_code']} {found['summary']['faults']}")
    return words


if __name__ == "__main__":
    main()
