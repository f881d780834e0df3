"""A finished run through the client. SEEDS_LOG names its database, SEEDS_OUT a folder for Parquet files."""
import json
import os
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import unittest

import seeds_client as seeds

LOG, OUT = os.environ["SEEDS_LOG"], os.environ["SEEDS_OUT"]


class Finished(unittest.TestCase):
    def setUp(self):
        self.log = seeds.open_log(LOG)
        self.addCleanup(self.log.close)
        self.plain = sqlite3.connect(LOG)
        self.addCleanup(self.plain.close)

    def count(self, table):
        return self.plain.execute(f"SELECT count(*) FROM {table}").fetchone()[0]

    def test_frames_have_all_rows_and_the_times_of_their_scans(self):
        for table, frame in (("tracks", self.log.tracks()), ("plots", self.log.plots()), ("truth", self.log.truth())):
            self.assertEqual(len(frame), self.count(table), table)
            self.assertTrue((frame.scan_time_s == frame.scan).all(), "a scan a second")
        errors = self.log.errors()
        self.assertEqual(len(errors), self.count("truth"))
        expected = self.plain.execute("SELECT avg(track_error_m) FROM truth").fetchone()[0]
        self.assertAlmostEqual(errors.track_error_m.mean(), expected, places=9)
        fastest = self.plain.execute("SELECT max(vx_ms * vx_ms + vy_ms * vy_ms) FROM truth").fetchone()[0]
        self.assertAlmostEqual(errors.speed_ms.max(), fastest ** 0.5, places=9)

    def test_parquet_has_the_same_rows_and_says_units(self):
        import pyarrow.parquet

        counts = self.log.to_parquet(OUT)
        for table, rows in counts.items():
            self.assertEqual(rows, self.count(table), table)
            read = pyarrow.parquet.read_table(os.path.join(OUT, f"{table}.parquet"))
            self.assertEqual(read.num_rows, rows, table)
        tracks = pyarrow.parquet.read_table(os.path.join(OUT, "tracks.parquet"))
        values = self.plain.execute("SELECT scan, track, x_m, altitude_m, callsign FROM tracks").fetchall()
        columns = (tracks.column(name).to_pylist() for name in ("scan", "track", "x_m", "altitude_m", "callsign"))
        self.assertEqual(list(zip(*columns)), values)
        metadata = tracks.schema.metadata
        self.assertEqual(json.loads(metadata[b"run"])["scene"], "zurich")
        self.assertEqual(tracks.schema.field("vx_ms").metadata[b"unit"], b"m/s")
        self.assertEqual(tracks.schema.field("var_ee_m2").metadata[b"unit"], b"m2")

    def test_nothing_can_be_written_and_wrong_files_are_said(self):
        with self.assertRaises(sqlite3.OperationalError):
            self.log.rows("DELETE FROM tracks")
        with self.assertRaisesRegex(ValueError, "no table 'x'"):
            self.log.table("x")
        with self.assertRaisesRegex(FileNotFoundError, "no such file"):
            seeds.open_log(LOG + ".nothing")
        with tempfile.TemporaryDirectory() as folder:
            other = os.path.join(folder, "other.sqlite")
            sqlite3.connect(other).executescript("CREATE TABLE a (b); INSERT INTO a VALUES (1);")
            with self.assertRaisesRegex(ValueError, "not of a run"):
                seeds.open_log(other)
            with open(other, "wb") as file:
                file.write(b"no database" * 100)
            with self.assertRaisesRegex(ValueError, "not a database"):
                seeds.open_log(other)

    def test_the_notebook_runs(self):
        import nbclient
        import nbformat

        here = os.path.dirname(os.path.abspath(__file__))
        notebook = nbformat.read(os.path.join(here, "..", "example.ipynb"), as_version=4)
        kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
        notebook.metadata["kernelspec"] = kernel
        # The kernel of this very Python, whatever else is installed.
        client = nbclient.NotebookClient(notebook, timeout=120, kernel_name="python3")
        client.create_kernel_manager()
        client.km.kernel_spec.argv[0] = sys.executable
        client.execute()
        outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
        self.assertFalse([output for output in outputs if output.output_type == "error"])
        pictures = [output for output in outputs if "image/png" in output.get("data", {})]
        self.assertEqual(len(pictures), 3, "error over time, map, errors by area")


class Exported(unittest.TestCase):
    """A database with a row in every table of the schema, whatever a scene says."""

    SCHEMA = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../federates/viewer_logger/log.sql")
    VALUES = {"INTEGER": -7, "REAL": 0.25, "TEXT": "Zürich", "BLOB": b"\x78\x9c\xff\x00\xc3"}

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path, self.out = os.path.join(folder.name, "run.sqlite"), os.path.join(folder.name, "out")
        self.plain = sqlite3.connect(self.path)
        self.addCleanup(self.plain.close)
        with open(self.SCHEMA, encoding="utf-8") as schema:
            self.plain.executescript(schema.read())
        self.plain.execute(f"PRAGMA application_id = {seeds.log.APPLICATION_ID}")
        found = self.plain.execute("SELECT name FROM sqlite_master WHERE type = 'table'").fetchall()
        self.tables = {name: self.plain.execute(f'PRAGMA table_info("{name}")').fetchall() for (name,) in found}
        for name, columns in self.tables.items():
            marks = ", ".join("?" * len(columns))
            self.plain.execute(f'INSERT INTO "{name}" VALUES ({marks})', [self.VALUES[column[2]] for column in columns])
        self.plain.commit()

    def test_every_column_of_every_table_comes_out_as_it_went_in(self):
        import pyarrow.parquet

        with seeds.open_log(self.path) as log:
            self.assertEqual(log.to_parquet(self.out), {name: 1 for name in self.tables})
        self.assertEqual(sorted(os.listdir(self.out)), sorted(f"{name}.parquet" for name in self.tables))
        for name, columns in self.tables.items():
            (row,) = pyarrow.parquet.read_table(os.path.join(self.out, f"{name}.parquet")).to_pylist()
            self.assertEqual(list(row.values()), [self.VALUES[column[2]] for column in columns], name)

    def test_every_real_number_with_a_unit_in_its_name_says_it(self):
        self.assertEqual([seeds.log.unit(name) for name in ("heading_rad", "ax_ms2", "vx_ms")], ["rad", "m/s2", "m/s"])

    def test_an_export_that_fails_names_its_table_and_leaves_nothing(self):
        self.plain.execute("INSERT INTO statistics VALUES (1, 'a', 'no number')")
        self.plain.commit()
        with seeds.open_log(self.path) as log:
            with self.assertRaisesRegex(ValueError, "table statistics, column value"):
                log.to_parquet(self.out)
        self.assertEqual(os.listdir(self.out), [])


class Wheel(unittest.TestCase):
    def test_it_is_pure_python_and_runs_from_the_wheel(self):
        try:
            import setuptools, wheel  # noqa: F401
        except ImportError:
            self.skipTest("setuptools or wheel is not installed (clients/python/install.sh)")
        source = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
        with tempfile.TemporaryDirectory() as folder:
            copy, out = os.path.join(folder, "copy"), os.path.join(folder, "out")
            shutil.copytree(source, copy, ignore=shutil.ignore_patterns(".venv"))
            build = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-build-isolation", "--no-deps", "-w", out, copy]
            subprocess.run(build, check=True)
            (wheel,) = os.listdir(out)
            self.assertRegex(wheel, r"^seeds_client-.*-py3-none-any\.whl$")
            code = f"import seeds_client as s; print(s.__file__, len(s.open_log({LOG!r}).tracks()))"
            environment = {**os.environ, "PYTHONPATH": os.path.join(out, wheel)}
            run = subprocess.run([sys.executable, "-c", code], env=environment, check=True, capture_output=True, text=True)
            place, rows = run.stdout.rsplit(maxsplit=1)
            self.assertIn(wheel, place)
            self.assertGreater(int(rows), 0)


if __name__ == "__main__":
    unittest.main()
