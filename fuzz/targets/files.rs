//! Any PCD or PLY file: a cloud that the file has room for, which is written and read again, or a
//! refusal.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ppnpack_clouds::{parse, to_pcd};

fuzz_target!(|data: &[u8]| {
    let Ok(cloud) = parse(data) else {
        return;
    };
    // Three packed bytes stand for 264 at most, and a point takes 12.
    assert!(cloud.points_m().len() <= 8 * data.len());
    let again = parse(&to_pcd(&cloud)).expect("what is written can be read");
    assert!(again == cloud);
});
