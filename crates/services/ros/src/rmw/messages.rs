//! Messages of ROS 2, as structs: those of its own packages that are needed here, and those of `ppnpack_msgs`.
//!
//! Names of structs and fields are those of ROS, but that a struct does not begin with two capitals. What they mean stands in
//! ROS's own interface files, and in those of `ros/ppnpack_msgs`, which a test holds the structs against. Lengths are in metres,
//! rotations are unit quaternions. A service is its request; where it names no response, that is [`Done`].

use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use super::description::{Field, FieldKind, Message, Service, Types};

/// Nanoseconds of a second.
const SECOND_NS: i64 = 1_000_000_000;

/// Structs that are messages: each with its fields in the order that ROS has them in.
macro_rules! messages {
    ($($name:ident = $type_name:literal { $($field:ident: $of:ty),* $(,)? } $(=> $response:ty)?)*) => {
        $(
            #[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
            pub(crate) struct $name {
                $(pub(crate) $field: $of,)*
            }

            impl Message for $name {
                const NAME: &'static str = $type_name;

                fn fields(types: &mut Types) -> Vec<Field> {
                    vec![$(Field {
                        name: stringify!($field).trim_start_matches("r#"),
                        of: <$of>::field_type(types),
                    },)*]
                }
            }

            $(impl Service for $name {
                type Response = $response;
            })?
        )*
    };
}

messages! {
    Time = "builtin_interfaces/msg/Time" { sec: i32, nanosec: u32 }
    Duration = "builtin_interfaces/msg/Duration" { sec: i32, nanosec: u32 }
    Header = "std_msgs/msg/Header" { stamp: Time, frame_id: String }
    ColorRgba = "std_msgs/msg/ColorRGBA" { r: f32, g: f32, b: f32, a: f32 }
    ServiceEventInfo = "service_msgs/msg/ServiceEventInfo" {
        event_type: u8,
        stamp: Time,
        client_gid: [u8; 16],
        sequence_number: i64,
    }

    Point = "geometry_msgs/msg/Point" { x: f64, y: f64, z: f64 }
    Vector3 = "geometry_msgs/msg/Vector3" { x: f64, y: f64, z: f64 }
    Quaternion = "geometry_msgs/msg/Quaternion" { x: f64, y: f64, z: f64, w: f64 }
    Pose = "geometry_msgs/msg/Pose" { position: Point, orientation: Quaternion }
    Transform = "geometry_msgs/msg/Transform" { translation: Vector3, rotation: Quaternion }
    TransformStamped = "geometry_msgs/msg/TransformStamped" {
        header: Header,
        child_frame_id: String,
        transform: Transform,
    }
    TfMessage = "tf2_msgs/msg/TFMessage" { transforms: Vec<TransformStamped> }

    CompressedImage = "sensor_msgs/msg/CompressedImage" { header: Header, format: String, data: Vec<u8> }

    UvCoordinate = "visualization_msgs/msg/UVCoordinate" { u: f32, v: f32 }
    MeshFile = "visualization_msgs/msg/MeshFile" { filename: String, data: Vec<u8> }
    Marker = "visualization_msgs/msg/Marker" {
        header: Header,
        ns: String,
        id: i32,
        r#type: i32,
        action: i32,
        pose: Pose,
        scale: Vector3,
        color: ColorRgba,
        lifetime: Duration,
        frame_locked: bool,
        points: Vec<Point>,
        colors: Vec<ColorRgba>,
        texture_resource: String,
        texture: CompressedImage,
        uv_coordinates: Vec<UvCoordinate>,
        text: String,
        mesh_resource: String,
        mesh_file: MeshFile,
        mesh_use_embedded_materials: bool,
    }
    MarkerArray = "visualization_msgs/msg/MarkerArray" { markers: Vec<Marker> }

    Trigger = "std_srvs/srv/Trigger" { structure_needs_at_least_one_member: u8 } => Done
    SetBool = "std_srvs/srv/SetBool" { data: bool } => Done
    Done = "" { success: bool, message: String }

    Announcement = "ppnpack_msgs/msg/Announcement" {
        item_id: String,
        object: String,
        is_fragile: bool,
        is_bottom_only: bool,
        is_upright: bool,
    }
    Body = "ppnpack_msgs/msg/Body" {
        item_id: String,
        object: String,
        pose: Pose,
        is_inside: bool,
        is_found: bool,
    }
    CellState = "ppnpack_msgs/msg/CellState" {
        header: Header,
        state_number: u64,
        executing_placement_id: String,
        bodies: Vec<Body>,
        is_simulated: bool,
        is_held: bool,
        hold_reason: String,
    }
    Item = "ppnpack_msgs/msg/Item" {
        item_id: String,
        object: String,
        state: u8,
        container: String,
        pose: Pose,
    }
    Outcome = "ppnpack_msgs/msg/Outcome" {
        header: Header,
        placement_id: String,
        item_id: String,
        kind: u8,
        failure: String,
        has_pose: bool,
        pose: Pose,
        is_found: bool,
        is_inside: bool,
        slide_m: f64,
        tilt_rad: f64,
        state_number: u64,
    }
    Session = "ppnpack_msgs/msg/Session" {
        header: Header,
        session_id: String,
        items: Vec<Item>,
        pending_decision_id: String,
        step: u64,
        is_automatic: bool,
        buffer: u32,
        end: u8,
        failure: String,
    }

    Announce = "ppnpack_msgs/srv/Announce" { items: Vec<Announcement> } => Done
    Begin = "ppnpack_msgs/srv/Begin" {
        session_id: String,
        is_automatic: bool,
        least_state_number: u64,
        gives_up_pending: bool,
    } => Done
    Changed = "ppnpack_msgs/srv/Changed" { removed_item_ids: Vec<String> } => Done
    Hold = "ppnpack_msgs/srv/Hold" { reason: String, is_aborting: bool } => Done
    Withdraw = "ppnpack_msgs/srv/Withdraw" { item_id: String } => Done
}

impl Time {
    /// Gives the time so many nanoseconds after 1970; what it cannot tell is moved to where it can.
    pub(crate) fn from_ns(at_ns: i64) -> Self {
        let seconds = at_ns.div_euclid(SECOND_NS);
        let sec = seconds.clamp(i32::MIN.into(), i32::MAX.into());
        Self {
            sec: i32::try_from(sec).unwrap_or_default(),
            nanosec: u32::try_from(at_ns.rem_euclid(SECOND_NS)).unwrap_or_default(),
        }
    }

    /// Gives the time of day.
    pub(crate) fn now() -> Self {
        Self::from_ns(now_ns())
    }
}

impl Quaternion {
    /// No rotation; the default is none, and no rotation of ROS.
    pub(crate) const IDENTITY: Self = Self {
        x: 0.0,
        y: 0.0,
        z: 0.0,
        w: 1.0,
    };
}

/// Gives the time of day, in nanoseconds since 1970.
pub(super) fn now_ns() -> i64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    now.map_or(0, |now| i64::try_from(now.as_nanos()).unwrap_or(i64::MAX))
}
