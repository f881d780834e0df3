"""The database of a finished run: tables as rows, data frames or Parquet files. Opened for reading only."""

from __future__ import annotations

import json
import os
import sqlite3
from typing import Any, Dict, List, Optional
from urllib.parse import quote

APPLICATION_ID = 0x53454544  # "SEED"
UNITS = {
    "_m": "m", "_m2": "m2", "_ms": "m/s", "_deg": "degrees", "_ns": "ns", "_s": "s", "_us": "us", "_db": "dB",
    "_bytes": "octets", "_percent": "%", "_hpa": "hPa", "_c": "degrees Celsius", "_per_h": "mm/h", "_kg": "kg",
    "_g_per_m3": "g/m3", "_mm": "mm", "_p": "probability", "_rad": "rad", "_ms2": "m/s2",
}


def unit(column: str) -> Optional[str]:
    """The unit that a column's name ends with."""
    endings = [ending for ending in UNITS if column.endswith(ending)]
    return UNITS[max(endings, key=len)] if endings else None


def open_log(path: "str | os.PathLike[str]") -> "Log":
    """Opens the database of a run."""
    return Log(path)


class Log:
    """One run. Use it in a `with` block, or close it."""

    def __init__(self, path: "str | os.PathLike[str]"):
        self.path = os.fspath(path)
        if not os.path.isfile(self.path):
            raise FileNotFoundError(f"{self.path}: no such file; `seeds run --record FILE.pcapng` makes FILE.sqlite")
        self._database = sqlite3.connect(f"file:{quote(self.path)}?mode=ro", uri=True)
        try:
            (identity,) = self._database.execute("PRAGMA application_id").fetchone()
        except sqlite3.DatabaseError as error:
            raise ValueError(f"{self.path}: not a database ({error})") from error
        if identity != APPLICATION_ID:
            raise ValueError(f"{self.path}: a database, but not of a run")
        self.run: Dict[str, str] = dict(self._database.execute("SELECT name, value FROM run"))

    def tables(self) -> List[str]:
        """Names of the tables."""
        found = self._database.execute("SELECT name FROM sqlite_master WHERE type = 'table' ORDER BY name")
        return [name for (name,) in found]

    def _columns(self, table: str) -> List["tuple[str, str]"]:
        if table not in self.tables():
            raise ValueError(f"no table {table!r}: {', '.join(self.tables())}")
        return [(row[1], row[2]) for row in self._database.execute(f'PRAGMA table_info("{table}")')]

    def rows(self, query: str, *values: Any) -> List[Dict[str, Any]]:
        """Rows of an SQL query as dictionaries."""
        found = self._database.execute(query, values)
        names = [column[0] for column in found.description]
        return [dict(zip(names, row)) for row in found]

    def frame(self, query: str, *values: Any):
        """The same as a pandas data frame."""
        import pandas

        return pandas.read_sql_query(query, self._database, params=list(values) or None)

    def table(self, name: str):
        """A whole table as a data frame; with the time of its scan in `time_s` where it has scans."""
        columns = [column for column, _ in self._columns(name)]
        if "scan" in columns and name != "scans":
            return self.frame(
                f'SELECT s.time_ns / 1e9 AS scan_time_s, t.* FROM "{name}" t JOIN scans s USING (scan)')
        return self.frame(f'SELECT * FROM "{name}"')

    def tracks(self):
        """System tracks as published, with the entity that each follows and the distance from it."""
        return self.table("tracks")

    def plots(self):
        """Plots with their causes."""
        return self.table("plots")

    def truth(self):
        """True states at the end of each scan."""
        return self.table("truth")

    def scans(self):
        """One row a scan."""
        return self.frame("SELECT time_ns / 1e9 AS scan_time_s, * FROM scans")

    def errors(self):
        """Distance of each target from the track that follows it: NULL where none does."""
        return self.frame(
            "SELECT s.time_ns / 1e9 AS scan_time_s, scan, callsign, type, x_m, y_m, "
            "sqrt(vx_ms * vx_ms + vy_ms * vy_ms) AS speed_ms, track, track_error_m FROM truth JOIN scans s USING (scan)"
        ) if self._has_root() else self._errors_without_root()

    def _has_root(self) -> bool:
        try:
            self._database.execute("SELECT sqrt(4.0)").fetchone()
            return True
        except sqlite3.OperationalError:
            return False

    def _errors_without_root(self):
        frame = self.frame(
            "SELECT s.time_ns / 1e9 AS scan_time_s, scan, callsign, type, x_m, y_m, vx_ms, vy_ms, track, track_error_m "
            "FROM truth JOIN scans s USING (scan)")
        frame.insert(6, "speed_ms", (frame.pop("vx_ms") ** 2 + frame.pop("vy_ms") ** 2) ** 0.5)
        return frame

    def to_parquet(self, folder: "str | os.PathLike[str]") -> Dict[str, int]:
        """Writes one Parquet file a table and returns their numbers of rows. Metadata: the run's facts and the units.

        All files or none: where a table cannot be written, ValueError names it and nothing of the export stays.
        """
        import pyarrow.parquet

        os.makedirs(folder, exist_ok=True)
        counts: Dict[str, int] = {}
        half = {table: os.path.join(folder, f"{table}.parquet.part") for table in self.tables()}
        try:
            for table, path in half.items():
                made = self._arrow(table)
                pyarrow.parquet.write_table(made, path)
                counts[table] = made.num_rows
            for table, path in half.items():
                os.replace(path, os.path.join(folder, f"{table}.parquet"))
        finally:
            for path in filter(os.path.exists, half.values()):
                os.remove(path)
        return counts

    def _arrow(self, table: str):
        """A whole table as Arrow has it."""
        import pyarrow

        kinds = {"INTEGER": pyarrow.int64(), "REAL": pyarrow.float64(), "BLOB": pyarrow.binary()}
        columns = self._columns(table)
        names = ", ".join(f'"{name}"' for name, _ in columns)
        rows = self._database.execute(f'SELECT {names} FROM "{table}"').fetchall()
        whole = list(zip(*rows)) if rows else [()] * len(columns)
        arrays, fields = [], []
        for (name, declared), values in zip(columns, whole):
            kind = kinds.get(declared, pyarrow.string())
            try:
                arrays.append(pyarrow.array(list(values), type=kind))
            except (pyarrow.ArrowException, OverflowError) as error:
                raise ValueError(f"table {table}, column {name}: {error}") from error
            said = unit(name)
            fields.append(pyarrow.field(name, kind, metadata={"unit": said} if said else None))
        facts = {"run": json.dumps(self.run), "schema": "seeds.log/1", "table": table}
        return pyarrow.Table.from_arrays(arrays, schema=pyarrow.schema(fields, metadata=facts))

    def close(self) -> None:
        """Closes the file."""
        self._database.close()

    def __enter__(self) -> "Log":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()
