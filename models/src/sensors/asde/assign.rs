//! Which level each look gets: by the plan of its box, its neighbours, and what stands before it.

use super::looks::Look;
use super::plan::boxes::{Key, SECTORS, band, part, ring, ring_m, sector};
use super::plan::class::ClassFacts;
use super::plan::outcome::Detection;
use super::plan::planner::{MOST_NEW, Planner, PlannerScene};
use super::{Air, Asde, Place, Tolerance, Truth};
use crate::effects::Level;
use crate::frames::{Azimuth, Vector2, Vector3, wrap_pi};
use crate::sensors::radar::detection::PdTable;
use crate::sensors::radar::effects::RadarEffect;
use crate::sensors::radar::ghost::ghost_power;
use crate::sensors::radar::levels::RadarLevels;
use crate::sensors::radar::span::Span;
use crate::sensors::{ScanInterval, TargetClass};
use std::f64::consts::TAU;

/// How a target was simulated in a scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Placed {
    /// The target, by its place in the truth.
    pub index: usize,
    /// Its box, by its place among those of the planner; `None` where everything was exact for it.
    pub place: Option<u32>,
    /// Sector of azimuth, 22.5° each from north.
    pub sector: u8,
    /// Whether the radar displays what is there; else nothing was simulated for it.
    pub shown: bool,
    /// Whether it may share a cell with another target: then everything was exact for it too.
    pub paired: bool,
    /// Whether an aircraft may stand before it.
    pub shadowed: bool,
}

/// Space of the assignment, used again from scan to scan.
#[derive(Clone, Debug, Default)]
pub(super) struct Assignment {
    /// Where each target of the last scan was.
    pub(super) placed: Vec<Placed>,
    /// Levels of each look.
    pub(super) levels: Vec<RadarLevels>,
    /// Whether a look may share a cell with another one.
    pub(super) paired: Vec<bool>,
    /// Whether any may.
    pub(super) any_pair: bool,
    /// Whether a target that is displayed is in no planned box.
    pub(super) exactly: bool,
    /// Whether ghosts of each target are looked for.
    pub(super) ghosts: Vec<bool>,
    /// Class of each target in the last scan, as a guess for this one.
    classes: Vec<u16>,
    keys: Vec<Option<Key>>,
    places: Vec<Option<u32>>,
    /// Whether no narrower box than that will be planned.
    settled: Vec<bool>,
    /// Box of each target in the last scan, as long as the planner has forgotten nothing: its place, and whether no
    /// narrower one will be planned.
    last: Vec<Option<(Key, Option<u32>, bool)>>,
    generation: u64,
    order: Vec<Place>,
    bias_m: Vec<f64>,
    ground_m: Vec<f64>,
    cells: Vec<CellView>,
}

/// A rain cell as seen from the radar.
#[derive(Clone, Copy, Debug)]
struct CellView {
    azimuth_rad: f64,
    half_rad: f64,
    near_m: f64,
    far_m: f64,
}

impl CellView {
    fn touches(&self, sector: u8, ring: i8) -> (bool, bool) {
        let middle = (f64::from(sector) + 0.5) / f64::from(SECTORS) * TAU;
        let aside = wrap_pi(self.azimuth_rad - middle).abs();
        let (near, far) = ring_m(ring);
        let on_way = aside <= self.half_rad + 0.5 * TAU / f64::from(SECTORS) && self.near_m <= far;
        (on_way, on_way && self.far_m >= near)
    }
}

/// Which sectors and rings a facade may mirror.
#[derive(Clone, Debug, Default)]
pub(super) struct Mirrored(Vec<u16>);

/// Rings with a table: to 100·2^12 m, beyond every display.
const RINGS: i8 = 24;

impl Mirrored {
    /// The table of a radar's facades.
    pub(super) fn of(radar: &Asde) -> Self {
        if radar.facades.is_empty() {
            return Self::default();
        }
        let cell = |ring: i8, sector: u8| radar.facades_of(ring, sector).next().is_some();
        let sectors = |ring: i8| (0..SECTORS).fold(0, |m, s| m | u16::from(cell(ring, s)) << s);
        Self((0..RINGS).map(sectors).collect())
    }

    fn has(&self, ring: i8, sector: u8) -> bool {
        // Inside the first ring, and beyond the table, nothing is left out anyway.
        let row = usize::try_from(ring).ok().and_then(|r| self.0.get(r));
        row.is_some_and(|sectors| sectors >> sector & 1 == 1)
    }
}

impl Asde {
    /// Facades that may mirror a target of a ring and sector: the cell as the circle that holds it, and a
    /// target's way within a scan.
    pub(super) fn facades_of(
        &self,
        ring: i8,
        sector: u8,
    ) -> impl Iterator<Item = &crate::sensors::radar::ghost::Facade> {
        const WAY_M: f64 = 150.0;
        let (near, far) = ring_m(ring);
        let middle = (f64::from(sector) + 0.5) / f64::from(SECTORS) * TAU;
        let half = 0.5 * TAU / f64::from(SECTORS);
        let (centre, cos) = (0.5 * (near + far), libm::cos(half));
        let apart = |d: f64| (d * d + centre * centre - 2.0 * d * centre * cos).max(0.0).sqrt();
        let radius_m = apart(far).max(apart(near)) + WAY_M;
        let place_m = self.site_m + Azimuth::from_rad(middle).unit() * centre;
        // The Fresnel zone on the wall, for every way that can be displayed.
        let margin_m = (self.radar.wavelength_m * (far + self.parameters.range_max_m)).sqrt();
        self.facades.iter().filter(move |f| f.may_mirror(place_m, radius_m, margin_m))
    }

    /// What the planner reads.
    pub(super) fn planner_scene<'a>(
        &'a self,
        air: &'a Air,
        tolerance: &'a Tolerance,
    ) -> PlannerScene<'a> {
        PlannerScene {
            radar: &self.radar,
            detection: Detection {
                parameters: &self.parameters,
                table: &self.table,
                steps: Planner::steps(),
                required: self.required,
                least_ratio: self.least_ratio,
            },
            correlation: self.rain_correlation,
            air,
            tolerance,
            fault: self.fault,
        }
    }

    /// Expected ghosts per scan of a target in a box, at most, and the share of the tolerated number that
    /// belongs to it.
    ///
    /// A ghost's budget is that of its range with the beam on it: no pattern gives more than the axis, no
    /// reflection more than the double amplitude.
    fn ghosts_in(&self, key: &Key, facts: &ClassFacts) -> (f64, f64) {
        let share = self.tolerance.false_plots / libm::exp2(f64::from(key.mirrored.1));
        let Some(sector) = key.mirrored.0.checked_sub(1) else { return (0.0, share) };
        let near_m = key.ground_m().0.max(1.0);
        let power = self.radar.constant * self.radar.circular_factor * facts.class.rcs_m2 * 16.0
            / (near_m * near_m * near_m * near_m)
            / self.radar.noise_w;
        let seen = |way: f64| {
            let ratio = power * way;
            let table = self.table.at(ratio) + PdTable::ERROR;
            match self.parameters.detection {
                super::DetectionRule::Bernoulli => table.min(1.0),
                super::DetectionRule::Threshold if ratio >= self.required => 1.0,
                super::DetectionRule::Threshold => 0.0,
            }
        };
        let expected = |facade: &crate::sensors::radar::ghost::Facade| {
            let (mixed, double) = ghost_power(facade.reflection(), 1.0, 1.0, 1.0);
            2.0 * seen(mixed) + seen(double)
        };
        (self.facades_of(key.ring, sector).map(expected).sum(), share)
    }

    /// The rain cells that are heavier than the rain around them, as seen from the radar.
    fn rain_seen<'a>(&'a self, air: &'a Air) -> impl Iterator<Item = CellView> + 'a {
        let uniform = air.uniform().rain_mm_per_h;
        let heavier = air.weather.cells.iter().filter(move |c| c.rain_mm_per_h > uniform);
        heavier.map(|cell| {
            let offset: Vector2<f64> = cell.centre_m - self.site_m;
            let (away, r) = (offset.norm(), cell.radius_m);
            let half_rad = if away > r { libm::asin(r / away) } else { TAU };
            let (near_m, far_m) = (away - r, away + r);
            CellView { azimuth_rad: Azimuth::of(offset).rad(), half_rad, near_m, far_m }
        })
    }

    /// What the plan leaves out for a target at a place, at most: rms shift, m, and probability of
    /// detection. Nothing where it is in no box.
    pub(super) fn left_out_at(
        &mut self,
        air: &Air,
        class: &TargetClass,
        place_m: Vector3<f64>,
    ) -> (f64, f64) {
        let mut planner = std::mem::take(&mut self.planner);
        let cells: Vec<CellView> = self.rain_seen(air).collect();
        let azimuth_rad = Azimuth::of(place_m.xy() - self.site_m).rad();
        let key = self.key_of(&mut planner, &mut 0, &cells, 0, class, place_m, azimuth_rad);
        let found = key.and_then(|key| {
            if !planner.find(key).is_some_and(|place| planner.is_settled(place, &key)) {
                let scene = self.planner_scene(air, &self.tolerance);
                planner.plan_waiting(&scene, usize::MAX, |key, facts| self.ghosts_in(key, facts));
            }
            planner.place(&key).map(|place| planner.boxes()[place as usize].plan.outcome)
        });
        self.planner = planner;
        found.map_or((0.0, 0.0), |outcome| (outcome.rms_m, outcome.detection))
    }

    /// The box of a target; `None` where everything is exact for it.
    #[expect(clippy::too_many_arguments, reason = "all parts of one target, already computed")]
    fn key_of(
        &self,
        planner: &mut Planner,
        guess: &mut u16,
        cells: &[CellView],
        size: u8,
        class: &TargetClass,
        place_m: Vector3<f64>,
        azimuth_rad: f64,
    ) -> Option<Key> {
        let ground_m2 = (place_m.xy() - self.site_m).norm_squared();
        let ring = ring(ground_m2);
        if ring < 0 {
            return None;
        }
        let height_m = place_m.z.max(0.5 * class.height_m);
        let down_m = self.radar.antenna_m - height_m;
        let slant_m = (ground_m2 + down_m * down_m).sqrt();
        let place = planner.class(class, *guess)?;
        *guess = place;
        let facts = planner.facts(place);
        // Beyond the edge nothing is displayed; so near it that errors may carry a plot over it, the plan
        // reckons with that.
        let margin_m = facts.bias_m + 8.0 * (self.most_sigma_m + facts.along_m.1);
        let shown = Span { low: self.parameters.range_min_m, high: self.parameters.range_max_m };
        if slant_m < shown.low || slant_m > shown.high {
            return None;
        }
        let edge = slant_m < shown.low + margin_m || slant_m > shown.high - margin_m;
        let sector = sector(azimuth_rad);
        let (mut rain_on_way, mut rain_here) = (false, false);
        for cell in cells {
            let (on_way, here) = cell.touches(sector, ring);
            (rain_on_way, rain_here) = (rain_on_way || on_way, rain_here || here);
        }
        let walls = self.fault != Some(super::plan::Fault::NoWalls);
        let mirrored =
            if walls && self.mirrored.has(ring, sector) { (sector + 1, size) } else { (0, 0) };
        let band = band(place_m.z);
        let part = part(ground_m2);
        Some(Key { part, class: place, ring, band, rain_on_way, rain_here, edge, mirrored })
    }

    /// Every effect at its exact level, with the table of the detection where that is tolerated.
    pub(super) fn base_levels(&self) -> RadarLevels {
        let tolerated = self.tolerance.detection >= PdTable::ERROR;
        let level = if tolerated { Level::Middle } else { Level::Exact };
        RadarLevels::EXACT.with(RadarEffect::Detection, level)
    }

    /// Gives every look its levels: new boxes are planned, up to [`MOST_NEW`] of them.
    pub(super) fn assign(
        &mut self,
        air: &Air,
        truth: &dyn Truth,
        interval: &ScanInterval,
        looks: &[Look],
        work: &mut Assignment,
    ) {
        let base = self.base_levels();
        let mut planner = std::mem::take(&mut self.planner);
        planner.begin();
        work.cells.clear();
        work.cells.extend(self.rain_seen(air));
        work.classes.resize(truth.len(), 0);
        let size = self.size_of(truth, interval);
        work.keys.clear();
        work.places.clear();
        work.settled.clear();
        if work.generation != planner.generation() {
            work.generation = planner.generation();
            work.last.clear();
        }
        for look in looks {
            let class = truth.class(look.index);
            let guess = &mut work.classes[look.index];
            let (place_m, azimuth_rad) = (look.state.position_m, look.azimuth_rad);
            let cells = &work.cells;
            let key = self.key_of(&mut planner, guess, cells, size, class, place_m, azimuth_rad);
            // A target is mostly where it was a scan ago.
            let (place, settled) =
                key.map_or((None, true), |key| match work.last.get(look.index) {
                    // What is not settled waits already.
                    Some(&Some((before, place, settled))) if before == key => (place, settled),
                    _ => {
                        let found = planner.find(key);
                        (found, found.is_some_and(|place| planner.is_settled(place, &key)))
                    }
                });
            work.keys.push(key);
            work.places.push(place);
            work.settled.push(settled);
        }
        if planner.waiting() > 0 {
            let scene = self.planner_scene(air, &self.tolerance);
            planner.plan_waiting(&scene, MOST_NEW, |key, facts| self.ghosts_in(key, facts));
        }
        work.last.clear();
        work.last.resize(truth.len(), None);
        for (i, look) in looks.iter().enumerate() {
            let Some(key) = work.keys[i] else { continue };
            if !work.settled[i] {
                work.places[i] = planner.place(&key);
                work.settled[i] = work.places[i].is_some_and(|p| planner.is_settled(p, &key));
            }
            work.last[look.index] = Some((key, work.places[i], work.settled[i]));
            let Some(place) = work.places[i] else { continue };
            if look.number == 0 {
                planner.count(place);
            }
        }
        planner.end();
        if let Some(budget_us) = self.tolerance.time_budget_us {
            planner.fit(budget_us);
        }
        self.find_pairs(truth, looks, work, &planner);
        work.exactly = false;
        work.levels.clear();
        work.placed.clear();
        for (i, place) in work.places.iter().enumerate() {
            let planned = place.filter(|_| !work.paired[i]);
            let shown = place.is_some() || self.shows(truth, &looks[i]);
            work.exactly |= shown && place.is_none();
            if looks[i].number == 0 {
                work.placed.push(Placed {
                    index: looks[i].index,
                    place: *place,
                    shown,
                    sector: sector(looks[i].azimuth_rad),
                    paired: work.paired[i],
                    shadowed: false,
                });
            }
            work.levels.push(planned.map_or(base, |p| *planner.levels(p)));
        }
        work.ghosts.clear();
        if !self.facades.is_empty() {
            for index in 0..truth.len() {
                let ghosts = truth.at(index, interval.to).is_some_and(|state| {
                    let azimuth_rad = Azimuth::of(state.position_m.xy() - self.site_m).rad();
                    let (guess, cells) = (&mut work.classes[index], &work.cells);
                    let class = truth.class(index);
                    let place_m = state.position_m;
                    let key =
                        self.key_of(&mut planner, guess, cells, size, class, place_m, azimuth_rad);
                    match key {
                        // Of no box: exact.
                        None => true,
                        Some(key) if key.mirrored.0 == 0 => false,
                        Some(key) => {
                            let place = match work.last[index] {
                                Some((before, place, _)) if before == key => place,
                                _ => planner.find(key),
                            };
                            place.is_none_or(|p| planner.levels(p).ghosts)
                        }
                    }
                });
                work.ghosts.push(ghosts);
            }
        }
        self.planner = planner;
    }

    /// Whether an echo from where a target is at a look is displayed.
    fn shows(&self, truth: &dyn Truth, look: &Look) -> bool {
        let (place_m, class) = (&look.state.position_m, truth.class(look.index));
        let down_m = self.radar.antenna_m - place_m.z.max(0.5 * class.height_m);
        let ground_m2 = (place_m.xy() - self.site_m).norm_squared();
        self.apparent_m(&self.base_levels(), (ground_m2 + down_m * down_m).sqrt()).is_some()
    }

    /// Binary logarithm of the number of targets that the radar can display, rounded up: the tolerated
    /// false plots are shared by so many.
    fn size_of(&self, truth: &dyn Truth, interval: &ScanInterval) -> u8 {
        if self.facades.is_empty() {
            return 0;
        }
        let reach_m = self.parameters.range_max_m;
        let shown = |i: &usize| {
            let state = truth.at(*i, interval.to).or_else(|| truth.at(*i, interval.from));
            state.is_some_and(|s| {
                (s.position_m.xy() - self.site_m).norm_squared() < reach_m * reach_m
            })
        };
        let n = (0..truth.len()).filter(shown).count().max(1);
        (usize::BITS - (n - 1).leading_zeros()) as u8
    }

    /// Looks that may share a cell with another one, wherever the centres of their echoes are.
    fn find_pairs(
        &self,
        truth: &dyn Truth,
        looks: &[Look],
        work: &mut Assignment,
        planner: &Planner,
    ) {
        work.paired.clear();
        work.paired.resize(looks.len(), false);
        work.any_pair = false;
        if looks.len() < 2 {
            return;
        }
        let mut widest = 0.0f64;
        work.bias_m.clear();
        work.ground_m.clear();
        work.order.clear();
        for (i, look) in (0u32..).zip(looks) {
            let class = truth.class(look.index);
            let height_m = look.state.position_m.z.max(0.5 * class.height_m);
            let down_m = self.radar.antenna_m - height_m;
            let ground_m2 = (look.state.position_m.xy() - self.site_m).norm_squared();
            let slant_m = (ground_m2 + down_m * down_m).sqrt();
            work.ground_m.push(ground_m2.sqrt());
            // How far the centre of its echo may lie from the target.
            let bias_m = match work.keys[i as usize] {
                Some(key) => planner.facts(key.class).bias_m,
                None => 0.5 * (class.length_m + class.span_m),
            };
            widest = widest.max(bias_m);
            work.bias_m.push(bias_m);
            work.order.push(Place::new(0, slant_m, i));
        }
        work.order.sort_unstable();
        let (cell_m, beam) = (self.radar.cell_m, self.radar.pattern.azimuth_rad);
        let reach = ((cell_m + 2.0 * widest) / super::PLACE_STEP_M) as u64 + 2;
        for first in 0..work.order.len() {
            let a = work.order[first];
            let one = &looks[a.index() as usize];
            let one_m = work.bias_m[a.index() as usize];
            for second in first + 1..work.order.len() {
                let b = work.order[second];
                if b.step() > a.step() + reach {
                    break;
                }
                let other = &looks[b.index() as usize];
                if one.index == other.index {
                    continue;
                }
                let biased = one_m + work.bias_m[b.index() as usize];
                let apart_m = (b.step() - a.step()) as f64 * super::PLACE_STEP_M;
                if apart_m > cell_m + biased + 2.0 * super::PLACE_STEP_M {
                    continue;
                }
                let ground_m = |place: Place| work.ground_m[place.index() as usize];
                let nearest = ground_m(a).min(ground_m(b)).max(1.0);
                let turned = (one.azimuth_rad - other.azimuth_rad).abs();
                let aside = turned.min(TAU - turned);
                if aside < beam + biased / nearest {
                    work.any_pair = true;
                    work.paired[a.index() as usize] = true;
                    work.paired[b.index() as usize] = true;
                }
            }
        }
    }
}
