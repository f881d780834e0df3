-- The database of one run. Times: time_ns is simulated time in nanoseconds since the start of the run, wall_utc_ns
-- is wall-clock time since 1970. Positions: metres east (x) and north (y) of the aerodrome reference point.
-- Headings: degrees clockwise from north; the same in radians as the messages had them. NULL is "not known" or "none".
-- place: where the row stood in the scan's report. PRAGMA user_version counts the versions of these tables.

CREATE TABLE run (name TEXT PRIMARY KEY, value TEXT) WITHOUT ROWID;

-- The scene's text and every file that it names, as they were.
CREATE TABLE files (name TEXT PRIMARY KEY, octets BLOB) WITHOUT ROWID;

CREATE TABLE sensors (sensor INTEGER PRIMARY KEY, name TEXT, kind TEXT, x_m REAL, y_m REAL, range_m REAL);

CREATE TABLE scans (
  scan INTEGER PRIMARY KEY, time_ns INTEGER, targets INTEGER, plots INTEGER, tracks INTEGER,
  untracked INTEGER,  -- targets that no track follows
  track_rmse_m REAL,  -- of the tracks that follow a target, at publication time
  plot_rmse_m REAL,   -- of the plots that a target caused, each at its own time
  took_us INTEGER,    -- wall time that the scan took in the SMDFM
  worst_error_m REAL, mean_error_m REAL,  -- of the tracks that follow a target
  false_tracks INTEGER,  -- confirmed tracks that follow nothing
  wrong_labels INTEGER   -- tracks with the call sign of another target
);

-- True state of every entity at the publication time of the scan, as the sensors received it.
CREATE TABLE truth (
  scan INTEGER, entity INTEGER, dis_id TEXT, callsign TEXT, type TEXT,
  x_m REAL, y_m REAL, altitude_m REAL, vx_ms REAL, vy_ms REAL, heading_deg REAL,
  track INTEGER, track_error_m REAL,  -- the track that follows it, and the distance to it
  vz_ms REAL, heading_rad REAL, length_m REAL, span_m REAL, aircraft INTEGER,
  ours INTEGER,  -- 0: an outsider's
  place INTEGER,
  PRIMARY KEY (scan, entity)
) WITHOUT ROWID;

CREATE TABLE plots (
  scan INTEGER, sensor INTEGER, sequence INTEGER, kind TEXT, time_ns INTEGER,  -- time of the measurement
  x_m REAL, y_m REAL, var_ee_m2 REAL, var_en_m2 REAL, var_nn_m2 REAL,
  range_m REAL, azimuth_deg REAL, scnr_db REAL,  -- radars
  identity TEXT,                                 -- as the target reported it
  track INTEGER,                                 -- the track that took it
  cause TEXT, truth_x_m REAL, truth_y_m REAL,    -- entity that caused it and where it was then; NULL: false alarm
  error_m REAL,
  axis_e REAL, axis_n REAL, along_m2 REAL, across_m2 REAL,  -- error ellipse: a direction, variances along and across it
  altitude_m REAL, azimuth_rad REAL, sigma_range_m REAL, sigma_azimuth_rad REAL,
  place INTEGER,
  PRIMARY KEY (scan, sensor, sequence)
) WITHOUT ROWID;
CREATE INDEX plots_of ON plots (cause, scan);

-- What each simulated effect did to a plot, where the run was asked to explain.
CREATE TABLE plot_effects (
  scan INTEGER, sensor INTEGER, sequence INTEGER, effect TEXT, value REAL, unit TEXT, place INTEGER,
  PRIMARY KEY (scan, sensor, sequence, place)
) WITHOUT ROWID;

-- System tracks as published.
CREATE TABLE tracks (
  scan INTEGER, track INTEGER, status TEXT, type TEXT, callsign TEXT,
  x_m REAL, y_m REAL, vx_ms REAL, vy_ms REAL, speed_ms REAL, heading_deg REAL, altitude_m REAL,
  var_ee_m2 REAL, var_en_m2 REAL, var_nn_m2 REAL, manoeuvre INTEGER,
  entity TEXT, error_m REAL,  -- the entity that it follows (call sign) and the distance to it; NULL: false track
  -- The publication before, revised by the plots of this scan; lag_coasted: there were none.
  lag_time_ns INTEGER, lag_x_m REAL, lag_y_m REAL, lag_var_ee_m2 REAL, lag_var_en_m2 REAL, lag_var_nn_m2 REAL,
  lag_coasted INTEGER, lag_error_m REAL,
  -- A call sign that is likely, but too unsure for a label; the probability of either.
  assumed TEXT, label_p REAL,
  estimate_ns INTEGER, first INTEGER, designator TEXT, wake TEXT, movement TEXT, runway_stand TEXT, routing TEXT,
  ctd_eta_ns INTEGER, heading_rad REAL, ax_ms2 REAL, ay_ms2 REAL, vvar_ee REAL, vvar_en REAL, vvar_nn REAL,
  address INTEGER,    -- 24-bit address that the target itself reports
  existence_p REAL,   -- probability that there is a target at all, where lives go by it
  unresolved INTEGER, -- more plots lay where it may be than it could be told from
  place INTEGER,
  altitude_ns INTEGER,             -- when altitude_m was reported
  PRIMARY KEY (scan, track)
) WITHOUT ROWID;
CREATE INDEX track_of ON tracks (track, scan);

-- What was said of tracks beside the reports, as of earlier scans, by the numbers of frame.rs: what each does (derived: by map and speed only), the
-- stage of its alert, what it was cleared for last.
CREATE TABLE track_notes (
  scan INTEGER, track INTEGER, doing INTEGER, derived INTEGER, alert INTEGER, cleared INTEGER,
  PRIMARY KEY (scan, track)
) WITHOUT ROWID;

-- What the time line marks: lost and swapped tracks, weather, operators, alerts.
CREATE TABLE events (time_ns INTEGER, kind TEXT, subject TEXT, text TEXT);

-- Tracks of somebody else's tracker, as the gateway heard them in ASTERIX (--asterix-in).
CREATE TABLE foreign_tracks (
  source TEXT, track INTEGER,      -- SAC/SIC, and the number there
  time_ns INTEGER, x_m REAL, y_m REAL, vx_ms REAL, vy_ms REAL, callsign TEXT, coasting INTEGER, last INTEGER,
  received_ns INTEGER              -- wall clock, UTC
);

-- Measures of the SMDFM since the start of the run, as they stood at each scan.
CREATE TABLE statistics (scan INTEGER, name TEXT, value REAL, PRIMARY KEY (scan, name)) WITHOUT ROWID;

-- The effect plan; a row stands from its scan on, until another one of its sensor and effect. Before version 5 one that
-- came back was not written again.
CREATE TABLE plan (scan INTEGER, sensor TEXT, effect TEXT, called_for_by TEXT, bound TEXT, decision TEXT);

CREATE TABLE weather (
  time_ns INTEGER, rain_mm_per_h REAL, visibility_m REAL,  -- visibility NULL: clear
  temperature_c REAL, pressure_hpa REAL, vapour_g_per_m3 REAL, wind_east_ms REAL, wind_north_ms REAL,
  film_mm REAL, cells_json TEXT  -- cells: [east m, north m, radius m, mm/h]
);

-- The flight data list as it stands.
CREATE TABLE flights (
  callsign TEXT, address TEXT, type TEXT, wake TEXT, movement TEXT, runway TEXT, stand TEXT,
  eta_ctd_s REAL, off_block_s REAL, routing TEXT
);

-- Clearances of traffic that behaves, also those of the plan (seat "plan"); until_ns NULL: it stands.
-- route: of a taxi clearance the names of the taxiways, in their order.
CREATE TABLE clearances (
  time_ns INTEGER, callsign TEXT, kind TEXT, runway TEXT, until_ns INTEGER, route TEXT, seat TEXT
);

-- One row a flight that behaves: actual off-block, take-off, landing and in-block times.
CREATE TABLE movements (
  callsign TEXT, kind TEXT, aobt_ns INTEGER, atot_ns INTEGER, aldt_ns INTEGER, aibt_ns INTEGER,
  runway TEXT, stand TEXT, stops INTEGER,
  taxi_s REAL,        -- off-block to line-up, or runway vacated to in-block; NULL before it has taxied
  additional_s REAL,  -- taxi time less that of the same way driven alone
  fuel_kg REAL        -- of all engines at idle, on the ground
);

CREATE TABLE measures (source TEXT, name TEXT, value REAL, unit TEXT);  -- source: truth or tracks

-- What the traffic core found worth a line: stands not free, no way, deadlock.
CREATE TABLE remarks (time_ns INTEGER, text TEXT);

-- Control alerts on tracks, one row per stage: raised at time_ns, ended at end_ns (NULL: it stands).
CREATE TABLE alerts (
  time_ns INTEGER, kind TEXT, stage TEXT, subjects TEXT, end_ns INTEGER, place_x_m REAL, place_y_m REAL, id INTEGER
);

-- What was said at a time as JSON, deflated (zlib): topic "traffic", flights that behave (docs/traffic.md, Seen), and
-- "lights", stop bars, when they changed.
CREATE TABLE said (topic TEXT, time_ns INTEGER, octets BLOB, PRIMARY KEY (topic, time_ns)) WITHOUT ROWID;

-- Lights: a row whenever one is switched, lit or dark. id: of a stop bar the runway and which of its bars, as "16/34 2"; of entry lights
-- "16/34 entry 2"; of take-off hold lights "34 hold"; of a segment of a taxiway "green 17".
CREATE TABLE lights (time_ns INTEGER, id TEXT, state TEXT);
CREATE INDEX lights_of ON lights (id);

-- The same rules on exact truth with the true clearances: what the alerts on tracks are scored against.
CREATE TABLE reference_alerts (
  time_ns INTEGER, kind TEXT, stage TEXT, subjects TEXT, end_ns INTEGER, place_x_m REAL, place_y_m REAL, id INTEGER,
  nearest_m REAL  -- how near its pair came while it stood, or its subject to anybody
);

-- What went wrong, since when it shows in the truth.
-- What each controller's seat did in a minute: share of it thinking, speaking or listening, and who wait for it.
CREATE TABLE seats (time_ns INTEGER, seat TEXT, busy REAL, queue INTEGER);

-- What was said on the frequencies, at its last word: request, clearance, readback or correction of a clearance (PSH, TAX, …).
CREATE TABLE radio (time_ns INTEGER, sender TEXT, receiver TEXT, kind TEXT, clearance TEXT);

-- What people at controllers' seats did (take, leave, here, say), from which frame on, and why not where it was refused: --inputs of
-- another run says it again. "silent": nothing was heard of the person for long, and the model had the seat again.
CREATE TABLE inputs (
  number INTEGER, frame INTEGER, time_ns INTEGER, seat TEXT, person TEXT, action TEXT, callsign TEXT, clearance TEXT, refused TEXT
);

-- Advice for controllers, a row for each time that something became of it: given, moved, decided, ended; decided by: person or model.
CREATE TABLE advice (
  id INTEGER, frame INTEGER, time_ns INTEGER, change TEXT, kind TEXT, seat TEXT, subjects TEXT, text TEXT,
  value REAL, unit TEXT, otherwise TEXT, until_ns INTEGER, decision TEXT, decided_by TEXT
);

CREATE TABLE failures (id TEXT, callsign TEXT, kind TEXT, time_ns INTEGER);

-- Every operator action and its answer.
CREATE TABLE operations (
  wall_utc_ns INTEGER, time_ns INTEGER, frame INTEGER, source TEXT, command TEXT, done INTEGER, answer TEXT
);

-- Every change of the run's state.
CREATE TABLE states (
  wall_utc_ns INTEGER, run INTEGER, frame INTEGER, phase TEXT,
  rate REAL,  -- NULL: as fast as possible
  achieved_rate REAL, reasons TEXT
);

-- Load and counters of each federate, about once a second of wall time.
CREATE TABLE federates (
  wall_utc_ns INTEGER, name TEXT, host TEXT, pid INTEGER, frame INTEGER, cpu_s REAL, cpu_percent REAL,
  memory_bytes INTEGER, pdus_in INTEGER, pdus_out INTEGER, lost INTEGER, repaired INTEGER, dropped INTEGER,
  exec_us REAL, latency_us REAL
);

-- Not every SQLite has a square root, so the views below take it by Newton's steps.

-- Every entity once.
CREATE VIEW entities AS
SELECT entity, dis_id, callsign, type, aircraft, length_m, span_m, ours, min(scan) AS first_scan, max(scan) AS last_scan
FROM truth GROUP BY entity;

-- How well was each target tracked?
CREATE VIEW target_accuracy AS
WITH mean AS (
  SELECT callsign, type, count(*) AS scans, sum(track IS NOT NULL) AS tracked_scans,
    avg(track_error_m * track_error_m) AS m, max(track_error_m) AS worst_m
  FROM truth GROUP BY entity
)
SELECT callsign, type, scans, tracked_scans, round(100.0 * tracked_scans / scans, 1) AS tracked_percent,
  (WITH RECURSIVE newton(step, r) AS (SELECT 0, m + 1.0 UNION ALL SELECT step + 1, (r + m / r) / 2 FROM newton WHERE step < 60)
   SELECT r FROM newton WHERE step = 60) AS rmse_m,
  worst_m
FROM mean ORDER BY rmse_m DESC;

-- How good is each sensor, and how many false alarms has it?
CREATE VIEW sensor_accuracy AS
WITH mean AS (
  SELECT sensor, kind, count(*) AS plots, sum(cause IS NULL) AS false_alarms, avg(error_m * error_m) AS m,
    max(error_m) AS worst_m, avg(scnr_db) AS mean_scnr_db
  FROM plots GROUP BY sensor, kind
)
SELECT sensor, sensors.name, mean.kind, plots, false_alarms,
  (WITH RECURSIVE newton(step, r) AS (SELECT 0, m + 1.0 UNION ALL SELECT step + 1, (r + m / r) / 2 FROM newton WHERE step < 60)
   SELECT r FROM newton WHERE step = 60) AS rmse_m,
  worst_m, mean_scnr_db
FROM mean LEFT JOIN sensors USING (sensor) ORDER BY sensor;

-- How did the errors go over time?
CREATE VIEW error_over_time AS
SELECT scan, time_ns / 1e9 AS time_s, track_rmse_m, plot_rmse_m, targets, untracked FROM scans;

-- Which tracks followed nothing?
CREATE VIEW false_tracks AS
SELECT track, min(scan) AS first_scan, max(scan) AS last_scan, count(*) AS scans
FROM tracks GROUP BY track HAVING count(entity) = 0;

-- Which labels were wrong?
CREATE VIEW wrong_labels AS
SELECT scan, track, callsign AS label, entity FROM tracks
WHERE callsign <> '' AND entity IS NOT NULL AND callsign <> entity;

-- Which effects cost a plot most?
CREATE VIEW effect_sizes AS
SELECT effect, unit, count(*) AS plots, avg(value) AS mean, min(value) AS least, max(value) AS most
FROM plot_effects GROUP BY effect, unit;

-- What was lost on the network, and what was repaired?
CREATE VIEW network_losses AS
SELECT name, max(pdus_in) AS pdus_in, max(pdus_out) AS pdus_out, max(lost) AS lost, max(repaired) AS repaired,
  max(dropped) AS dropped, max(cpu_s) AS cpu_s, max(memory_bytes) AS most_memory_bytes
FROM federates GROUP BY name;

-- Who sat at which seat, from when until when, how it ended (leave, silent; NULL: with the run), and how much was said.
CREATE VIEW people_seats AS
WITH turns AS (
  SELECT *, lag(action, 1, '') OVER (PARTITION BY seat ORDER BY frame, number) AS before
  FROM inputs WHERE refused = '' AND action IN ('take', 'leave', 'silent')
), spells AS (
  SELECT seat, person, action, frame, time_ns, lead(frame) OVER turn AS until_frame, lead(time_ns) OVER turn AS until_ns,
    lead(action) OVER turn AS ended
  FROM turns WHERE action <> 'take' OR before <> 'take'
  WINDOW turn AS (PARTITION BY seat ORDER BY frame, number)
)
SELECT seat, person, frame AS taken_frame, time_ns / 1e9 AS taken_s, until_frame, until_ns / 1e9 AS until_s, ended,
  (SELECT count(*) FROM inputs i WHERE action = 'say' AND i.seat = s.seat AND i.person = s.person
    AND i.frame >= s.frame AND (until_frame IS NULL OR i.frame <= until_frame)) AS orders,
  (SELECT count(*) FROM inputs i WHERE action = 'say' AND refused <> '' AND i.seat = s.seat AND i.person = s.person
    AND i.frame >= s.frame AND (until_frame IS NULL OR i.frame <= until_frame)) AS refused
FROM spells s WHERE action = 'take' ORDER BY frame, seat;

-- What people said to whom, and what came of it: the answer, when it was first read back and since when it held, within 300 s.
CREATE VIEW people_orders AS
SELECT number, frame, time_ns / 1e9 AS time_s, seat, person, callsign, clearance,
  CASE refused WHEN '' THEN 'accepted' ELSE refused END AS answer,
  CASE refused WHEN '' THEN (SELECT min(r.time_ns) / 1e9 FROM radio r WHERE r.sender = i.callsign AND r.kind = 'readback'
    AND r.clearance = i.clearance AND r.time_ns BETWEEN i.time_ns AND i.time_ns + 300000000000) END AS read_back_s,
  CASE refused WHEN '' THEN (SELECT min(c.time_ns) / 1e9 FROM clearances c WHERE c.callsign = i.callsign
    AND c.kind = i.clearance AND c.time_ns BETWEEN i.time_ns AND i.time_ns + 300000000000) END AS holds_s
FROM inputs i WHERE action = 'say' ORDER BY frame, number;

-- Which alerts were raised within 300 s after an order, of whom it was given to; source: tracks, or truth (reference_alerts).
CREATE VIEW people_alerts AS
WITH raised AS (
  SELECT 'tracks' AS source, id, kind, min(stage) AS stage, max(subjects) AS subjects, min(time_ns) AS time_ns FROM alerts GROUP BY id
  UNION ALL
  SELECT 'truth', id, kind, min(stage), max(subjects), min(time_ns) FROM reference_alerts GROUP BY id
)
SELECT i.number, i.frame, i.time_ns / 1e9 AS time_s, i.seat, i.person, i.callsign, i.clearance,
  a.source, a.kind, a.stage, a.subjects, (a.time_ns - i.time_ns) / 1e9 AS raised_after_s
FROM inputs i JOIN raised a ON a.time_ns BETWEEN i.time_ns AND i.time_ns + 300000000000
  AND instr(' ' || a.subjects || ' ', ' ' || i.callsign || ' ') > 0
WHERE i.action = 'say' AND i.refused = '' ORDER BY a.time_ns, i.frame, i.number, a.source;
