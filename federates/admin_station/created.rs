//! Entities that somebody had created by Create Entity: pending until Set Data has given them a place, then told of as
//! any outsider's are, so that the member `visitors` lets them in.
//!
//! They move straight on in simulated time, stand while they are frozen, and are forgotten with the run.

use crate::exchange::weather_pdu::WORLD_APPLICATION;
use crate::runtime::messages::Frame;
use pdu::enumerations::{AirAppearance, DatumId, DeadReckoningAlgorithm, EntityKind, ForceId};
use pdu::records::{
    EntityId, EntityType, FixedDatum, Location, Marking, Orientation, VariableDatum, Vector32,
};
use pdu::{EncodeError, EntityState, Envelope, List};
use std::collections::{BTreeMap, BTreeSet};

/// Entities at a time, at most.
const MOST: usize = 256;

/// An entity is told of as often, and whenever something of it changes.
const TELL_EVERY_NS: u64 = 4_000_000_000;

/// Distances from the centre of the earth at which an entity may be, m.
const RADIUS_M: std::ops::RangeInclusive<f64> = 6.3e6..=6.5e6;

/// Highest speed along an axis, m/s.
const SPEED_MPS: f32 = 1_000.0;

/// What was taken of a Set Data: fixed and variable datums, as they came.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Taken {
    /// Fixed ones.
    pub(super) fixed: Vec<FixedDatum>,
    /// Variable ones.
    pub(super) variable: Vec<(DatumId, Vec<u8>)>,
}

/// The entities.
pub(super) struct Created {
    site: u16,
    /// Entities of the scene: (application, number).
    own: BTreeSet<(u16, u16)>,
    made: BTreeMap<EntityId, Made>,
}

struct Made {
    /// As it was in frame `since`.
    state: EntityState<'static>,
    placed: bool,
    frozen: bool,
    since: Frame,
    /// When it is told of again; none once it was told of while nothing has changed and it is pending.
    tell_ns: u64,
}

impl Made {
    /// Where it is in `frame`.
    fn location(&self, frame: Frame, step_s: f64) -> Location {
        let s = if self.frozen { 0.0 } else { frame.saturating_sub(self.since) as f64 * step_s };
        let v = self.state.linear_velocity_mps.to_f64();
        let at = self.state.location;
        Location { x_m: at.x_m + v[0] * s, y_m: at.y_m + v[1] * s, z_m: at.z_m + v[2] * s }
    }

    /// What changes from `frame` on begins where it is then.
    fn rebase(&mut self, frame: Frame, step_s: f64) {
        self.state.location = self.location(frame, step_s);
        self.since = frame;
        self.tell_ns = 0;
    }

    fn told(&self, frame: Frame, step_s: f64) -> EntityState<'static> {
        let stands = self.frozen || self.state.linear_velocity_mps == Vector32::default();
        let mut state = self.state.clone();
        state.location = self.location(frame, step_s);
        state.appearance = AirAppearance(state.appearance).with_frozen(self.frozen).0;
        if stands {
            state.linear_velocity_mps = Vector32::default();
        }
        state.dead_reckoning_algorithm = match stands {
            true => DeadReckoningAlgorithm::STATIC,
            false => DeadReckoningAlgorithm::FPW,
        };
        state
    }
}

impl Created {
    /// None yet, in a scene whose entities at `site` are `own`.
    pub(super) fn new(site: u16, own: BTreeSet<(u16, u16)>) -> Self {
        Self { site, own, made: BTreeMap::new() }
    }

    /// A new run begins without them.
    pub(super) fn clear(&mut self) {
        self.made.clear();
    }

    /// Whether this is one of them.
    pub(super) fn has(&self, id: EntityId) -> bool {
        self.made.contains_key(&id)
    }

    /// Whether this is an entity of the scene, which nobody else may change.
    pub(super) fn is_own(&self, id: EntityId) -> bool {
        id.site == self.site && self.own.contains(&(id.application, id.entity))
    }

    /// Whether an entity of this identifier would be for us to create: of a partition of this site.
    pub(super) fn ours(&self, id: EntityId) -> bool {
        id.site == self.site && (1..WORLD_APPLICATION).contains(&id.application)
    }

    /// A pending entity; false if it is there, is one of the scene, has no number of its own, or if there are too many.
    pub(super) fn create(&mut self, id: EntityId) -> bool {
        let number = (1..0xffff).contains(&id.entity);
        if !self.ours(id) || !number || self.is_own(id) || self.has(id) || self.made.len() >= MOST {
            return false;
        }
        let state = EntityState {
            entity_id: id,
            force_id: ForceId::NEUTRAL,
            // A vehicle on the ground, until something else is said.
            entity_type: EntityType::new(EntityKind::PLATFORM.0, 1, 0, 0, 0, 0, 0),
            ..EntityState::default()
        };
        let made = Made { state, placed: false, frozen: false, since: 0, tell_ns: 0 };
        self.made.insert(id, made);
        true
    }

    /// Removes whom `whom` names or stands for; their last PDUs, if any of them was ours.
    pub(super) fn remove(
        &mut self,
        whom: EntityId,
        frame: Frame,
        (step_s, envelope): (f64, &Envelope),
    ) -> Option<Result<Vec<Vec<u8>>, EncodeError>> {
        let ids: Vec<_> = self.made.keys().copied().filter(|id| whom.addresses(*id)).collect();
        let gone: Vec<Made> = ids.iter().filter_map(|id| self.made.remove(id)).collect();
        let last = |made: &Made| {
            let mut state = made.told(frame, step_s);
            state.appearance = AirAppearance(state.appearance).with_deactivated(true).0;
            encoded(envelope, &state)
        };
        (!gone.is_empty()).then(|| gone.iter().filter(|made| made.placed).map(last).collect())
    }

    /// Stops one of them in `frame`, or lets it go on.
    pub(super) fn freeze(&mut self, id: EntityId, frozen: bool, frame: Frame, step_s: f64) {
        if let Some(made) = self.made.get_mut(&id) {
            made.rebase(frame, step_s);
            made.frozen = frozen;
        }
    }

    /// Sets what is understood of the datums, from `frame` on; what is not sound or not known changes nothing.
    pub(super) fn set(
        &mut self,
        id: EntityId,
        (frame, step_s): (Frame, f64),
        fixed: &List<'_, FixedDatum>,
        variable: &List<'_, VariableDatum<'_>>,
    ) -> Taken {
        let mut taken = Taken::default();
        let Some(made) = self.made.get_mut(&id) else { return taken };
        made.rebase(frame, step_s);
        for datum in fixed.iter().filter(|datum| set_fixed(&mut made.state, *datum).is_some()) {
            taken.fixed.push(datum);
        }
        for datum in variable.iter() {
            let place = datum.id == DatumId::ENTITY_LOCATION;
            if set_variable(&mut made.state, datum).is_some() {
                made.placed |= place;
                taken.variable.push((datum.id, datum.value.to_vec()));
            }
        }
        taken
    }

    /// What Data says of one of them in `frame`.
    pub(super) fn data(&self, id: EntityId, frame: Frame, step_s: f64) -> Taken {
        let Some(made) = self.made.get(&id) else { return Taken::default() };
        let state = made.told(frame, step_s);
        let place = state.location;
        let xyz = [place.x_m, place.y_m, place.z_m].map(f64::to_be_bytes).concat();
        let v = state.linear_velocity_mps;
        let velocity = [v.x, v.y, v.z].map(f32::to_be_bytes).concat();
        let marking = state.marking.octets.to_vec();
        let fixed = vec![FixedDatum::from_u32(DatumId::ENTITY_APPEARANCE, state.appearance)];
        let placed = made.placed.then_some((DatumId::ENTITY_LOCATION, xyz));
        let rest = [
            (DatumId::ENTITY_LINEAR_VELOCITY, velocity),
            (DatumId::ENTITY_MARKING_11_BYTES, marking),
        ];
        Taken { fixed, variable: placed.into_iter().chain(rest).collect() }
    }

    /// The PDUs that are due.
    pub(super) fn due(
        &mut self,
        now_ns: u64,
        frame: Frame,
        (step_s, envelope): (f64, &Envelope),
    ) -> Result<Vec<Vec<u8>>, EncodeError> {
        let mut out = Vec::new();
        for made in self.made.values_mut().filter(|m| m.placed && now_ns >= m.tell_ns) {
            made.tell_ns = now_ns + TELL_EVERY_NS;
            out.push(encoded(envelope, &made.told(frame, step_s))?);
        }
        Ok(out)
    }
}

fn encoded(envelope: &Envelope, state: &EntityState<'_>) -> Result<Vec<u8>, EncodeError> {
    let mut octets = Vec::new();
    envelope.append(state, &mut octets)?;
    Ok(octets)
}

fn set_fixed(state: &mut EntityState<'_>, datum: FixedDatum) -> Option<()> {
    let small = || u8::try_from(datum.as_u32()).ok();
    let speed = || Some(datum.as_f32()).filter(|v| v.abs() <= SPEED_MPS);
    let angle = || Some(datum.as_f32()).filter(|v| v.abs() <= 2.0 * std::f32::consts::PI);
    let (kind, v) = (&mut state.entity_type, &mut state.linear_velocity_mps);
    let orientation = &mut state.orientation;
    match datum.id {
        DatumId::FORCE_ID_240002 => state.force_id = ForceId(small()?),
        DatumId::ENTITY_TYPE_KIND => kind.kind = EntityKind(small()?),
        DatumId::ENTITY_TYPE_DOMAIN => kind.domain = small()?,
        DatumId::ENTITY_TYPE_COUNTRY => kind.country.0 = u16::try_from(datum.as_u32()).ok()?,
        DatumId::ENTITY_TYPE_CATEGORY => kind.category = small()?,
        DatumId::ENTITY_TYPE_SUB_CATEGORY => kind.subcategory = small()?,
        DatumId::ENTITY_TYPE_SPECIFIC => kind.specific = small()?,
        DatumId::ENTITY_TYPE_EXTRA => kind.extra = small()?,
        DatumId::ENTITY_LINEAR_VELOCITY_X => v.x = speed()?,
        DatumId::ENTITY_LINEAR_VELOCITY_Y => v.y = speed()?,
        DatumId::ENTITY_LINEAR_VELOCITY_Z => v.z = speed()?,
        DatumId::ENTITY_ORIENTATION_PSI => orientation.psi_rad = angle()?,
        DatumId::ENTITY_ORIENTATION_THETA => orientation.theta_rad = angle()?,
        DatumId::ENTITY_ORIENTATION_PHI => orientation.phi_rad = angle()?,
        DatumId::ENTITY_APPEARANCE => {
            // Whether it is frozen or gone is said by other PDUs.
            let bits = AirAppearance(datum.as_u32()).with_frozen(false).with_deactivated(false);
            state.appearance = bits.0;
        }
        _ => return None,
    }
    Some(())
}

fn set_variable(state: &mut EntityState<'_>, datum: VariableDatum<'_>) -> Option<()> {
    let small = || -> Option<[f32; 3]> {
        let octets: &[u8; 12] = datum.value.try_into().ok()?;
        let at = |n: usize| f32::from_be_bytes([0, 1, 2, 3].map(|k| octets[4 * n + k]));
        Some([at(0), at(1), at(2)])
    };
    match datum.id {
        DatumId::ENTITY_LOCATION => {
            let octets: &[u8; 24] = datum.value.try_into().ok()?;
            let at =
                |n: usize| f64::from_be_bytes([0, 1, 2, 3, 4, 5, 6, 7].map(|k| octets[8 * n + k]));
            let [x_m, y_m, z_m] = [at(0), at(1), at(2)];
            let radius_m = libm::sqrt(x_m * x_m + y_m * y_m + z_m * z_m);
            if !RADIUS_M.contains(&radius_m) {
                return None;
            }
            state.location = Location { x_m, y_m, z_m };
        }
        DatumId::ENTITY_LINEAR_VELOCITY => {
            let [x, y, z] = small().filter(|v| v.iter().all(|v| v.abs() <= SPEED_MPS))?;
            state.linear_velocity_mps = Vector32 { x, y, z };
        }
        DatumId::ENTITY_ORIENTATION => {
            let turn = 2.0 * std::f32::consts::PI;
            let [psi_rad, theta_rad, phi_rad] =
                small().filter(|a| a.iter().all(|a| a.abs() <= turn))?;
            state.orientation = Orientation { psi_rad, theta_rad, phi_rad };
        }
        DatumId::ENTITY_MARKING_11_BYTES => {
            let text = std::str::from_utf8(datum.value).ok()?.trim_end_matches('\0');
            state.marking = Marking::new(text).ok()?;
        }
        _ => return None,
    }
    Some(())
}
