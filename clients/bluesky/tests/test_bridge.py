"""The bridge without BlueSky: what it says of ours, its clocks, and a log in place of a server."""

import contextlib
import io
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import types
import unittest
import unittest.mock

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

import bridge  # noqa: E402
import clock  # noqa: E402
import recorded  # noqa: E402

KT_MPS = 1852 / 3600


class Speeds(unittest.TestCase):
    """BlueSky takes 0.1 to 2 m/s for a Mach number, and at exactly 0 it may go at 73 m/s in its next step."""

    def told(self, speed_mps, heading_deg=30.0, backwards=False):
        course = math.radians(heading_deg + (180.0 if backwards else 0.0))
        row = {"vx_ms": speed_mps * math.sin(course), "vy_ms": speed_mps * math.cos(course), "heading_deg": heading_deg}
        # As BlueSky reads it: the text, knots unless it is between 0.1 and 1.
        text = float(f"{bridge.move_speed_kt(row, 432.0):.2f}")
        return text if 0.1 < text < 1.0 else text * KT_MPS

    def test_no_speed_is_a_mach_number_and_none_is_nothing(self):
        for n in range(0, 9000):
            told_mps = self.told(n / 100)
            self.assertTrue(0.0 < told_mps <= 0.1 or told_mps >= 2.0, (n / 100, told_mps))

    def test_what_rolls_is_told_within_two_metres_a_second(self):
        for n in range(0, 3000):
            speed = n / 100
            self.assertLess(abs(self.told(speed) - speed), 1.1 + 0.03 * speed, speed)

    def test_who_is_pushed_back_stands_from_one_move_to_the_next(self):
        for speed in (0.5, 1.5, 2.5):
            self.assertLess(self.told(speed, 300.0, backwards=True), 0.1)


class SimTimes(unittest.TestCase):
    def test_what_comes_late_is_told_by_how_much_at_any_pace(self):
        for pace in (1.0, 2.9, 8.1):
            sim = clock.SimTime()
            for n in range(15):
                sim.hear(100.0 + 0.2 * n * pace, 50.0 + 0.2 * n)
                self.assertLess(sim.late_s(), 0.01 * pace)
                self.assertAlmostEqual(sim.pace(pace), pace, delta=1e-6)
            # The next one is of its time and came 0.1 s late.
            sim.hear(100.0 + 3.0 * pace, 53.1)
            self.assertAlmostEqual(sim.late_s(), min(0.1 * pace, clock.MOST_LATE_S), delta=0.03 * pace)

    def test_what_is_held_or_reset_is_no_pace(self):
        sim = clock.SimTime()
        for n in range(15):
            sim.hear(100.0 + 0.2 * n, 50.0 + 0.2 * n)
        for n in range(20):
            sim.hear(102.8, 53.0 + 0.2 * n)
            self.assertLessEqual(sim.late_s(), clock.MOST_LATE_S)
        self.assertEqual((sim.late_s(), sim.pace(1.0)), (0.0, 0.0))
        sim.hear(0.05, 58.0)
        self.assertEqual(sim.pace(1.0), 1.0)
        self.assertEqual(sim.late_s(), 0.0)

    def test_bluesky_behind_is_said_once_and_again_after_five_seconds(self):
        sim, said = clock.SimTime(), []
        for n in range(200):
            # From 10 s on it goes at half the pace for 4 s.
            lost = max(0.0, min(n * 0.2 - 10.0, 4.0)) / 2
            sim.hear(n * 0.2 - lost + 1e-6 * n, n * 0.2)
            told = sim.behind_s(n * 0.2, n * 0.2)
            if told is not None:
                said.append((n * 0.2, told))
        self.assertEqual(len(said), 1, said)
        self.assertAlmostEqual(said[0][1], 1.1, delta=0.15)
        # What was off for five seconds is the measure from then on.
        self.assertAlmostEqual(sim.anchor, -2.0, delta=0.1)


class Rates(unittest.TestCase):
    """As BlueSky's simulation does, OP and RESET set its rate to 1."""

    def setUp(self):
        self.rate, self.state, self.told = None, None, []
        arguments = bridge.parser().parse_args(["--dis", "127.0.0.1:9"])
        wire = types.SimpleNamespace(nodes=[], command=lambda _, line: self.obey(line))
        with unittest.mock.patch.object(bridge, "connected", return_value=wire):
            self.bridge = bridge.Bridge(arguments)
        self.addCleanup(self.bridge.socket.close)

    def obey(self, line):
        self.told.append(line)
        words = line.split()
        if words[0] == "DTMULT":
            self.rate = float(words[1])
        elif words[0] == "OP":
            self.state, self.rate = "OP", 1.0
        elif words[0] == "HOLD":
            self.state = "HOLD"

    def run_is(self, phase, rate):
        self.bridge.on_state({"phase": phase, "rate": rate})
        return self.state, self.rate

    def test_bluesky_goes_at_the_rate_of_the_run_whatever_made_it_go(self):
        self.bridge.take(b"*S123")
        self.assertEqual(self.state, "OP", "nobody has said how the run stands")
        self.assertEqual(self.run_is("FROZEN", 4.0)[0], "HOLD")
        self.assertEqual(self.run_is("RUNNING", 4.0), ("OP", 4.0))
        self.assertEqual(self.run_is("RUNNING", 2.0), ("OP", 2.0))
        told = len(self.told)
        self.assertEqual(self.run_is("RUNNING", 2.0), ("OP", 2.0))
        self.assertEqual(len(self.told), told, "nothing new")
        self.run_is("FROZEN", 2.0)
        self.assertEqual(self.run_is("RUNNING", 3.0), ("OP", 3.0), "another rate, as it goes on")
        self.state, self.rate = "INIT", 1.0
        self.bridge.from_node("RESET", None)
        self.assertEqual((self.state, self.rate), ("OP", 3.0))
        # Somebody holds it: it is told to go on after two seconds.
        self.bridge.aircraft({"simt": 5.0})
        self.state = "HOLD"
        self.bridge.moved_s -= 3.0
        self.bridge.aircraft({"simt": 5.0})
        self.assertEqual((self.state, self.rate), ("OP", 3.0))
        # Another node.
        self.state, self.rate = None, 1.0
        self.bridge.take(b"*S124")
        self.assertEqual((self.state, self.rate), ("OP", 3.0))
        self.run_is("FROZEN", 3.0)
        self.bridge.from_node("RESET", None)
        self.assertEqual(self.state, "HOLD")


class Headings(unittest.TestCase):
    """Where the nose of theirs points in the run."""

    def setUp(self):
        arguments = bridge.parser().parse_args(["--dis", "127.0.0.1:9"])
        wire = types.SimpleNamespace(nodes=[], command=lambda *_: None)
        with unittest.mock.patch.object(bridge, "connected", return_value=wire):
            self.bridge = bridge.Bridge(arguments)
        self.addCleanup(self.bridge.socket.close)
        self.pdus = []
        self.bridge.send = self.pdus.append

    def points(self, heading_deg, place):
        """That the last PDU has this heading, level."""
        wanted = bridge.entity_pdu.euler(math.radians(heading_deg), 0.0, *place)
        for said, angle in zip(struct.unpack_from(">3f", self.pdus[-1], 72), wanted):
            self.assertAlmostEqual(math.remainder(said - angle, math.tau), 0.0, delta=1e-6)

    def test_who_stands_or_is_held_points_where_bluesky_has_it(self):
        for n, place in enumerate([(47.458, 8.548), (-33.9, 151.2), (0.1, -77.0)]):
            for heading_deg in (0.0, 90.0, 200.0, 359.0):
                for gs, pace in ((0.0, 1.0), (80.0, 1.0), (80.0, 0.0)):
                    self.bridge.pace = lambda pace=pace: pace
                    name = f"BSK{n}{heading_deg:.0f}{gs:.0f}{pace:.0f}"
                    self.bridge.visit(name, place, 10.0, gs, math.radians(heading_deg), 0.0, 100.0, 5.0, 0.0)
                    self.points(heading_deg, place)
                    # And where it was when it is taken out.
                    self.bridge.end([name])
                    self.points(heading_deg, place)


class Meridians(unittest.TestCase):
    """All is the same at the meridian of 180° as anywhere else."""

    LAT = -17.7

    def at(self, meridian):
        arguments = bridge.parser().parse_args(["--dis", "127.0.0.1:9"])
        wire = types.SimpleNamespace(nodes=[], command=lambda *_: None)
        with unittest.mock.patch.object(bridge, "connected", return_value=wire):
            made = bridge.Bridge(arguments)
        self.addCleanup(made.socket.close)
        limits = {"capture_nm": 5.0, "capture_ft": 1500.0, "release_ft": 1000.0}
        with unittest.mock.patch.object(bridge.handover.threading, "Thread"):
            made.handover = bridge.handover.Handover(made, limits)
        made.phase, made.rate = "RUNNING", 1.0
        made.types = {"BSK1": "A320"}
        made.pace = lambda: 1.0
        made.handover.on_state({"reference_lat_deg": self.LAT, "reference_lon_deg": self.degrees(meridian, 0.004)})
        return made

    @staticmethod
    def degrees(meridian, east):
        return (meridian + east + 180.0) % 360.0 - 180.0

    def story(self, meridian):
        """What one of theirs that comes over a meridian from the west makes, told in degrees from the meridian."""
        made, sent, placed = self.at(meridian), [], []
        east = lambda lon: round((lon - meridian + 180.0) % 360.0 - 180.0, 9)
        made.send = lambda octets: None
        made.pdu = lambda name, entity, row, gone=False: sent.append((name, round(row[0], 9), east(row[1]), round(row[2], 6), gone))
        made.clock.placed = lambda time_s, at: placed.append((time_s, round(at, 6)))
        cos = 111_194.9 * math.cos(math.radians(self.LAT))
        far = bridge.metres((self.LAT, self.degrees(meridian, 0.001)), (self.LAT, self.degrees(meridian, -0.001)))
        for n in range(20):
            place = (self.LAT, self.degrees(meridian, (n - 10) * 10.0 / cos))
            made.visit("BSK1", place, 200.0, 50.0, math.pi / 2, -2.0, 100.0 + 0.2 * n, 5.0 + 0.2 * n, 0.05)
        made.types["BSK3"] = "A320"
        made.handover.wanted("BSK3", (self.LAT, meridian + 0.0001), 200.0, 50.0, math.pi / 2, -2.0, 104.0)
        asks = [(name, body) for name, _, body in iter_queue(made.handover.asks)]
        self.assertTrue(all(-180.0 <= body["lon_deg"] <= 180.0 for _, body in asks), asks)
        asked = [(name, body["command"], east(body["lon_deg"])) for name, body in asks]
        row = {"lat_deg": self.LAT, "lon_deg": self.degrees(meridian, -0.0005)}
        entity = types.SimpleNamespace(sent=((self.LAT, self.degrees(meridian, 0.0005)), 0.0, (50.0, 0.0, 0.0), 7.0))
        made.handover._calibrate(row, entity, 30.0)
        last = ((self.LAT, self.degrees(meridian, -0.0005)), 300.0, (50.0, 0.0, 2.0))
        made.handover.released["BSK2"] = {"last": last, "at": 100.0, "offset": None, "time_s": 9.0}
        shown = []
        for n in range(40):
            place = (self.LAT, self.degrees(meridian, 0.0005 + n * 50.0 / cos))
            found, height, _ = made.handover.blended("BSK2", place, 310.0, (50.0, 0.0, 2.0), 100.0 + n)
            shown.append((round(found[0], 9), east(found[1]), round(height, 6)))
        return [round(far, 6), sent, made.count["entities"], asked, placed, shown]

    def test_nothing_leaps_where_east_becomes_west(self):
        plain = self.story(20.0)
        self.assertLess(plain[0], 250.0)
        self.assertEqual(plain[2], 1)
        self.assertEqual([ask[:2] for ask in plain[3]], [("BSK1", "give"), ("BSK3", "give")])
        for meridian in (180.0, -180.0, 0.0):
            for told, wanted in zip(self.story(meridian), plain):
                self.assertEqual(told, wanted, meridian)


def iter_queue(queue):
    while not queue.empty():
        yield queue.get()


class Interfaces(unittest.TestCase):
    def of(self, *more):
        with unittest.mock.patch.object(bridge, "connected"):
            socket = bridge.Bridge(bridge.parser().parse_args([*more])).socket
        self.addCleanup(socket.close)
        return ".".join(map(str, socket.getsockopt(bridge.socket.IPPROTO_IP, bridge.socket.IP_MULTICAST_IF, 4)))

    def test_a_group_is_sent_to_from_the_interface_that_was_asked_for(self):
        group = ("--dis", "239.9.1.1:3000")
        self.assertEqual(self.of(*group), "127.0.0.1")
        self.assertEqual(self.of(*group, "--interface", "127.0.0.2"), "127.0.0.2")

    def test_what_is_no_address_is_refused(self):
        for wrong in ("eth0", "::1", "1.2.3"):
            with contextlib.redirect_stderr(io.StringIO()), self.assertRaises(SystemExit) as ended:
                bridge.parser().parse_args(["--interface", wrong])
            self.assertEqual(ended.exception.code, 2)


class Recorded(unittest.TestCase):
    def wire(self, lines):
        with tempfile.NamedTemporaryFile("w", suffix=".jsonl", delete=False) as file:
            file.write("\n".join(lines))
        self.addCleanup(pathlib.Path(file.name).unlink)
        self.now_s = None
        return recorded.Wire(file.name, types.SimpleNamespace(now_s=lambda at: self.now_s))

    def test_everything_comes_at_its_time_and_in_its_order(self):
        def entry(topic, our_s, body, way="in"):
            return json.dumps({"wall_ns": 0, "our_ns": our_s and int(our_s * 1e9), "dir": way, "topic": topic, "body": body})

        wire = self.wire([
            entry("came", None, "531a741f81"), entry("STACK", 1.0, "OP", "out"), entry("ACDATA", 2.0, {"simt": 1.0}),
            entry("ECHO", 2.5, {"text": "x", "flags": 2}), entry("lost", 4.0, None), entry("came", 5.0, "531a741f82"), entry("RESET", 5.0, None),
        ])
        topics = lambda: [event[0] for event in wire.poll(0)]
        self.assertEqual(topics(), ["came"])
        self.assertEqual(wire.nodes, [bytes.fromhex("531a741f81")])
        self.now_s = 1.9
        self.assertEqual(topics(), [])
        self.now_s = 2.6
        self.assertEqual(topics(), ["ACDATA", "ECHO"])
        self.now_s = 4.5
        self.assertEqual(topics(), ["lost"])
        self.assertEqual(wire.nodes, [])
        self.now_s = 9.0
        self.assertEqual(topics(), ["came", "RESET"])

    def test_what_is_no_log_is_refused_by_line(self):
        for line, why in (("not json", ":1: not a line"), ('{"dir": "in"}', ":1: not a line"), ("[]", ":1: not a line"),
                          ('{"dir": "own", "topic": "stats", "our_ns": 1, "body": {}}', "BlueSky says nothing")):
            said = io.StringIO()
            with contextlib.redirect_stderr(said), self.assertRaises(SystemExit) as ended:
                self.wire([line])
            self.assertEqual(ended.exception.code, 2)
            self.assertIn(why, said.getvalue())

    def test_a_file_that_is_not_there_is_one_line(self):
        command = [sys.executable, str(HERE.parent / "bridge.py"), "--replay", "/nowhere/x.jsonl"]
        done = subprocess.run(command, capture_output=True, text=True)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)


if __name__ == "__main__":
    unittest.main()
