//! What a target sends when.
//!
//! | squitter | moving, or in the air | standing |
//! |---|---|---|
//! | position (and velocity in the air) | 0.5 s | 5 s |
//! | identification | 5 s | 10 s |
//! | operational status | 2.5 s | 5 s |

use crate::message::{Emitter, Message, ModeSError};
use crate::squitters::{
    AirbornePosition, AirborneVelocity, Identification, OperationalStatus, SurfacePosition,
    length_width_code, nic_type_code,
};
use crate::{FOOT_M, KNOT_MPS};

/// State of a target at one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// Who sends; the capability of a transponder follows `on_ground`.
    pub emitter: Emitter,
    /// Call sign; what six-bit characters cannot carry is left out.
    pub callsign: String,
    /// Emitter category as [`Identification::category`].
    pub category: u8,
    /// Latitude, degrees.
    pub lat_deg: f64,
    /// Longitude, degrees.
    pub lon_deg: f64,
    /// Pressure altitude, m.
    pub pressure_altitude_m: f64,
    /// Velocity, m/s east, north, up.
    pub velocity_mps: [f64; 3],
    /// Where the nose points, degrees from true north.
    pub heading_deg: f64,
    /// On the ground.
    pub on_ground: bool,
    /// Length and width, m; zero where they are not known.
    pub size_m: [f64; 2],
    /// Navigation accuracy category of the position.
    pub nac_p: u8,
}

/// Below this speed a target counts as standing, m/s.
pub(crate) const STANDING_MPS: f64 = 0.5;

impl Target {
    /// Speed over ground, kt.
    #[must_use]
    pub fn speed_kt(&self) -> f64 {
        let [east, north, _] = self.velocity_mps;
        libm::hypot(east, north) / KNOT_MPS
    }

    /// Whether it moves.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.speed_kt() * KNOT_MPS >= STANDING_MPS
    }

    /// Course over ground, where it moves; else where the nose points. Degrees in [0, 360).
    #[must_use]
    pub fn track_deg(&self) -> f64 {
        let [east, north, _] = self.velocity_mps;
        let track =
            if self.moves() { libm::atan2(east, north).to_degrees() } else { self.heading_deg };
        track.rem_euclid(360.0)
    }

    /// The state `dt_s` later, in a straight line.
    #[must_use]
    pub fn after(&self, dt_s: f64) -> Self {
        let [east, north, up] = self.velocity_mps;
        let cosine = libm::cos(self.lat_deg.to_radians()).max(1e-3);
        let mut later = self.clone();
        // Radii of curvature differ from this one by at most 0.4 %: 0.1 m over half a second at 70 m/s.
        later.lat_deg += (north * dt_s / EARTH_M).to_degrees();
        later.lon_deg += (east * dt_s / (EARTH_M * cosine)).to_degrees();
        later.pressure_altitude_m += up * dt_s;
        later
    }

    fn from(&self) -> Emitter {
        let Emitter { format, capability, .. } = self.emitter;
        let on_ground = if self.on_ground { 4 } else { 5 };
        let capability = if format == 17 { on_ground } else { capability };
        Emitter { capability, ..self.emitter }
    }
}

/// Mean of the radii of curvature at middle latitudes, m.
const EARTH_M: f64 = 6_378_000.0;

/// One squitter to be sent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Due {
    /// When, ns of simulated time.
    pub time_ns: i64,
    /// What.
    pub message: Message,
    /// Of position kind: even and odd alternate.
    pub position: bool,
}

/// When one target sent what, and which half of a position comes next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Schedule {
    odd: bool,
    position_ns: Option<i64>,
    identity_ns: Option<i64>,
    status_ns: Option<i64>,
}

impl Schedule {
    /// The squitters of a target from `from_ns` to before `to_ns`, whose state is known at `from_ns`.
    ///
    /// # Errors
    /// If a value of the target cannot be sent; nothing of this interval is sent then.
    pub fn due(
        &mut self,
        target: &Target,
        from_ns: i64,
        to_ns: i64,
    ) -> Result<Vec<Due>, ModeSError> {
        let before = *self;
        let made = self.make(target, from_ns, to_ns);
        if made.is_err() {
            *self = before;
        }
        made
    }

    fn make(&mut self, target: &Target, from_ns: i64, to_ns: i64) -> Result<Vec<Due>, ModeSError> {
        let mut out = Vec::new();
        let lively = target.moves() || !target.on_ground;
        let period = |fast_ns: i64, slow_ns: i64| if lively { fast_ns } else { slow_ns };
        let from = target.from();
        let times = |last: &mut Option<i64>, period_ns: i64| {
            let mut list = Vec::new();
            // A restart of the run, or a target that stood: it begins again now.
            let mut next = last.filter(|l| *l <= from_ns).map_or(from_ns, |l| l + period_ns);
            next = next.max(from_ns);
            while next < to_ns {
                list.push(next);
                *last = Some(next);
                next += period_ns;
            }
            list
        };
        for time_ns in times(&mut self.position_ns, period(HALF_NS, 10 * HALF_NS)) {
            let now = target.after((time_ns - from_ns) as f64 * 1e-9);
            let odd = self.odd;
            self.odd = !odd;
            let message = if target.on_ground {
                SurfacePosition {
                    lat_deg: now.lat_deg,
                    lon_deg: now.lon_deg,
                    speed_kt: Some(now.speed_kt()),
                    track_deg: Some(now.track_deg()),
                    odd,
                    type_code: nic_type_code(now.nac_p),
                }
                .message(from)?
            } else {
                AirbornePosition {
                    lat_deg: now.lat_deg,
                    lon_deg: now.lon_deg,
                    altitude_ft: now.pressure_altitude_m / FOOT_M,
                    odd,
                }
                .message(from)?
            };
            out.push(Due { time_ns, message, position: true });
            if !target.on_ground {
                let [east, north, up] = target.velocity_mps;
                let message = AirborneVelocity {
                    east_kt: east / KNOT_MPS,
                    north_kt: north / KNOT_MPS,
                    climb_fpm: up / FOOT_M * 60.0,
                }
                .message(from)?;
                out.push(Due { time_ns, message, position: false });
            }
        }
        let callsign = callsign(&target.callsign);
        for time_ns in times(&mut self.identity_ns, period(10 * HALF_NS, 20 * HALF_NS)) {
            let said = Identification { callsign: &callsign, category: target.category };
            out.push(Due { time_ns, message: said.message(from)?, position: false });
        }
        for time_ns in times(&mut self.status_ns, period(5 * HALF_NS, 10 * HALF_NS)) {
            let code = length_width_code(target.size_m[0], target.size_m[1]);
            let message = OperationalStatus {
                length_width_code: target.on_ground.then_some(code),
                nac_p: target.nac_p,
                sil: 3,
            }
            .message(from)?;
            out.push(Due { time_ns, message, position: false });
        }
        out.sort_by_key(|due| due.time_ns);
        Ok(out)
    }
}

/// Half a second.
const HALF_NS: i64 = 500_000_000;

/// What six-bit characters carry of a name.
fn callsign(name: &str) -> String {
    let capitals = name.chars().map(|c| c.to_ascii_uppercase());
    capitals.filter(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || *c == ' ').take(8).collect()
}
