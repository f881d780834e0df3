//! What a transponder answers, to and from IFF PDUs.

use crate::enumerations::IffSystemType;
use crate::iff::{BasicDataLayer, Iff, IffBasic, IffLayer, ModeSTransponder};
use crate::records::EntityId;

/// A transponder: modes A, C and S.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Transponder {
    /// It answers.
    pub on: bool,
    /// Mode 3/A code, 0 to 0o7777.
    pub mode_3a: Option<u16>,
    /// Mode C altitude, feet.
    pub mode_c_feet: Option<i32>,
    /// 24-bit address of Mode S.
    pub address: Option<u32>,
    /// Aircraft identification of Mode S, upper case ASCII, spaces or zeros behind.
    pub identification: Option<[u8; 8]>,
    /// Whether it says that it is on the ground.
    pub on_ground: Option<bool>,
}

/// Bit of a mode's parameter and of the Mode S status that says "on"; the two above it say damaged
/// and out of order.
const ON: u16 = 1 << 13;
const FAILED: u16 = 3 << 14;

/// Aircraft present domain. SISO-REF-010, UID 356.
const AIRBORNE: u8 = 1;
const ON_GROUND: u8 = 2;

impl Transponder {
    /// The transponder that an IFF PDU speaks of; `None` for interrogators.
    #[must_use]
    pub fn of(iff: &Iff<'_>) -> Option<Self> {
        use IffSystemType as T;
        let basic = &iff.basic;
        if matches!(
            basic.system_type,
            T::MARK_X_XII_ATCRBS_INTERROGATOR
                | T::SOVIET_INTERROGATOR
                | T::MARK_XIIA_INTERROGATOR
                | T::MODE_5_INTERROGATOR
                | T::MODE_S_INTERROGATOR
        ) {
            return None;
        }
        let mut transponder = Self {
            // Bit 0 on, bit 7 failed.
            on: basic.status & 0x81 == 1,
            mode_3a: iff.mode_3a().filter(|_| basic.parameter_3 & FAILED == 0),
            mode_c_feet: iff.mode_c_feet().filter(|_| basic.parameter_5 & FAILED == 0),
            ..Self::default()
        };
        for layer in iff.layers.iter() {
            let IffLayer::ModeS(layer) = layer else { continue };
            let Some(data) = layer.mode_s_transponder() else { continue };
            if data.status & FAILED != 0 {
                continue;
            }
            let address = data.aircraft_address & 0xff_ffff;
            transponder.address = (address != 0).then_some(address);
            let named = data.aircraft_identification.iter().any(u8::is_ascii_alphanumeric);
            transponder.identification = named.then_some(data.aircraft_identification);
            transponder.on_ground = match data.aircraft_present_domain {
                AIRBORNE => Some(false),
                ON_GROUND => Some(true),
                _ => None,
            };
        }
        Some(transponder)
    }

    /// The PDU's body for the transponder of `entity`.
    #[must_use]
    pub fn iff(&self, entity: EntityId) -> Iff<'static> {
        let mode_s = self.address.is_some() || self.identification.is_some();
        let (kind, layers) = match mode_s {
            // Bit n for layer n.
            true => (IffSystemType::MODE_S_TRANSPONDER, 1 << 1 | 1 << 4),
            false => (IffSystemType::MARK_X_XII_ATCRBS_TRANSPONDER, 1 << 1),
        };
        let basic = IffBasic {
            emitting_entity: entity,
            system_type: kind,
            status: u8::from(self.on),
            information_layers: layers,
            parameter_3: self.mode_3a.map_or(0, |code| ON | code & 0o7777),
            parameter_5: self.mode_c_feet.map_or(0, |feet| {
                let hundreds = ((f64::from(feet.abs()) / 100.0).round() as u16).min(0x7ff);
                ON | hundreds << 1 | u16::from(feet < 0)
            }),
            ..IffBasic::default()
        };
        let mut iff = Iff { basic, ..Iff::default() };
        if mode_s {
            let data = ModeSTransponder {
                status: 1 | ON,
                aircraft_present_domain: match self.on_ground {
                    Some(true) => ON_GROUND,
                    Some(false) => AIRBORNE,
                    None => 0,
                },
                aircraft_identification: self.identification.unwrap_or([b' '; 8]),
                aircraft_address: self.address.unwrap_or(0) & 0xff_ffff,
                ..ModeSTransponder::default()
            };
            let mut layer = BasicDataLayer::from(data);
            layer.reporting_simulation.site = entity.site;
            layer.reporting_simulation.application = entity.application;
            iff.layers = vec![IffLayer::ModeS(layer)].into();
        }
        iff
    }

    /// The aircraft identification without what fills it up.
    #[must_use]
    pub fn identification_text(&self) -> Option<String> {
        let octets = self.identification?;
        let text: String = octets
            .iter()
            .take_while(|b| **b != 0)
            .filter(|b| b.is_ascii_graphic())
            .map(|b| char::from(b.to_ascii_uppercase()))
            .collect();
        (!text.is_empty()).then_some(text)
    }

    /// Eight characters of a call sign, as [`Self::identification`] has them.
    #[must_use]
    pub fn identification_of(callsign: &str) -> [u8; 8] {
        let mut octets = [b' '; 8];
        let graphic = callsign.bytes().filter(u8::is_ascii_graphic);
        octets.iter_mut().zip(graphic).for_each(|(slot, octet)| *slot = octet.to_ascii_uppercase());
        octets
    }
}
