"""Who owns a call sign: OURS (the run's), THEIRS (BlueSky's), HANDING for two seconds at most, while its giver keeps it.

Theirs on final is given (`give` of the public interface); the run's own traffic lands it and takes it to a stand. Ours that climbs away is let go
(`release`), and BlueSky flies on. Whoever is told of in truth as ours is ours, whatever was heard of the ask.
"""

import math
import queue
import threading
import time

import seeds_client as seeds

NM_M, FT_M, EARTH_M = 1852.0, 0.3048, 6_371_000.0
HANDING_S, RETRY_S, BLEND_S = 2.0, 5.0, 30.0
CLIMBS_MPS = 1.0
MADE_ADDRESS = 0xF40000  # theirs have none of their own


def east_deg(degrees):
    """A difference of longitudes, or a longitude, within half a turn."""
    return (degrees + 180.0) % 360.0 - 180.0


class Asked:
    """One who changes hands."""

    def __init__(self, kind, at):
        self.kind, self.at, self.number = kind, at, None


class Handover:
    """`bridge` has the aircraft, sends their PDUs and speaks to BlueSky; `limits`: capture_nm, capture_ft, release_ft."""

    def __init__(self, bridge, limits):
        self.bridge, self.limits, self.clock = bridge, limits, bridge.clock
        self.reference, self.addresses, self.asked_type = None, {}, set()
        self.handing, self.retry_at = {}, {}
        self.released, self.rows, self.climbs = {}, {}, {}
        self.asks, self.answers = queue.Queue(64), queue.Queue()
        threading.Thread(target=self._work, daemon=True).start()

    # The thread that asks: an answer may take seconds, and nobody waits for it.

    def _work(self):
        run = None
        while True:
            name, known_at, body = self.asks.get()
            try:
                if run is None:
                    run = seeds.connect(self.bridge.arguments.endpoint, self.bridge.arguments.exercise, client="bluesky")
                if known_at is not None:
                    # By the time of the run, where theirs in truth tell it: what the ask takes on its way is then in nothing.
                    body = {**body, **self.clock.state_at(known_at)}
                answer = run.command(**body)
                self.answers.put((name, True, answer.text))
            except seeds.Refused as error:
                self.answers.put((name, False, str(error)))
            except Exception as error:  # the run is gone, or comes again
                run = None
                self.answers.put((name, False, str(error)))

    def note(self, name, word, text=""):
        self.bridge.count[word] = self.bridge.count.get(word, 0) + 1
        self.bridge.write("own", word, [name, text])

    def address(self, name):
        entity = self.bridge.theirs.get(name)
        return self.addresses.get(name) or (MADE_ADDRESS + entity.number if entity else None)

    # What the run says.

    def on_state(self, body):
        self.reference = (body["reference_lat_deg"], body["reference_lon_deg"])

    def on_flights(self, body):
        for row in body.get("flights", []):
            if row.get("address"):
                address = row["address"]
                self.addresses[row["callsign"].upper()] = int(address, 16) if isinstance(address, str) else address

    def on_truth(self, body, ours, now):
        """`ours`: rows by name; those of who was let go since are taken out."""
        time_s = body["time_s"]
        for name in [n for n in ours if n in self.released and time_s < self.released[n]["time_s"]]:
            del ours[name]
        for row in body["truth"]:
            entity = self.bridge.theirs.get(str(row.get("callsign", "")).upper())
            if not row.get("ours") and entity and entity.sent:
                self._calibrate(row, entity, time_s)
        for name in [n for n in ours if n in self.bridge.theirs]:
            asked = self.handing.get(name)
            if asked is None or asked.kind == "give":
                self.handing.pop(name, None)
                self.bridge.end([name])
                self.bridge.created[name] = now
                self.released.pop(name, None)
                self.note(name, "taken")
        for name in [n for n, asked in self.handing.items() if asked.kind == "release" and n not in ours]:
            self._let_go(name, now, time_s)
        for name, row in ours.items():
            before = self.rows.get(name)
            if before and time_s > before[0]:
                self.climbs[name] = (row["altitude_m"] - before[1]["altitude_m"]) / (time_s - before[0])
        self.rows = {name: (time_s, row) for name, row in ours.items()}
        if self.bridge.phase == "RUNNING":
            for name in ours:
                self._may_release(name, now)

    def _calibrate(self, row, entity, time_s):
        (lat, lon), _, (east, north, _), at = entity.sent
        speed2 = east * east + north * north
        if speed2 > 900.0:
            dy, dx = (row["lat_deg"] - lat) * 111_194.9, east_deg(row["lon_deg"] - lon) * 111_194.9 * math.cos(math.radians(lat))
            self.clock.placed(time_s, at + (dx * east + dy * north) / speed2 / self.clock.rate)

    def on_handovers(self, body):
        for done in body["handovers"]:
            for name, asked in list(self.handing.items()):
                if asked.number == done["number"]:
                    if done.get("refused"):
                        self._kept(name, done["refused"])
                    elif asked.kind == "release":
                        self._let_go(name, time.monotonic(), done["time_s"])

    # Theirs to ours.

    def wanted(self, name, place, alt, gs, track, vs, now):
        """One of theirs, as it is at `now`: given if it comes to land."""
        if self.bridge.phase != "RUNNING" or self.reference is None or name in self.handing or now < self.retry_at.get(name, 0.0):
            return
        north = (place[0] - self.reference[0]) * 111_194.9
        east = east_deg(place[1] - self.reference[1]) * 111_194.9 * math.cos(math.radians(place[0]))
        height_m = alt - self.bridge.arguments.elevation
        near = math.hypot(north, east) <= self.limits["capture_nm"] * NM_M and height_m <= self.limits["capture_ft"] * FT_M
        if not near or vs > -0.5 or name in self.released:
            return
        if not self.bridge.types.get(name):
            self.bridge.ask_types([name])
            self.retry_at[name] = now + 0.5
            if name not in self.asked_type:
                self.asked_type.add(name)
                return
        address = self.address(name)
        body = {
            "command": "give", "callsign": name, "type": self.bridge.types.get(name) or self.bridge.arguments.type, "lat_deg": place[0], "lon_deg": east_deg(place[1]),
            "height_m": alt, "vx_ms": gs * math.sin(track), "vy_ms": gs * math.cos(track), "vz_ms": vs,
            "address": f"{address:06x}" if address else None,
        }
        self._ask(name, "give", now, body)

    def _ask(self, name, kind, known_at, body):
        self.handing[name] = Asked(kind, time.monotonic())
        self.note(name, f"{kind}_asked")
        try:
            self.asks.put_nowait((name, known_at if kind == "give" else None, body))
        except queue.Full:
            self._kept(name, "too many asks at once")

    # Ours to theirs.

    def _may_release(self, name, now):
        _, row = self.rows[name]
        high = row["altitude_m"] >= self.limits["release_ft"] * FT_M + 5.0
        if not (row.get("aircraft") and high and self.climbs.get(name, 0.0) > CLIMBS_MPS) or name in self.handing:
            return
        if name not in self.bridge.created or now < self.retry_at.get(name, 0.0):
            return
        # The taker shows it already, as the run has it: while it is ours nobody sees that.
        self.bridge.shows(name)
        self._ask(name, "release", now, {"command": "release", "callsign": name})

    def as_ours(self, name, now):
        """Place, height above the ellipsoid and velocity of one of ours now, by the last scan."""
        known, time_s = self.rows.get(name), self.clock.now_s(now)
        if not known or time_s is None:
            return None
        since_s = max(-1.0, min(time_s - known[0], 3.0))
        row, climb = known[1], self.climbs.get(name, 0.0)
        lat = row["lat_deg"] + row["vy_ms"] * since_s / 111_194.9
        lon = row["lon_deg"] + row["vx_ms"] * since_s / (111_194.9 * math.cos(math.radians(lat)))
        return (lat, lon), self.height_m(row) + climb * since_s, (row["vx_ms"], row["vy_ms"], climb)

    def height_m(self, row):
        """Height above the ellipsoid: up in the airport's frame is above a plane."""
        return row["altitude_m"] + self.bridge.arguments.elevation + (row["x_m"] ** 2 + row["y_m"] ** 2) / (2 * EARTH_M)

    def releasing(self, name):
        asked = self.handing.get(name)
        return asked is not None and asked.kind == "release"

    def _let_go(self, name, now, time_s):
        self.handing.pop(name, None)
        last = self.as_ours(name, now)
        self.bridge.created.pop(name, None)
        self.bridge.pending.pop(name, None)
        self.released[name] = {"last": last, "at": now, "offset": None, "time_s": time_s}
        self.note(name, "let_go")
        self.bridge.flies_on(name, last)

    def blended(self, name, place, alt, velocity, now):
        """Where one that was let go is shown: from where it was to where BlueSky has it, in half a minute."""
        let_go = self.released.get(name)
        if not let_go or not let_go["last"]:
            return place, alt, velocity
        since = (now - let_go["at"]) * self.clock.rate
        if let_go["offset"] is None:
            (lat, lon), height, (vx, vy, vz) = let_go["last"]
            lat, height = lat + vy * since / 111_194.9, height + vz * since
            cos = 111_194.9 * math.cos(math.radians(lat))
            lon += vx * since / cos
            let_go["offset"] = (east_deg(lon - place[1]) * cos, (lat - place[0]) * 111_194.9, height - alt)
            let_go["rate"] = (vx - velocity[0], vy - velocity[1], vz - velocity[2])
            let_go["from"] = now
        x = min((now - let_go["from"]) * self.clock.rate / BLEND_S, 1.0)
        x3 = x**3
        offset, rate = 1 - x3 * (10 - 15 * x + 6 * x * x), x - x3 * (6 - 8 * x + 3 * x * x)
        offset_rate, rate_rate = -30 * x * x * (1 - x) ** 2 / BLEND_S, 1 - x * x * (18 - 32 * x + 15 * x * x)
        shift = [o * offset + r * BLEND_S * rate for o, r in zip(let_go["offset"], let_go["rate"])]
        change = [o * offset_rate + r * rate_rate for o, r in zip(let_go["offset"], let_go["rate"])]
        shown = (place[0] + shift[1] / 111_194.9, place[1] + shift[0] / (111_194.9 * math.cos(math.radians(place[0]))))
        return shown, alt + shift[2], tuple(v + c for v, c in zip(velocity, change))

    # Both.

    def poll(self, now):
        while not self.answers.empty():
            name, ok, text = self.answers.get()
            asked = self.handing.get(name)
            if asked and ok:
                asked.number = int(text.rsplit(" ", 1)[-1])
            elif asked:
                self._kept(name, text)
        for name, asked in list(self.handing.items()):
            if now - asked.at > HANDING_S:
                self._kept(name, "no confirmation")

    def _kept(self, name, why):
        """It stays with its giver, who asks again."""
        asked = self.handing.pop(name, None)
        self.retry_at[name] = time.monotonic() + RETRY_S
        self.note(name, "kept", why)
        if asked and asked.kind == "release":
            self.bridge.end([name])

    def forget(self):
        """BlueSky begins again."""
        self.handing.clear()
        self.released.clear()
        self.asked_type.clear()
