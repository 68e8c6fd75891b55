//! Messages of ROS 2, as structs: those of its own packages that are needed here, and those of
//! `ppnpack_msgs`.
//!
//! Names of structs and fields are those of ROS, but that a struct does not begin with two
//! capitals. What they mean stands in ROS's own interface files, and in those of
//! `ros/ppnpack_msgs`, which a test holds the structs against. Lengths are in metres, rotations are
//! unit quaternions. A service is its request; where it names no response, that is [`Done`].

use ppnpack_service::clock::now_ns;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

const SECOND_NS: u64 = 1_000_000_000;

/// A message, or a part of one.
pub(crate) trait Message: Serialize + DeserializeOwned + Send + Sync + 'static {
    /// Its name, such as `std_msgs/msg/Header`; a response has none of its own.
    const NAME: &'static str;

    /// The names and types of its fields, in the order that ROS has them in.
    #[cfg(test)]
    const FIELDS: &'static [(&'static str, &'static str)];
}

/// A message that is published, or stands as a request for its service.
pub(crate) trait Typed: Message {
    /// The hash of its type, or of its service's: SHA-256 of the description that REP 2011
    /// prescribes. It changes with any field.
    const HASH: &'static str;

    /// Gives its type as keys name it, such as `std_msgs::msg::dds_::Bool_/RIHS01_…`.
    fn key() -> String {
        let (package, name) = Self::NAME.rsplit_once('/').unwrap_or_default();
        let (package, hash) = (package.replace('/', "::"), Self::HASH);
        format!("{package}::dds_::{name}_/RIHS01_{hash}")
    }
}

/// A service, which its request stands for.
pub(crate) trait Service: Typed {
    type Response: Message;
}

/// Structs that are messages: each with its fields in the order that ROS has them in.
macro_rules! messages {
    ($(
        $name:ident = $type_name:literal $(hash $hash:literal)?
        { $($field:ident: $of:ty),* $(,)? } $(=> $response:ty)?
    )*) => {
        $(
            #[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
            pub(crate) struct $name {
                $(pub(crate) $field: $of,)*
            }

            impl Message for $name {
                const NAME: &'static str = $type_name;

                #[cfg(test)]
                const FIELDS: &'static [(&'static str, &'static str)] =
                    &[$((stringify!($field), stringify!($of)),)*];
            }

            $(impl Typed for $name {
                const HASH: &'static str = $hash;
            })?

            $(impl Service for $name {
                type Response = $response;
            })?
        )*
    };
}

messages! {
    Time = "builtin_interfaces/msg/Time" { sec: i32, nanosec: u32 }
    Header = "std_msgs/msg/Header" { stamp: Time, frame_id: String }

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
    TfMessage = "tf2_msgs/msg/TFMessage"
        hash "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087" {
        transforms: Vec<TransformStamped>,
    }

    Trigger = "std_srvs/srv/Trigger"
        hash "eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f" {
        structure_needs_at_least_one_member: u8,
    } => Done
    SetBool = "std_srvs/srv/SetBool"
        hash "abe9e4bb6b41b40e6789712c00ec8871923e089af3f667a79992a428cff2da0a" {
        data: bool,
    } => Done
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
    CellState = "ppnpack_msgs/msg/CellState"
        hash "8e084bd6a3c4107d13391630081b7f287a37eee69a6f39e1388b390dc7ff00fe" {
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
    Session = "ppnpack_msgs/msg/Session"
        hash "5fc6bbce1b8e7cef99ebcf5e19ce491501cfa28dcba6f2dec135c25e679c2d12" {
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

    Announce = "ppnpack_msgs/srv/Announce"
        hash "1cecc98ba34d3fabc4ccf1fbeac51d8fe7324564172075f53e5ca771e05961f7" {
        items: Vec<Announcement>,
    } => Done
    Begin = "ppnpack_msgs/srv/Begin"
        hash "cd4791f645e66c1b32c23295c1356d8af03faf83be594a63bd92ba4881592289" {
        session_id: String,
        is_automatic: bool,
        least_state_number: u64,
        gives_up_pending: bool,
    } => Done
    Changed = "ppnpack_msgs/srv/Changed"
        hash "79cb6a0b7cd505e1479b55c7931c9c6da42349bac5a65e531cef6639b33b1e2e" {
        removed_item_ids: Vec<String>,
    } => Done
    Hold = "ppnpack_msgs/srv/Hold"
        hash "bfcf16c0ed18f07835a3f64df81a5757b443ea78b46c4d804c23c1926db69016" {
        reason: String,
        is_aborting: bool,
    } => Done
    Withdraw = "ppnpack_msgs/srv/Withdraw"
        hash "e798d5c39a374482ac12c1875311e2ef6033f55463698a181d6a80ab2d3060c3" {
        item_id: String,
    } => Done
}

impl Time {
    /// Gives the time of day.
    pub(crate) fn now() -> Self {
        let now_ns = now_ns();
        Self {
            sec: i32::try_from(now_ns / SECOND_NS).unwrap_or(i32::MAX),
            nanosec: u32::try_from(now_ns % SECOND_NS).unwrap_or_default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A field's type as interface files of the package write it.
    fn of_ros(of: &str) -> String {
        let element = of.strip_prefix("Vec<").and_then(|of| of.strip_suffix('>'));
        if let Some(element) = element {
            return of_ros(element) + "[]";
        }
        let known = match of {
            "u8" => "uint8",
            "u32" => "uint32",
            "u64" => "uint64",
            "f64" => "float64",
            "String" => "string",
            "Header" => "std_msgs/Header",
            "Pose" => "geometry_msgs/Pose",
            same => same,
        };
        known.to_owned()
    }

    /// The fields of a struct, one a line, as an interface file of the package writes them.
    fn written<M: Message>() -> String {
        let fields = M::FIELDS.iter();
        let lines = fields.map(|(name, of)| format!("{} {name}\n", of_ros(of)));
        lines.collect()
    }

    fn message<M: Message>() -> (&'static str, String) {
        (M::NAME, written::<M>())
    }

    fn service<S: Service>() -> (&'static str, String) {
        let parts = written::<S>() + "---\n" + &written::<S::Response>();
        (S::NAME, parts)
    }

    /// ROS makes its types of the interface files. Where one changes, so does a hash.
    #[test]
    fn interface_files_and_structs_agree() {
        let types = [
            message::<Announcement>(),
            message::<Body>(),
            message::<CellState>(),
            message::<Item>(),
            message::<Session>(),
            service::<Announce>(),
            service::<Begin>(),
            service::<Changed>(),
            service::<Hold>(),
            service::<Withdraw>(),
        ];
        let package = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../ros/ppnpack_msgs");
        let package = std::path::Path::new(package);
        let listed = std::fs::read_to_string(package.join("CMakeLists.txt")).unwrap();
        let lines = listed.lines().map(str::trim);
        let listed = lines.filter(|line| line.starts_with('"')).count();
        let there = ["msg", "srv"].map(|of| package.join(of).read_dir().unwrap().count());
        assert_eq!((listed, there.iter().sum()), (types.len(), types.len()));
        for (name, written) in types {
            let path = name.strip_prefix("ppnpack_msgs/").unwrap();
            let of = path.split('/').next().unwrap();
            let text = std::fs::read_to_string(package.join(format!("{path}.{of}"))).unwrap();
            let is_field = |line: &&str| !(line.is_empty() || line.contains(['#', '=']));
            let fields = text.lines().filter(is_field);
            let fields = fields.map(|line| format!("{line}\n"));
            assert_eq!(fields.collect::<String>(), written, "{name}");
        }
    }
}
