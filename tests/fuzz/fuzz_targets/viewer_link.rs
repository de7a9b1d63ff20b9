#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| haptor_fuzz::targets::run("viewer_link", bytes));
