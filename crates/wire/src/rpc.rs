//! The requests of the protocol, each with its service, method and reply.

use prost::{Message, Name};

use crate::keys::{Method, Service};
use crate::v1;

/// A request.
pub trait Request: Message + Name + Default + Send + 'static {
    /// What it is answered with.
    type Reply: Reply;

    /// The service that it is sent to; `None` where every service answers it.
    const SERVICE: Option<Service>;

    /// The method that it is sent to.
    const METHOD: Method;

    /// Its header.
    fn header(&self) -> Option<&v1::RequestHeader>;

    /// Sets its header.
    fn set_header(&mut self, header: v1::RequestHeader);
}

/// A reply.
pub trait Reply: Message + Name + Default + Send + 'static {
    /// Its header.
    fn header(&self) -> Option<&v1::ReplyHeader>;

    /// Sets its header.
    fn set_header(&mut self, header: v1::ReplyHeader);
}

macro_rules! requests {
    ($($request:ident -> $reply:ident: $service:expr, $method:ident;)*) => {
        $(
            impl Request for v1::$request {
                type Reply = v1::$reply;
                const SERVICE: Option<Service> = $service;
                const METHOD: Method = Method::$method;

                fn header(&self) -> Option<&v1::RequestHeader> {
                    self.header.as_ref()
                }

                fn set_header(&mut self, header: v1::RequestHeader) {
                    self.header = Some(header);
                }
            }

            impl Reply for v1::$reply {
                fn header(&self) -> Option<&v1::ReplyHeader> {
                    self.header.as_ref()
                }

                fn set_header(&mut self, header: v1::ReplyHeader) {
                    self.header = Some(header);
                }
            }
        )*
    };
}

requests! {
    HealthRequest -> HealthReply: None, Health;
    HeightmapRequest -> HeightmapReply: Some(Service::Perception), Heightmap;
    ItemsRequest -> ItemsReply: Some(Service::Perception), Items;
    InspectRequest -> InspectReply: Some(Service::Perception), Inspect;
    ProposeRequest -> ProposeReply: Some(Service::Ppn), Propose;
    EvaluateRequest -> EvaluateReply: Some(Service::Heuristic), Evaluate;
    PlaceRequest -> PlaceReply: Some(Service::Bridge), Place;
    OutcomeRequest -> OutcomeReply: Some(Service::Bridge), Outcome;
    RenewRequest -> RenewReply: Some(Service::Bridge), Renew;
    HoldRequest -> HoldReply: Some(Service::Bridge), Hold;
    ResumeRequest -> ResumeReply: Some(Service::Bridge), Resume;
    ChangedRequest -> ChangedReply: Some(Service::Bridge), Changed;
    CellStateRequest -> CellStateReply: Some(Service::Bridge), State;
    BeginRequest -> BeginReply: Some(Service::Planner), Begin;
    AnnounceRequest -> AnnounceReply: Some(Service::Planner), Announce;
    WithdrawRequest -> WithdrawReply: Some(Service::Planner), Withdraw;
    PlanRequest -> PlanReply: Some(Service::Planner), Plan;
    ReportRequest -> ReportReply: Some(Service::Planner), Report;
    OpenRequest -> OpenReply: Some(Service::Planner), Open;
    CloseRequest -> CloseReply: Some(Service::Planner), Close;
    ExplainRequest -> ExplainReply: Some(Service::Planner), Explain;
    AutomaticRequest -> AutomaticReply: Some(Service::Planner), Automatic;
    SessionRequest -> SessionReply: Some(Service::Planner), Session;
    ShapesRequest -> ShapesReply: Some(Service::Planner), Shapes;
}

macro_rules! session_replies {
    ($($reply:ident)*) => {
        $(
            impl From<v1::Session> for v1::$reply {
                fn from(session: v1::Session) -> Self {
                    Self {
                        session: Some(session),
                        ..Self::default()
                    }
                }
            }
        )*
    };
}

session_replies! {
    BeginReply AnnounceReply WithdrawReply ReportReply OpenReply CloseReply AutomaticReply SessionReply
}
