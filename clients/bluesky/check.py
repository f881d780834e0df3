"""A real headless BlueSky beside a real run: `unshare -rn python check.py SEEDS SCENE FOLDER` (it listens on all interfaces: a namespace of its own).

200 of ours are mirrored, 100 of theirs come in, HOLD, RESET, a killed node and a killed server are survived. Prints one JSON object.
"""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import seeds_client as seeds
from wire import Wire

HERE = Path(__file__).resolve().parent
OURS, THEIRS = 200, 100
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

    def poll(self):
        for event in self.wire.poll(20):
            if event[0] == "ACDATA" and isinstance(event[2], dict):
                self.names, self.simt, self.came_s = list(event[2]["id"]), event[2]["simt"], time.monotonic()

    def ours(self):
        return sum(name.startswith("CAR") for name in self.names) if time.monotonic() - self.came_s < 1.0 else 0

    def node(self):
        return self.wire.nodes[-1] if self.wire.nodes else None


def bluesky(folder):
    return subprocess.Popen([sys.executable, "-m", "bluesky", "--headless", "--workdir", str(folder)],
                            stdout=open(folder / "bluesky.txt", "a"), stderr=subprocess.STDOUT, start_new_session=True)


def children(pid):
    text = subprocess.run(["ps", "-o", "pid=", "--ppid", str(pid)], capture_output=True, text=True).stdout
    return [int(word) for word in text.split()]


def create(picture):
    """Aircraft of theirs, on a grid well above the airport."""
    lines = []
    for n in range(THEIRS):
        lat, lon = 47.60 + n // 10 * 0.02, 8.30 + n % 10 * 0.03
        lines.append(f"CRE BS{n:03},A320,{lat:.4f},{lon:.4f},90,6000,220")
    picture.wire.command(picture.node(), ";".join(lines))


def main():
    program, scene, folder = sys.argv[1], sys.argv[2], Path(sys.argv[3])
    subprocess.run(["ip", "link", "set", "lo", "up"], check=True)
    found = {}
    run = subprocess.Popen([program, "run", scene, "--duration", "110", "--no-viewer", "--visitors", "--public=tcp/127.0.0.1:7448",
                            "--record", str(folder / "run.pcapng")],
                           stdout=subprocess.PIPE, stderr=open(folder / "run.txt", "w"), text=True)
    server = bluesky(folder)
    picture, bridge = None, None
    try:
        picture = Picture()
        assert wait(60, picture.node, picture.poll), "no node of BlueSky"
        client = wait(60, lambda: attempt(seeds.connect))
        assert client, "no run"
        wait(30, lambda: client.state().phase == "RUNNING")
        bridge = subprocess.Popen([sys.executable, str(HERE / "bridge.py"), "--log", str(folder / "bluesky.jsonl"), "--elevation", "432",
                                   "--dis", "127.255.255.255:3000"],
                                  stdout=subprocess.PIPE, stderr=open(folder / "bridge.txt", "w"), text=True)
        assert wait(30, lambda: picture.ours() == OURS, picture.poll), f"{picture.ours()} of ours"
        calm_from = time.time_ns() + 3_000_000_000
        settle(15, picture)
        found["mirror"] = mirrored(folder, calm_from)
        create(picture)
        found["theirs"] = bool(wait(20, lambda: outsiders(client) >= THEIRS, picture.poll))
        found["theirs_seen"] = outsiders(client)
        # Held: SEEDS owns time.
        picture.wire.command(picture.node(), "HOLD")
        settle(2.0, picture)
        held = picture.simt
        found["goes_on_after_hold"] = bool(wait(PICTURE_S, lambda: picture.simt > held + 1, picture.poll))
        picture.wire.command(picture.node(), "RESET")
        settle(1.0, picture)
        found["whole_after_reset"] = bool(wait(PICTURE_S, lambda: picture.ours() == OURS, picture.poll))
        found["theirs_after_reset"] = bool(wait(PICTURE_S, lambda: outsiders(client) == 0, picture.poll))
        # The node is killed; the server starts another when asked to.
        before = picture.node()
        for pid in children(server.pid):
            os.kill(pid, signal.SIGKILL)
        wait(PICTURE_S, lambda: before not in picture.wire.nodes, picture.poll)
        picture.wire._out.send_multipart([before[:-1] + b"\x80" + b"ADDNODES" + picture.wire.own, b"\x01"])
        found["node_again"] = bool(wait(30, picture.node, picture.poll))
        found["whole_after_node"] = bool(wait(PICTURE_S, lambda: picture.ours() == OURS, picture.poll))
        # Server and all.
        os.killpg(server.pid, signal.SIGKILL)
        server.wait()
        settle(1.0, picture)
        server = bluesky(folder)
        picture.wire.close()
        picture = Picture()
        assert wait(60, picture.node, picture.poll), "no node of the second server"
        found["whole_after_server"] = bool(wait(PICTURE_S + 5, lambda: picture.ours() == OURS, picture.poll))
        bridge.send_signal(signal.SIGINT)
        found["bridge"] = json.loads(bridge.communicate(timeout=20)[0].strip().splitlines()[-1])
        client.stop()
        client.close()
        found["summary"] = json.loads(run.communicate(timeout=60)[0].strip().splitlines()[-1])
        found["run_code"] = run.returncode
    finally:
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
    print(json.dumps(found))


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
