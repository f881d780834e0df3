//! A datagram of any octets.
#![no_main]

#[path = "../../tests/common/any_bytes.rs"]
mod any_bytes;

libfuzzer_sys::fuzz_target!(|octets: &[u8]| {
    any_bytes::check_any_bytes(octets);
});
