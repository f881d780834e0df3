//! One PDU whose header is right: version and type from the first two octets, length as it is.
#![no_main]

#[path = "../../tests/common/any_bytes.rs"]
mod any_bytes;

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    let [version, pdu_type, body @ ..] = input else { return };
    let Ok(length) = u16::try_from(12 + body.len()) else { return };
    let [high, low] = length.to_be_bytes();
    let header = [5 + version % 3, 1, pdu_type % 73, 1, 0, 0, 0, 1, high, low, 0, 0];
    any_bytes::check_any_bytes(&[&header, body].concat());
});
