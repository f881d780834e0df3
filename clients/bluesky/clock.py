"""Three clocks: of this process, of the run, and BlueSky's `simt`, which no command tells (DTMULT 4 may give 2.9)."""

import collections
import statistics
import time

HEARD_S = 3.0  # what says how fast `simt` goes
MOST_LATE_S = 0.5
BEHIND_S, ANCHORED_S = 1.0, 5.0


class Clock:
    """Time of the run by the clock of this process: from how theirs are told of in truth, else from the scan that came soonest."""

    def __init__(self):
        self.rate, self.seen, self.exact = 1.0, collections.deque(maxlen=60), collections.deque(maxlen=20)

    def paced(self, rate):
        if rate and rate != self.rate:
            self.rate = rate
            self.seen.clear()
            self.exact.clear()

    def stood(self):
        """The run stood: what was known of it is of before."""
        self.seen.clear()
        self.exact.clear()

    def scan(self, time_s, at):
        self.seen.append(at - time_s / self.rate)

    def placed(self, time_s, at):
        """Something was somewhere at a time of ours that it passed at `at` of this clock."""
        self.exact.append(at - time_s / self.rate)

    def state_at(self, at):
        """When something was that was so at `at`, as `give` wants it."""
        exact = list(self.exact)
        if len(exact) >= 3:
            return {"time_s": round((at - sorted(exact)[len(exact) // 2]) * self.rate, 4)}
        return {"age_s": round(time.monotonic() - at, 4)}

    def now_s(self, at):
        if self.exact:
            offset = sorted(self.exact)[len(self.exact) // 2]
        elif self.seen:
            offset = min(self.seen)
        else:
            return None
        return (at - offset) * self.rate


class SimTime:
    """How `simt` goes by the clock of this process: a line through what was heard in the last seconds."""

    def __init__(self):
        self.heard, self.stands = collections.deque(maxlen=60), 0
        self.anchor = None  # simt less the run's time, and since when it is that far off
        self.off_since = None

    def forget(self):
        self.heard.clear()
        self.anchor = self.off_since = None

    def hear(self, simt, at):
        self.stands = self.stands + 1 if self.heard and simt == self.heard[-1][0] else 0
        if self.heard and simt <= self.heard[-1][0]:
            self.heard.clear()  # held, or begun again
        self.heard.append((simt, at))
        while at - self.heard[0][1] > HEARD_S:
            self.heard.popleft()

    def _line(self):
        """Where the line is now, and its slope; none of less than five."""
        if len(self.heard) < 5:
            return None
        simt, at = zip(*self.heard)
        middle_s, middle = statistics.fmean(at), statistics.fmean(simt)
        spread = sum((t - middle_s) ** 2 for t in at)
        if spread <= 0.0:
            return None
        slope = sum((t - middle_s) * (s - middle) for s, t in self.heard) / spread
        return middle + slope * (at[-1] - middle_s), slope

    def late_s(self):
        """Seconds of `simt` by which what came last is older than now: a burst of a loaded host came late, not out of place."""
        line = self._line()
        return 0.0 if line is None else max(0.0, min(line[0] - self.heard[-1][0], MOST_LATE_S))

    def pace(self, asked):
        """Seconds of `simt` in one of this process: what was `asked` for until it is known, none while it is held."""
        if self.stands > 1:
            return 0.0
        line = self._line()
        return asked if line is None else max(0.0, min(line[1], 4.0 * asked))

    def behind_s(self, run_s, now):
        """Seconds that BlueSky has fallen behind the run (less than 0: it is ahead), once when it is more than a second; then that is the measure."""
        if run_s is None or not self.heard:
            return None
        offset = self.heard[-1][0] - run_s
        if self.anchor is None:
            self.anchor = offset
        if abs(offset - self.anchor) <= BEHIND_S:
            self.off_since = None
            return None
        if self.off_since is None:
            self.off_since = now
            return self.anchor - offset
        if now - self.off_since > ANCHORED_S:
            self.anchor, self.off_since = offset, None
        return None
