//! Why an item has no place, or where it would go, as pages show it.

use ppnpack_wire::convert;
use ppnpack_wire::v1::{self, Check};
use serde::Serialize;

use super::decision::{PlacementPart, ReasonPart};
use super::words;

#[derive(Debug, Serialize)]
struct RefusalsPart {
    check: String,
    text: String,
    count: u64,
    detail: String,
}

#[derive(Debug, Serialize)]
struct CountsPart {
    possible: u64,
    proposed: u64,
    fitting: u64,
    refusals: Vec<RefusalsPart>,
}

/// What a planner says of an item of the buffer.
#[derive(Debug, Serialize)]
pub(crate) struct ExplainedPart {
    item_id: String,
    object: String,
    best: Option<PlacementPart>,
    reason: Option<ReasonPart>,
    counts: CountsPart,
}

impl ExplainedPart {
    pub(super) fn new(
        item_id: &str,
        object: &str,
        best: Option<PlacementPart>,
        reply: &v1::ExplainReply,
    ) -> Self {
        let reason = reply.reason.as_ref();
        let counts = reply.counts.clone().unwrap_or_default();
        let refusals = counts.refusals.iter().map(refusals);
        Self {
            item_id: item_id.to_owned(),
            object: object.to_owned(),
            best,
            reason: reason.map(|reason| ReasonPart::new(reason, object)),
            counts: CountsPart {
                possible: counts.possible,
                proposed: counts.proposed,
                fitting: counts.fitting,
                refusals: refusals.collect(),
            },
        }
    }
}

fn refusals(refusals: &v1::Refusals) -> RefusalsPart {
    let check = Check::try_from(refusals.check).unwrap_or(Check::Unspecified);
    let cause = convert::check::cause(check);
    RefusalsPart {
        check: words::of_check(check),
        text: cause.map_or_else(|| "refused".to_owned(), |cause| cause.to_string()),
        count: refusals.count,
        detail: refusals.detail.clone(),
    }
}
