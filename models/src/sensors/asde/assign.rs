//! Which level each look gets: by the plan of its box, its neighbours, and what stands before it.

use super::looks::{End, Look};
use super::pairs::{Near, Pairs};
use super::plan::boxes::{Key, SECTORS, band, part, ring, ring_m, sector};
use super::plan::class::ClassFacts;
use super::plan::outcome::Detection;
use super::plan::planner::{MOST_NEW, Planner, PlannerScene};
use super::plan::{BoxEffect, Kind};
use super::{Air, Asde, Tolerance, Truth};
use crate::effects::Level;
use crate::frames::{Azimuth, Point2, Point3, Vector2, wrap_pi};
use crate::sensors::TargetClass;
use crate::sensors::radar::costs;
use crate::sensors::radar::detection::PdTable;
use crate::sensors::radar::effects::RadarEffect;
use crate::sensors::radar::ghost::{Facade, ghost_power};
use crate::sensors::radar::levels::RadarLevels;
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
    /// The box of each look, by its place among those of the planner; `None` where everything is exact.
    pub(super) places: Vec<Option<u32>>,
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
    /// Looks whose box is still to be planned, what was placed before them, and those boxes.
    open: Vec<(u32, u32, Key)>,
    /// The box in which each target was when it was last looked at, as long as the planner has forgotten nothing.
    last: Vec<Option<Found>>,
    generation: u64,
    pairs: Pairs,
    cells: Vec<CellView>,
}

/// A box and its place among those of the planner. Once settled, no narrower box will be planned.
#[derive(Clone, Copy, Debug)]
struct Found {
    code: u64,
    place: Option<u32>,
    settled: bool,
}

impl Found {
    fn of(key: &Key, (place, settled): (Option<u32>, bool)) -> Self {
        Self { code: key.code(), place, settled }
    }
}

/// Where a target is seen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    place_m: Point2<f64>,
    ground_m2: f64,
    slant_m: f64,
    up_m: f64,
    /// Of the middle of its body.
    height_m: f64,
    sector: u8,
}

impl Assignment {
    /// Room for so many targets; what is remembered of their boxes stays while the planner's generation does.
    fn begin(&mut self, targets: usize, generation: u64) {
        self.placed.clear();
        self.places.clear();
        self.exactly = false;
        self.ghosts.clear();
        self.classes.resize(targets, 0);
        self.open.clear();
        if self.generation != generation {
            self.generation = generation;
            self.last.clear();
        }
        self.last.resize(targets, None);
        self.pairs.clear();
        self.cells.clear();
    }
}

/// A rain cell as seen from the radar.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellView {
    azimuth_rad: f64,
    half_rad: f64,
    near_m: f64,
    far_m: f64,
}

impl CellView {
    pub(super) fn touches(&self, sector: u8, ring: i8) -> (bool, bool) {
        let middle = (f64::from(sector) + 0.5) / f64::from(SECTORS) * TAU;
        let aside = wrap_pi(self.azimuth_rad - middle).abs();
        let (near, far) = ring_m(ring);
        let on_way = aside <= self.half_rad + 0.5 * TAU / f64::from(SECTORS) && self.near_m <= far;
        (on_way, on_way && self.far_m >= near)
    }
}

/// Which facades may mirror which sectors and rings: a bit each, the last one for all that have none of their own.
#[derive(Clone, Debug, Default)]
pub(super) struct Mirrored(Vec<[u64; SECTORS as usize]>);

/// Rings with a table: to 100·2^12 m, beyond every display.
const RINGS: i8 = 24;

impl Mirrored {
    /// The table of a radar's facades.
    pub(super) fn of(radar: &Asde) -> Self {
        if radar.facades.is_empty() {
            return Self::default();
        }
        let cell = |ring: i8, sector: usize| {
            let facades = radar.facades_of(ring, sector as u8);
            facades.fold(0, |bits, (place, _)| bits | Self::bit(place))
        };
        Self((0..RINGS).map(|ring| std::array::from_fn(|sector| cell(ring, sector))).collect())
    }

    fn bit(facade: usize) -> u64 {
        1 << facade.min(63)
    }

    /// Inside the first ring, and beyond the table, nothing is left out anyway.
    fn at(&self, ring: i8, sector: u8) -> u64 {
        let row = usize::try_from(ring).ok().and_then(|ring| self.0.get(ring));
        row.map_or(0, |sectors| sectors[usize::from(sector)])
    }
}

impl Asde {
    /// Facades that may mirror a target of a ring and sector: the cell as the circle that holds it, and a
    /// target's way within a scan.
    pub(super) fn facades_of(
        &self,
        ring: i8,
        sector: u8,
    ) -> impl Iterator<Item = (usize, &Facade)> {
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
        let all = self.facades.iter().enumerate();
        all.filter(move |(_, f)| f.may_mirror(place_m, radius_m, margin_m))
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
    pub(super) fn ghosts_in(&self, key: &Key, facts: &ClassFacts) -> (f64, f64) {
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
        let expected = |(_, facade): (usize, &Facade)| {
            let (mixed, double) = ghost_power(facade.reflection(), 1.0, 1.0, 1.0);
            2.0 * seen(mixed) + seen(double)
        };
        (self.facades_of(key.ring, sector).map(expected).sum(), share)
    }

    /// The rain cells that are heavier than the rain around them, as seen from the radar.
    pub(super) fn rain_seen<'a>(&'a self, air: &'a Air) -> impl Iterator<Item = CellView> + 'a {
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
        place_m: Point3<f64>,
    ) -> (f64, f64) {
        let mut planner = std::mem::take(&mut self.planner);
        let cells: Vec<CellView> = self.rain_seen(air).collect();
        let azimuth_rad = Azimuth::of(place_m.xy() - self.site_m).rad();
        let sight = self.sight(class, place_m, azimuth_rad);
        let key = self.key_of(&mut planner, &mut 0, &cells, 0, class, &sight);
        let found = key.and_then(|key| {
            if !planner.find(key).1 {
                let scene = self.planner_scene(air, &self.tolerance);
                planner.plan_waiting(&scene, usize::MAX, |key, facts| self.ghosts_in(key, facts));
            }
            planner.place(&key).0.map(|place| planner.boxes()[place as usize].plan.outcome)
        });
        self.planner = planner;
        found.map_or((0.0, 0.0), |outcome| (outcome.rms_m, outcome.detection))
    }

    /// Where a target of a class is seen from the radar.
    pub(super) fn sight(
        &self,
        class: &TargetClass,
        place_m: Point3<f64>,
        azimuth_rad: f64,
    ) -> Sight {
        let ground_m2 = (place_m.xy() - self.site_m).norm_squared();
        let height_m = place_m.z.max(0.5 * class.height_m);
        let down_m = self.radar.antenna_m - height_m;
        Sight {
            place_m: place_m.xy(),
            ground_m2,
            slant_m: (ground_m2 + down_m * down_m).sqrt(),
            up_m: place_m.z,
            height_m,
            sector: sector(azimuth_rad),
        }
    }

    /// The box of a target; `None` where everything is exact for it.
    pub(super) fn key_of(
        &self,
        planner: &mut Planner,
        guess: &mut u16,
        cells: &[CellView],
        size: u8,
        class: &TargetClass,
        sight: &Sight,
    ) -> Option<Key> {
        let ring = ring(sight.ground_m2);
        if ring < 0 {
            return None;
        }
        let place = planner.class(class, *guess)?;
        *guess = place;
        if !self.shown().contains(sight.slant_m) {
            return None;
        }
        let sector = sight.sector;
        let (mut rain_on_way, mut rain_here) = (false, false);
        for cell in cells {
            let (on_way, here) = cell.touches(sector, ring);
            (rain_on_way, rain_here) = (rain_on_way || on_way, rain_here || here);
        }
        let mirrored = if self.is_mirrored(ring, sight) { (sector + 1, size) } else { (0, 0) };
        let band = band(sight.up_m);
        let part = part(sight.ground_m2);
        Some(Key { part, class: place, ring, band, rain_on_way, rain_here, mirrored })
    }

    /// Whether a facade mirrors what is there: of those that may in its sector and ring, whether the ray meets one.
    fn is_mirrored(&self, ring: i8, sight: &Sight) -> bool {
        let facades = self.mirrored.at(ring, sight.sector);
        if facades == 0 || self.fault == Some(super::plan::Fault::NoWalls) {
            return false;
        }
        let meets = |facade: &Facade| {
            let (antenna_m, wavelength_m) = (self.radar.antenna_m, self.radar.wavelength_m);
            facade.ghost(antenna_m, sight.place_m, sight.height_m, wavelength_m).is_some()
        };
        let all = self.facades.iter().enumerate();
        all.filter(|(place, _)| facades & Mirrored::bit(*place) > 0)
            .any(|(_, facade)| meets(facade))
    }

    /// Every effect at its exact level, with the table of the detection where that is tolerated: not where nothing may
    /// move, since what a plot states of its errors follows from its probability, and bends its arc.
    pub(super) fn base_levels(&self) -> RadarLevels {
        let Tolerance { detection, position_m, .. } = self.tolerance;
        let tolerated = detection >= PdTable::ERROR && position_m > 0.0;
        let level = if tolerated { Level::Middle } else { Level::Exact };
        RadarLevels::EXACT.with(RadarEffect::Detection, level)
    }

    /// Gives every look its box: new ones are planned, up to [`MOST_NEW`] of them. `ends` is where each target is
    /// at the end of the scan, `shadowed` whether an aircraft may stand before it.
    pub(super) fn assign(
        &mut self,
        air: &Air,
        truth: &dyn Truth,
        looks: &[Look],
        ends: &[Option<End>],
        shadowed: &dyn Fn(&Look) -> bool,
        work: &mut Assignment,
    ) {
        let mut planner = std::mem::take(&mut self.planner);
        planner.begin();
        work.begin(truth.len(), planner.generation());
        work.cells.extend(self.rain_seen(air));
        let base = self.base_levels();
        let size = self.size_of(ends);
        for (i, look) in (0u32..).zip(looks) {
            let class = truth.class(look.index);
            let sight = self.sight(class, look.state.position_m, look.azimuth_rad);
            let guess = &mut work.classes[look.index];
            let key = self.key_of(&mut planner, guess, &work.cells, size, class, &sight);
            // How far the centre of its echo may lie from the target.
            let bias_m = match key {
                Some(key) => planner.facts(key.class).bias_m,
                None => 0.5 * (class.length_m + class.span_m),
            };
            let near =
                Near { azimuth_rad: look.azimuth_rad, ground_m: sight.ground_m2.sqrt(), bias_m };
            work.pairs.add(look.index, sight.slant_m, near);
            let place = key.and_then(|key| {
                // A target is mostly where it was a scan ago.
                let (last, code) = (&mut work.last[look.index], key.code());
                let found = match *last {
                    Some(found) if found.code == code => found,
                    _ => *last.insert(Found::of(&key, planner.find(key))),
                };
                if !found.settled {
                    work.open.push((i, work.placed.len() as u32, key));
                } else if let (Some(place), 0) = (found.place, look.number) {
                    planner.count(place);
                }
                found.place
            });
            work.places.push(place);
            let shown = key.is_some() || self.apparent_m(&base, sight.slant_m).is_some();
            work.exactly |= shown && key.is_none();
            if look.number == 0 {
                work.placed.push(Placed {
                    index: look.index,
                    place,
                    shown,
                    sector: sight.sector,
                    paired: false,
                    shadowed: shadowed(look),
                });
            }
        }
        if planner.waiting() > 0 {
            let scene = self.planner_scene(air, &self.tolerance);
            planner.plan_waiting(&scene, MOST_NEW, |key, facts| self.ghosts_in(key, facts));
        }
        for &(i, placed, key) in &work.open {
            let look = &looks[i as usize];
            let found = planner.place(&key);
            let place = found.0;
            work.places[i as usize] = place;
            work.last[look.index] = Some(Found::of(&key, found));
            work.exactly |= place.is_none();
            if look.number == 0 {
                work.placed[placed as usize].place = place;
                if let Some(place) = place {
                    planner.count(place);
                }
            }
        }
        planner.end();
        let (cell_m, beam) = (self.radar.cell_m, self.radar.pattern.azimuth_rad);
        work.any_pair = work.pairs.find(cell_m, beam, &mut work.paired);
        if work.any_pair {
            let firsts = looks.iter().zip(&work.paired).filter(|(look, _)| look.number == 0);
            for (placed, (_, paired)) in work.placed.iter_mut().zip(firsts) {
                placed.paired = *paired;
            }
        }
        if let Some(budget_us) = self.tolerance.time_budget_us {
            let beside = work.placed.iter().filter(|p| p.paired).filter_map(|p| p.place);
            let (fixed_ns, beside) =
                (self.fixed_ns(&planner, air, &work.placed), beside.collect::<Vec<_>>());
            planner.fit(budget_us, fixed_ns, &beside);
        }
        if !self.facades.is_empty() {
            for (index, end) in ends.iter().enumerate() {
                let ghosts = end.filter(|end| end.there).is_some_and(|end| {
                    self.may_have_ghosts(&mut planner, truth, index, &end, size, work)
                });
                work.ghosts.push(ghosts);
            }
        }
        self.planner = planner;
    }

    /// What the targets of a scan cost by the table whatever is tolerated, ns: what is around each of them, and
    /// everything where one is in no box or beside another.
    fn fixed_ns(&self, planner: &Planner, air: &Air, placed: &[Placed]) -> f64 {
        use RadarEffect as E;
        let cells = !air.weather.cells.is_empty();
        let exact = |effect: E| costs::of_weather(effect, Level::Exact, cells);
        let boxed = || {
            let alone = placed.iter().filter(|p| p.shown && !p.paired).filter_map(|p| p.place);
            alone.map(|place| &planner.boxes()[place as usize].plan.effects)
        };
        let nowhere = |effect: E| {
            let absent = |e: &BoxEffect| e.effect == effect && e.kind == Kind::NotThere;
            boxed().next().is_some() && boxed().all(|effects| effects.iter().any(absent))
        };
        let of_target = |effect: &E| match effect {
            E::BuildingShadow | E::AircraftShadow | E::Merging | E::FalseAlarms => 0.0,
            E::Processing | E::SecondTrace => 0.0,
            E::Detection => costs::of(E::Detection, Level::Middle),
            effect if nowhere(*effect) => 0.0,
            effect => exact(*effect),
        };
        let all_ns: f64 = E::ALL.iter().map(of_target).sum();
        let of = |p: &Placed| {
            let alone = p.place.is_some() && !p.paired;
            let parts = [
                (true, exact(E::FalseAlarms)),
                (!self.buildings.is_empty(), exact(E::BuildingShadow)),
                (p.shadowed, exact(E::AircraftShadow)),
                (p.paired, exact(E::Merging)),
                (!alone, all_ns),
            ];
            parts.iter().filter(|(there, _)| *there).map(|(_, ns)| ns).sum::<f64>()
        };
        placed.iter().filter(|p| p.shown).map(of).sum()
    }

    /// Whether ghosts of a target are looked for.
    fn may_have_ghosts(
        &self,
        planner: &mut Planner,
        truth: &dyn Truth,
        index: usize,
        end: &End,
        size: u8,
        work: &mut Assignment,
    ) -> bool {
        let class = truth.class(index);
        let sight = self.sight(class, end.place_m, end.azimuth_rad);
        let ring = ring(sight.ground_m2);
        if ring >= 0 && self.shown().contains(sight.slant_m) && !planner.is_full() {
            // Whatever its class is.
            if self.mirrored.at(ring, sight.sector) == 0 {
                return false;
            }
        }
        let guess = &mut work.classes[index];
        let Some(key) = self.key_of(planner, guess, &work.cells, size, class, &sight) else {
            // Of no box: exact.
            return true;
        };
        if key.mirrored.0 == 0 {
            return false;
        }
        let place = match work.last[index] {
            Some(found) if found.code == key.code() && found.settled => found.place,
            Some(found) if found.code == key.code() => planner.place(&key).0,
            _ => planner.find(key).0,
        };
        place.is_none_or(|place| planner.levels(place).ghosts)
    }

    /// What is simulated for a look: what its box says; everything exactly where it has none, and where it may share
    /// a cell.
    pub(super) fn planned_levels(&self, work: &Assignment, look: usize) -> RadarLevels {
        match work.places[look] {
            Some(place) if !work.paired[look] => *self.planner.levels(place),
            _ => self.base_levels(),
        }
    }

    /// Binary logarithm of the number of targets that the radar can display, rounded up: the tolerated
    /// false plots are shared by so many.
    fn size_of(&self, ends: &[Option<End>]) -> u8 {
        if self.facades.is_empty() {
            return 0;
        }
        let reach_m = self.parameters.range_max_m;
        let shown =
            |end: &&End| (end.place_m.xy() - self.site_m).norm_squared() < reach_m * reach_m;
        let n = ends.iter().flatten().filter(shown).count().max(1);
        (usize::BITS - (n - 1).leading_zeros()) as u8
    }
}
