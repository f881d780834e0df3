"""Which runs a client takes, without one: what a run answers is given."""
import unittest
from unittest import mock

from seeds_client import live
from seeds_client.messages import VERSION


def asked(*names):
    """What becomes of a client whose question for the state is answered so."""
    run = live.Run.__new__(live.Run)
    run._endpoint = "tcp/127.0.0.1:7448"
    with mock.patch.object(live.Run, "_ask", lambda self, key, payload: [{"schema": name} for name in names]):
        run._check_version(1)


class Version(unittest.TestCase):
    """A run serves the version before its own beside it for one minor release, and answers come in any order."""

    OURS, NEXT, LAST = (f"seeds.state/{VERSION + n}" for n in (0, 1, 2))

    def test_one_answer_of_ours_among_others_is_enough(self):
        for names in ((self.OURS,), (self.OURS, self.NEXT), (self.NEXT, self.OURS), (self.LAST, self.NEXT, self.OURS)):
            asked(*names)

    def test_who_speaks_nothing_of_ours_is_told_of_by_name(self):
        for names in ((self.NEXT,), (self.NEXT, self.LAST)):
            with self.assertRaises(live.VersionMismatch) as caught:
                asked(*names)
            for name in (*names, self.OURS):
                self.assertIn(name, str(caught.exception))

    def test_who_says_nothing_is_not_there(self):
        with self.assertRaises(live.Disconnected):
            asked()


if __name__ == "__main__":
    unittest.main()
