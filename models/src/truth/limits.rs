//! What a type of aircraft or vehicle can do: bounds of every truth.

/// Speeds and accelerations of a type as tables give them, SI units; `None` where there is no figure.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Kinematics {
    /// Speed at lift-off.
    pub liftoff_mps: Option<f64>,
    /// Usual acceleration in the take-off run.
    pub takeoff_acc_ms2: Option<f64>,
    /// Speed at touchdown.
    pub touchdown_mps: Option<f64>,
    /// Usual braking in the landing run, positive.
    pub braking_ms2: Option<f64>,
    /// Taxi or driving speed on straights.
    pub taxi_straight_mps: f64,
    /// Taxi or driving speed in a turn of 90 degrees.
    pub taxi_turn_mps: f64,
    /// Acceleration when taxiing or driving.
    pub taxi_acc_ms2: f64,
    /// Braking when taxiing or driving, positive.
    pub taxi_dec_ms2: f64,
}

/// Hard bounds that a truth keeps at every time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Largest speed on taxiways: the straight taxi speed of the type.
    pub taxi_mps: f64,
    /// Largest acceleration and braking on taxiways.
    pub taxi_acc_ms2: f64,
    /// The same for braking, positive.
    pub taxi_dec_ms2: f64,
    /// Largest speed on the ground in a take-off run: that of lift-off; on vehicles the driving speed.
    pub takeoff_mps: f64,
    /// Largest speed on the ground in a landing run: that of touchdown; on vehicles the driving speed.
    pub landing_mps: f64,
    /// Speed below which it does not fly; infinite for vehicles.
    pub least_air_mps: f64,
    /// Largest acceleration in a take-off run and in the air.
    pub roll_acc_ms2: f64,
    /// Largest braking in a landing run and in the air, positive.
    pub roll_dec_ms2: f64,
    /// Largest lateral acceleration on the ground: that of the 90-degree turn at its speed.
    pub lateral_ms2: f64,
    /// Largest change of acceleration on taxiways, m/s³.
    pub jerk_ms3: f64,
    /// The same in a take-off or landing run.
    pub roll_jerk_ms3: f64,
    /// Smallest radius of the path of the reference point, m.
    pub least_radius_m: f64,
}

/// Lateral acceleration of a turn with bank in the air, m/s² (30 degrees).
pub(super) const AIR_LATERAL_MS2: f64 = 5.66;

impl Limits {
    /// Bounds of a type.
    ///
    /// | bound | from |
    /// | --- | --- |
    /// | speed on taxiways | `taxi_straight_max_ms` |
    /// | acceleration, braking on taxiways | `taxi_acc_ms2`, `taxi_dec_ms2` |
    /// | lateral acceleration on the ground | `taxi_turn90_max_ms`² / 15 m (aircraft) or 12 m (vehicles) |
    /// | acceleration, braking on the runway and in the air | `takeoff_acc_ms2`, `braking_acc_ms2` |
    /// | speed on the ground in take-off, in landing | `liftoff_mps`, `touchdown_mps` |
    ///
    /// The table gives usual values, averaged over a whole run; single recorded movements exceed them
    /// (a light A320 accelerates with 2.5 m/s² for 20 s). They are held to the table all the same, and
    /// the report of the import says where. A type without figures for the runway gets those of an A320.
    #[must_use]
    pub fn of(aircraft: bool, kinematics: &Kinematics) -> Self {
        let k = kinematics;
        let turn_radius_m = if aircraft { 15.0 } else { 12.0 };
        let liftoff_mps = k.liftoff_mps.unwrap_or(85.3);
        let ground = Self {
            taxi_mps: k.taxi_straight_mps,
            taxi_acc_ms2: k.taxi_acc_ms2,
            taxi_dec_ms2: k.taxi_dec_ms2,
            takeoff_mps: k.taxi_straight_mps,
            landing_mps: k.taxi_straight_mps,
            least_air_mps: f64::INFINITY,
            roll_acc_ms2: k.taxi_acc_ms2,
            roll_dec_ms2: k.taxi_dec_ms2,
            lateral_ms2: k.taxi_turn_mps * k.taxi_turn_mps / turn_radius_m,
            jerk_ms3: k.taxi_acc_ms2.min(k.taxi_dec_ms2),
            roll_jerk_ms3: k.taxi_acc_ms2,
            least_radius_m: if aircraft { 12.0 } else { 6.0 },
        };
        if !aircraft {
            return ground;
        }
        let touchdown_mps = k.touchdown_mps.unwrap_or(69.4);
        Self {
            takeoff_mps: liftoff_mps,
            landing_mps: touchdown_mps,
            least_air_mps: 0.8 * touchdown_mps.min(liftoff_mps),
            roll_acc_ms2: k.takeoff_acc_ms2.unwrap_or(1.93).max(k.taxi_acc_ms2),
            roll_dec_ms2: k.braking_ms2.unwrap_or(1.22).max(k.taxi_dec_ms2),
            roll_jerk_ms3: 2.0,
            ..ground
        }
    }
}
