//! What messages are made of, and the hash that stands for it in keys.
//!
//! The hash is that of REP 2011: SHA-256 of the description as JSON, of the type itself and of all that it names, sorted by
//! name. Names of fields, types and lengths count; constants, defaults and comments do not. Source:
//! `rosidl_generator_type_description` and `type_description_interfaces` of ROS 2 Jazzy.

use std::collections::BTreeMap;

use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};

use super::messages::ServiceEventInfo;

/// What is added to the number of a type where a field has so many of it, instead of one.
const ARRAY: u8 = 48;
const BOUNDED_SEQUENCE: u8 = 96;
const SEQUENCE: u8 = 144;

/// The number of a type that has a name.
const NESTED: u8 = 1;

/// The member of a message that has none of its own.
const NO_MEMBER: &str = "structure_needs_at_least_one_member";

/// A message: its name, and its fields in their order.
pub(crate) trait Message: Serialize + DeserializeOwned + Send + Sync + 'static {
    /// Its name, such as `std_msgs/msg/Header`; requests and responses are named by their service.
    const NAME: &'static str;

    /// Its fields. A message without any has one, `uint8 structure_needs_at_least_one_member`.
    fn fields(types: &mut Types) -> Vec<Field>;
}

/// A service, which its request stands for.
pub(crate) trait Service: Message {
    /// What is answered.
    type Response: Message;
}

/// A field of a message: its name, and what it is.
#[derive(Debug, Clone)]
pub(crate) struct Field {
    pub(super) name: &'static str,
    pub(super) of: FieldType,
}

/// What a field is.
#[derive(Debug, Clone)]
pub(crate) struct FieldType {
    /// The number of its type, and above it whether there are several.
    id: u8,
    /// The name of its type, or of that of its elements.
    name: String,
    /// The length of an array, or the greatest one of a bounded sequence.
    capacity: usize,
}

impl FieldType {
    fn new(id: u8, name: &str) -> Self {
        let name = name.to_owned();
        Self {
            id,
            name,
            capacity: 0,
        }
    }

    /// Several of it.
    fn several(self, several: u8, capacity: usize) -> Self {
        let id = self.id + several;
        Self {
            id,
            capacity,
            ..self
        }
    }
}

/// What a field of a message may be.
pub(crate) trait FieldKind {
    /// Says what it is; a message is added to the types that are known.
    fn field_type(types: &mut Types) -> FieldType;
}

/// The messages that a type names, and those that they name.
#[derive(Debug, Default)]
pub(crate) struct Types(BTreeMap<String, Vec<Field>>);

impl Types {
    /// Adds a message under a name, and what it names; gives it as a field.
    fn add<M: Message>(&mut self, name: &str) -> FieldType {
        if !self.0.contains_key(name) {
            let fields = M::fields(self);
            self.0.insert(name.to_owned(), fields);
        }
        FieldType::new(NESTED, name)
    }
}

impl<M: Message> FieldKind for M {
    fn field_type(types: &mut Types) -> FieldType {
        types.add::<M>(M::NAME)
    }
}

macro_rules! simple_fields {
    ($($type:ty = $id:literal $name:literal,)*) => {
        $(
            impl FieldKind for $type {
                fn field_type(_: &mut Types) -> FieldType {
                    FieldType::new($id, $name)
                }
            }
        )*
    };
}

simple_fields! {
    u8 = 3 "uint8",
    i32 = 6 "int32",
    u32 = 7 "uint32",
    i64 = 8 "int64",
    u64 = 9 "uint64",
    f32 = 10 "float32",
    f64 = 11 "float64",
    bool = 15 "bool",
    String = 17 "string",
}

impl<T: FieldKind> FieldKind for Vec<T> {
    fn field_type(types: &mut Types) -> FieldType {
        T::field_type(types).several(SEQUENCE, 0)
    }
}

impl<T: FieldKind, const N: usize> FieldKind for [T; N] {
    fn field_type(types: &mut Types) -> FieldType {
        T::field_type(types).several(ARRAY, N)
    }
}

/// Tells whether a message has no members of its own.
pub(super) fn is_empty<M: Message>() -> bool {
    let fields = M::fields(&mut Types::default());
    matches!(fields.as_slice(), [only] if only.name == NO_MEMBER)
}

/// Gives a message's type as keys name it, with its hash.
pub(crate) fn message_key<M: Message>() -> String {
    let mut types = Types::default();
    let fields = M::fields(&mut types);
    key(M::NAME, &fields, &types)
}

/// Gives a service's type as keys name it. Its hash is that of request, response, and the event that tells of both.
pub(crate) fn service_key<S: Service>() -> String {
    let (mut types, name) = (Types::default(), S::NAME);
    let request = types.add::<S>(&format!("{name}_Request"));
    let response = types.add::<S::Response>(&format!("{name}_Response"));
    let info = types.add::<ServiceEventInfo>(ServiceEventInfo::NAME);
    let field = |name, of| Field { name, of };
    let event = vec![
        field("info", info),
        field("request", request.clone().several(BOUNDED_SEQUENCE, 1)),
        field("response", response.clone().several(BOUNDED_SEQUENCE, 1)),
    ];
    let event_name = format!("{name}_Event");
    let fields = [
        field("request_message", request),
        field("response_message", response),
        field("event_message", FieldType::new(NESTED, &event_name)),
    ];
    types.0.insert(event_name, event);
    key(name, &fields, &types)
}

/// Gives `std_msgs/msg/Bool` as `std_msgs::msg::dds_::Bool_/RIHS01_…`.
fn key(name: &str, fields: &[Field], types: &Types) -> String {
    let own = described(name, fields);
    let named = types.0.iter().map(|(name, fields)| described(name, fields));
    let named = named.collect::<Vec<_>>().join(", ");
    let json =
        format!("{{\"type_description\": {own}, \"referenced_type_descriptions\": [{named}]}}");
    let hash: [u8; 32] = Sha256::digest(json).into();
    let hash: String = hash.iter().map(|byte| format!("{byte:02x}")).collect();
    let (package, name) = name.rsplit_once('/').unwrap_or_default();
    let package = package.replace('/', "::");
    format!("{package}::dds_::{name}_/RIHS01_{hash}")
}

/// Gives a type as JSON. Its names are identifiers, in which nothing has to be escaped.
fn described(name: &str, fields: &[Field]) -> String {
    let fields = fields.iter().map(|Field { name, of }| {
        let FieldType { id, capacity, .. } = of;
        let nested = match id % ARRAY {
            NESTED => of.name.as_str(),
            _ => "",
        };
        format!(
            "{{\"name\": \"{name}\", \"type\": {{\"type_id\": {id}, \"capacity\": {capacity}, \"string_capacity\": 0, \
             \"nested_type_name\": \"{nested}\"}}}}"
        )
    });
    let fields = fields.collect::<Vec<_>>().join(", ");
    format!("{{\"type_name\": \"{name}\", \"fields\": [{fields}]}}")
}

#[cfg(test)]
mod tests {
    use super::super::messages::{
        Announce, Announcement, Begin, Body, CellState, Changed, Hold, Item, MarkerArray, Outcome,
        Session, SetBool, TfMessage, Time, Trigger, Withdraw,
    };
    use super::*;

    #[test]
    fn hashes_are_those_of_ros() {
        let keys = [
            message_key::<Time>(),
            message_key::<TfMessage>(),
            message_key::<MarkerArray>(),
            service_key::<Trigger>(),
            service_key::<SetBool>(),
        ];
        let expected = [
            "builtin_interfaces::msg::dds_::Time_/RIHS01_b106235e25a4c5ed35098aa0a61a3ee9c9b18d197f398b0e4206cea9acf9c197",
            "tf2_msgs::msg::dds_::TFMessage_/RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
            "visualization_msgs::msg::dds_::MarkerArray_/RIHS01_86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf",
            "std_srvs::srv::dds_::Trigger_/RIHS01_eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f",
            "std_srvs::srv::dds_::SetBool_/RIHS01_abe9e4bb6b41b40e6789712c00ec8871923e089af3f667a79992a428cff2da0a",
        ];
        assert_eq!(keys, expected);
    }

    /// The fields of a struct, one a line, as an interface file of the package writes them.
    fn written<M: Message>() -> String {
        let fields = M::fields(&mut Types::default()).into_iter();
        let fields = fields.filter(|field| field.name != NO_MEMBER).map(|field| {
            let of = field.of.name.replace("/msg/", "/");
            let several = if field.of.id > SEQUENCE { "[]" } else { "" };
            format!(
                "{}{several} {}\n",
                of.replace("ppnpack_msgs/", ""),
                field.name
            )
        });
        fields.collect()
    }

    fn message<M: Message>() -> (&'static str, String) {
        (M::NAME, written::<M>())
    }

    fn service<S: Service>() -> (&'static str, String) {
        let parts = written::<S>() + "---\n" + &written::<S::Response>();
        (S::NAME, parts)
    }

    /// ROS makes its types of the interface files, and this of the structs.
    #[test]
    fn interface_files_and_structs_agree() {
        let types = [
            message::<Announcement>(),
            message::<Body>(),
            message::<CellState>(),
            message::<Item>(),
            message::<Outcome>(),
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
        let listed = listed
            .lines()
            .filter(|line| line.trim().starts_with('"'))
            .count();
        let there = ["msg", "srv"].map(|of| package.join(of).read_dir().unwrap().count());
        assert_eq!((listed, there.iter().sum()), (types.len(), types.len()));
        for (name, written) in types {
            let path = name.strip_prefix("ppnpack_msgs/").unwrap();
            let of = path.split('/').next().unwrap();
            let text = std::fs::read_to_string(package.join(format!("{path}.{of}"))).unwrap();
            let is_field = |line: &&str| !(line.is_empty() || line.contains(['#', '=']));
            let fields = text
                .lines()
                .filter(is_field)
                .map(|line| format!("{line}\n"));
            assert_eq!(fields.collect::<String>(), written, "{name}");
        }
    }
}
