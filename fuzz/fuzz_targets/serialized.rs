#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| rutilant_fuzz::hold("serialized", bytes));
