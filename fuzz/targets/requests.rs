//! Any bytes as any request: decoding is bounded and never panics, and what was decoded is encoded
//! to the same again.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ppnpack_wire::header::RequestHeader;
use ppnpack_wire::rpc::Request;
use ppnpack_wire::{MAX_MESSAGE_BYTES, decode, v1};

fn check<R: Request + PartialEq>(payload: &[u8]) {
    let Ok(message) = decode::<R>(payload, MAX_MESSAGE_BYTES) else {
        return;
    };
    let encoded = message.encode_to_vec();
    let again: R = decode(&encoded, MAX_MESSAGE_BYTES).expect("what was encoded is decoded");
    // Compared as bytes: a NaN is not equal to itself.
    assert_eq!(again.encode_to_vec(), encoded);
    drop(RequestHeader::read(message.header()));
}

fuzz_target!(|data: &[u8]| {
    let Some((kind, payload)) = data.split_first() else {
        return;
    };
    let checks: &[fn(&[u8])] = &[
        check::<v1::HealthRequest>,
        check::<v1::HeightmapRequest>,
        check::<v1::ItemsRequest>,
        check::<v1::InspectRequest>,
        check::<v1::ProposeRequest>,
        check::<v1::EvaluateRequest>,
        check::<v1::PlaceRequest>,
        check::<v1::OutcomeRequest>,
        check::<v1::RenewRequest>,
        check::<v1::HoldRequest>,
        check::<v1::ResumeRequest>,
        check::<v1::ChangedRequest>,
        check::<v1::CellStateRequest>,
        check::<v1::BeginRequest>,
        check::<v1::AnnounceRequest>,
        check::<v1::WithdrawRequest>,
        check::<v1::PlanRequest>,
        check::<v1::ReportRequest>,
        check::<v1::OpenRequest>,
        check::<v1::CloseRequest>,
        check::<v1::ExplainRequest>,
        check::<v1::AutomaticRequest>,
        check::<v1::SessionRequest>,
        check::<v1::ShapesRequest>,
    ];
    checks[usize::from(*kind) % checks.len()](payload);
});
