//! Items on a tray, as messages.

use nalgebra::{Isometry3, Translation3};
use ppnpack_packing::kernel::grid::Resolution;
use ppnpack_recognition::posed::posed_item;
use ppnpack_recognition::recognise::{Known, Recogniser, Recognition, UnknownReason};
use ppnpack_recognition::segmentation::Cluster;
use ppnpack_recognition::unknown_item::unknown_item;
use ppnpack_wire::{MAX_MESSAGE_BYTES, convert, v1};
use prost::Message;

/// Maximum size of a message beside heightmaps, in bytes.
const OVERHEAD_BYTES: usize = 64 << 10;

/// Makes an item of a cluster, ready to be announced to a planner.
pub(crate) fn item(
    cluster: &Cluster,
    recogniser: &Recogniser,
    resolution: &Resolution,
) -> v1::SeenItem {
    let recognition = recogniser.recognise(cluster);
    let best = match &recognition {
        Recognition::Known(known) => Some(&known.best),
        Recognition::Unknown(unknown) => unknown.candidates.first(),
    };
    let agreement = best.map(|best| best.agreement).unwrap_or_default();
    let seen = v1::SeenItem {
        points: cluster.points_m.len() as u64,
        fitness: agreement.fitness,
        unexplained: agreement.unexplained,
        ..v1::SeenItem::default()
    };
    match recognition {
        Recognition::Known(known) => self::known(&seen, *known, recogniser, resolution),
        Recognition::Unknown(unknown) => self::unknown(seen, unknown.reason, cluster, resolution),
    }
}

/// Takes the heightmaps off the items for which a message has no room.
pub(crate) fn within_message(mut items: Vec<v1::SeenItem>) -> Vec<v1::SeenItem> {
    let mut room = MAX_MESSAGE_BYTES - OVERHEAD_BYTES;
    for item in &mut items {
        let bytes = item.item.as_ref().map_or(0, Message::encoded_len);
        match room.checked_sub(bytes) {
            Some(left) => room = left,
            None => item.item = None,
        }
    }
    items
}

/// Describes an object of the catalogue, with its heightmaps as it lies.
fn known(
    seen: &v1::SeenItem,
    known: Known,
    recogniser: &Recogniser,
    resolution: &Resolution,
) -> v1::SeenItem {
    let best = known.best;
    let object = recogniser.library().objects.get(best.object);
    let posed =
        object.and_then(|object| posed_item(&object.model, &best.world_from_item, resolution).ok());
    let frame = posed.as_ref().map(|posed| {
        let no_shift = Translation3::identity();
        convert::pose::write(&Isometry3::from_parts(no_shift, posed.heightmap_from_item))
    });
    v1::SeenItem {
        object: best.name,
        item: posed.map(|posed| convert::item::write(&posed.item)),
        heightmap_from_item: frame,
        container_from_item: Some(convert::pose::write(&best.world_from_item)),
        runner_up: known.runner_up.map_or_else(String::new, |other| other.name),
        margin: known.margin,
        ..*seen
    }
}

/// Describes an item of which only that is known that was seen.
fn unknown(
    seen: v1::SeenItem,
    reason: UnknownReason,
    cluster: &Cluster,
    resolution: &Resolution,
) -> v1::SeenItem {
    let reason = match reason {
        UnknownReason::FewPoints => v1::UnknownReason::FewPoints,
        UnknownReason::NoCandidate => v1::UnknownReason::NoCandidate,
        UnknownReason::PoorFit => v1::UnknownReason::PoorFit,
    };
    let made = unknown_item(&name(cluster), cluster, resolution).ok();
    let pose = made.as_ref().map(|made| &made.world_from_item);
    v1::SeenItem {
        unknown_reason: reason.into(),
        container_from_item: pose.map(convert::pose::write),
        item: made.map(|made| convert::item::write(&made.item)),
        ..seen
    }
}

/// Names an unknown item for people.
fn name(cluster: &Cluster) -> String {
    let size_mm = cluster.extents_m() * 1e3;
    format!(
        "unknown, {:.0} x {:.0} x {:.0} mm",
        size_mm.x, size_mm.y, size_mm.z
    )
}
