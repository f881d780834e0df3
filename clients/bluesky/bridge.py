"""Mirrors a run of SEEDS in BlueSky and BlueSky's aircraft in the run. SEEDS owns time.

    seeds run zurich --public=tcp/127.0.0.1:7448
    bluesky --headless
    python clients/bluesky/bridge.py --dis 127.255.255.255:3000

Ours go out as MOVE once a scan; theirs come in as DIS entities of application 300, as those of any visitor do. Who is in the run's truth
and ours there is never taken from BlueSky. With --handover theirs on final are given to the run's traffic, and ours that climb away are
let go (handover.py); the scene needs [[traffic]] kind = "handover" for that. Freeze sends HOLD, going on OP, rate x DTMULT x. Ends with the run, or by Ctrl-C.
"""

import argparse
import ipaddress
import json
import math
import queue
import socket
import sys
import threading
import time

import clock
import entity_pdu
import handover
import seeds_client as seeds

FT_M, KT_MPS = 0.3048, 1852 / 3600
MOST = 2000  # aircraft of theirs
GONE_S = 2.0  # not in the data while their time moves
LEAST_JUMP_M = 300.0
HELD_S = 2.0
HEARTBEAT_S = 4.0
DRIFT_M = 1.0
ANSWERS_S = 5.0
COLUMNS = ("id", "lat", "lon", "alt", "gs", "trk", "vs")
REFUSALS = (1, 2, 4)  # unknown call sign, one that is there, unknown command
MOST_SAID = 20
TYPES_AT_ONCE = 20
STANDS_KT = 0.04  # at 0 its drag is not a number, and it goes at 73 m/s in the next step
LEAST_MPS = 2.06  # 0.1 to 2 m/s is a Mach number to BlueSky: Mach 1.5 is what it makes of 1.5 m/s


def cas_mps(tas_mps, altitude_m):
    """Calibrated from true air speed in the standard atmosphere (below 11 km)."""
    ratio = 1 - 2.25577e-5 * max(-500.0, min(altitude_m, 11_000.0))
    pressure, temperature = 101_325 * ratio**5.25588, 288.15 * ratio
    mach2 = tas_mps**2 / (1.4 * 287.053 * temperature)
    impact = pressure * ((1 + 0.2 * mach2) ** 3.5 - 1)
    return math.sqrt(5 * 1.4 * 287.053 * 288.15 * ((impact / 101_325 + 1) ** (1 / 3.5) - 1) / 1.0)


def move_speed_kt(row, altitude_m):
    """What MOVE is told: calibrated, kt; what goes slower than half of what BlueSky can take, or backwards, stands until the next."""
    east, north, heading = row["vx_ms"], row["vy_ms"], math.radians(row["heading_deg"])
    speed = math.hypot(east, north)
    if speed < LEAST_MPS / 2 or east * math.sin(heading) + north * math.cos(heading) < 0.0:
        return STANDS_KT
    return cas_mps(max(speed, LEAST_MPS), altitude_m) / KT_MPS


def metres(a, b):
    """Distance of two places (degrees) near each other."""
    north, east = (a[0] - b[0]) * 111_194.9, handover.east_deg(a[1] - b[1]) * 111_194.9 * math.cos(math.radians(a[0]))
    return math.hypot(north, east)


def rounded(key, column):
    """A column of ACDATA for the log: 1e-7 degrees, 1e-3 of all else."""
    if key == "id":
        return [str(name) for name in column]
    return [round(float(value), 7 if key in ("lat", "lon") else 3) for value in column]


def connected(arguments, clock_of_run):
    """BlueSky's wire, or what it said once."""
    if arguments.replay:
        import recorded

        return recorded.Wire(arguments.replay, clock_of_run)
    from wire import Wire

    return Wire(arguments.host, arguments.receive, arguments.send)


class Theirs:
    """An aircraft of BlueSky in the run."""

    def __init__(self, number):
        self.number, self.seen_s, self.place, self.simt = number, 0.0, None, None
        self.sent = None  # place, height, velocity and wall time as others know them
        self.answered_s = None  # when its transponder was told last
        self.pace = 1.0  # at which it was told
        self.heading = 0.0  # rad from north


class Bridge:
    def __init__(self, arguments):
        self.arguments = arguments
        self.clock, self.sim_time = clock.Clock(), clock.SimTime()
        self.wire = connected(arguments, self.clock)
        self.node = None
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        if ipaddress.ip_address(arguments.dis[0]).is_multicast:
            self.socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(arguments.interface))
        self.log = open(arguments.log, "w", encoding="utf-8") if arguments.log else None
        self.theirs, self.ours, self.numbers = {}, {}, {}
        self.phase = self.rate = None
        self.simt, self.moved_s, self.asked_op_s = None, time.monotonic(), 0.0
        self.created, self.pending, self.types, self.said = {}, {}, {}, set()
        self.count = {key: 0 for key in ("moves", "confirmed", "late", "dropped", "resets", "nodes_lost", "server_lost", "entities", "pdus", "damaged", "refused", "behind")}
        self.latencies = []
        limits = {key: getattr(arguments, key) for key in ("capture_nm", "capture_ft", "release_ft")}
        self.handover = handover.Handover(self, limits) if arguments.handover else None

    # What goes out.

    def say(self, line):
        if self.node is None:
            return
        self.write("out", "STACK", line)
        self.wire.command(self.node, line)

    def write(self, direction, topic, body):
        if self.log:
            our_s = self.clock.now_s(time.monotonic())
            our_ns = None if our_s is None else round(our_s * 1e9)
            self.log.write(json.dumps({"wall_ns": time.time_ns(), "our_ns": our_ns, "dir": direction, "topic": topic, "body": body}) + "\n")
            if direction != "in":
                self.log.flush()

    def pdu(self, callsign, entity, row, gone=False):
        lat, lon, height_m, velocity = row
        identifier = (self.arguments.site, 300, entity.number)
        kind = self.types.get(callsign) or "ZZZZ"
        # Stamps are of the host's time, and so is velocity: who hears them divides by the rate.
        entity.pace = self.pace()
        velocity = tuple(v * entity.pace for v in velocity)
        self.send(entity_pdu.entity_state(self.arguments.exercise, identifier, callsign, kind, lat, lon, height_m, velocity, entity.heading, gone))
        now = time.monotonic()
        if self.handover and not gone and (entity.answered_s is None or now - entity.answered_s > ANSWERS_S):
            entity.answered_s = now
            address = self.handover.address(callsign)
            self.send(entity_pdu.iff(self.arguments.exercise, identifier, callsign, address))

    def pace(self):
        """Seconds of BlueSky's time in one of the host's."""
        return self.sim_time.pace(self.rate or 1.0)

    def send(self, octets):
        try:
            self.socket.sendto(octets, self.arguments.dis)
            self.count["pdus"] += 1
        except OSError:
            pass  # the run has no network any more: it ends elsewhere

    def shows(self, name):
        """One of ours is told of as theirs, too: who has it in the run hides it there."""
        if name not in self.theirs:
            self.theirs[name] = Theirs(self.numbers.setdefault(name, len(self.numbers) % 65_000 + 1))
            self.count["entities"] += 1

    def flies_on(self, name, last):
        """BlueSky has it from now on: it climbs straight on."""
        if last:
            _, height_m, (east, north, _) = last
            speed = math.hypot(east, north)
            heading, knots = math.degrees(math.atan2(east, north)) % 360.0, cas_mps(speed, height_m) / KT_MPS
            self.say(f"ALT {name},{height_m / FT_M + 5000.0:.0f};SPD {name},{knots:.0f};HDG {name},{heading:.1f}")

    # The run.

    def on_state(self, body):
        phase, rate = body["phase"], body.get("rate")
        self.clock.paced(rate)
        if phase != self.phase:
            self.clock.stood()
            self.sim_time.forget()
        if self.handover:
            self.handover.on_state(body)
        if rate is None and phase == "RUNNING":
            sys.exit("bridge: the run goes as fast as possible; BlueSky has real time: leave out --fast")
        before = self.phase, self.rate
        self.phase, self.rate = phase, rate
        if phase != before[0]:
            self.go() if phase == "RUNNING" else self.say("HOLD")
        elif rate != before[1]:
            self.tell_rate()

    def go(self):
        """OP sets BlueSky's rate to 1, as RESET does: ours goes after it."""
        self.say("OP")
        self.tell_rate()

    def tell_rate(self):
        if self.rate:
            self.say(f"DTMULT {max(1, min(20, round(self.rate)))}")

    def on_truth(self, body):
        rows = {row["callsign"].upper(): row for row in body["truth"] if row.get("ours") and row.get("lat_deg") is not None and row["callsign"]}
        now = time.monotonic()
        self.clock.scan(body["time_s"], now)
        if self.handover:
            self.handover.on_truth(body, rows, now)
        gone = [name for name in self.created if name not in rows]
        lines = [f"DEL {name}" for name in gone]
        for name in gone:
            del self.created[name]
            self.pending.pop(name, None)
        for name, row in rows.items():
            altitude_m = self.handover.height_m(row) if self.handover else row["altitude_m"] + self.arguments.elevation
            speed = math.hypot(row["vx_ms"], row["vy_ms"])
            knots = move_speed_kt(row, altitude_m)
            place = f"{row['lat_deg']:.7f},{row['lon_deg']:.7f}"
            heading = row["heading_deg"] % 360.0
            if name not in self.created:
                kind = row.get("type") if row.get("aircraft") else "C172"
                lines.append(f"CRE {name},{kind or 'A320'},{place},{heading:.2f},{altitude_m / FT_M:.1f},{knots:.2f}")
                self.created[name] = now
            lines.append(f"MOVE {name},{place},{altitude_m / FT_M:.1f},{heading:.2f},{knots:.2f},0")
            if self.node is not None:
                before = self.pending.get(name)
                if before:
                    self.count["late"] += 1
                    self.write("own", "late", [name, before[3], before[1]])
                self.count["moves"] += 1
                self.pending[name] = [(row["lat_deg"], row["lon_deg"]), speed, now, None]
        self.ours = {"time_s": body["time_s"], "names": set(rows)}
        worst = sorted(self.latencies[-2000:])
        spread = [worst[0], worst[len(worst) // 2], worst[-1]] if worst else None
        self.write("own", "stats", {**self.count, "latency_s": spread})
        del self.latencies[:-2000]
        # One message a cycle, as long as a line may be.
        for at in range(0, len(lines), 100):
            self.say(";".join(lines[at:at + 100]))

    # BlueSky.

    def on_event(self, event):
        topic = event[0]
        if topic == "came":
            if self.node is None:
                self.take(event[1])
        elif topic == "left":
            self.write("in", "left", event[1].hex())
            if event[1] == self.node:
                self.count["nodes_lost"] += 1
                self.leave()
                if self.wire.nodes:
                    self.take(self.wire.nodes[0])
        elif topic == "lost":
            self.count["server_lost"] += 1
            self.write("in", "lost", None)
            self.leave()
        elif topic == "damaged":
            self.count["damaged"] += 1
        elif event[1] == self.node:
            self.from_node(topic, event[2])

    def take(self, node):
        """A node is there: everything begins again on it."""
        self.node, self.simt, self.moved_s = node, None, time.monotonic()
        self.sim_time.forget()
        self.created.clear()
        self.pending.clear()
        self.write("in", "came", node.hex())
        self.go() if self.phase in (None, "RUNNING") else self.say("HOLD")

    def leave(self):
        """The node is gone: what was its own ends at once."""
        self.node = None
        self.begin_again()

    def begin_again(self):
        for known in (self.created, self.pending, self.types):
            known.clear()
        self.sim_time.forget()
        if self.handover:
            self.handover.forget()
        self.end(list(self.theirs))

    def end(self, names):
        for name in names:
            entity = self.theirs.pop(name)
            if entity.sent:
                self.pdu(name, entity, (*entity.sent[0], entity.sent[1], (0.0, 0.0, 0.0)), gone=True)

    def from_node(self, topic, data):
        if topic == "RESET":
            self.count["resets"] += 1
            self.write("in", topic, None)
            self.begin_again()
            self.go() if self.phase in (None, "RUNNING") else self.say("HOLD")
        elif topic == "ECHO":
            self.write("in", topic, data if isinstance(data, (dict, str)) else str(data))
            if isinstance(data, dict):
                self.on_echo(str(data.get("text", "")), data.get("flags"))
        elif topic == "ACDATA" and isinstance(data, dict):
            try:
                self.aircraft(data)
            except (KeyError, TypeError, ValueError):
                self.count["damaged"] += 1

    def ask_types(self, names):
        """BlueSky tells what they are in an ECHO each; a node takes a line every 50 ms."""
        for name in names:
            self.types.setdefault(name, None)
        if names:
            self.say(";".join(f"POS {name}" for name in names))

    def on_echo(self, text, flags):
        """`Info on BSK1 A320 index = 3`; or what BlueSky refuses, which is said once."""
        words = text.split()
        if words[:2] == ["Info", "on"] and len(words) > 3:
            name = words[2].upper()
            if name in self.types:
                self.types[name] = words[3].upper()
                if name in self.theirs:
                    self.theirs[name].sent = None  # told anew, as what it is
        elif isinstance(flags, int) and flags in REFUSALS:
            self.count["refused"] += 1
            if text not in self.said and len(self.said) < MOST_SAID:
                self.said.add(text)
                print(f"bridge: BlueSky refuses: {text.strip()[:200]}", file=sys.stderr, flush=True)

    def paced(self, simt, now):
        """Says once when BlueSky falls behind."""
        self.sim_time.hear(simt, now)
        behind_s = self.sim_time.behind_s(self.clock.now_s(now), now) if self.phase == "RUNNING" else None
        if behind_s is not None:
            self.count["behind"] += 1
            self.write("own", "behind", behind_s)
            word = f"{behind_s:.1f} s behind" if behind_s > 0 else f"{-behind_s:.1f} s ahead"
            print(f"bridge: bluesky is {word}", file=sys.stderr, flush=True)

    def aircraft(self, data):
        now, simt = time.monotonic(), float(data["simt"])
        if self.simt is None or simt != self.simt:
            self.moved_s = now
        if self.simt is not None and simt < self.simt:
            self.created.clear()  # a reset that was not said
        self.simt = simt
        self.paced(simt, now)
        # SEEDS owns time: who holds it is told to go on.
        if self.phase == "RUNNING" and now - self.moved_s > HELD_S and now - self.asked_op_s > HELD_S:
            self.asked_op_s = now
            self.go()
        ours = self.ours.get("names", set()) if self.ours else None
        if ours is None:
            return  # nobody has said yet who is ours
        columns = [data[key] for key in COLUMNS]
        if self.log:
            self.write("in", "ACDATA", {"simt": simt, **{key: rounded(key, column) for key, column in zip(COLUMNS, columns)}})
        late_s, unknown = self.sim_time.late_s(), []
        for name, lat, lon, alt, gs, trk, vs in zip(*columns):
            name = str(name).upper()
            if not all(map(math.isfinite, (lat, lon, alt, gs, trk, vs))) or abs(lat) > 90 or abs(lon) > 360:
                self.count["dropped"] += 1
                continue
            if self.handover and self.handover.releasing(name) and name in self.theirs:
                self.confirm(name, (lat, lon), now)
                self.as_ours(name, now, simt)
            elif (name in ours or name in self.created) and not (self.handover and name in self.handover.released):
                self.confirm(name, (lat, lon), now)
            else:
                self.visit(name, (lat, lon), alt, gs, math.radians(trk), vs, now, simt, late_s)
                if name not in self.types and len(unknown) < TYPES_AT_ONCE:
                    unknown.append(name)
        self.ask_types(unknown)
        if now - self.moved_s < GONE_S:
            gone = [name for name, entity in self.theirs.items() if now - entity.seen_s > GONE_S]
            self.end(gone)
            for name in gone:
                self.types.pop(name, None)
            # One of ours that somebody took out there is made again.
            there = {str(name).upper() for name in columns[0]}
            for name in [n for n, at in self.created.items() if n not in there and now - at > GONE_S]:
                del self.created[name]

    def as_ours(self, name, now, simt):
        """One that is to be let go is told of where the run has it."""
        entity, known = self.theirs[name], self.handover.as_ours(name, now)
        entity.seen_s, entity.place, entity.simt = now, None, simt
        if known:
            place, height_m, velocity = known
            entity.heading = math.radians(self.handover.rows[name][1]["heading_deg"])
            entity.sent = (place, height_m, velocity, now)
            self.pdu(name, entity, (*place, height_m, velocity))

    def confirm(self, name, place, now):
        asked = self.pending.get(name)
        if not asked:
            return
        wanted, speed, at, _ = asked
        # It rolls on from where it was put: so far at most until it was seen.
        off_m = metres(place, wanted)
        asked[3] = [off_m, now - at] if asked[3] is None or off_m < asked[3][0] else asked[3]
        if off_m <= 2.0 + speed * (now - at) * 1.5 + 3.0 * (now - at):
            del self.pending[name]
            self.latencies.append(now - at)
            self.count["confirmed" if now - at <= 0.5 else "late"] += 1

    def visit(self, name, place, alt, gs, track, vs, now, simt, late_s):
        entity = self.theirs.get(name)
        if entity and entity.place:
            elapsed = max(simt - entity.simt, 0.2)
            if metres(place, entity.place) > max(LEAST_JUMP_M, 3 * gs * elapsed):
                self.end([name])
                entity = None
        if entity is None:
            if len(self.theirs) >= MOST:
                self.count["dropped"] += 1
                return
            number = self.numbers.setdefault(name, len(self.numbers) % 65_000 + 1)
            entity = self.theirs[name] = Theirs(number)
            self.count["entities"] += 1
        entity.seen_s, entity.place, entity.simt = now, place, simt
        entity.heading = track
        velocity = told = (gs * math.sin(track), gs * math.cos(track), vs)
        cos = 111_194.9 * math.cos(math.radians(place[0]))
        place, alt = (place[0] + velocity[1] * late_s / 111_194.9, place[1] + velocity[0] * late_s / cos), alt + vs * late_s
        if self.handover:
            self.handover.wanted(name, place, alt, gs, track, vs, now)
            place, alt, velocity = self.handover.blended(name, place, alt, velocity, now)
            if velocity != told:
                entity.heading = math.atan2(velocity[0], velocity[1])
        if entity.sent:
            (lat, lon), height_m, known, at = entity.sent
            scale = entity.pace * (now - at)
            believed = (lat + known[1] * scale / 111_194.9, lon + known[0] * scale / (111_194.9 * math.cos(math.radians(lat))))
            off_m = math.hypot(metres(place, believed), alt - height_m - known[2] * scale)
            handing = self.handover and name in self.handover.handing
            same = (self.pace() == 0.0) == (entity.pace == 0.0)  # held, or going
            if off_m < DRIFT_M and now - at < HEARTBEAT_S and same and not handing:
                return
        entity.sent = (place, alt, velocity, now)
        self.pdu(name, entity, (*place, alt, velocity))

    # All of it.

    def run(self):
        heard = queue.Queue(256)

        def listen():
            try:
                with seeds.connect(self.arguments.endpoint, self.arguments.exercise, client="bluesky") as run:
                    heard.put(("state", run.last("state")))
                    if self.handover:
                        heard.put(("flights", run.last("flights")))
                    for body in run.messages("truth", "state", *(("handovers",) if self.handover else ())):
                        heard.put((body["schema"].split("/")[0].removeprefix("seeds."), body))
                heard.put(("over", None))
            except Exception as error:  # said by the main thread
                heard.put(("over", str(error)))

        threading.Thread(target=listen, daemon=True).start()
        why = None
        try:
            while True:
                for event in self.wire.poll(20):
                    self.on_event(event)
                while not heard.empty():
                    kind, body = heard.get()
                    if kind == "over":
                        why = body
                        return why
                    if kind in ("flights", "handovers"):
                        getattr(self.handover, f"on_{kind}")(body)
                    else:
                        (self.on_state if kind == "state" else self.on_truth)(body)
                if self.handover:
                    self.handover.poll(time.monotonic())
        except KeyboardInterrupt:
            return None
        finally:
            self.finish()

    def finish(self):
        self.end(list(self.theirs))
        if self.created:
            self.say(";".join(f"DEL {name}" for name in self.created))
            time.sleep(0.2)
        self.wire.close()
        if self.log:
            self.log.close()
        worst = max(self.latencies, default=None)
        share = self.count["confirmed"] / self.count["moves"] if self.count["moves"] else None
        print(json.dumps({**self.count, "confirmed_share": share, "worst_s": worst}), flush=True)


def address(text):
    host, _, port = text.rpartition(":")
    return str(ipaddress.ip_address(host)), int(port)


def interface(text):
    return str(ipaddress.IPv4Address(text))


def parser():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--endpoint", default=seeds.live.DEFAULT_ENDPOINT, help="public interface of the run")
    parser.add_argument("--exercise", type=int, default=1)
    parser.add_argument("--dis", type=address, default=("127.255.255.255", 3000), metavar="ADDR:PORT", help="data plane of the run")
    parser.add_argument("--interface", type=interface, default="127.0.0.1", metavar="IP", help="of this host, where --dis is a multicast group [127.0.0.1]")
    parser.add_argument("--site", type=int, default=300, help="DIS site of BlueSky's aircraft")
    parser.add_argument("--elevation", type=float, default=0.0, metavar="M", help="height of the aerodrome: ours fly as much higher in BlueSky")
    parser.add_argument("--host", default="127.0.0.1", help="of the BlueSky server")
    parser.add_argument("--receive", type=int, default=11000)
    parser.add_argument("--send", type=int, default=11001)
    parser.add_argument("--handover", action="store_true", help="give theirs on final to the run's traffic, take ours that climb away")
    parser.add_argument("--capture-nm", type=float, default=5.0, help="theirs are given within so many miles of the airport")
    parser.add_argument("--capture-ft", type=float, default=1500.0, help="and below so many feet above it")
    parser.add_argument("--release-ft", type=float, default=1000.0, help="ours are let go above so many feet")
    parser.add_argument("--type", default="A320", help="type of theirs whose type BlueSky does not tell")
    parser.add_argument("--replay", metavar="FILE", help="what BlueSky said as --log wrote it, by the time of the run, in place of a BlueSky")
    parser.add_argument("--log", metavar="FILE", help="what comes and goes, one JSON object a line")
    return parser


def main():
    why = Bridge(parser().parse_args()).run()
    if why:
        sys.exit(f"bridge: {why}")


if __name__ == "__main__":
    main()
