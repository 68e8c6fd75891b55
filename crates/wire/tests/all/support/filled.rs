//! Messages with a value in every field.

use prost_reflect::{
    DescriptorPool, DynamicMessage, FieldDescriptor, Kind, MessageDescriptor, Value,
};

pub(crate) fn pool() -> DescriptorPool {
    DescriptorPool::from_file_descriptor_set(ppnpack_wire::schema().unwrap()).unwrap()
}

/// A message with every field set; of alternatives the one of this index, or the last.
pub(crate) fn filled(message: &MessageDescriptor, alternative: usize) -> DynamicMessage {
    let mut filled = DynamicMessage::new(message.clone());
    for field in message.fields() {
        let is_other = field.containing_oneof().is_some_and(|oneof| {
            let fields: Vec<FieldDescriptor> = oneof.fields().collect();
            fields[alternative.min(fields.len() - 1)] != field
        });
        if is_other {
            continue;
        }
        let set = if field.is_list() {
            Value::List((0..2).map(|index| value(&field, index)).collect())
        } else {
            value(&field, 0)
        };
        filled.set_field(&field, set);
    }
    filled
}

/// A value that is no default, and differs from that of other fields.
fn value(field: &FieldDescriptor, index: u32) -> Value {
    let number = field.number() * 10 + index;
    match field.kind() {
        Kind::Bool => Value::Bool(true),
        Kind::Uint32 => Value::U32(number + 1000),
        Kind::Uint64 => Value::U64(u64::from(number) + (1 << 40)),
        Kind::Int64 => Value::I64(i64::from(number) - (1 << 40)),
        Kind::Double => Value::F64(f64::from(number) + 0.25),
        Kind::String => Value::String(format!("{}-{index}", field.name())),
        Kind::Bytes => Value::Bytes(vec![number as u8, 0, 0xff].into()),
        Kind::Enum(kind) => {
            let values: Vec<i32> = kind.values().map(|value| value.number()).collect();
            Value::EnumNumber(values[1 + number as usize % (values.len() - 1)])
        }
        Kind::Message(message) => Value::Message(filled(&message, index as usize)),
        kind => panic!("a field of type {kind:?} needs a value here"),
    }
}
