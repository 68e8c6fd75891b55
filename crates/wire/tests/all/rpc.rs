//! Every request of the schema can be sent.

use std::collections::BTreeSet;

use ppnpack_wire::rpc::{Reply, Request};
use ppnpack_wire::v1;
use prost::Name;

use crate::support::filled;

/// Gives the names of a request and its reply, once their headers were seen to be set and read.
fn names<R: Request>() -> [String; 2] {
    let header = v1::RequestHeader {
        request_id: "a".to_owned(),
        time_limit_us: 1,
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

macro_rules! names_of {
    ($($request:ident)*) => {
        [$(names::<v1::$request>()),*]
    };
}

#[test]
fn every_request_has_its_method_and_reply() {
    let known = names_of! {
        AnnounceRequest AutomaticRequest BeginRequest BringEmptyRequest CarryOutRequest
        CellStateRequest ChangedRequest CloseRequest
        EvaluateRequest ExplainRequest HealthRequest HeightmapRequest HoldRequest InspectRequest
        ItemsRequest OpenRequest OutcomeRequest PlaceRequest PlanRequest ProposeRequest RenewRequest
        ReportRequest ResumeRequest SessionRequest ShapesRequest TakeOverRequest
        WithdrawRequest
    };
    let pool = filled::pool();
    let messages = pool.all_messages().map(|message| message.name().to_owned());
    let requests: BTreeSet<String> = messages.filter(|name| name.ends_with("Request")).collect();
    let found: BTreeSet<String> = known.iter().map(|[request, _]| request.clone()).collect();
    assert_eq!(found, requests);
    for [request, reply] in known {
        assert_eq!(request.strip_suffix("Request"), reply.strip_suffix("Reply"));
    }
}
