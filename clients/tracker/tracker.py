#!/usr/bin/env python3
"""A small tracker in a process of its own: plots of category 010 in, system tracks of category 062 out.

An example of what `seeds score` judges, not a good tracker: one constant-velocity Kalman filter a target and axis, the
nearest plot within a gate. Needs nothing but Python.

    tracker.py --in 239.9.1.1:8600 --out 239.9.1.2:8601 --seconds 60
"""
import argparse
import math
import socket
import struct

SAC, SIC = 77, 9
DAY_S = 86_400
# Items of category 010 in the order of its profile: octets, "x" (ends by its extension bit) or ("n", octets of a repetition).
PROFILE = [
    ("010", 2), ("000", 1), ("020", "x"), ("140", 3), ("041", 8), ("040", 4), ("042", 4),
    ("200", 4), ("202", 4), ("161", 2), ("170", "x"), ("060", 2), ("220", 3), ("245", 7),
    ("250", ("n", 8)), ("300", 1), ("090", 2), ("091", 2), ("270", "x"), ("550", 1), ("310", 1),
    ("500", 4), ("280", ("n", 2)), ("131", 1), ("210", 2),
]


def address(text):
    host, port = text.rsplit(":", 1)
    return host, int(port)


def records(datagram):
    """The records of every block of category 010, as items by their number."""
    at = 0
    while at + 3 <= len(datagram):
        category, length = datagram[at], struct.unpack_from(">H", datagram, at + 1)[0]
        if length < 3 or at + length > len(datagram):
            return
        place, end = at + 3, at + length
        while category == 10 and place < end:
            present, more = [], True
            while more:
                octet = datagram[place]
                present += [bool(octet >> bit & 1) for bit in range(7, 0, -1)]
                more = octet & 1
                place += 1
            items = {}
            for there, (name, size) in zip(present, PROFILE):
                if not there:
                    continue
                start = place
                if size == "x":
                    while datagram[place] & 1:
                        place += 1
                    place += 1
                elif isinstance(size, tuple):
                    place += 1 + datagram[place] * size[1]
                else:
                    place += size
                items[name] = datagram[start:place]
            yield items
        at += length


class Track:
    """Position and velocity of both axes, with the covariance of one axis (equal for both)."""

    def __init__(self, number, time, x, y):
        self.number, self.time, self.seen, self.hits, self.since = number, time, time, 1, 0
        self.x, self.y, self.vx, self.vy = x, y, 0.0, 0.0
        self.p = [25.0, 0.0, 100.0]  # position, cross, velocity

    def at(self, time):
        dt = time - self.time
        return self.x + self.vx * dt, self.y + self.vy * dt

    def update(self, time, x, y, r=16.0, q=1.0):
        dt = max(time - self.time, 0.0)
        self.x, self.y = self.at(time)
        a, b, c = self.p
        a, b, c = a + 2 * dt * b + dt * dt * c + q * dt**3 / 3, b + dt * c + q * dt * dt / 2, c + q * dt
        k, l = a / (a + r), b / (a + r)
        dx, dy = x - self.x, y - self.y
        self.x, self.y = self.x + k * dx, self.y + k * dy
        self.vx, self.vy = self.vx + l * dx, self.vy + l * dy
        self.p = [a * (1 - k), b * (1 - k), c - l * b]
        self.time = self.seen = time
        self.hits += 1


def system_track(track, time, last):
    x, y = track.at(time)
    clip = lambda value, bits: max(-(1 << bits - 1), min((1 << bits - 1) - 1, math.floor(value + 0.5)))
    tentative, coasting = track.hits < 3, time - track.seen > 1.5
    status = bytes([
        0x01 | (0x02 if tentative else 0),
        0x81 | (0x40 if last else 0),
        0x01,
        0x80 if coasting else 0,
    ])
    body = bytes([SAC, SIC]) + (math.floor(time * 128 + 0.5) % 11059200).to_bytes(3, "big")
    body += clip(x / 0.5, 24).to_bytes(3, "big", signed=True) + clip(y / 0.5, 24).to_bytes(3, "big", signed=True)
    body += struct.pack(">hhH", clip(track.vx / 0.25, 16), clip(track.vy / 0.25, 16), track.number)
    return bytes([0x97, 0x0C]) + body + status


class Tracker:
    def __init__(self):
        self.tracks, self.next, self.cycle = [], 0, None

    def plot(self, time, x, y):
        def distance(track):
            px, py = track.at(time)
            return math.hypot(x - px, y - py)

        near = min(self.tracks, key=distance, default=None)
        if near and distance(near) < 20.0 + 15.0 * (time - near.time) and time >= near.time:
            near.update(time, x, y)
        else:
            self.tracks.append(Track(self.next % 4096, time, x, y))
            self.next += 1

    def publish(self, time):
        """All tracks at this time; those without a plot for too long end."""
        ended = [t for t in self.tracks if time - t.seen > (8.0 if t.hits > 5 else 2.5)]
        self.tracks = [t for t in self.tracks if t not in ended]
        found = [system_track(t, time, False) for t in self.tracks if t.hits >= 2]
        found += [system_track(t, time, True) for t in ended if t.hits >= 2]
        blocks = [b"".join(found[i : i + 40]) for i in range(0, len(found), 40)]
        return [bytes([62]) + struct.pack(">H", 3 + len(b)) + b for b in blocks]


class Listener:
    """Datagrams in, blocks of tracks out."""

    def __init__(self):
        self.tracker, self.count, self.latest = Tracker(), 0, None

    def seconds(self, of_day):
        """A time of day as seconds that go on over midnight: the nearest to the latest that was heard, which may be of the day before."""
        if self.latest is None:
            self.latest = of_day
        time = self.latest + (of_day - self.latest + DAY_S / 2) % DAY_S - DAY_S / 2
        self.latest = max(self.latest, time)
        return time

    def take(self, datagram):
        tracker, found = self.tracker, []
        for items in records(datagram):
            time = self.seconds(int.from_bytes(items["140"], "big") / 128)
            if items["000"][0] == 2 and time != tracker.cycle:
                tracker.cycle = time
                found += tracker.publish(time)
            elif items["000"][0] == 1 and "042" in items:
                x, y = struct.unpack(">hh", items["042"])
                tracker.plot(time, float(x), float(y))
                self.count += 1
        return found


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--in", dest="source", default="239.9.1.1:8600", type=address)
    arguments.add_argument("--out", dest="to", default="239.9.1.2:8601", type=address)
    arguments.add_argument("--interface", default="127.0.0.1", help="address of the network interface")
    arguments.add_argument("--seconds", default=5.0, type=float, help="ends after so long a silence")
    given = arguments.parse_args()
    hear = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    hear.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    hear.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
    hear.bind(given.source)
    if given.source[0].split(".")[0] in map(str, range(224, 240)):
        group = socket.inet_aton(given.source[0]) + socket.inet_aton(given.interface)
        hear.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, group)
    hear.settimeout(given.seconds)
    say = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    say.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(given.interface))
    listener = Listener()
    print("listening", flush=True)
    while True:
        try:
            datagram = hear.recv(65535)
        except socket.timeout:
            break
        for block in listener.take(datagram):
            say.sendto(block, given.to)
    print(f"{listener.count} plots, {listener.tracker.next} tracks")


if __name__ == "__main__":
    main()
