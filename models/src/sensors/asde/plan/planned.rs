//! One box planned: the ladders of its effects, the choice, and what it loses.

use super::bounds::BoxBounds;
use super::class::ClassFacts;
use super::outcome::{BoxLoss, BoxOutcome, Effect, LeftOut};
use super::reflection::Refinement;
use crate::effects::choice::{Candidate, Choice, MARGIN, cheapest};
use crate::effects::{Level, Loss, Tolerance};
use crate::sensors::radar::aspect;
use crate::sensors::radar::costs;
use crate::sensors::radar::detection::{PdTable, to_db};
use crate::sensors::radar::effects::{RadarEffect, VALUES};
use crate::sensors::radar::equation::{Air, Polarisation};
use crate::sensors::radar::levels::RadarLevels;
use crate::sensors::radar::parameters::{AsdeParameters, DetectionRule};

/// What became of an effect in a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// It is not there: nobody would simulate it.
    NotThere,
    /// A faster form, equal within its stated error.
    Table,
    /// Left out, or a cheaper form, with a loss that the tolerance allows.
    LeftOut,
    /// As exact as it can be.
    Exact,
}

impl Kind {
    /// Word in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::NotThere => "not_there",
            Self::Table => "table",
            Self::LeftOut => "left_out",
            Self::Exact => "exact",
        }
    }
}

/// One effect in one box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxEffect {
    /// Which one.
    pub effect: RadarEffect,
    /// How it is simulated.
    pub level: Level,
    /// What that is.
    pub kind: Kind,
    /// What leaving it out would lose; what the level loses where it is not left out but not exact.
    pub loss: Loss,
    /// The bound of leaving it out in the unit in which it says most.
    pub shown: (f64, &'static str),
    /// Cost of the level, ns a target and scan.
    pub cost_ns: u32,
    /// Cost of the exact level.
    pub exact_ns: u32,
}

/// The plan of one box.
#[derive(Clone, Debug, PartialEq)]
pub struct BoxPlan {
    /// What is simulated there.
    pub levels: RadarLevels,
    /// Every effect of a target.
    pub effects: Vec<BoxEffect>,
    /// Sum of the losses.
    pub loss: Loss,
    /// What they may do at most.
    pub outcome: Effect,
    /// Largest share of a tolerance.
    pub share: f64,
    /// Ratio of signal to clutter and noise, dB, and largest clutter over noise.
    pub ratio_db: (f64, f64),
    /// Whether no cheaper choice is tolerated.
    pub is_best: bool,
}

impl BoxPlan {
    /// Costs of a target there, ns: simulated, and all exact.
    #[must_use]
    pub fn cost_ns(&self) -> (u64, u64) {
        let sum = |of: fn(&BoxEffect) -> u32| self.effects.iter().map(|e| u64::from(of(e))).sum();
        (sum(|e| e.cost_ns), sum(|e| e.exact_ns))
    }

    /// Time saved by effects of one kind, ns a target.
    #[must_use]
    pub fn saved_ns(&self, kind: Kind) -> u64 {
        let of = self.effects.iter().filter(|e| e.kind == kind);
        of.map(|e| u64::from(e.exact_ns.saturating_sub(e.cost_ns))).sum()
    }
}

/// A rung: the levels it sets and its loss.
#[derive(Clone, Debug, PartialEq)]
struct Rung {
    set: Vec<(RadarEffect, Level)>,
    loss: BoxLoss,
    cost_ns: u32,
}

/// The ladders of a box, and its outcome test.
#[derive(Debug)]
pub struct Prepared<'a> {
    ladders: Vec<Vec<Rung>>,
    /// Ladders of what refines the reflection: nothing of them counts where that is left out.
    refining: Vec<Vec<Rung>>,
    reflection: Rung,
    shown: Vec<(RadarEffect, Loss, (f64, &'static str))>,
    outcome: BoxOutcome<'a>,
    bounds: BoxBounds,
    tolerance: Tolerance,
    false_plots: f64,
    /// Whether there are rain cells, which costs depend on.
    cells: bool,
}

/// What the table of centroids by aspect loses: the bias moves for good, the glint with its draw.
const BY_ASPECT: Loss = Loss {
    raises_db: aspect::ERROR_DB,
    lowers_db: aspect::ERROR_DB,
    fixed_m: aspect::ERROR_M,
    own_m2: aspect::ERROR_M * aspect::ERROR_M,
    ..Loss::NONE
};

fn whole_ns(effect: RadarEffect, level: Level, cells: bool) -> u32 {
    costs::of_weather(effect, level, cells).max(0.0) as u32
}

/// What of a box is there to be simulated.
#[derive(Clone, Copy, Debug)]
pub struct Called<'a> {
    /// Parameters of the radar.
    pub parameters: &'a AsdeParameters,
    /// The weather.
    pub air: &'a Air,
    /// The class.
    pub facts: &'a ClassFacts,
    /// Expected ghosts of a target there per scan.
    pub ghosts: f64,
    /// Share of the tolerated false plots that belongs to one target.
    pub false_plots: f64,
}

impl<'a> Prepared<'a> {
    /// The ladders of a box.
    #[must_use]
    pub fn new(
        called: &Called<'_>,
        bounds: BoxBounds,
        outcome: BoxOutcome<'a>,
        tolerance: &Tolerance,
    ) -> Self {
        use Level::{Cheap, Exact, Middle, Skipped};
        use RadarEffect as E;
        let (p, air, facts) = (called.parameters, called.air, called.facts);
        let cells = !air.weather.cells.is_empty();
        let mut ladders: Vec<Vec<Rung>> = Vec::new();
        let mut shown: Vec<(RadarEffect, Loss, (f64, &'static str))> = Vec::new();
        let rung = |set: &[(RadarEffect, Level)], loss: Loss, out: LeftOut| {
            let cost_ns = set.iter().map(|(e, l)| whole_ns(*e, *l, cells)).sum();
            Rung { set: set.to_vec(), loss: BoxLoss { loss, out }, cost_ns }
        };
        let none = LeftOut::default();
        let simple = |effect: RadarEffect, loss: Loss, out: LeftOut| {
            vec![rung(&[(effect, Skipped)], loss, out), rung(&[(effect, Exact)], Loss::NONE, none)]
        };
        let mut show = |effect: RadarEffect, loss: Loss, value: f64, unit: &'static str| {
            shown.push((effect, loss, (value, unit)));
        };

        // Attenuation.
        let rain = Loss::raises(bounds.rain_db);
        let raining = air.heaviest().rain_mm_per_h > 0.0;
        let line =
            Loss { raises_db: bounds.linear_db.0, lowers_db: bounds.linear_db.1, ..Loss::NONE };
        let mut rungs = vec![rung(&[(E::RainAttenuation, Skipped)], rain, none)];
        // Without cells the whole law costs less than the line in its place.
        if raining && cells {
            rungs.push(rung(&[(E::RainAttenuation, Cheap)], line, none));
        }
        rungs.push(rung(&[(E::RainAttenuation, Exact)], Loss::NONE, none));
        ladders.push(rungs);
        show(E::RainAttenuation, rain, bounds.rain_db, "dB");
        for ((effect, value), losses) in VALUES.iter().zip(&bounds.values) {
            let levels = std::iter::once(Skipped).chain(value.worth());
            let at = |level: Level| rung(&[(*effect, level)], losses[level as usize], none);
            ladders.push(levels.map(at).collect());
            let skipped = losses[Skipped as usize];
            let moves = skipped.fixed_m > 0.0;
            let (bound, unit) = if moves { (skipped.fixed_m, "m") } else { (skipped.db(), "dB") };
            show(*effect, skipped, bound, unit);
        }

        // Clutter: powers add, decibels do not.
        let (ground, rain) = (E::GroundClutter, E::RainClutter);
        let clutter = |set: [Level; 2], db: f64| {
            rung(&[(ground, set[0]), (rain, set[1])], Loss::raises(db), none)
        };
        ladders.push(vec![
            clutter([Skipped, Skipped], bounds.clutter_db),
            clutter([Skipped, Exact], bounds.ground_db),
            clutter([Exact, Skipped], bounds.rain_clutter_db),
            clutter([Exact, Exact], 0.0),
        ]);
        show(ground, Loss::raises(bounds.ground_db), bounds.ground_db, "dB");
        show(rain, Loss::raises(bounds.rain_clutter_db), bounds.rain_clutter_db, "dB");

        // The reflection and what refines it.
        let b = &bounds.reflection;
        let coupling = p.reflection_coupling * p.azimuth_beamwidth_deg.to_radians();
        let whole = Loss {
            raises_db: b.reflection_db.0,
            lowers_db: b.reflection_db.1,
            coupled_rad: coupling * b.most,
            ..Loss::NONE
        };
        let refined = |r: Refinement| {
            let db = b.refined_db[r as usize];
            let coupled_rad = coupling * b.change[r as usize];
            Loss { raises_db: db, lowers_db: db, coupled_rad, ..Loss::NONE }
        };
        let lobing = Loss { raises_db: b.lobing_db.0, lowers_db: b.lobing_db.1, ..Loss::NONE };
        let mut refining = vec![simple(E::Lobing, lobing, none)];
        show(E::SurfaceReflection, whole, whole.db(), "dB");
        show(E::Lobing, lobing, lobing.db(), "dB");
        for (effect, refinement, skipped) in [
            (E::Roughness, Refinement::Roughness, Skipped),
            (E::WaterFilm, Refinement::Film, Skipped),
            (E::ReflectedPolarisation, Refinement::Polarisation, Cheap),
            (E::RoundEarth, Refinement::Curvature, Skipped),
        ] {
            let there = match effect {
                E::Roughness => p.roughness_m > 0.0,
                E::WaterFilm => air.weather.film_mm > 0.0,
                E::ReflectedPolarisation => p.polarisation != Polarisation::Horizontal,
                _ => true,
            };
            let loss = if there { refined(refinement) } else { Loss::NONE };
            refining.push(vec![
                rung(&[(effect, skipped)], loss, none),
                rung(&[(effect, Exact)], Loss::NONE, none),
            ]);
            show(effect, loss, loss.db(), "dB");
        }
        let mut left_out = vec![(E::SurfaceReflection, Skipped), (E::Lobing, Skipped)];
        left_out.extend(
            [E::Roughness, E::WaterFilm, E::ReflectedPolarisation, E::RoundEarth]
                .map(|e| (e, Skipped)),
        );
        let reflection = rung(&left_out, whole, none);

        // Detection.
        let threshold = p.detection == DetectionRule::Threshold;
        let table = if threshold { Loss::NONE } else { Loss::odds(PdTable::ERROR) };
        let mut rungs = vec![rung(&[(E::Detection, Exact)], Loss::NONE, none)];
        if threshold || tolerance.position_m > 0.0 {
            // What a plot states of its errors follows from its probability: where nothing may move, no table.
            rungs.insert(0, rung(&[(E::Detection, Middle)], table, none));
        }
        ladders.push(rungs);
        show(E::Detection, table, table.odds, "probability");

        // The centre of the echo and its wander; a point has neither.
        let sized = facts.class.length_m > 0.0 || facts.class.span_m > 0.0;
        let glint_m = libm::hypot(facts.along_m.1, facts.across_m.1);
        let glint = Loss { own_m2: glint_m * glint_m, ..Loss::NONE };
        let point = Loss {
            raises_db: -to_db(facts.aspect.0).min(0.0),
            lowers_db: to_db(facts.aspect.1).max(0.0),
            fixed_m: facts.bias_m,
            ..glint
        };
        let out = LeftOut { glint: sized, ..none };
        ladders.push(vec![
            rung(&[(E::Extent, Skipped), (E::Glint, Skipped)], point, out),
            rung(&[(E::Extent, Middle), (E::Glint, Skipped)], glint.plus(BY_ASPECT), out),
            rung(&[(E::Extent, Middle), (E::Glint, Exact)], BY_ASPECT, none),
            rung(&[(E::Extent, Exact), (E::Glint, Exact)], Loss::NONE, none),
        ]);
        show(E::Extent, point, facts.bias_m, "m");
        show(E::Glint, glint, glint_m, "m");

        // Thermal errors and steps.
        let (range_m, azimuth_m, steps_m) = outcome.own_m();
        for (effect, metres, out) in [
            (E::ThermalRange, range_m, LeftOut { range: true, ..none }),
            (E::ThermalAzimuth, azimuth_m, LeftOut { azimuth: true, ..none }),
        ] {
            ladders.push(simple(effect, Loss::NONE, out));
            show(effect, Loss { own_m2: metres * metres, ..Loss::NONE }, metres, "m");
        }
        let steps = Loss { own_m2: steps_m * steps_m, ..Loss::NONE };
        let out = LeftOut { steps: steps_m > 0.0, ..none };
        ladders.push(simple(E::Quantisation, Loss::NONE, out));
        show(E::Quantisation, steps, steps_m, "m");

        // Ghosts.
        let ghosts = Loss { false_plots: called.ghosts, ..Loss::NONE };
        ladders.push(simple(E::Ghosts, ghosts, none));
        show(E::Ghosts, ghosts, called.ghosts, "plots a scan");
        Self {
            ladders,
            refining,
            reflection,
            shown,
            outcome,
            bounds,
            tolerance: *tolerance,
            false_plots: called.false_plots,
            cells,
        }
    }

    /// The cheapest choice whose losses take at most `factor` of each tolerance.
    #[must_use]
    pub fn choose(&self, factor: f64) -> BoxPlan {
        let limit = factor * (1.0 + MARGIN);
        let within =
            |loss: &BoxLoss| self.outcome.fits(loss, &self.tolerance, self.false_plots, limit);
        let alone = |loss: &BoxLoss| {
            let effect = self.outcome.effect(loss, &self.tolerance, true);
            effect.share(&self.tolerance, self.false_plots)
        };
        let candidates = |ladder: &Vec<Rung>| -> Vec<Candidate<BoxLoss>> {
            ladder.iter().map(|r| Candidate { cost_ns: r.cost_ns, loss: r.loss }).collect()
        };
        let common: Vec<_> = self.ladders.iter().map(candidates).collect();
        // Branch: with the reflection and its refinements, or without all of them.
        let with: Vec<_> =
            common.iter().cloned().chain(self.refining.iter().map(candidates)).collect();
        let mut without = common;
        let only = Candidate { cost_ns: self.reflection.cost_ns, loss: self.reflection.loss };
        without.push(vec![only]);
        let base = u64::from(whole_ns(RadarEffect::SurfaceReflection, Level::Exact, self.cells));
        let exact = cheapest(&with, within, alone);
        let skipped =
            if within(&self.reflection.loss) { cheapest(&without, within, alone) } else { None };
        let reflected = match (&exact, &skipped) {
            (Some(a), Some(b)) => a.cost_ns + base <= b.cost_ns,
            (_, None) => true,
            (None, Some(_)) => false,
        };
        let choice = if reflected { exact } else { skipped };
        self.plan(choice, reflected)
    }

    /// Whether the choice at a factor on the tolerance saves so many ns a target more than a plan.
    #[must_use]
    pub fn saves_with(&self, factor: f64, ns: u64, plan: &BoxPlan) -> bool {
        self.choose(factor).cost_ns().0 + ns <= plan.cost_ns().0
    }

    fn plan(&self, choice: Option<Choice<BoxLoss>>, reflected: bool) -> BoxPlan {
        let mut levels = RadarLevels::EXACT;
        let mut chosen: Vec<(RadarEffect, Level)> = Vec::new();
        let exact = |ladder: &Vec<Rung>| ladder.len() - 1;
        let (rungs, loss, is_best) = match choice {
            Some(choice) => (choice.chosen, choice.loss, choice.is_best),
            None => {
                let all = self.ladders.iter().chain(&self.refining);
                (all.map(exact).collect(), BoxLoss::default(), true)
            }
        };
        for (ladder, &rung) in self.ladders.iter().zip(&rungs) {
            chosen.extend(&ladder[rung].set);
        }
        if reflected {
            chosen.push((RadarEffect::SurfaceReflection, Level::Exact));
            for (ladder, &rung) in self.refining.iter().zip(&rungs[self.ladders.len()..]) {
                chosen.extend(&ladder[rung].set);
            }
        } else {
            chosen.extend(&self.reflection.set);
        }
        chosen.sort_unstable_by_key(|(effect, _)| *effect);
        let mut effects = Vec::with_capacity(chosen.len());
        for (effect, level) in chosen {
            levels = levels.with(effect, level);
            let none = (effect, Loss::NONE, (0.0, "dB"));
            let &(_, left_out, shown) = self.shown.iter().find(|s| s.0 == effect).unwrap_or(&none);
            let absent = left_out == Loss::NONE && effect != RadarEffect::Detection;
            let kind = match level {
                _ if absent => Kind::NotThere,
                Level::Exact => Kind::Exact,
                Level::Middle if effect.value().is_none() => Kind::Table,
                Level::Skipped | Level::Cheap | Level::Middle => Kind::LeftOut,
            };
            let by_aspect = effect == RadarEffect::Extent && level == Level::Middle;
            effects.push(BoxEffect {
                effect,
                level,
                kind,
                loss: if by_aspect { BY_ASPECT } else { left_out },
                shown,
                cost_ns: whole_ns(effect, level, self.cells),
                exact_ns: whole_ns(effect, Level::Exact, self.cells),
            });
        }
        let outcome = self.outcome.effect(&loss, &self.tolerance, false);
        BoxPlan {
            levels,
            effects,
            loss: loss.loss,
            share: outcome.share(&self.tolerance, self.false_plots),
            outcome,
            ratio_db: (to_db(self.bounds.ratio.low), to_db(self.bounds.ratio.high)),
            is_best,
        }
    }
}
