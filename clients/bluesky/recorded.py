"""What BlueSky said in an earlier run, at the same time of this one: a log of the bridge in place of a server."""

import json
import pathlib
import sys
import time
from collections import deque


def refuse(why):
    """Ends with 2, as for any wrong option."""
    print(f"bridge: {why}; give a file that bridge.py --log wrote", file=sys.stderr)
    raise SystemExit(2)


class Wire:
    """As `wire.Wire`, from a file; what is said to BlueSky is said to nobody."""

    def __init__(self, path, clock):
        self.clock, self.nodes, self.waiting, due_ns = clock, [], deque(), 0
        try:
            lines = pathlib.Path(path).read_text(encoding="utf-8").splitlines()
        except (OSError, UnicodeDecodeError) as error:
            refuse(f"{path}: {error}")
        for number, line in enumerate(lines, 1):
            try:
                entry = json.loads(line)
                if entry["dir"] != "in":
                    continue
                # What was said before the run was known to be is due at once, and nothing before what was said before it.
                due_ns = max(due_ns, entry["our_ns"] or 0)
                self.waiting.append((due_ns, entry["topic"], entry["body"]))
            except (KeyError, TypeError, ValueError) as error:
                refuse(f"{path}:{number}: not a line of a bridge's log ({error!r})")
        if not self.waiting:
            refuse(f"{path}: BlueSky says nothing in it")

    def poll(self, timeout_ms):
        time.sleep(timeout_ms / 1000)
        now_s, events = self.clock.now_s(time.monotonic()), []
        while self.waiting and self.waiting[0][0] <= (0 if now_s is None else now_s * 1e9):
            events += self._event(*self.waiting.popleft()[1:])
        return events

    def _event(self, topic, body):
        if topic == "came":
            self.nodes.append(bytes.fromhex(body))
            return [("came", self.nodes[-1])]
        if topic == "left":
            node = bytes.fromhex(body)
            self.nodes = [n for n in self.nodes if n != node]
            return [("left", node)]
        if topic == "lost":
            self.nodes.clear()
            return [("lost",)]
        return [(topic, self.nodes[-1], body)] if self.nodes else []

    def command(self, node, line):
        pass

    def close(self):
        pass
