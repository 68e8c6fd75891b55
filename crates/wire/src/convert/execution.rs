//! Requests that carry out decisions.

use crate::v1;

/// The request that has a decision carried out. The decision's id is its idempotency key: the
/// placement is executed once, however often it is sent.
impl From<&v1::Decision> for v1::PlaceRequest {
    fn from(decision: &v1::Decision) -> Self {
        Self {
            placement_id: decision.decision_id.clone(),
            item_id: decision.item_id.clone(),
            object: decision.object.clone(),
            container_from_item: decision.container_from_item,
            state_number: decision.state_number,
            cycle: decision.cycle.clone(),
            decided_at_ns: decision.decided_at_ns,
            ..Self::default()
        }
    }
}
