//! Every message of the schema, and values to fill them with.

pub(crate) mod domain;
pub(crate) mod filled;

use ppnpack_wire::{WireError, decode, v1};
use prost::{Message, Name};

/// A message as the tests go through them all.
pub(crate) struct Known {
    pub(crate) name: String,
    /// Decodes it and encodes it again.
    pub(crate) recode: fn(&[u8]) -> Result<Vec<u8>, WireError>,
}

fn recode<M: Message + Name + Default>(payload: &[u8]) -> Result<Vec<u8>, WireError> {
    decode::<M>(payload, usize::MAX).map(|message| message.encode_to_vec())
}

macro_rules! messages {
    ($($name:ident)*) => {
        /// All messages, in the order of their names.
        pub(crate) fn known() -> Vec<Known> {
            let mut known = vec![
                $(Known { name: v1::$name::full_name(), recode: recode::<v1::$name> },)*
            ];
            known.sort_by(|a, b| a.name.cmp(&b.name));
            known
        }
    };
}

messages! {
    // arm.proto
    ArmCycle ArmLeg Trajectory
    // bridge.proto
    PlaceRequest PlaceReply OutcomeRequest OutcomeReply RenewRequest RenewReply HoldRequest HoldReply
    ResumeRequest ResumeReply ChangedRequest ChangedReply Execution Outcome CellState Hold Body CellStateRequest CellStateReply
    // cloud.proto
    PointCloud PackedField
    // geometry.proto
    Vector3 Quaternion Pose
    // grid.proto
    Grid BoxSize
    // header.proto
    RequestHeader ReplyHeader StageTiming Versions
    // health.proto
    HealthRequest HealthReply HealthCheck
    // heuristic.proto
    EvaluateRequest CandidateItem SearchPart EvaluateReply
    // item.proto
    Item ItemView Underside
    // objective.proto
    Objective Weights
    // perception.proto
    HeightmapRequest HeightmapReply ItemsRequest ItemsReply SeenItem InspectRequest InspectReply Inspection
    // placement.proto
    Placements RestingPlacement RankedPlacement PlacementCounts Refusals
    // planner.proto
    BeginRequest BeginReply ContainerStart Region AnnounceRequest Announcement OrderLine ItemRules AnnounceReply WithdrawRequest WithdrawReply
    PlanRequest PlanReply Decision ItemReason ReportRequest ReportReply OpenRequest OpenReply CloseRequest CloseReply
    ExplainRequest ExplainReply AutomaticRequest AutomaticReply SessionRequest SessionReply Session SessionItem
    SessionContainer ClosedContainer SettledDecision Settling Load
    // ppn.proto
    ProposeRequest ProposeReply
    // record.proto
    PlanningRecord RecordedItem RecordedCandidate RecordedContainer RecordedContent RecordedBody RecordedAttempt AdmittedCandidates Solid
    ConvexPiece ShapesRequest ShapesReply Shape
    // robot.proto
    TakeOverRequest TakeOverReply CarryOutRequest CarryOutReply BringEmptyRequest BringEmptyReply Bodies
    // scene.proto
    Scene Surface Heightmap HeightmapId HeightmapQuality Doubt
}

/// The field that an error shall name, and a change that makes a valid message impossible.
pub(crate) type Change<M> = (&'static str, fn(&mut M));

/// Has a valid message refused after each of these changes.
macro_rules! refused {
    ($valid:expr, $read:expr, $it:ident; $($field:literal => $change:expr;)*) => {
        $crate::support::refused_by_each($valid, $read, &[$(($field, |$it| { $change; })),*])
    };
}
pub(crate) use refused;

/// Makes each change to a message that is accepted as it is, and looks at which field is named.
pub(crate) fn refused_by_each<M: Clone, T>(
    valid: &M,
    read: impl Fn(&M) -> Result<T, WireError>,
    changes: &[Change<M>],
) {
    if let Err(error) = read(valid) {
        panic!("the message is refused before any change: {error}");
    }
    for (index, (field, change)) in changes.iter().enumerate() {
        let mut changed = valid.clone();
        change(&mut changed);
        match read(&changed) {
            Ok(_) => panic!("change {index}, of {field}, is accepted"),
            Err(WireError::Missing { field: named } | WireError::Invalid { field: named, .. }) => {
                assert_eq!(named, *field, "change {index}");
            }
            Err(error) => panic!("change {index}, of {field}: {error}"),
        }
    }
}

/// The text of a file of recorded values; empty where there is none.
pub(crate) fn recorded(file: &str) -> String {
    std::fs::read_to_string(path(file)).unwrap_or_default()
}

/// Writes a file of recorded values where the environment asks for it; says whether it did.
pub(crate) fn record(file: &str, text: &str) -> bool {
    let is_wanted = std::env::var("PPNPACK_RECORD").is_ok_and(|value| value == "1");
    if is_wanted {
        std::fs::write(path(file), text).unwrap();
    }
    is_wanted
}

fn path(file: &str) -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/golden")
        .join(file)
}
