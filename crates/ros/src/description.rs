//! What messages are made of, and the hash that stands for it in keys.
//!
//! The hash is that of REP 2011: SHA-256 of the description as JSON, of the type itself and of all that it names, sorted by name. Names of
//! fields, types and lengths count; constants, defaults and comments do not. Source: `rosidl_generator_type_description` and
//! `type_description_interfaces` of ROS 2 Jazzy.

use std::collections::BTreeMap;
use std::fmt;

use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};

use crate::cdr::Bytes;
use crate::messages::service_msgs::ServiceEventInfo;
use crate::service::Service;

/// What is added to the number of a type where a field has one of it, or so many.
const ONE: u8 = 0;
const ARRAY: u8 = 48;
const BOUNDED_SEQUENCE: u8 = 96;
const SEQUENCE: u8 = 144;

/// The number of a type that has a name.
const NESTED: u8 = 1;

/// The member of a message that has none of its own.
const NO_MEMBER: &str = "structure_needs_at_least_one_member";

/// A message: its name, and its fields in their order.
pub trait Message: Field + Serialize + DeserializeOwned + Send + Sync + 'static {
    /// Its name, such as `std_msgs/msg/Header`.
    fn type_name() -> String;

    /// Its fields. A message without any has one, `uint8 structure_needs_at_least_one_member`.
    fn fields(types: &mut Types) -> Vec<FieldDescription>;
}

/// Whether a message has no members of its own.
pub(crate) fn is_empty<M: Message>() -> bool {
    let fields = M::fields(&mut Types::default());
    matches!(fields.as_slice(), [only] if only.name == NO_MEMBER)
}

/// What a field of a message may be.
pub trait Field {
    /// What it is; a message is added to the types that are known.
    fn field_type(types: &mut Types) -> FieldType;
}

/// What a field is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FieldType {
    /// The number of its type, or of that of its elements.
    id: u8,
    /// The name of a number or text; empty for messages.
    simple: &'static str,
    /// The name of the message that it is; empty for numbers and texts.
    nested: String,
    /// Whether it is one, an array or a sequence.
    several: u8,
    /// The length of an array, or the greatest one of a bounded sequence.
    capacity: usize,
}

/// A field: its name, and what it is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FieldDescription {
    name: &'static str,
    field_type: FieldType,
}

impl FieldDescription {
    /// A field of this name; that of a raw identifier goes without its `r#`.
    pub fn of<T: Field>(name: &'static str, types: &mut Types) -> Self {
        let name = name.strip_prefix("r#").unwrap_or(name);
        Self::new(name, T::field_type(types))
    }

    fn new(name: &'static str, field_type: FieldType) -> Self {
        Self { name, field_type }
    }
}

impl FieldType {
    fn simple(id: u8, name: &'static str) -> Self {
        Self {
            id,
            simple: name,
            nested: String::new(),
            several: ONE,
            capacity: 0,
        }
    }

    fn nested(name: String) -> Self {
        Self {
            nested: name,
            ..Self::simple(NESTED, "")
        }
    }

    /// Several of it.
    fn several(self, several: u8, capacity: usize) -> Self {
        Self {
            several,
            capacity,
            ..self
        }
    }
}

/// As an interface file writes it, such as `geometry_msgs/Pose pose`.
impl fmt::Display for FieldDescription {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let FieldType {
            simple,
            nested,
            capacity,
            ..
        } = &self.field_type;
        write!(formatter, "{simple}{}", nested.replace("/msg/", "/"))?;
        match self.field_type.several {
            ARRAY => write!(formatter, "[{capacity}]")?,
            BOUNDED_SEQUENCE => write!(formatter, "[<={capacity}]")?,
            SEQUENCE => formatter.write_str("[]")?,
            _ => {}
        }
        write!(formatter, " {}", self.name)
    }
}

/// The messages that a type names, and those that they name.
#[derive(Debug, Default)]
pub struct Types(BTreeMap<String, Vec<FieldDescription>>);

impl Types {
    /// Adds a message and what it names; gives it as a field.
    pub fn nested<M: Message>(&mut self) -> FieldType {
        let name = M::type_name();
        if self.0.contains_key(&name) {
            return FieldType::nested(name);
        }
        let fields = M::fields(self);
        self.0.insert(name.clone(), fields);
        FieldType::nested(name)
    }
}

macro_rules! simple_fields {
    ($($type:ty = $id:literal $name:literal,)*) => {
        $(
            impl Field for $type {
                fn field_type(_: &mut Types) -> FieldType {
                    FieldType::simple($id, $name)
                }
            }
        )*
    };
}

simple_fields! {
    i8 = 2 "int8",
    u8 = 3 "uint8",
    i16 = 4 "int16",
    u16 = 5 "uint16",
    i32 = 6 "int32",
    u32 = 7 "uint32",
    i64 = 8 "int64",
    u64 = 9 "uint64",
    f32 = 10 "float32",
    f64 = 11 "float64",
    bool = 15 "bool",
    String = 17 "string",
}

impl Field for Bytes {
    fn field_type(types: &mut Types) -> FieldType {
        Vec::<u8>::field_type(types)
    }
}

impl<T: Field> Field for Vec<T> {
    fn field_type(types: &mut Types) -> FieldType {
        T::field_type(types).several(SEQUENCE, 0)
    }
}

impl<T: Field, const N: usize> Field for [T; N] {
    fn field_type(types: &mut Types) -> FieldType {
        T::field_type(types).several(ARRAY, N)
    }
}

/// What stands for a type's description in keys, such as `RIHS01_df66…`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TypeHash([u8; 32]);

impl TypeHash {
    /// The hash of a message.
    pub fn of_message<M: Message>() -> Self {
        let mut types = Types::default();
        let fields = M::fields(&mut types);
        Self::new(&M::type_name(), &fields, &types)
    }

    /// The hash of a service: of its request, its response, and the event that tells of both.
    pub fn of_service<S: Service>() -> Self {
        let mut types = Types::default();
        let name = S::type_name();
        let request = types.nested::<S::Request>();
        let response = types.nested::<S::Response>();
        let event = format!("{name}_Event");
        let fields = vec![
            FieldDescription::new("info", types.nested::<ServiceEventInfo>()),
            FieldDescription::new("request", request.clone().several(BOUNDED_SEQUENCE, 1)),
            FieldDescription::new("response", response.clone().several(BOUNDED_SEQUENCE, 1)),
        ];
        types.0.insert(event.clone(), fields);
        let fields = [
            FieldDescription::new("request_message", request),
            FieldDescription::new("response_message", response),
            FieldDescription::new("event_message", FieldType::nested(event)),
        ];
        Self::new(&name, &fields, &types)
    }

    fn new(name: &str, fields: &[FieldDescription], types: &Types) -> Self {
        let own = described(name, fields);
        let named = types.0.iter().map(|(name, fields)| described(name, fields));
        let named: Vec<String> = named.collect();
        let named = named.join(", ");
        let json =
            format!("{{\"type_description\": {own}, \"referenced_type_descriptions\": [{named}]}}");
        Self(Sha256::digest(json).into())
    }
}

impl fmt::Display for TypeHash {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("RIHS01_")?;
        self.0
            .iter()
            .try_for_each(|byte| write!(formatter, "{byte:02x}"))
    }
}

/// A type as JSON. Its names are identifiers, in which nothing has to be escaped.
fn described(name: &str, fields: &[FieldDescription]) -> String {
    let fields = fields.iter().map(|FieldDescription { name, field_type }| {
        let FieldType {
            nested, capacity, ..
        } = field_type;
        let id = field_type.id + field_type.several;
        format!(
            "{{\"name\": \"{name}\", \"type\": {{\"type_id\": {id}, \"capacity\": {capacity}, \"string_capacity\": 0, \
             \"nested_type_name\": \"{nested}\"}}}}"
        )
    });
    let fields: Vec<String> = fields.collect();
    let fields = fields.join(", ");
    format!("{{\"type_name\": \"{name}\", \"fields\": [{fields}]}}")
}
