//! The requests of the protocol, each with its service, method and reply.

use std::fmt;

use prost::{Message, Name};

use crate::keys::{Service, chunks};
use crate::v1;

/// A request.
pub trait Request: Message + Name + Default + Send + 'static {
    /// Its reply.
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
    ($($method:ident = $text:literal: $request:ident -> $reply:ident, $service:expr;)*) => {
        chunks! {
            /// A method of services, for each request.
            Method {
                $(
                    #[doc = concat!("[`", stringify!($request), "`](v1::", stringify!($request), ")")]
                    $method = $text,
                )*
            }
        }

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
    Health = "health": HealthRequest -> HealthReply, None;
    Heightmap = "heightmap": HeightmapRequest -> HeightmapReply, Some(Service::Perception);
    Items = "items": ItemsRequest -> ItemsReply, Some(Service::Perception);
    Inspect = "inspect": InspectRequest -> InspectReply, Some(Service::Perception);
    Propose = "propose": ProposeRequest -> ProposeReply, Some(Service::Ppn);
    Evaluate = "evaluate": EvaluateRequest -> EvaluateReply, Some(Service::Heuristic);
    Place = "place": PlaceRequest -> PlaceReply, Some(Service::Bridge);
    Outcome = "outcome": OutcomeRequest -> OutcomeReply, Some(Service::Bridge);
    Renew = "renew": RenewRequest -> RenewReply, Some(Service::Bridge);
    Hold = "hold": HoldRequest -> HoldReply, Some(Service::Bridge);
    Resume = "resume": ResumeRequest -> ResumeReply, Some(Service::Bridge);
    Changed = "changed": ChangedRequest -> ChangedReply, Some(Service::Bridge);
    State = "state": CellStateRequest -> CellStateReply, Some(Service::Bridge);
    TakeOver = "take_over": TakeOverRequest -> TakeOverReply, Some(Service::Robot);
    CarryOut = "carry_out": CarryOutRequest -> CarryOutReply, Some(Service::Robot);
    BringEmpty = "bring_empty": BringEmptyRequest -> BringEmptyReply, Some(Service::Robot);
    Begin = "begin": BeginRequest -> BeginReply, Some(Service::Planner);
    Announce = "announce": AnnounceRequest -> AnnounceReply, Some(Service::Planner);
    Withdraw = "withdraw": WithdrawRequest -> WithdrawReply, Some(Service::Planner);
    Plan = "plan": PlanRequest -> PlanReply, Some(Service::Planner);
    Report = "report": ReportRequest -> ReportReply, Some(Service::Planner);
    Open = "open": OpenRequest -> OpenReply, Some(Service::Planner);
    Close = "close": CloseRequest -> CloseReply, Some(Service::Planner);
    Explain = "explain": ExplainRequest -> ExplainReply, Some(Service::Planner);
    Automatic = "automatic": AutomaticRequest -> AutomaticReply, Some(Service::Planner);
    Session = "session": SessionRequest -> SessionReply, Some(Service::Planner);
    Shapes = "shapes": ShapesRequest -> ShapesReply, Some(Service::Planner);
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
