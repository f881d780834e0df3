"""A run that goes on: its public interface over Zenoh."""

from __future__ import annotations

import json
import threading
import time
from dataclasses import dataclass
from typing import Any, Dict, Iterator, List, Optional

from .messages import VERSION, Scan, State

DEFAULT_ENDPOINT = "tcp/127.0.0.1:7448"
SILENCE_S = 3.0  # the state comes once a second
QUEUE = 4096


def _flat(row: Dict[str, Any]) -> Dict[str, Any]:
    """A row of a table: what is nested gets columns with the names of the database (`lag_x_m`)."""
    lag = {f"lag_{name}": value for name, value in row.get("lag", {}).items()}
    return {**{name: value for name, value in row.items() if name != "lag"}, **lag}


class Disconnected(ConnectionError):
    """Nothing is heard of the run any more, or nobody answers."""


class VersionMismatch(RuntimeError):
    """The other side speaks another version of the messages."""


class Refused(RuntimeError):
    """The run did not carry a command out; the text says why."""


@dataclass
class Answer:
    """What became of a command."""

    ok: bool
    text: str
    state: Optional[State] = None


def connect(endpoint: str = DEFAULT_ENDPOINT, exercise: int = 1, client: str = "python",
            certs: Optional[Dict[str, str]] = None) -> "Run":
    """Connects to the public interface of a run (`seeds run --public`).

    `certs` names the files `authority`, `certificate` and `key` for a tls/ endpoint.
    Raises Disconnected if nobody is there, VersionMismatch if it speaks another version.
    """
    return Run(endpoint, exercise, client, certs)


class Run:
    """A connection to a run. Use it in a `with` block, or close it."""

    def __init__(self, endpoint: str, exercise: int, client: str, certs: Optional[Dict[str, str]]):
        import zenoh

        self._zenoh, self._client, self._endpoint = zenoh, client, endpoint
        self._prefix = f"seeds-v{VERSION}/{exercise}"
        settings = {
            "mode": "client",
            "connect/endpoints": [endpoint],
            "connect/timeout_ms": 2000,
            "connect/exit_on_failure": True,
            "scouting/multicast/enabled": False,
        }
        if certs:
            settings["transport/link/tls"] = {
                "root_ca_certificate": certs["authority"],
                "enable_mtls": True,
                "connect_certificate": certs["certificate"],
                "connect_private_key": certs["key"],
            }
        config = zenoh.Config()
        for key, value in settings.items():
            config.insert_json5(key, json.dumps(value))
        try:
            self._session = zenoh.open(config)
        except Exception as error:
            raise Disconnected(f"nobody answers at {endpoint}: start the run with --public ({error})") from error
        self._closed = False
        try:
            self._check_version(exercise)
        except BaseException:
            self.close()
            raise

    def _check_version(self, exercise: int) -> None:
        # A run may serve two versions beside each other; answers come in any order.
        names = {str(body.get("schema", "")) for body in self._ask(f"seeds-v$*/{exercise}/state", b"")}
        if f"seeds.state/{VERSION}" in names:
            return
        if names:
            said = ", ".join(sorted(names))
            raise VersionMismatch(f"the run speaks {said}, this client seeds.state/{VERSION}: install the other one")
        raise Disconnected(f"{self._endpoint} answers, but knows no exercise {exercise} with seeds.state/{VERSION}")

    def _ask(self, key: str, payload: bytes, timeout_s: float = 3.0) -> List[Dict[str, Any]]:
        found = []
        for reply in self._session.get(key, payload=payload, timeout=timeout_s):
            if reply.ok is not None:
                found.append(json.loads(reply.ok.payload.to_bytes()))
        return found

    def last(self, key: str) -> Dict[str, Any]:
        """The last value of a key (`state`, `scan`, `tracks`, `plots`, `truth`, `flights`, `weather`, `operation`, `handovers`,
        `federate/NAME`, `schema`) as it is."""
        for body in self._ask(f"{self._prefix}/{key}", b""):
            return body
        raise Disconnected(f"{self._endpoint} has no {key}, or is gone")

    def state(self) -> State:
        """How the run stands."""
        return State.read(self.last("state"))

    def scan(self) -> Scan:
        """The last scan."""
        return Scan.read(self.last("scan"))

    def messages(self, *keys: str, timeout_s: Optional[float] = None) -> Iterator[Dict[str, Any]]:
        """Every message of these keys as it comes. Raises Disconnected after 3 s without a sign of life.

        Ends after `timeout_s`, or when the run has ended.
        """
        import queue

        waiting: "queue.Queue[Dict[str, Any]]" = queue.Queue(QUEUE)

        def take(sample) -> None:
            try:
                waiting.put_nowait(json.loads(sample.payload.to_bytes()))
            except queue.Full:
                pass  # who does not read loses messages; their numbers tell

        declared = [self._session.declare_subscriber(f"{self._prefix}/{key}", take) for key in {*keys, "state"}]
        wanted = {f"seeds.{key.split('/')[0]}/{VERSION}" for key in keys}
        until = None if timeout_s is None else time.monotonic() + timeout_s
        heard, stopped = time.monotonic(), False
        try:
            while until is None or time.monotonic() < until:
                try:
                    body = waiting.get(timeout=0.1)
                except queue.Empty:
                    if stopped:
                        return
                    if time.monotonic() - heard > SILENCE_S:
                        raise Disconnected(f"nothing heard of {self._endpoint} for {SILENCE_S:.0f} s")
                    continue
                heard = time.monotonic()
                name = body.get("schema")
                stopped = body.get("phase") == "STOPPED" if name == f"seeds.state/{VERSION}" else stopped
                if name in wanted:
                    yield body
        finally:
            for subscriber in declared:
                subscriber.undeclare()

    def scans(self, limit: Optional[int] = None, timeout_s: Optional[float] = None) -> Iterator[Scan]:
        """Scans as they come: at most `limit`, for at most `timeout_s`."""
        if limit == 0:
            return
        for count, body in enumerate(self.messages("scan", timeout_s=timeout_s), start=1):
            yield Scan.read(body)
            if count == limit:
                return

    def frame(self, table: str = "tracks", seconds: float = 10.0):
        """`tracks`, `plots` or `truth` of the next `seconds` of wall time as a pandas data frame."""
        if table not in ("tracks", "plots", "truth"):
            raise ValueError(f"no table {table!r}: tracks, plots or truth")
        import pandas

        rows = []
        for body in self.messages(table, timeout_s=seconds):
            head = {"scan": body["scan"], "time_s": body["time_s"]}
            rows += [{**head, **_flat(row)} for row in body[table]]
        return pandas.DataFrame(rows)

    def command(self, command: str, **more: Any) -> Answer:
        """Carries a command out and waits for the state that it leads to. Raises Refused with the reason otherwise."""
        body = {"command": command, "client": self._client, **{k: v for k, v in more.items() if v is not None}}
        answers = self._ask(f"{self._prefix}/command", json.dumps(body).encode(), timeout_s=12.0)
        if not answers:
            raise Disconnected(f"{self._endpoint} does not answer to {command} (or this client may not command)")
        found = answers[0]
        state = State.read(found["state"]) if "state" in found else None
        answer = Answer(bool(found.get("ok")), str(found.get("text", "")), state)
        if not answer.ok:
            raise Refused(answer.text)
        return answer

    def start(self) -> Answer:
        """Starts, or goes on after a freeze."""
        return self.command("start")

    def resume(self) -> Answer:
        """Goes on after a freeze."""
        return self.command("resume")

    def freeze(self) -> Answer:
        """All federates stop at one frame."""
        return self.command("freeze")

    def step(self, frames: int = 1) -> Answer:
        """Executes so many frames, then freezes again."""
        return self.command("step", n=frames)

    def stop(self) -> Answer:
        """Closes the run."""
        return self.command("stop")

    def restart(self) -> Answer:
        """Back to frame 0 with a new run number."""
        return self.command("restart")

    def rate(self, rate: Optional[float]) -> Answer:
        """Simulated seconds per wall second; None: as fast as possible."""
        return self.command("rate", rate=rate)

    def move(self, name: str, to: str) -> Answer:
        """Gives the place of a generator or of the external world to another one's process, at a frame boundary."""
        return self.command("move", name=name, to=to)

    def close(self) -> None:
        """Leaves within 2 s."""
        if self._closed:
            return
        self._closed = True
        closing = threading.Thread(target=self._session.close, daemon=True)
        closing.start()
        closing.join(2.0)

    def __enter__(self) -> "Run":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()
