//! Messages as types of the domain: a value is refused, or read and written to what is read as the
//! same again.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ppnpack_wire::convert::{check, grid, item, objective, placement, pose, scene};
use ppnpack_wire::{MAX_MESSAGE_BYTES, decode, v1};

fn message<M: prost::Message + prost::Name + Default>(payload: &[u8]) -> Option<M> {
    decode(payload, MAX_MESSAGE_BYTES).ok()
}

fn read(kind: u8, payload: &[u8]) -> Option<()> {
    match kind % 7 {
        0 => {
            let read = grid::read(&message(payload)?).ok()?;
            assert_eq!(grid::read(&grid::write(&read)), Ok(read));
        }
        1 => {
            let (grid, read) = scene::read(&message(payload)?).ok()?;
            let (_, again) = scene::read(&scene::write(&grid, &read)).expect("it was written");
            assert_eq!(again.heightmap().heights(), read.heightmap().heights());
        }
        2 => {
            let read = item::read(&message(payload)?).ok()?;
            let written = item::write(&read);
            let again = item::read(&written).expect("it was written");
            assert_eq!(item::write(&again), written);
        }
        3 => {
            let message: v1::Objective = message(payload)?;
            let read = objective::read_required("objective", Some(&message)).ok()?;
            let written = objective::write(&read);
            let again = objective::read_required("objective", Some(&written));
            assert_eq!(again, Ok(read));
        }
        4 => {
            let read = placement::read_all("placements", &message(payload)?).ok()?;
            let written = placement::write_all(read.iter().copied());
            assert_eq!(placement::read_all("placements", &written), Ok(read));
        }
        5 => {
            let message: v1::Pose = message(payload)?;
            let read = pose::read_required("pose", Some(&message)).ok()?;
            pose::read_required("pose", Some(&pose::write(&read))).expect("it was written");
        }
        _ => {
            let message: v1::EvaluateRequest = message(payload)?;
            drop(check::read_all(&message.checks));
        }
    }
    Some(())
}

fuzz_target!(|data: &[u8]| {
    if let Some((kind, payload)) = data.split_first() {
        read(*kind, payload);
    }
});
