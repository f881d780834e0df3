"""A run through its public interface. It waits for `start`, plays 60 s at rate 4. SEEDS_PUBLIC is its endpoint."""
import json
import os
import sqlite3
import threading
import time
import unittest

import jsonschema
import zenoh

import seeds_client as seeds

ENDPOINT, LOG = os.environ["SEEDS_PUBLIC"], os.environ["SEEDS_LOG"]
with open(os.environ["SEEDS_SCHEMA"]) as file:
    SCHEMA = json.load(file)
KEYS = ("state", "scan", "tracks", "plots", "truth", "flights", "weather", "operation")


# One validator a message, made once: checking the schema itself anew for each message takes longer than the run.
VALIDATORS = {
    f"seeds.{name}/1": jsonschema.Draft202012Validator({"$ref": f"#/$defs/{name}", "$defs": SCHEMA["$defs"]}) for name in KEYS
}


def validate(body):
    VALIDATORS[body["schema"]].validate(body)


def connected(within_s=90.0):
    until = time.monotonic() + within_s
    while True:
        try:
            return seeds.connect(ENDPOINT, client="test")
        except seeds.Disconnected:
            if time.monotonic() > until:
                raise
            time.sleep(0.2)


class Live(unittest.TestCase):
    def test_a_whole_run(self):
        run = connected()
        self.addCleanup(run.close)
        while run.state().phase != "CONFIGURED":
            time.sleep(0.1)
        self.assertEqual(run.last("schema"), SCHEMA)

        # A client that sleeps, and ones that send garbage.
        config = zenoh.Config()
        for key, value in (("mode", "client"), ("connect/endpoints", [ENDPOINT])):
            config.insert_json5(key, json.dumps(value))
        other = zenoh.open(config)
        self.addCleanup(other.close)
        woken = threading.Event()
        self.addCleanup(woken.set)
        asleep = other.declare_subscriber("seeds-v1/1/**", lambda sample: woken.wait(30))
        crowd = [seeds.connect(ENDPOINT, client=f"crowd {n}") for n in range(6)]
        for client in crowd:
            self.addCleanup(client.close)
            threading.Thread(target=lambda c=client: list(c.scans(limit=5)), daemon=True).start()
        garbage = [r.ok.payload.to_string() for r in other.get("seeds-v1/1/command", payload=b"\x01\x06\0\0\0\x01")]
        self.assertFalse(json.loads(garbage[0])["ok"])
        too_long = [r.ok for r in other.get("seeds-v1/1/command", payload=b" " * 70000, timeout=2.0)]
        self.assertFalse(any(ok and json.loads(ok.payload.to_string())["ok"] for ok in too_long))
        # The private plane is not here: what once ended a run goes nowhere.
        other.put("seeds/1/ctl/order", b"\x01\x06\0\0\0\x01")
        self.assertEqual(list(other.get("seeds/1/**", timeout=1.0)), [])

        found, errors = [], []

        def listen():
            try:
                for body in run.messages(*KEYS):
                    validate(body)
                    found.append(body)
            except Exception as error:
                errors.append(error)

        listener = threading.Thread(target=listen)
        listener.start()
        time.sleep(1.0)
        self.assertTrue(run.start().ok)
        while self.scans(found) < 10:
            time.sleep(0.1)
        answer = run.freeze()
        self.assertEqual(answer.state.phase, "FROZEN", answer)
        before = run.state().frame
        run.step(20)
        self.assertEqual(run.state().frame, before + 20)
        with self.assertRaisesRegex(seeds.Refused, "nearest is freeze"):
            run.command("freez")
        run.resume()
        listener.join(60)
        self.assertEqual(errors, [])
        self.assertFalse(listener.is_alive(), "the client sees the end of the run")
        # A session with a callback that sleeps cannot be closed.
        woken.set()
        asleep.undeclare()

        scans = [body for body in found if body["schema"] == "seeds.scan/1"]
        self.assertEqual([body["scan"] for body in scans], list(range(1, 61)), "none lost")
        kinds = {body["schema"] for body in found}
        self.assertLessEqual({f"seeds.{key}/1" for key in ("state", "scan", "tracks", "plots", "truth", "operation")}, kinds)
        read = [seeds.Track.read(row) for body in scans for row in body["tracks"]]
        lags = [track.lag for track in read if track.lag is not None]
        self.assertTrue(lags and all(isinstance(lag, seeds.Lag) for lag in lags), "the publication before")
        self.same_as_the_database(scans)
        began = time.monotonic()
        run.close()
        self.assertLess(time.monotonic() - began, 2.5)

    @staticmethod
    def scans(found):
        return sum(body["schema"] == "seeds.scan/1" for body in list(found))

    def same_as_the_database(self, scans):
        # The logger closes its file when the run is over.
        until = time.monotonic() + 20
        while time.monotonic() < until and (not os.path.exists(LOG) or os.path.exists(LOG + "-wal")):
            time.sleep(0.1)
        database = sqlite3.connect(f"file:{LOG}?mode=ro", uri=True)
        for table, order in (("tracks", "track"), ("plots", "sensor, sequence"), ("truth", "entity")):
            database.row_factory = sqlite3.Row
            for body in scans:
                rows = database.execute(f"SELECT * FROM {table} WHERE scan = ? ORDER BY {order}", [body["scan"]]).fetchall()
                keys = [part.strip() for part in order.split(",")]
                said = sorted(body[table], key=lambda row: [row[key] for key in keys])
                self.assertEqual(len(rows), len(said), f"{table} of scan {body['scan']}")
                for row, message in zip(rows, said):
                    message = {**message, **{f"lag_{name}": value for name, value in message.get("lag", {}).items()}}
                    for name in row.keys():
                        if name not in message:
                            continue
                        if isinstance(row[name], float):
                            self.assertLess(abs(row[name] - message[name]), 1e-9, f"{table}.{name}")
                        else:
                            self.assertEqual(row[name], message[name], f"{table}.{name}")
        sources = [row["source"] for row in database.execute("SELECT source FROM operations")]
        self.assertIn("client:test", sources)
        database.close()


class Nobody(unittest.TestCase):
    def test_where_nobody_is_it_says_so(self):
        with self.assertRaisesRegex(seeds.Disconnected, "nobody answers"):
            seeds.connect("tcp/127.0.0.1:9")


if __name__ == "__main__":
    unittest.main()
