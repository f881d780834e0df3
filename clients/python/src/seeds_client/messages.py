"""The public messages as data classes. Keys that this version does not know are ignored; absent ones are None."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any, Dict, List, Optional

VERSION = 1


class _Message:
    @classmethod
    def read(cls, body: Dict[str, Any]):
        known = {f.name for f in fields(cls)}
        return cls(**{key: value for key, value in body.items() if key in known})


@dataclass
class Lag(_Message):
    """A track at the publication before, as it is known now."""

    time_ns: int
    x_m: float
    y_m: float
    var_ee_m2: float
    var_en_m2: float
    var_nn_m2: float
    coasted: bool = False
    error_m: Optional[float] = None


@dataclass
class Track(_Message):
    """A system track as published."""

    track: int
    status: str
    type: str
    callsign: str
    x_m: float
    y_m: float
    vx_ms: float
    vy_ms: float
    speed_ms: float
    heading_deg: float
    var_ee_m2: float
    var_en_m2: float
    var_nn_m2: float
    manoeuvre: int = 0
    type_designator: str = ""
    movement: str = ""
    lat_deg: Optional[float] = None
    lon_deg: Optional[float] = None
    altitude_m: Optional[float] = None
    entity: Optional[str] = None
    error_m: Optional[float] = None
    assumed: Optional[str] = None
    label_p: Optional[float] = None
    altitude_age_s: Optional[float] = None
    lag: Optional[Lag] = None

    @classmethod
    def read(cls, body: Dict[str, Any]):
        lag = body.get("lag")
        return super().read({**body, "lag": Lag.read(lag) if lag else None})


@dataclass
class Plot(_Message):
    """A plot, with its cause for evaluation."""

    sensor: int
    sequence: int
    kind: str
    time_ns: int
    x_m: float
    y_m: float
    var_ee_m2: float
    var_en_m2: float
    var_nn_m2: float
    range_m: Optional[float] = None
    azimuth_deg: Optional[float] = None
    scnr_db: Optional[float] = None
    altitude_m: Optional[float] = None
    identity: Optional[str] = None
    track: Optional[int] = None
    cause: Optional[str] = None
    truth_x_m: Optional[float] = None
    truth_y_m: Optional[float] = None
    error_m: Optional[float] = None


@dataclass
class Truth(_Message):
    """True state of an entity at the end of a scan."""

    entity: int
    dis_id: str
    callsign: str
    type: str
    x_m: float
    y_m: float
    altitude_m: float
    vx_ms: float
    vy_ms: float
    heading_deg: float
    aircraft: Optional[bool] = None
    ours: Optional[bool] = None
    lat_deg: Optional[float] = None
    lon_deg: Optional[float] = None
    length_m: Optional[float] = None
    width_m: Optional[float] = None
    track: Optional[int] = None
    track_error_m: Optional[float] = None


@dataclass
class Scan:
    """Tracks, plots and truth of one second."""

    run: int
    scan: int
    time_s: float
    utc: str
    scene: str
    tracks: List[Track] = field(default_factory=list)
    plots: List[Plot] = field(default_factory=list)
    truth: List[Truth] = field(default_factory=list)
    measures: Dict[str, float] = field(default_factory=dict)

    @classmethod
    def read(cls, body: Dict[str, Any]) -> "Scan":
        head = {key: body[key] for key in ("run", "scan", "time_s", "utc", "scene")}
        return cls(
            **head,
            tracks=[Track.read(row) for row in body.get("tracks", [])],
            plots=[Plot.read(row) for row in body.get("plots", [])],
            truth=[Truth.read(row) for row in body.get("truth", [])],
            measures=body.get("measures", {}),
        )


@dataclass
class Member(_Message):
    """A federate as the conductor sees it."""

    name: str
    host: str
    pid: int
    essential: bool
    alive: bool
    frame: int


@dataclass
class State:
    """How the run stands. `rate` is None for as fast as possible."""

    run: int
    phase: str
    frame: int
    last_frame: int
    time_s: float
    scene: str
    seed: int
    achieved_rate: float
    rate: Optional[float] = None
    reasons: List[str] = field(default_factory=list)
    federates: List[Member] = field(default_factory=list)
    reference_lat_deg: Optional[float] = None
    reference_lon_deg: Optional[float] = None

    @classmethod
    def read(cls, body: Dict[str, Any]) -> "State":
        known = {f.name for f in fields(cls)} - {"federates"}
        rest = {key: value for key, value in body.items() if key in known}
        return cls(**rest, federates=[Member.read(row) for row in body.get("federates", [])])
