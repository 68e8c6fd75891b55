//! `ppnpack watch`: the cells in the terminal, as they work.

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

use anyhow::Context;
use clap::Args;
use ppnpack_service::actor::{self, LatestValues};
use ppnpack_service::stream::{self, Subscription};
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::{MAX_MESSAGE_BYTES, v1};
use prost::{Message, Name};
use prost_reflect::{DescriptorPool, DynamicMessage, SerializeOptions};
use serde_json::{Value, json};

use super::call::schema;
use crate::failure::{OrRun, Outcome};
use crate::stack::connect::ConnectOptions;
use crate::text::{render, template};

/// Minimum time between two pictures.
const FRAME: Duration = Duration::from_millis(200);

/// Shows the cells as they work, until Ctrl-C.
#[derive(Debug, Args)]
pub(crate) struct WatchArguments {
    #[command(flatten)]
    connection: ConnectOptions,

    /// Draw once what is known after the connection's --wait, and end
    #[arg(long)]
    once: bool,
}

/// The newest message of each cell and stream: its name, and itself. However long drawing takes, no
/// more is kept.
type News = LatestValues<(Cell, Stream), (String, Vec<u8>)>;

/// The newest messages of each cell's streams, as JSON.
#[derive(Default)]
struct Cells(BTreeMap<Cell, BTreeMap<&'static str, Value>>);

pub(crate) fn run(arguments: &WatchArguments) -> Outcome {
    let session = arguments.connection.open()?;
    let deadline = arguments.connection.deadline()?;
    let schema = schema()?;
    let (address, mailbox) = actor::mailbox::<Infallible>(1);
    let news = News::new(&address);
    let _subscriptions = (
        follow::<v1::Session>(&session, &news, Stream::Session)?,
        follow::<v1::CellState>(&session, &news, Stream::State)?,
        follow::<v1::Decision>(&session, &news, Stream::Plan)?,
        follow::<v1::Heightmap>(&session, &news, Stream::Heightmap)?,
    );
    let mut cells = Cells::default();
    if arguments.once {
        std::thread::sleep(deadline.saturating_duration_since(Instant::now()));
        cells.take(&news, &schema)?;
        return cells.draw();
    }
    loop {
        cells.draw()?;
        let until = Instant::now() + Duration::from_secs(1);
        mailbox.receive(Some(until)).or_run()?;
        std::thread::sleep(FRAME);
        cells.take(&news, &schema)?;
    }
}

fn follow<M: Message + Name + Default + 'static>(
    session: &zenoh::Session,
    news: &News,
    stream: Stream,
) -> Outcome<Subscription> {
    let news = news.clone();
    let on_message = move |cell, message: M| {
        news.put((cell, stream), (M::full_name(), message.encode_to_vec()));
    };
    stream::subscribe(session, None, stream, MAX_MESSAGE_BYTES, on_message).or_run()
}

impl Cells {
    /// Takes in what is new.
    fn take(&mut self, news: &News, schema: &DescriptorPool) -> Outcome {
        for ((cell, stream), (name, message)) in news.take() {
            let told = as_json(schema, &name, &message).or_run()?;
            let known = self.0.entry(cell).or_default();
            known.insert(stream.as_str(), told);
        }
        Ok(())
    }

    fn draw(&self) -> Outcome {
        let pictures = self.0.iter().map(|(cell, known)| picture(cell, known));
        let mut text: String = pictures.collect::<anyhow::Result<_>>().or_run()?;
        if text.is_empty() {
            text.push_str("Nothing heard yet.\n");
        }
        let mut out = std::io::stdout().lock();
        if out.is_terminal() {
            // Home, and clear what is below.
            write!(out, "\x1b[H\x1b[J").or_run()?;
        }
        out.write_all(text.as_bytes()).or_run()?;
        out.flush().or_run()
    }
}

/// Converts a message to JSON in which every field has its value.
fn as_json(schema: &DescriptorPool, name: &str, message: &[u8]) -> anyhow::Result<Value> {
    let descriptor = schema.get_message_by_name(name);
    let descriptor = descriptor.with_context(|| format!("there is no message {name}"))?;
    let options = SerializeOptions::new()
        .use_proto_field_name(true)
        .stringify_64_bit_integers(false)
        .skip_default_fields(false);
    let message = DynamicMessage::decode(descriptor, message)?;
    Ok(message.serialize_with_options(serde_json::value::Serializer, &options)?)
}

fn picture(cell: &Cell, known: &BTreeMap<&'static str, Value>) -> anyhow::Result<String> {
    let it = json!({"cell": cell.as_str(), "known": known});
    render(template!("watch.txt"), it)
}

#[cfg(test)]
mod tests {
    use ppnpack_wire::v1::ItemState;

    use super::*;

    /// Shows a cell of which a stream had this message.
    fn shown<M: Message + Name>(stream: Stream, message: &M) -> String {
        let bytes = message.encode_to_vec();
        let told = as_json(&schema().unwrap(), &M::full_name(), &bytes).unwrap();
        let known = BTreeMap::from([(stream.as_str(), told)]);
        picture(&Cell::new("c1").unwrap(), &known).unwrap()
    }

    fn item(state: ItemState, container_sequence: u64) -> v1::SessionItem {
        v1::SessionItem {
            state: state.into(),
            container: "left".to_owned(),
            container_sequence,
            ..v1::SessionItem::default()
        }
    }

    #[test]
    fn a_session_is_shown_with_its_containers_and_what_was_set_aside() {
        let container = |name: &str, is_open, renewal_id: &str| v1::SessionContainer {
            container: name.to_owned(),
            sequence: 1,
            is_open,
            renewal_id: renewal_id.to_owned(),
            ..v1::SessionContainer::default()
        };
        let mut session = v1::Session {
            session_id: "s".to_owned(),
            items: vec![item(ItemState::Packed, 1), item(ItemState::SetAside, 0)],
            containers: vec![container("left", true, "")],
            ..v1::Session::default()
        };
        session.set_end(v1::SessionEnd::OthersSetAside);
        let told =
            "session  s: 1 packed, 0 waiting, 1 set aside, 0 gone, all packed but 1 set aside";
        let lines = |session: &v1::Session| -> Vec<String> {
            let text = shown(Stream::Session, session);
            text.lines().skip(1).map(str::to_owned).collect()
        };
        assert_eq!(lines(&session), [told]);
        session.containers.push(container("right", false, "r"));
        session.closed = vec![v1::ClosedContainer {
            container: "right".to_owned(),
            items: 7,
            text: "it is full".to_owned(),
            ..v1::ClosedContainer::default()
        }];
        let told = [
            told,
            "open     left #2: 1 items, right #2: waits for an empty one",
            "closed   right #1 with 7 items: it is full",
        ];
        assert_eq!(lines(&session), told);
    }

    #[test]
    fn a_held_cell_says_why() {
        let mut state = v1::CellState {
            holds: vec![v1::Hold {
                reason: "a door is open".to_owned(),
                id: "h1".to_owned(),
                holder: "door".to_owned(),
            }],
            ..v1::CellState::default()
        };
        let told = shown(Stream::State, &state);
        assert!(told.contains("HELD     a door is open (h1, door)"));
        state.holds.clear();
        let told = shown(Stream::State, &state);
        assert!(told.contains("robot    idle, state 0, 0 bodies") && !told.contains("HELD"));
    }

    #[test]
    fn a_decision_is_shown_with_its_pose_and_with_what_it_loads() {
        let mut decision = v1::Decision {
            item_id: "i".to_owned(),
            object: "mug".to_owned(),
            placement: Some(v1::RestingPlacement::default()),
            ..v1::Decision::default()
        };
        assert!(shown(Stream::Plan, &decision).contains("step 0    i (mug) at yaw 0"));
        decision.pose = 2;
        decision.load = Some(Box::new(v1::Load {
            item_id: "base".to_owned(),
            estimated_kg: 0.15,
            carries_kg: 0.2,
        }));
        let line = shown(Stream::Plan, &decision);
        let load = "value 0.00, on base with 0.15 of 0.20 kg, ";
        for part in ["i (mug) in pose 2 at yaw 0", load] {
            assert!(line.contains(part), "{line}");
        }
    }
}
