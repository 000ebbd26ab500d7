#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hullwright_fuzz::hulls_file(bytes));
