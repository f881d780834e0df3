//! The planner of one radar: boxes met since the last weather notice, their plans, and what waits.
//!
//! A plan is a function of its box and the weather notice (with a time budget, also of one factor for
//! the whole radar). At most [`MOST_NEW`] boxes are planned in a scan, in the order of their numbers;
//! what waits is simulated exactly. Where a narrower box may leave out more, a ring is cut into parts: they are planned
//! behind all whole rings, and until then the plan of the ring holds.

use super::bounds::{BoxBounds, BoxGrid, Place};
use super::boxes::{Key, PARTS, band_m};
use super::class::ClassFacts;
use super::fault::Fault;
use super::outcome::{BoxLoss, BoxOutcome, Detection};
use super::planned::{BoxPlan, Called, Prepared};
use super::reflection::Refinement;
use crate::effects::outcome::StepTable;
use crate::effects::{Loss, Tolerance};
use crate::sensors::TargetClass;
use crate::sensors::radar::equation::{Air, Radar};
use crate::sensors::radar::levels::RadarLevels;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::OnceLock;

/// Boxes planned in one scan: a count and not a time, so that every run does the same.
pub const MOST_NEW: usize = 16;
/// Classes whose extremes are kept; a target of a further one is simulated exactly.
const MOST_CLASSES: usize = 1000;
/// Boxes kept: a target in a further one is simulated exactly.
const MOST_BOXES: usize = 20_000;
/// Boxes up to which rings are cut into parts.
const MOST_PARTED: usize = 5_000;
/// A ring is cut where twice the tolerance would save so much more, ns a target: within a ring thermal errors double.
const WORTH_NS: u64 = 10;

/// Factors on the tolerance that a time budget chooses from: four a doubling, from 1/32 to about 100.
const FACTORS: u32 = 48;

fn factor(step: u32) -> f64 {
    libm::exp2((f64::from(step) - 20.0) / 4.0)
}

/// What the planner reads of a radar and the weather.
#[derive(Clone, Copy, Debug)]
pub struct PlannerScene<'a> {
    /// The budget's constants.
    pub radar: &'a Radar,
    /// Its detection.
    pub detection: Detection<'a>,
    /// Factor on rain clutter before the detector.
    pub correlation: f64,
    /// The weather.
    pub air: &'a Air,
    /// What is tolerated.
    pub tolerance: &'a Tolerance,
    /// A fault planted on purpose.
    pub fault: Option<Fault>,
}

/// Boxes of one radar with their plans.
#[derive(Clone, Debug, Default)]
pub struct Planner {
    classes: Vec<ClassFacts>,
    /// Codes of the rings that have boxes, sorted: few enough to stay near the processor, in whose caches a tree would not.
    rings: Vec<u64>,
    /// The boxes of each of `rings`.
    known: Vec<Ring>,
    plans: Vec<PlannedBox>,
    /// Of each of `plans`: its levels, targets of this scan, and of the last one told. Beside each other, as a scan
    /// reads them for every target.
    levels: Vec<RadarLevels>,
    counts: Vec<u32>,
    told: Vec<u32>,
    waiting: BTreeSet<Key>,
    /// Plans at factors of a time budget: by box and step.
    at_factor: BTreeMap<(u32, u32), BoxPlan>,
    /// Step of the factor in force; `None` without a budget.
    step: Option<u32>,
    fitted: Option<Fitted>,
    /// Grows whenever the plans change.
    version: u64,
    generation: u64,
}

/// What a budget of time came to in a scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fitted {
    /// What the targets of the scan cost by the table, µs.
    pub cost_us: f64,
    /// The factor on the tolerance.
    pub factor: f64,
    /// Whether that is within the budget; else it is the least that there is.
    pub reached: bool,
}

/// The boxes of a ring: their places among all.
#[derive(Clone, Copy, Debug, Default)]
struct Ring {
    /// Of the whole ring and of its parts.
    places: [Option<u32>; 1 + PARTS as usize],
    /// Whether parts may have boxes of their own.
    parted: bool,
}

/// A box with its plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedBox {
    /// Which box.
    pub key: Key,
    /// Type designator of the first target of its class.
    pub class: String,
    /// Its plan.
    pub plan: BoxPlan,
    /// Whether parts of its ring may leave out more, and have boxes of their own.
    pub parted: bool,
    /// Targets in it in the last scan.
    pub targets: u32,
}

/// Factors of the steps, shared by all radars.
fn step_table() -> &'static StepTable {
    static TABLE: OnceLock<StepTable> = OnceLock::new();
    TABLE.get_or_init(StepTable::default)
}

impl Planner {
    /// Factors of the steps of an extractor.
    #[must_use]
    pub fn steps() -> &'static StepTable {
        step_table()
    }

    /// Forgets all boxes: the weather, the tolerance or the surroundings are others.
    pub fn clear(&mut self) {
        self.rings.clear();
        self.known.clear();
        self.plans.clear();
        self.levels.clear();
        self.counts.clear();
        self.told.clear();
        self.waiting.clear();
        self.at_factor.clear();
        self.version += 1;
        self.generation += 1;
    }

    /// Grows whenever all boxes are forgotten.
    #[must_use]
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// The boxes planned since the weather notice.
    #[must_use]
    pub fn boxes(&self) -> &[PlannedBox] {
        &self.plans
    }

    /// Boxes that wait for their plan.
    #[must_use]
    pub fn waiting(&self) -> usize {
        self.waiting.len()
    }

    /// Grows whenever the plans change.
    #[must_use]
    pub fn version(&self) -> u64 {
        self.version
    }

    /// The factor on the tolerance that a time budget takes; 1 without a budget.
    #[must_use]
    pub fn factor(&self) -> f64 {
        self.step.map_or(1.0, factor)
    }

    /// What the budget of time came to in the last scan; `None` without one.
    #[must_use]
    pub fn fitted(&self) -> Option<Fitted> {
        self.fitted
    }

    /// Half the diagonal of the largest class met, m.
    #[must_use]
    pub fn half_m(&self) -> f64 {
        self.classes.iter().fold(0.0, |m, facts| f64::max(m, facts.half_m()))
    }

    /// Length or span of the largest class met, m.
    #[must_use]
    pub fn longest_m(&self) -> f64 {
        self.classes.iter().fold(0.0, |m, f| f64::max(m, f.class.length_m.max(f.class.span_m)))
    }

    /// The facts of a class that was met.
    #[must_use]
    pub fn facts(&self, class: u16) -> &ClassFacts {
        &self.classes[usize::from(class)]
    }

    /// The place of a class among those met, `guess` first; made where it is new. `None` where there
    /// are too many.
    pub fn class(&mut self, class: &TargetClass, guess: u16) -> Option<u16> {
        if self.classes.get(usize::from(guess)).is_some_and(|facts| facts.is_of(class)) {
            return Some(guess);
        }
        if let Some(place) = self.classes.iter().position(|facts| facts.is_of(class)) {
            return Some(place as u16);
        }
        if self.is_full() {
            return None;
        }
        self.classes.push(ClassFacts::of(class));
        Some((self.classes.len() - 1) as u16)
    }

    /// Whether there are so many classes that a target of a further one is simulated exactly.
    #[must_use]
    pub fn is_full(&self) -> bool {
        self.classes.len() >= MOST_CLASSES
    }

    /// Forgets which targets were where.
    pub fn begin(&mut self) {
        self.counts.fill(0);
    }

    /// Tells the boxes how many targets are in them.
    pub fn end(&mut self) {
        for (place, (count, told)) in self.counts.iter().zip(&mut self.told).enumerate() {
            if count != told {
                self.plans[place].targets = *count;
                *told = *count;
            }
        }
    }

    /// What is simulated for a target in the box at a place.
    #[must_use]
    pub fn levels(&self, place: u32) -> &RadarLevels {
        &self.levels[place as usize]
    }

    /// The place of a box among [`Self::boxes`], or that of its whole ring as long as there is none; `None`
    /// where both are new. What is new waits. Beside it: whether no narrower box will be planned.
    pub fn find(&mut self, key: Key) -> (Option<u32>, bool) {
        let (place, settled) = self.place(&key);
        if !settled {
            let room = self.plans.len() + self.waiting.len();
            if place.is_none() && room < MOST_BOXES {
                self.waiting.insert(key.whole());
            }
            if room < MOST_PARTED {
                self.waiting.insert(key);
            }
        }
        (place, settled)
    }

    /// The place of a box among [`Self::boxes`], or that of its whole ring, and whether no narrower box will be
    /// planned.
    #[must_use]
    pub fn place(&self, key: &Key) -> (Option<u32>, bool) {
        let Ok(ring) = self.rings.binary_search(&key.whole().code()) else {
            return (None, false);
        };
        let Ring { places, parted } = self.known[ring];
        let own = places[usize::from(key.part)];
        let place = own.or(places[0]);
        let full = self.plans.len() >= MOST_PARTED;
        (place, place.is_some() && (own.is_some() || !parted || full))
    }

    /// Counts a target in a box.
    pub fn count(&mut self, place: u32) {
        self.counts[place as usize] += 1;
    }

    /// Plans boxes that wait, at most `most` of them. `ghosts` gives the expected ghosts of a target of
    /// a class in a box.
    pub fn plan_waiting(
        &mut self,
        scene: &PlannerScene<'_>,
        most: usize,
        ghosts: impl Fn(&Key, &ClassFacts) -> (f64, f64),
    ) {
        let mut planned = 0;
        while planned < most {
            let Some(key) = self.waiting.pop_first() else { return };
            if key.part > 0 {
                // Only where the ring's own plan, which is made before, says that it is worth it.
                let whole = self.place(&key.whole()).0;
                if whole.is_none_or(|place| !self.plans[place as usize].parted) {
                    continue;
                }
            }
            planned += 1;
            let facts = &self.classes[usize::from(key.class)];
            let prepared = prepare(scene, &key, facts, ghosts(&key, facts));
            let plan = match (&prepared, scene.tolerance.time_budget_us) {
                (Some(prepared), None) => Some(prepared.choose(1.0)),
                (Some(prepared), Some(_)) => {
                    // All of its front at once: afterwards only the factor changes.
                    let place = self.plans.len() as u32;
                    for step in 0..FACTORS {
                        self.at_factor.insert((place, step), prepared.choose(factor(step)));
                    }
                    Some(prepared.choose(0.0))
                }
                (None, _) => None,
            };
            if let Some(plan) = plan {
                let class = facts.class.designator.clone();
                let whole = key.part == 0 && scene.tolerance.time_budget_us.is_none();
                let parted = whole && prepared.is_some_and(|p| p.saves_with(2.0, WORTH_NS, &plan));
                let code = key.whole().code();
                let ring = self.rings.binary_search(&code).unwrap_or_else(|ring| {
                    self.rings.insert(ring, code);
                    self.known.insert(ring, Ring::default());
                    ring
                });
                let ring = &mut self.known[ring];
                ring.places[usize::from(key.part)] = Some(self.plans.len() as u32);
                ring.parted |= parted;
                self.levels.push(plan.levels);
                self.counts.push(0);
                self.told.push(0);
                self.plans.push(PlannedBox { key, class, plan, parted, targets: 0 });
                self.version += 1;
            }
        }
    }

    /// With a time budget: takes the least factor at which the targets of this scan cost no more, or the largest where
    /// none is enough. `fixed_ns` is what they cost whatever the factor is; for those in the boxes `beside`, one entry
    /// each, that is everything.
    pub fn fit(&mut self, budget_us: f64, fixed_ns: f64, beside: &[u32]) {
        let mut targets: Vec<u32> = self.plans.iter().map(|b| b.targets).collect();
        for place in beside {
            targets[*place as usize] = targets[*place as usize].saturating_sub(1);
        }
        let cost = |step: u32| -> f64 {
            let boxes = (0..).zip(&self.plans).zip(&targets).filter(|(_, n)| **n > 0);
            let of_boxes = boxes.map(|((place, b), n)| {
                let plan = self.at_factor.get(&(place, step)).unwrap_or(&b.plan);
                plan.cost_ns().0 as f64 * f64::from(*n)
            });
            fixed_ns + of_boxes.sum::<f64>()
        };
        let (mut low, mut high) = (0, FACTORS - 1);
        while low < high {
            let middle = (low + high) / 2;
            if cost(middle) <= budget_us * 1000.0 {
                high = middle;
            } else {
                low = middle + 1;
            }
        }
        let cost_us = cost(low) / 1000.0;
        self.fitted = Some(Fitted { cost_us, factor: factor(low), reached: cost_us <= budget_us });
        if self.step != Some(low) {
            self.step = Some(low);
            self.version += 1;
        }
        for ((place, planned), levels) in (0..).zip(&mut self.plans).zip(&mut self.levels) {
            if let Some(plan) = self.at_factor.get(&(place, low))
                && planned.plan != *plan
            {
                planned.plan = plan.clone();
                *levels = plan.levels;
            }
        }
    }
}

/// The place that a box takes in the physics, cut to what the radar displays; `None` where it displays
/// nothing of it.
fn place_of(scene: &PlannerScene<'_>, key: &Key, facts: &ClassFacts) -> Option<Place> {
    let p = scene.detection.parameters;
    let (low, high) = band_m(key.band);
    let half_m = 0.5 * facts.class.height_m;
    let height_m = (low.max(half_m), high.max(half_m));
    let height_m = if key.band == 0 { (half_m, high.max(half_m)) } else { height_m };
    let (near, far) = key.ground_m();
    let down =
        (scene.radar.antenna_m - height_m.0).abs().max((scene.radar.antenna_m - height_m.1).abs());
    let shown = (p.range_min_m * p.range_min_m - down * down).max(0.0).sqrt();
    let (near, far) = (near.max(shown), far.min(p.range_max_m));
    // Echoes from beyond the unambiguous range are seen nearer than they are.
    let near = near.min(far);
    let (rain_on_way, rain_here) = (key.rain_on_way, key.rain_here);
    (near > 0.0 && far >= near).then_some(Place {
        ground_m: (near, far),
        height_m,
        rain_on_way,
        rain_here,
    })
}

/// The ladders of a box; `None` where everything is exact.
pub fn prepare<'a>(
    scene: &PlannerScene<'a>,
    key: &Key,
    facts: &ClassFacts,
    (ghosts, false_plots): (f64, f64),
) -> Option<Prepared<'a>> {
    let place = place_of(scene, key, facts)?;
    let mut facts = facts.clone();
    match scene.fault {
        Some(Fault::NoExtent) => {
            (facts.bias_m, facts.aspect) = (0.0, (1.0, 1.0));
            (facts.along_m, facts.across_m) = ((0.0, 0.0), (0.0, 0.0));
        }
        Some(Fault::LeastGlint) => {
            (facts.along_m.1, facts.across_m.1) = (facts.along_m.0, facts.across_m.0);
        }
        _ => (),
    }
    let facts = &facts;
    let grid = BoxGrid::new(scene.radar, scene.air, scene.correlation, facts, place);
    let mut bounds = grid.bounds(Refinement::ANY);
    let test = |bounds: &BoxBounds| {
        BoxOutcome::new(&scene.detection, facts, bounds, place.ground_m.0, scene.tolerance)
    };
    let mut outcome = test(&bounds);
    if scene.tolerance.time_budget_us.is_none() {
        // What cannot be left out even alone is exact, and the others need not reckon with it.
        let fits = |r: &Refinement| {
            let db = bounds.reflection.refined_db[*r as usize];
            let loss = Loss { raises_db: db, lowers_db: db, ..Loss::NONE };
            let loss = BoxLoss { loss, ..BoxLoss::default() };
            outcome.fits(&loss, scene.tolerance, false_plots, 1.0)
        };
        let open = Refinement::ALL.iter().filter(|r| fits(r)).fold(0, |m, r| m | 1 << *r as usize);
        if open != Refinement::ANY {
            bounds = grid.bounds(open);
            outcome = test(&bounds);
        }
    }
    match scene.fault {
        Some(Fault::PolarisationAtOneEnd) => {
            let of = Refinement::Polarisation as usize;
            let end = grid.far_end(Refinement::ANY).refined_db[of];
            bounds.reflection.refined_db[of] = 0.1 * end;
        }
        Some(Fault::NoFlips) => outcome.without_flips(),
        _ => (),
    }
    let called = Called {
        parameters: scene.detection.parameters,
        air: scene.air,
        facts,
        ghosts,
        false_plots,
    };
    Some(Prepared::new(&called, bounds, outcome, scene.tolerance))
}
