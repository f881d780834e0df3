"""The tracker without a network: what it makes of times of day."""
import pathlib
import struct
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import tracker  # noqa: E402

DAY_S = 86_400


def block(kind, of_day_s, x=None, y=None):
    """A block of category 010: a start of cycle (2) or a plot (1)."""
    items = bytes([0, 1]) + bytes([kind]) + round(of_day_s * 128).to_bytes(3, "big")
    present = 0b1101_0000 if x is None else 0b1101_0010
    body = bytes([present]) + items + (b"" if x is None else struct.pack(">hh", x, y))
    return bytes([10]) + struct.pack(">H", 3 + len(body)) + body


def followed(start_s, seconds, late=False):
    """Two movers at 10 m/s from a time of day on: the tracker, and what it published."""
    heard, published = tracker.Listener(), []
    for n in range(seconds):
        s = start_s + n
        published += heard.take(block(2, s % DAY_S))
        places = [(0.25, 10 * n, 100), (0.5, -10 * n, -100)]
        # What was measured first may be heard last.
        for share, x, y in reversed(places) if late else places:
            published += heard.take(block(1, (s + share) % DAY_S, x, y))
    return heard, published


class Midnight(unittest.TestCase):
    def test_tracks_go_on_at_midnight_as_at_noon(self):
        for late in (False, True):
            for start_s in (DAY_S / 2, DAY_S - 10, DAY_S - 0.375, DAY_S - 1):
                heard, published = followed(start_s, 30, late)
                with self.subTest(start_s=start_s, late=late):
                    self.assertEqual((heard.tracker.next, len(heard.tracker.tracks), heard.count), (2, 2, 60))
                    # A cycle from the third on, each block with both tracks; the time in it is a time of day.
                    self.assertGreaterEqual(len(published), 27)
                    for datagram in published:
                        of_day_s = int.from_bytes(datagram[7:10], "big") / 128
                        self.assertLess(of_day_s, DAY_S)

    def test_speeds_are_those_of_the_movers(self):
        for start_s in (DAY_S / 2, DAY_S - 10):
            heard, _ = followed(start_s, 30)
            speeds = sorted(round(track.vx) for track in heard.tracker.tracks)
            self.assertEqual(speeds, [-10, 10], start_s)


if __name__ == "__main__":
    unittest.main()
