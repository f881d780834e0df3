//! All thresholds of the control alerts in one table; a scene may set each of them.

/// When a track is not good enough to raise an alert by itself (`docs/control.md`). An alert that stands goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Doubt {
    /// A track without a name that is younger, s.
    pub unnamed_s: f64,
    /// Any track that is younger, s.
    pub young_s: f64,
    /// A track whose last plot is older, s.
    pub coasting_s: f64,
    /// A track without a name so near to a named one, m, and so many seconds of the named one's speed more: its double.
    pub double_m: f64,
    /// And these seconds.
    pub double_s: f64,
    /// And until so long after it was one of somebody who rolls or flies, s: it falls behind him.
    pub beside_s: f64,
    /// A track without a name whose mean speed is above this, m/s, and that never was slow: faster than anybody lands (the fastest of
    /// `types.csv` touches down at 78 m/s).
    pub lands_mps: f64,
    /// A track whose velocity has changed by more than this, m/s², over three scans
    pub jump_mps2: f64,
    /// and this, m/s, or that is farther from where its last three seconds lead than this, m,
    pub jump_mps: f64,
    /// and
    pub step_m: f64,
    /// so many seconds of its way: it moves as nothing can, for the next while, s.
    pub step_s: f64,
    /// That while.
    pub jump_s: f64,
    /// The same of a track without a name, and of one that jumps time and again: those of one that is seen by radar alone do.
    pub restless_s: f64,
    /// The same, for everything about the track: change of velocity, m/s², over three scans
    pub leap_mps2: f64,
    /// and this, m/s,
    pub leap_mps: f64,
    /// or so many times the distance,
    pub leap_steps: f64,
    /// for so long, s.
    pub leap_s: f64,
    /// A name that was another track's is doubted for so long, s.
    pub taken_over_s: f64,
    /// The nose of one slower than this is taken from its cleared way, m/s: its velocity is noise.
    pub slow_mps: f64,
    /// A roll without clearance is one whose places of three seconds show its speed but for this, m/s.
    pub roll_lag_mps: f64,
    /// Scans in a row (1 to 3) with the nose before a bar, then one over it: it was passed.
    pub before_bar_scans: usize,
    /// And of one slower than a taxi speed, whose nose noise may put there: over it by this, m; so is the edge of a strip,
    pub past_line_m: f64,
    /// or on its way over it, faster than this across it, m/s,
    pub over_bar_mps: f64,
    /// and by this nearer to the runway than these scans before, m.
    pub over_bar_m: f64,
    /// A track without a name that was never slower than a roll has to have been on one final for so long, s: else it
    /// flies over, or is an echo of one that does.
    pub final_s: f64,
    /// And that final has to have begun so long before the threshold, s: nobody comes from nowhere.
    pub from_s: f64,
    /// A name that a track had so recently, s, and that nobody has now, is still its name.
    pub name_s: f64,
    /// Scans in a row for movements off the runways (push, taxi, speed, way), stop bars and landings without clearance.
    pub move_scans: u32,
}

impl Default for Doubt {
    fn default() -> Self {
        Self {
            unnamed_s: 4.0,
            young_s: 3.0,
            coasting_s: 2.2,
            double_m: 45.0,
            double_s: 1.5,
            beside_s: 5.0,
            lands_mps: 80.5,
            jump_mps2: 1.7,
            jump_mps: 3.0,
            step_m: 5.0,
            step_s: 0.15,
            jump_s: 3.0,
            restless_s: 12.0,
            leap_mps2: 4.0,
            leap_mps: 5.0,
            leap_steps: 2.5,
            leap_s: 5.0,
            taken_over_s: 8.0,
            slow_mps: 10.0,
            roll_lag_mps: 5.0,
            before_bar_scans: 3,
            past_line_m: 4.0,
            over_bar_mps: 1.0,
            over_bar_m: 2.0,
            final_s: 10.0,
            from_s: 15.0,
            name_s: 60.0,
            move_scans: 2,
        }
    }
}

/// Thresholds of the alerts (`docs/control.md`). Speeds in m/s, times in s, distances in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// An arrival nearer than this to its threshold, s, gives an information.
    pub information_s: f64,
    /// And an alarm.
    pub alarm_s: f64,
    /// Procedures for low visibility are in force below this runway visual range, m (from memory).
    pub low_visibility_m: f64,
    /// The same in low visibility.
    pub low_visibility_information_s: f64,
    /// The same in low visibility.
    pub low_visibility_alarm_s: f64,
    /// Slowest along a runway that is a roll.
    pub fast_mps: f64,
    /// Least share of the speed along the runway in a roll.
    pub fast_aligned: f64,
    /// Slowest on final.
    pub final_mps: f64,
    /// Half width of the approach at the threshold, m.
    pub funnel_m: f64,
    /// And its growth with the distance.
    pub funnel_slope: f64,
    /// Longest approach that is looked at, m.
    pub funnel_length_m: f64,
    /// Largest angle between course and runway on final, degrees.
    pub aligned_deg: f64,
    /// Taken off the hold distance: the tracker's 95 % error, m.
    pub strip_margin_m: f64,
    /// The strip reaches so far beyond the ends of the runway, m.
    pub strip_beyond_m: f64,
    /// A track above this height is not in the strip, m.
    pub strip_top_m: f64,
    /// A roll may be so far beside the runway's edge, m.
    pub runway_side_m: f64,
    /// A track above this height is airborne, m.
    pub airborne_m: f64,
    /// One short of the threshold by more than this is no obstacle, m.
    pub short_of_threshold_m: f64,
    /// An aircraft that lifts off and is so far behind the threshold when the next one arrives is no obstacle, m.
    pub departed_m: f64,
    /// Opposite traffic on final is looked at up to this time, s.
    pub opposite_s: f64,
    /// One ahead that is faster than this much below the roll, and farther than the next, is no obstacle.
    pub following_mps: f64,
    /// The distance for it, m.
    pub following_m: f64,
    /// Crossing runways: farthest time to the intersection, s.
    pub crossing_ahead_s: f64,
    /// And largest difference of both times, s.
    pub crossing_apart_s: f64,
    /// Entries farther apart are two line-ups, m.
    pub entries_apart_m: f64,
    /// Arrival without clearance to land: time to the threshold, s.
    pub landing_clearance_s: f64,
    /// A landing is one of an arrival for so long, s.
    pub landed_s: f64,
    /// Without altitude, one that rolled is not taxiing for so long, s.
    pub rolled_s: f64,
    /// Mean speed of a push-back that needs a clearance.
    pub push_mps: f64,
    /// Mean speed of taxiing that needs a clearance.
    pub taxi_mps: f64,
    /// The mean is over so long, s.
    pub mean_s: f64,
    /// What is nearer to its stand than this is pushed back, m.
    pub stand_reach_m: f64,
    /// A bar counts for who crosses within this distance of its place, m.
    pub bar_reach_m: f64,
    /// The nose counts as over a bar so far behind it, m.
    pub bar_margin_m: f64,
    /// Farther than this from the cleared way is off it, m.
    pub way_m: f64,
    /// Cleared for take-off and standing for so long, s.
    pub stands_cleared_s: f64,
    /// Lined up and standing for so long, s.
    pub stands_lined_up_s: f64,
    /// One that moves less than this stands, m.
    pub anchor_m: f64,
    /// Fast taxiing: information.
    pub high_speed_mps: f64,
    /// Take-off from a taxiway: alarm.
    pub taxiway_take_off_mps: f64,
    /// A stand is occupied by what stands so near to it, m.
    pub stand_occupied_m: f64,
    /// Who is nearer to another stand, which is farther than this from that, does not occupy it, m.
    pub stands_apart_m: f64,
    /// An occupied stand is told so long before, s.
    pub stand_ahead_s: f64,
    /// Assumed speed between here and the stand.
    pub stand_taxi_mps: f64,
    /// Successive scans before an alert is raised.
    pub confirm_scans: u32,
    /// Scans without its condition before it ends.
    pub end_scans: u32,
    /// Coasting tracks count for so long, s.
    pub coasting_s: f64,
    /// Nose heading is that of the last speed above this.
    pub heading_mps: f64,
    /// Which tracks are doubted; nobody where the tracks are exact.
    pub doubt: Option<Doubt>,
}

impl Parameters {
    /// Whether low visibility procedures are in force at a runway visual range, m.
    #[must_use]
    pub fn is_low(&self, visibility_m: f64) -> bool {
        visibility_m < self.low_visibility_m
    }

    /// Those for the tracks of a tracker.
    #[must_use]
    pub fn on_tracks() -> Self {
        Self { doubt: Some(Doubt::default()), ..Self::default() }
    }
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            information_s: 30.0,
            alarm_s: 15.0,
            low_visibility_m: 550.0,
            low_visibility_information_s: 45.0,
            low_visibility_alarm_s: 30.0,
            fast_mps: 18.0,
            fast_aligned: 0.94,
            final_mps: 40.0,
            funnel_m: 60.0,
            funnel_slope: 0.035,
            funnel_length_m: 12_000.0,
            aligned_deg: 20.0,
            strip_margin_m: 7.5,
            strip_beyond_m: 60.0,
            strip_top_m: 150.0,
            runway_side_m: 10.0,
            airborne_m: 15.0,
            short_of_threshold_m: 100.0,
            departed_m: 2400.0,
            opposite_s: 60.0,
            following_mps: 5.0,
            following_m: 1500.0,
            crossing_ahead_s: 40.0,
            crossing_apart_s: 10.0,
            entries_apart_m: 30.0,
            landing_clearance_s: 30.0,
            landed_s: 120.0,
            rolled_s: 60.0,
            push_mps: 1.0,
            taxi_mps: 2.6,
            mean_s: 10.0,
            stand_reach_m: 60.0,
            bar_reach_m: 40.0,
            bar_margin_m: 0.0,
            way_m: 25.0,
            stands_cleared_s: 45.0,
            stands_lined_up_s: 90.0,
            anchor_m: 15.0,
            high_speed_mps: 20.0,
            taxiway_take_off_mps: 26.0,
            stand_occupied_m: 25.0,
            stands_apart_m: 15.0,
            stand_ahead_s: 300.0,
            stand_taxi_mps: 8.0,
            confirm_scans: 1,
            end_scans: 3,
            coasting_s: 8.0,
            heading_mps: 1.0,
            doubt: None,
        }
    }
}
