//! Doubts as they stand on the wire.

use ppnpack_perception::doubts::Doubt;
use ppnpack_wire::v1;
use ppnpack_wire::v1::DoubtKind;

pub(crate) fn write(doubt: &Doubt) -> v1::Doubt {
    let kind = match doubt {
        Doubt::LittleSeen { .. } => DoubtKind::LittleSeen,
        Doubt::RimAway { .. } => DoubtKind::RimAway,
        Doubt::Intrusion { .. } => DoubtKind::Intrusion,
        Doubt::NotStill { .. } => DoubtKind::NotStill,
        // One that the protocol has no name for yet.
        _ => DoubtKind::Unspecified,
    };
    v1::Doubt {
        kind: kind.into(),
        message: doubt.to_string(),
    }
}
