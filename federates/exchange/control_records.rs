//! What control tells those who hear DIS: the state of its lights, and its alerts.
//!
//! Lights: an Environmental Process with one private record of type [`LIGHTS`]: count (u16), then of each light its number (u16) and its
//! state (u8: 0 dark, 1 lit, 2 dark and failed, 3 lit and failed), zeros to a multiple of eight octets. Numbers count the lights as `control/1/lights` lists them: stop bars, entry
//! lights, take-off hold lights; those of the taxiways are a process of their own.
//! An alert: an Event Report with [`ALERT`] as its event, fixed datums kind, stage, change, number and one for each subject that is an
//! entity of the scene (its application and entity number), and its kind and subjects in words as a variable datum.
//! Both are of no frame and in no digest: whoever looks on may lose them.

use crate::runtime::federate::Octets;
use crate::runtime::messages::AlertMessage;
use models::control::alert::{Change, Stage};
use pdu::Envelope;
use pdu::enumerations::{DatumId, EnvironmentRecordType, EventType};
use pdu::environment::{EnvironmentRecord, EnvironmentRecords, EnvironmentalProcess};
use pdu::management::EventReport;
use pdu::records::{EntityId, EntityType, FixedDatum, VariableDatum};
use scenarios::Scene;

/// Type of the record: "SELT".
pub const LIGHTS: u32 = 0x5345_4C54;

/// Event of a report: "SEAL".
pub const ALERT: u32 = 0x5345_414C;

/// Datums of a report of an alert, by number: kind (its ASTERIX 004 message type), stage (1 information, 2 alarm), change (1 raised, 2
/// changed, 3 ended), number of the alert, an entity that it is about (application, entity number), words.
const KIND: u32 = ALERT + 1;
const STAGE: u32 = ALERT + 2;
const CHANGE: u32 = ALERT + 3;
const NUMBER: u32 = ALERT + 4;
const SUBJECT: u32 = ALERT + 5;
const WORDS: u32 = ALERT + 6;

/// DIS application number of control.
pub const CONTROL_APPLICATION: u16 = 65_002;
/// Its numbers there: itself, the lights of the runways, the lamps of the taxiways.
const CONTROL: u16 = 1;
const BARS: u16 = 2;
const GREENS: u16 = 3;

/// A light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Light {
    /// Lit.
    pub lit: bool,
    /// Does not do what it is told.
    pub failed: bool,
}

/// Whose lights they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lights {
    /// Stop bars, entry lights, take-off hold lights.
    Runways,
    /// Segments of the taxiways.
    Taxiways,
}

impl Lights {
    fn id(self, site: u16) -> EntityId {
        let number = if self == Self::Runways { BARS } else { GREENS };
        EntityId::new(site, CONTROL_APPLICATION, number)
    }
}

/// Most lights of a PDU.
const MOST: usize = 400;

/// The state of some lights by number, in PDUs of at most `MOST`.
#[must_use]
pub fn lights(
    site: u16,
    whose: Lights,
    envelope: &Envelope,
    lights: &[(u16, Light)],
) -> Vec<Octets> {
    let one = |lights: &[(u16, Light)]| {
        let mut content = (lights.len() as u16).to_be_bytes().to_vec();
        for (number, light) in lights {
            content.extend(number.to_be_bytes());
            content.push(u8::from(light.lit) + 2 * u8::from(light.failed));
        }
        content.resize(content.len().next_multiple_of(8), 0);
        let record = EnvironmentRecord {
            record_type: EnvironmentRecordType(LIGHTS),
            index: 0,
            padding: 0,
            content: &content,
        };
        let process = EnvironmentalProcess {
            process_id: whose.id(site),
            // Kind 4, environmental; domain 1, land.
            environment_type: EntityType::new(4, 1, 0, 0, 0, 0, 0),
            status: 2,
            records: EnvironmentRecords::Standard(vec![record].into()),
            ..EnvironmentalProcess::default()
        };
        let mut octets = Vec::new();
        envelope.append(&process, &mut octets).expect("some hundred lights fit a PDU");
        Octets::from(octets)
    };
    lights.chunks(MOST).map(one).collect()
}

/// The lights in a PDU by number; `None` if it has no such record, or a damaged one.
#[must_use]
pub fn decode_lights(process: &EnvironmentalProcess<'_>) -> Option<Vec<(u16, Light)>> {
    let record = process.records.iter().find(|r| r.record_type.0 == LIGHTS)?;
    let (count, rest) = record.content.split_first_chunk::<2>()?;
    let count = usize::from(u16::from_be_bytes(*count));
    let rows = rest.get(..3 * count)?.chunks_exact(3);
    let row = |r: &[u8]| {
        let light = Light { lit: r[2] & 1 == 1, failed: r[2] & 2 == 2 };
        (r[2] < 4).then_some((u16::from_be_bytes([r[0], r[1]]), light))
    };
    rows.map(row).collect()
}

/// The report of an alert; `subjects`: application and entity number of those of them that are entities of the scene.
#[must_use]
pub fn alert(
    site: u16,
    envelope: &Envelope,
    told: &AlertMessage,
    subjects: &[(u16, u16)],
) -> Octets {
    let stage = match told.stage {
        Stage::Information => 1_u32,
        Stage::Alarm => 2,
    };
    let change = match told.change {
        Change::Raised => 1_u32,
        Change::Changed => 2,
        Change::Ended => 3,
    };
    let fixed = |id: u32, value: u32| FixedDatum { id: DatumId(id), value: value.to_be_bytes() };
    let mut datums = vec![
        fixed(KIND, u32::from(told.asterix)),
        fixed(STAGE, stage),
        fixed(CHANGE, change),
        fixed(NUMBER, told.id),
    ];
    let entity = |(application, number): &(u16, u16)| {
        fixed(SUBJECT, u32::from(*application) << 16 | u32::from(*number))
    };
    datums.extend(subjects.iter().map(entity));
    let words = format!("{} {}", told.kind.word(), told.subjects);
    let report = EventReport {
        originating_id: EntityId::new(site, CONTROL_APPLICATION, CONTROL),
        receiving_id: EntityId::ALL,
        event_type: EventType(ALERT),
        fixed_datums: datums.into(),
        variable_datums: vec![VariableDatum::new(DatumId(WORDS), words.as_bytes())].into(),
        ..EventReport::default()
    };
    let mut octets = Vec::new();
    envelope.append(&report, &mut octets).expect("two call signs fit a PDU");
    octets.into()
}

/// What a report says of an alert.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AlertReport {
    /// Message type of ASTERIX category 004.
    pub asterix: u8,
    /// An alarm; else an information.
    pub alarm: bool,
    /// It has ended.
    pub ended: bool,
    /// Number of the alert.
    pub id: u32,
    /// Application and entity number of each subject that is an entity of the scene.
    pub subjects: Vec<(u16, u16)>,
    /// Its kind, and its subjects as people call them.
    pub words: String,
}

/// The alert in a report; `None` if it is about something else, or damaged.
#[must_use]
pub fn decode_alert(report: &EventReport<'_>) -> Option<AlertReport> {
    if report.event_type.0 != ALERT {
        return None;
    }
    let all = || report.fixed_datums.iter();
    let value = |id: u32| {
        let datum = all().find(|d| d.id.0 == id)?;
        Some(u32::from_be_bytes(datum.value))
    };
    let entity = |d: &FixedDatum| {
        let value = u32::from_be_bytes(d.value);
        ((value >> 16) as u16, value as u16)
    };
    let words = report.variable_datums.iter().find(|d| d.id.0 == WORDS)?;
    Some(AlertReport {
        asterix: u8::try_from(value(KIND)?).ok()?,
        alarm: value(STAGE)? == 2,
        ended: value(CHANGE)? == 3,
        id: value(NUMBER)?,
        subjects: all().filter(|d| d.id.0 == SUBJECT).map(|d| entity(&d)).collect(),
        words: String::from_utf8(words.value.to_vec()).ok()?,
    })
}

/// Whoever tells it, with what every PDU of his has.
#[derive(Clone, Copy, Debug)]
pub struct Teller {
    /// DIS exercise.
    pub exercise: u8,
    /// DIS site.
    pub site: u16,
}

impl Teller {
    /// Lights in their order, as of a time.
    #[must_use]
    pub fn lights(self, whose: Lights, at: pdu::DisTime, all: &[(u16, Light)]) -> Vec<Octets> {
        lights(self.site, whose, &Envelope::new(self.exercise, at), all)
    }

    /// An alert about these call signs of a scene, as of a time.
    #[must_use]
    pub fn alert(self, at: pdu::DisTime, told: &AlertMessage, scene: &Scene) -> Octets {
        let entity = |name: &str| {
            let own = scene.traffic.entities.iter().find(|e| e.callsign.as_str() == name)?;
            Some((own.application, own.number))
        };
        let subjects: Vec<(u16, u16)> = told.subjects.split(' ').filter_map(entity).collect();
        alert(self.site, &Envelope::new(self.exercise, at), told, &subjects)
    }
}

/// Whether a PDU is one of these, by who sends it.
#[must_use]
pub fn is_of_control(body: &pdu::Body<'_>, site: u16) -> bool {
    let own = |id: EntityId| id.site == site && id.application == CONTROL_APPLICATION;
    match body {
        pdu::Body::EnvironmentalProcess(process) => own(process.process_id),
        pdu::Body::EventReport(report) => own(report.originating_id),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use models::control::alert::AlertKind;
    use models::frames::Point2;
    use pdu::{Body, DisTime};

    fn envelope() -> Envelope {
        Envelope::new(1, DisTime(1))
    }

    #[test]
    fn lights_come_back_and_lie_as_the_record_says() {
        let lit = |lit, failed| Light { lit, failed };
        let all = [(0, lit(true, false)), (258, lit(false, true)), (7, lit(false, false))];
        let pdus = lights(417, Lights::Runways, &envelope(), &all);
        let [octets] = &pdus[..] else { panic!("one PDU") };
        // Count, then number and state of each.
        let content = [0, 3, 0, 0, 1, 1, 2, 2, 0, 7, 0];
        assert!(octets.windows(content.len()).any(|w| w == content), "{octets:?}");
        assert!(octets.windows(4).any(|w| w == b"SELT"));
        let received = pdu::pdus(octets).next().expect("one").expect("sound");
        let Body::EnvironmentalProcess(process) = received.body() else { panic!("a process") };
        assert_eq!(decode_lights(process), Some(all.to_vec()));
        assert!(is_of_control(received.body(), 417) && !is_of_control(received.body(), 418));
        assert_eq!(decode_lights(&EnvironmentalProcess::default()), None);
        // Many are several PDUs, none is lost.
        let many: Vec<(u16, Light)> = (0..1000).map(|n| (n, lit(n % 2 == 0, false))).collect();
        let back = lights(417, Lights::Taxiways, &envelope(), &many);
        let back = back.iter().flat_map(|octets| {
            let received = pdu::pdus(octets).next().expect("one").expect("sound");
            let Body::EnvironmentalProcess(process) = received.body() else { panic!("a process") };
            decode_lights(process).expect("lights")
        });
        assert_eq!(back.collect::<Vec<_>>(), many);
    }

    #[test]
    fn an_alert_comes_back_with_its_subjects() {
        let told = AlertMessage {
            run: 1,
            time_ns: 5,
            change: Change::Ended,
            id: 77,
            kind: AlertKind::RunwayArrival,
            stage: Stage::Alarm,
            subjects: "CAR1 SWR1A".into(),
            since_ns: 4,
            asterix: 9,
            place_m: Point2::origin(),
            number: 3,
        };
        let octets = alert(417, &envelope(), &told, &[(3, 65_535), (1, 2)]);
        let received = pdu::pdus(&octets).next().expect("one").expect("sound");
        let Body::EventReport(report) = received.body() else { panic!("a report") };
        let read = AlertReport {
            asterix: 9,
            alarm: true,
            ended: true,
            id: 77,
            subjects: vec![(3, 65_535), (1, 2)],
            words: "RMCA_ARR CAR1 SWR1A".into(),
        };
        assert_eq!(decode_alert(report), Some(read));
        assert!(is_of_control(received.body(), 417));
        assert_eq!(decode_alert(&EventReport::default()), None);
    }
}
