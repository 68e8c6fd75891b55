//! Bytes of any kind are decoded or refused: nothing panics, and memory stays in bounds.

use std::fmt::Debug;

use ppnpack_wire::convert::{cloud, grid, item, objective, placement, pose, scene};
use ppnpack_wire::{MAX_MESSAGE_BYTES, WireError, decode, encoding_of, v1};
use proptest::prelude::*;
use prost::{Message, Name};
use prost_reflect::Kind;

use crate::support::filled::{filled, pool};

/// What can be read from a payload is written to something that is read the same.
fn stays<M: Message + Name + Default + PartialEq + Debug, T>(
    payload: &[u8],
    read: impl Fn(&M) -> Result<T, WireError>,
    write: impl Fn(&T) -> M,
) {
    let message = decode(payload, MAX_MESSAGE_BYTES);
    if let Ok(value) = message.and_then(|message| read(&message)) {
        let written = write(&value);
        assert_eq!(write(&read(&written).unwrap()), written);
    }
}

/// Reads a payload as every message, and as every type of the domain.
fn read_as_everything(payload: &[u8]) {
    for known in crate::support::known() {
        if let Ok(recoded) = (known.recode)(payload) {
            assert!((known.recode)(&recoded).is_ok(), "{}", known.name);
        }
    }
    stays(payload, grid::read, grid::write);
    stays(payload, scene::read, |(grid, scene)| {
        scene::write(grid, scene)
    });
    stays(payload, item::read, item::write);
    let read = |message: &v1::Objective| objective::read_required("objective", Some(message));
    stays(payload, read, objective::write);
    stays(
        payload,
        |message| pose::read_required("pose", Some(message)),
        pose::write,
    );
    stays(
        payload,
        |message| placement::read_all("placements", message),
        |placements| placement::write_all(placements.iter().copied()),
    );
    stays(payload, placement::read_ranked, placement::write_ranked);
    stays(payload, placement::read_tally, placement::write_tally);
    if let Ok(message) = decode::<v1::PointCloud>(payload, MAX_MESSAGE_BYTES)
        && let Ok(cloud) = cloud::read(&message)
    {
        assert_eq!(cloud.points().count(), cloud.len());
    }
}

/// Encodings of every message, so that changes to them reach deep.
fn encodings() -> Vec<Vec<u8>> {
    let pool = pool();
    let messages = pool.all_messages();
    let mut encodings: Vec<Vec<u8>> = messages
        .map(|message| filled(&message, 0).encode_to_vec())
        .collect();
    let grid = ppnpack_packing::kernel::grid::Grid::reference();
    let surface = ppnpack_packing::kernel::heightmap::Surface::empty(&grid);
    let scene = ppnpack_packing::scene::Scene::from_surface(&grid, surface).unwrap();
    encodings.push(scene::write(&grid, &scene).encode_to_vec());
    encodings
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn random_bytes_are_decoded_or_refused(payload in proptest::collection::vec(any::<u8>(), 0..200)) {
        read_as_everything(&payload);
    }

    #[test]
    fn changed_messages_are_decoded_or_refused(
        encoding in proptest::sample::select(encodings()),
        changes in proptest::collection::vec((any::<proptest::sample::Index>(), any::<u8>()), 0..6),
        length in proptest::option::of(any::<proptest::sample::Index>()),
    ) {
        let mut payload = encoding;
        if payload.is_empty() {
            return Ok(());
        }
        for (at, byte) in changes {
            let at = at.index(payload.len());
            payload[at] = byte;
        }
        if let Some(length) = length {
            payload.truncate(length.index(payload.len()));
        }
        read_as_everything(&payload);
    }
}

#[test]
fn what_is_too_large_is_refused_unseen() {
    let payload = [0xff; 11];
    assert_eq!(
        decode::<v1::Grid>(&payload, 10),
        Err(WireError::TooLarge {
            message: "Grid",
            bytes: 11,
            limit: 10
        })
    );
}

#[test]
fn encodings_name_the_message() {
    assert_eq!(
        encoding_of::<v1::Heightmap>(),
        "application/protobuf;ppnpack.v1.Heightmap"
    );
}

/// As many empty parts as are looked at, in any list of any message.
#[test]
fn many_empty_parts_take_bounded_memory() {
    const PARTS: usize = 200_000;
    const MOST_BYTES: u64 = 256 << 20;
    for known in crate::support::known() {
        let message = pool().get_message_by_name(&known.name).unwrap();
        let lists = message.fields().filter(|field| {
            field.is_list() && matches!(field.kind(), Kind::Message(_) | Kind::String | Kind::Bytes)
        });
        for list in lists {
            let mut part = Vec::new();
            let wire_type = prost::encoding::WireType::LengthDelimited;
            prost::encoding::encode_key(list.number(), wire_type, &mut part);
            part.push(0);
            let payload = part.repeat(PARTS);
            let taken = allocation_counter::measure(|| assert!((known.recode)(&payload).is_ok()));
            assert!(
                taken.bytes_max < MOST_BYTES,
                "{} takes {} bytes",
                list.full_name(),
                taken.bytes_max
            );
            let payload = part.repeat(PARTS + 1);
            let taken = allocation_counter::measure(|| assert!((known.recode)(&payload).is_err()));
            assert!(
                taken.bytes_max < 1 << 20,
                "{} is looked at",
                list.full_name()
            );
        }
    }
}
