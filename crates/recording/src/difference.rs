//! The first difference between two messages.

use std::fmt;

use ppnpack_wire::schema;
use prost::{Message, Name};
use prost_reflect::{DescriptorPool, DynamicMessage, FieldDescriptor, ReflectMessage, Value};

use crate::error::RecordingError;

/// The first field that two messages do not have alike.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Difference {
    /// Its path, such as `placement.placement.x` or `alternatives[2].value`.
    pub field: String,
    /// Its value in the first message.
    pub first: String,
    /// Its value in the second.
    pub second: String,
}

/// Maximum length of the text of a value, in bytes.
const MOST_SHOWN_BYTES: usize = 200;

/// Finds the first field, in the order of the schema, in which two messages differ by any bit.
/// `None` where they are the same.
///
/// # Errors
/// [`RecordingError::Message`] where it is no message of this protocol.
pub fn difference<M: Message + Name>(
    first: &M,
    second: &M,
) -> Result<Option<Difference>, RecordingError> {
    let dynamic = |message: &M| dynamic(message).map_err(RecordingError::Message);
    Ok(of_messages("", &dynamic(first)?, &dynamic(second)?))
}

fn dynamic<M: Message + Name>(message: &M) -> Result<DynamicMessage, String> {
    let schema = schema().map_err(|error| error.to_string())?;
    let pool = DescriptorPool::from_file_descriptor_set(schema);
    let pool = pool.map_err(|error| error.to_string())?;
    let name = M::full_name();
    let descriptor = pool.get_message_by_name(&name);
    let descriptor = descriptor.ok_or_else(|| format!("{name} is not known"))?;
    let decoded = DynamicMessage::decode(descriptor, message.encode_to_vec().as_slice());
    decoded.map_err(|error| error.to_string())
}

fn of_messages(at: &str, first: &DynamicMessage, second: &DynamicMessage) -> Option<Difference> {
    let mut fields: Vec<_> = first.descriptor().fields().collect();
    fields.sort_by_key(FieldDescriptor::number);
    fields.iter().find_map(|field| {
        let name = match at {
            "" => field.name().to_owned(),
            at => format!("{at}.{}", field.name()),
        };
        match (first.has_field(field), second.has_field(field)) {
            (false, false) => None,
            (true, true) => of_values(&name, &first.get_field(field), &second.get_field(field)),
            _ => Some(different(
                &name,
                shown_field(field, first),
                shown_field(field, second),
            )),
        }
    })
}

/// Shows a field of a message; a number that is not there is 0.
fn shown_field(field: &FieldDescriptor, message: &DynamicMessage) -> String {
    let may_lack = field.supports_presence() || field.is_list();
    match may_lack && !message.has_field(field) {
        true => "nothing".to_owned(),
        false => shown(&message.get_field(field)),
    }
}

fn of_values(at: &str, first: &Value, second: &Value) -> Option<Difference> {
    let both = || different(at, shown(first), shown(second));
    match (first, second) {
        (Value::Message(first), Value::Message(second)) => of_messages(at, first, second),
        (Value::List(first), Value::List(second)) => {
            let mut pairs = first.iter().zip(second).enumerate();
            let found = pairs.find_map(|(index, (first, second))| {
                of_values(&format!("{at}[{index}]"), first, second)
            });
            found.or_else(|| {
                let count = |list: &[Value]| format!("{} of them", list.len());
                let is_longer = first.len() != second.len();
                is_longer.then(|| different(at, count(first), count(second)))
            })
        }
        // Zeros and numbers that are none are compared as they are written.
        (Value::F64(a), Value::F64(b)) => (a.to_bits() != b.to_bits()).then(both),
        (Value::F32(a), Value::F32(b)) => (a.to_bits() != b.to_bits()).then(both),
        _ => (first != second).then(both),
    }
}

fn different(at: &str, first: String, second: String) -> Difference {
    let field = at.to_owned();
    Difference {
        field,
        first,
        second,
    }
}

fn shown(value: &Value) -> String {
    let text = match value {
        Value::String(text) => format!("'{text}'"),
        Value::F64(number) => number.to_string(),
        Value::F32(number) => number.to_string(),
        Value::I32(number) | Value::EnumNumber(number) => number.to_string(),
        Value::I64(number) => number.to_string(),
        Value::U32(number) => number.to_string(),
        Value::U64(number) => number.to_string(),
        Value::Bool(is_so) => is_so.to_string(),
        Value::Bytes(bytes) => format!("{} bytes", bytes.len()),
        Value::List(list) => format!("{} of them", list.len()),
        Value::Map(map) => format!("{} of them", map.len()),
        Value::Message(message) => format!("a {}", message.descriptor().name()),
    };
    let end = text.floor_char_boundary(MOST_SHOWN_BYTES);
    match text.get(..end) {
        Some(part) if end < text.len() => format!("{part}..."),
        _ => text,
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            formatter,
            "{}: {} and {}",
            self.field, self.first, self.second
        )
    }
}

#[cfg(test)]
mod tests {
    use ppnpack_wire::v1;

    use super::*;

    fn decision() -> v1::Decision {
        v1::Decision {
            item_id: "a".to_owned(),
            value: 0.1,
            container_from_item: Some(v1::Pose {
                position: Some(v1::Vector3 {
                    x_m: 1.0,
                    ..v1::Vector3::default()
                }),
                orientation: None,
            }),
            alternatives: vec![
                v1::RankedPlacement::default(),
                v1::RankedPlacement::default(),
            ],
            ..v1::Decision::default()
        }
    }

    fn found(change: impl FnOnce(&mut v1::Decision)) -> Option<[String; 3]> {
        let mut other = decision();
        change(&mut other);
        let difference = difference(&decision(), &other).unwrap();
        difference.map(|found| [found.field, found.first, found.second])
    }

    #[test]
    fn the_first_field_that_is_not_alike_is_named_with_both_values() {
        assert_eq!(found(|_| {}), None);
        let next = 0.1_f64.next_up();
        let expected = ["value".to_owned(), "0.1".to_owned(), next.to_string()];
        assert_eq!(found(|other| other.value = next), Some(expected));
        let moved = found(|other| {
            let pose = other.container_from_item.as_mut().unwrap();
            pose.position.as_mut().unwrap().x_m = 2.0;
            other.value = 7.0;
        });
        let expected = ["container_from_item.position.x_m", "1", "2"];
        assert_eq!(moved, Some(expected.map(str::to_owned)));
        let ranked = found(|other| other.alternatives[1].value = 3.0);
        let expected = ["alternatives[1].value", "0", "3"];
        assert_eq!(ranked, Some(expected.map(str::to_owned)));
        let fewer = found(|other| other.alternatives.truncate(1));
        let expected = ["alternatives", "2 of them", "1 of them"];
        assert_eq!(fewer, Some(expected.map(str::to_owned)));
        let gone = found(|other| other.container_from_item = None).unwrap();
        assert_eq!([&gone[0], &gone[2]], ["container_from_item", "nothing"]);
    }
}
