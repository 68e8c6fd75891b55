//! Files with a damaged page, for the tests of what services keep.

use std::fs;
use std::path::Path;

/// The size of a database's pages.
const PAGE: usize = 4096;

/// Ways to damage a page of a file.
const DAMAGES: [fn(&mut Vec<u8>, usize); 5] = [
    |file, at| file[at..at + PAGE].fill(0),
    |file, at| file[at..at + PAGE].fill(0x5a),
    // One bit.
    |file, at| {
        let length = file[at..at + PAGE].iter().rposition(|byte| *byte != 0);
        file[at + length.unwrap_or(0) / 2] ^= 4;
    },
    // What was meant for another place.
    |file, at| {
        let from = (at + 3 * PAGE) % file.len();
        let to = (from + PAGE).min(file.len());
        file.copy_within(from..to, at);
    },
    // Cut off.
    |file, at| file.truncate(at),
];

/// Damages each page of a file in each way, and looks at what comes of it, which is told what was
/// done.
pub(crate) fn with_each_damage(file: &Path, look: impl Fn(&str)) {
    let whole = fs::read(file).unwrap();
    for at in (0..whole.len()).step_by(PAGE) {
        for (way, damage) in DAMAGES.iter().enumerate() {
            let mut bytes = whole.clone();
            damage(&mut bytes, at);
            if bytes != whole {
                fs::write(file, bytes).unwrap();
                look(&format!("page {}, damage {way}", at / PAGE));
            }
        }
    }
}
