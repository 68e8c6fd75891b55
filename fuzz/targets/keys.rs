//! Any text as a key expression: refused, or written as it was.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ppnpack_wire::keys::Key;

fuzz_target!(|text: &str| {
    if let Ok(key) = Key::parse(text) {
        assert_eq!(key.to_string(), text);
    }
});
