"""Entity State PDUs (IEEE 1278.1-2012) of aircraft, as a simulator of its own sends them."""

import math
import struct
import time

# WGS 84: equatorial radius (m), flattening.
RADIUS_M, FLATTENING = 6_378_137.0, 1 / 298.257223563
DEACTIVATED = 1 << 23
TYPES = {  # kind 1 platform, domain 2 air: country, category, subcategory, specific, extra
    "A320": (71, 87, 32, 1, 0), "A319": (71, 87, 32, 4, 0), "A321": (71, 87, 32, 5, 0), "A333": (71, 88, 32, 3, 1),
    "A388": (71, 88, 34, 2, 1), "B738": (225, 87, 32, 5, 8), "B744": (225, 88, 34, 1, 2), "B77W": (225, 88, 32, 2, 5),
    "B788": (225, 88, 32, 3, 1), "E145": (29, 87, 32, 3, 3), "C172": (225, 85, 11, 1, 0),
}
UNKNOWN = (0, 87, 0, 0, 0)  # an airliner of 36 m of span


def ecef(lat_deg, lon_deg, height_m):
    """Earth-centred coordinates, m."""
    lat, lon = math.radians(lat_deg), math.radians(lon_deg)
    e2 = FLATTENING * (2 - FLATTENING)
    n = RADIUS_M / math.sqrt(1 - e2 * math.sin(lat) ** 2)
    flat = (n + height_m) * math.cos(lat)
    return flat * math.cos(lon), flat * math.sin(lon), (n * (1 - e2) + height_m) * math.sin(lat)


def axes(lat_deg, lon_deg):
    """East, north and up as unit vectors of the earth-centred axes."""
    lat, lon = math.radians(lat_deg), math.radians(lon_deg)
    sl, cl, so, co = math.sin(lat), math.cos(lat), math.sin(lon), math.cos(lon)
    return (-so, co, 0.0), (-sl * co, -sl * so, cl), (cl * co, cl * so, sl)


def world(vector, lat_deg, lon_deg):
    """A vector east, north, up in earth-centred axes."""
    return [sum(v * axis[i] for v, axis in zip(vector, axes(lat_deg, lon_deg))) for i in range(3)]


def euler(heading, pitch, lat_deg, lon_deg):
    """Psi, theta, phi (rad) of a body without roll: heading from north, pitch up, rad."""
    sh, ch, sp, cp = math.sin(heading), math.cos(heading), math.sin(pitch), math.cos(pitch)
    nose = world((sh * cp, ch * cp, sp), lat_deg, lon_deg)
    right = world((ch, -sh, 0.0), lat_deg, lon_deg)
    down = world((sh * sp, ch * sp, -cp), lat_deg, lon_deg)
    return (math.atan2(nose[1], nose[0]), math.asin(max(-1.0, min(1.0, -nose[2]))), math.atan2(right[2], down[2]))


def stamp(wall_s):
    """Absolute timestamp: 2^31 units an hour, lowest bit set."""
    return int(wall_s % 3600.0 / 3600.0 * 2**31) % 2**31 << 1 | 1


def entity_state(exercise, identifier, marking, designator, lat_deg, lon_deg, height_m, velocity_mps, heading, gone=False, wall_s=None):
    """The PDU; `velocity_mps` east, north, up; `heading` of the nose from north, rad: who stands has one too."""
    east, north, up = velocity_mps
    speed = math.hypot(east, north)
    pitch = math.atan2(up, speed) if speed > 1.0 else 0.0
    moves = not gone and math.hypot(speed, up) > 3.0
    velocity = world(velocity_mps, lat_deg, lon_deg) if moves else (0.0, 0.0, 0.0)
    country, category, subcategory, specific, extra = TYPES.get(designator, UNKNOWN)
    entity_type = struct.pack(">BBHBBBB", 1, 2, country, category, subcategory, specific, extra)
    name = marking.encode("ascii", "ignore")[:11].ljust(11, b"\0")
    body = b"".join([
        struct.pack(">HHHBB", *identifier, 0, 0), entity_type, bytes(8),
        struct.pack(">3f", *velocity), struct.pack(">3d", *ecef(lat_deg, lon_deg, height_m)),
        struct.pack(">3f", *euler(heading, pitch, lat_deg, lon_deg)),
        struct.pack(">I", DEACTIVATED if gone else 0),
        # Dead reckoning: fixed axes, constant velocity; or it stands.
        struct.pack(">B", 2 if moves else 1), bytes(15 + 12 + 12), b"\x01", name, bytes(4),
    ])
    wall_s = time.time() if wall_s is None else wall_s
    return struct.pack(">BBBBIHBB", 7, exercise, 1, 1, stamp(wall_s), 12 + len(body), 0, 0) + body


def iff(exercise, identifier, callsign, address, wall_s=None):
    """IFF: a Mode S transponder in the air, on; the aircraft's call sign and address in layer 4."""
    name = callsign.encode("ascii", "ignore")[:8].ljust(8)
    layer_1 = struct.pack(">HHH6x12xHHBBBBBBBB12x", *identifier, 11, 0, 0, 0, 0, 0, 1, 0, 1 << 1 | 1 << 4, 0)
    basic = struct.pack(">HBB8sIBBHB3x", 1 | 1 << 13, 0, 1, name, address & 0xFFFFFF, 0, 0, 0, 0)
    layer_4 = struct.pack(">BBHHH", 4, 0, 36, *identifier[:2]) + basic + bytes(4)
    body = layer_1 + layer_4
    wall_s = time.time() if wall_s is None else wall_s
    return struct.pack(">BBBBIHBB", 7, exercise, 28, 6, stamp(wall_s), 12 + len(body), 0, 0) + body
