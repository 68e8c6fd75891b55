//! Every request of the schema can be sent.

use ppnpack_wire::rpc::{Reply, Request};
use ppnpack_wire::v1;
use prost::Name;

use crate::support::filled;

/// The names of a request and its reply, once their headers were seen to be set and read.
fn names<R: Request>() -> [String; 2] {
    let header = v1::RequestHeader {
        request_id: "a".to_owned(),
        time_limit_us: 1,
        caller: String::new(),
        ..v1::RequestHeader::default()
    };
    let mut request = R::default();
    request.set_header(header.clone());
    assert_eq!(request.header(), Some(&header));
    let header = v1::ReplyHeader::default();
    let mut reply = R::Reply::default();
    reply.set_header(header.clone());
    assert_eq!(reply.header(), Some(&header));
    [R::NAME.to_owned(), <R::Reply as Name>::NAME.to_owned()]
}

#[test]
fn every_request_has_its_method_and_reply() {
    let known = [
        names::<v1::AnnounceRequest>(),
        names::<v1::AutomaticRequest>(),
        names::<v1::BeginRequest>(),
        names::<v1::CellStateRequest>(),
        names::<v1::ChangedRequest>(),
        names::<v1::CloseRequest>(),
        names::<v1::EvaluateRequest>(),
        names::<v1::ExplainRequest>(),
        names::<v1::HealthRequest>(),
        names::<v1::HeightmapRequest>(),
        names::<v1::HoldRequest>(),
        names::<v1::InspectRequest>(),
        names::<v1::ItemsRequest>(),
        names::<v1::OpenRequest>(),
        names::<v1::OutcomeRequest>(),
        names::<v1::PlaceRequest>(),
        names::<v1::PlanRequest>(),
        names::<v1::ProposeRequest>(),
        names::<v1::RenewRequest>(),
        names::<v1::ReportRequest>(),
        names::<v1::ResumeRequest>(),
        names::<v1::SessionRequest>(),
        names::<v1::ShapesRequest>(),
        names::<v1::WithdrawRequest>(),
    ];
    let pool = filled::pool();
    let mut requests: Vec<String> = pool
        .all_messages()
        .map(|message| message.name().to_owned())
        .filter(|name| name.ends_with("Request"))
        .collect();
    requests.sort();
    let found: Vec<String> = known.iter().map(|[request, _]| request.clone()).collect();
    assert_eq!(found, requests);
    for [request, reply] in known {
        assert_eq!(request.strip_suffix("Request"), reply.strip_suffix("Reply"));
    }
}
