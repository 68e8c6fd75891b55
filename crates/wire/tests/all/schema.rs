//! The schema may grow, but what was once recorded of it stays. `PPNPACK_RECORD=1` records what is
//! new.

use std::collections::BTreeSet;

use prost_reflect::{Cardinality, DescriptorPool, FieldDescriptor, Kind};
use prost_types::FileDescriptorSet;
use prost_types::field_descriptor_proto::{Label, Type};

const FILE: &str = "schema.txt";

/// A line for each field of a message and each value of an enum.
fn lines(schema: FileDescriptorSet) -> BTreeSet<String> {
    let pool = DescriptorPool::from_file_descriptor_set(schema).unwrap();
    let messages = pool.all_messages().flat_map(|message| {
        let fields = message
            .fields()
            .map(|field| line_of(message.name(), &field));
        fields
            .chain([format!("message {}", message.name())])
            .collect::<Vec<_>>()
    });
    let enums = pool.all_enums().flat_map(|kind| {
        let line = |value: prost_reflect::EnumValueDescriptor| {
            format!(
                "enum {} {:03} {}",
                kind.name(),
                value.number(),
                value.name()
            )
        };
        kind.values().map(line).collect::<Vec<_>>()
    });
    messages.chain(enums).collect()
}

fn line_of(message: &str, field: &FieldDescriptor) -> String {
    let kind = match field.kind() {
        Kind::Message(message) => message.name().to_owned(),
        Kind::Enum(kind) => kind.name().to_owned(),
        kind => format!("{kind:?}").to_lowercase(),
    };
    let label = match (field.cardinality(), field.containing_oneof()) {
        (Cardinality::Repeated, _) => "repeated".to_owned(),
        (_, Some(oneof)) => format!("oneof:{}", oneof.name()),
        _ => "singular".to_owned(),
    };
    format!(
        "message {message} {:03} {} {kind} {label}",
        field.number(),
        field.name()
    )
}

/// What was recorded and is no longer so: those who speak the old schema would be misunderstood.
fn breaks(recorded: &BTreeSet<String>, now: &BTreeSet<String>) -> Vec<String> {
    recorded.difference(now).cloned().collect()
}

#[test]
fn what_was_recorded_of_the_schema_still_holds() {
    let recorded: BTreeSet<String> = crate::support::recorded(FILE)
        .lines()
        .map(str::to_owned)
        .collect();
    let now = lines(ppnpack_wire::schema().unwrap());
    let breaks = breaks(&recorded, &now);
    assert!(
        breaks.is_empty(),
        "these were removed or changed, which breaks clients: {breaks:#?}\nKeep them and add fields with new numbers, \
         or make a new version of the protocol. Before its first release, take the lines out of tests/golden/{FILE}"
    );
    let text: Vec<&str> = now.iter().map(String::as_str).collect();
    if recorded != now && !crate::support::record(FILE, &(text.join("\n") + "\n")) {
        let new: Vec<&String> = now.difference(&recorded).collect();
        panic!("new, to be recorded with PPNPACK_RECORD=1: {new:#?}");
    }
}

/// What the change of a schema breaks.
fn broken_by(change: impl FnOnce(&mut FileDescriptorSet)) -> Vec<String> {
    let recorded = lines(ppnpack_wire::schema().unwrap());
    let mut schema = ppnpack_wire::schema().unwrap();
    change(&mut schema);
    breaks(&recorded, &lines(schema))
}

fn message<'a>(
    schema: &'a mut FileDescriptorSet,
    name: &str,
) -> &'a mut prost_types::DescriptorProto {
    let mut messages = schema
        .file
        .iter_mut()
        .flat_map(|file| &mut file.message_type);
    messages.find(|message| message.name() == name).unwrap()
}

#[test]
fn breaking_changes_are_found_and_additions_are_none() {
    type Change = fn(&mut FileDescriptorSet);
    let slide = "message Outcome 007 slide_m";
    let cases: [(&str, &str, Change); 6] = [
        ("removed", slide, |schema| {
            let fields = &mut message(schema, "Outcome").field;
            fields.retain(|field| field.number() != 7);
        }),
        ("renumbered", slide, |schema| {
            message(schema, "Outcome").field[6].number = Some(77);
        }),
        ("of another type", slide, |schema| {
            message(schema, "Outcome").field[6].set_type(Type::Float);
        }),
        ("singular", "message Grid 004 yaws_rad", |schema| {
            message(schema, "Grid").field[3].set_label(Label::Optional);
        }),
        ("renamed", "message Grid 002 cell_m", |schema| {
            message(schema, "Grid").field[1].name = Some("edge_m".to_owned());
        }),
        ("a value", "enum Status 004 STATUS_BUSY", |schema| {
            let mut enums = schema.file.iter_mut().flat_map(|file| &mut file.enum_type);
            let status = enums.find(|kind| kind.name() == "Status").unwrap();
            status.value[4].number = Some(44);
        }),
    ];
    for (what, line, change) in cases {
        let broken = broken_by(change);
        assert_eq!(broken.len(), 1, "{what}: {broken:?}");
        assert!(broken[0].starts_with(line), "{what}: {broken:?}");
    }
    let added = broken_by(|schema| {
        let grid = message(schema, "Grid");
        let mut field = grid.field[1].clone();
        (field.name, field.number) = (Some("new_m".to_owned()), Some(9));
        field.json_name = None;
        grid.field.push(field);
    });
    assert_eq!(added, Vec::<String>::new());
}
