//! `ppnpack watch`: the cells in the terminal, as they work.

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

use clap::Args;
use ppnpack_service::actor::{self, LatestValues};
use ppnpack_service::stream::{self, Subscription};
use ppnpack_wire::MAX_MESSAGE_BYTES;
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::v1::{self, ItemState};
use prost::{Message, Name};

use crate::failure::{OrRun, Outcome};
use crate::stack::connect::ConnectOptions;

/// How often the picture is drawn at most.
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

/// What is known of a cell.
#[derive(Default)]
struct CellView {
    session: Option<v1::Session>,
    state: Option<v1::CellState>,
    decision: Option<v1::Decision>,
    heightmap: Option<v1::Heightmap>,
}

/// What the newest message of each cell and stream changes in what is known of the cell.
type News = LatestValues<(Cell, Stream), Box<dyn FnOnce(&mut CellView) + Send>>;

pub(crate) fn run(arguments: &WatchArguments) -> Outcome {
    let session = arguments.connection.open()?;
    let deadline = arguments.connection.deadline()?;
    let (address, mailbox) = actor::mailbox::<Infallible>(1);
    let news = News::new(&address);
    let _subscriptions = (
        follow(&session, &news, Stream::Session, |view| &mut view.session)?,
        follow(&session, &news, Stream::State, |view| &mut view.state)?,
        follow(&session, &news, Stream::Plan, |view| &mut view.decision)?,
        follow(&session, &news, Stream::Heightmap, |view| {
            &mut view.heightmap
        })?,
    );
    let mut cells = BTreeMap::new();
    if arguments.once {
        std::thread::sleep(deadline.saturating_duration_since(Instant::now()));
        take(&news, &mut cells);
        return draw(&cells);
    }
    loop {
        draw(&cells)?;
        mailbox
            .receive(Some(Instant::now() + Duration::from_secs(1)))
            .or_run()?;
        std::thread::sleep(FRAME);
        take(&news, &mut cells);
    }
}

/// Takes in what is new.
fn take(news: &News, cells: &mut BTreeMap<Cell, CellView>) {
    for ((cell, _), change) in news.take() {
        change(cells.entry(cell).or_default());
    }
}

/// Keeps the newest message of a stream of every cell: however long drawing takes, no more is kept.
fn follow<M: Message + Name + Default + 'static>(
    session: &zenoh::Session,
    news: &News,
    stream: Stream,
    place: fn(&mut CellView) -> &mut Option<M>,
) -> Outcome<Subscription> {
    let news = news.clone();
    let on_message = move |cell, message| {
        let change = move |view: &mut CellView| *place(view) = Some(message);
        news.put((cell, stream), Box::new(change));
    };
    stream::subscribe(session, None, stream, MAX_MESSAGE_BYTES, on_message).or_run()
}

fn draw(cells: &BTreeMap<Cell, CellView>) -> Outcome {
    let pictures = cells.iter().map(|(cell, view)| picture(cell, view));
    let mut text: String = pictures.collect();
    if cells.is_empty() {
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

fn picture(cell: &Cell, view: &CellView) -> String {
    let mut lines = vec![format!("── {cell} {}", "─".repeat(40))];
    if let Some(session) = &view.session {
        lines.push(progress(session));
        lines.extend(containers(session));
    }
    if let Some(state) = &view.state {
        let doing = match state.executing_placement_id.as_str() {
            "" => "idle".to_owned(),
            placement => format!("placing {placement}"),
        };
        lines.push(format!(
            "robot    {doing}, state {}, {} bodies",
            state.state_number,
            state.bodies.len()
        ));
        let held = state.hold.iter();
        lines.extend(held.map(|hold| format!("HELD     {}", hold.reason)));
    }
    if let Some(decision) = &view.decision {
        lines.push(last_decision(decision));
        let reasons = decision.degraded.iter();
        lines.extend(reasons.map(|reason| format!("degraded {reason}")));
    }
    if let Some(heightmap) = &view.heightmap {
        let doubts = heightmap.quality.iter().flat_map(|quality| &quality.doubts);
        lines.extend(doubts.map(|doubt| format!("doubtful {}", doubt.message)));
    }
    lines.join("\n") + "\n"
}

fn progress(session: &v1::Session) -> String {
    let count = |state: ItemState| {
        let items = session.items.iter();
        items.filter(|item| item.state() == state).count()
    };
    let set_aside = count(ItemState::SetAside);
    let end = match session.end() {
        v1::SessionEnd::Unspecified => String::new(),
        v1::SessionEnd::AllPacked => ", all packed".to_owned(),
        v1::SessionEnd::OthersSetAside => format!(", all packed but {set_aside} set aside"),
        v1::SessionEnd::NothingFits => ", nothing fits any more".to_owned(),
        v1::SessionEnd::Failed => format!(", failed: {}", session.failure),
    };
    format!(
        "session  {}: {} packed, {} waiting, {set_aside} set aside, {} gone{end}",
        session.session_id,
        count(ItemState::Packed),
        count(ItemState::Waiting),
        count(ItemState::Gone)
    )
}

/// The containers of a cell that has several, and how many were closed.
fn containers(session: &v1::Session) -> Vec<String> {
    if session.containers.len() < 2 && session.closed.is_empty() {
        return Vec::new();
    }
    let containers = session.containers.iter().map(|container| {
        let lies_there = |item: &&v1::SessionItem| {
            item.state() == ItemState::Packed
                && (&item.container, item.container_sequence)
                    == (&container.container, container.sequence)
        };
        let items = session.items.iter().filter(lies_there).count();
        let state = match (container.is_open, container.renewal_id.as_str()) {
            (true, _) => format!("{items} items"),
            (false, "") => "closed".to_owned(),
            (false, _) => "waits for an empty one".to_owned(),
        };
        let name = match container.container.as_str() {
            "" => "the container",
            name => name,
        };
        format!("{name} #{}: {state}", container.sequence + 1)
    });
    let containers: Vec<String> = containers.collect();
    let mut lines = vec![format!("open     {}", containers.join(", "))];
    lines.extend(session.closed.last().map(|closed| {
        let name = match closed.container.as_str() {
            "" => String::new(),
            name => format!("{name} "),
        };
        format!(
            "closed   {name}#{} with {} items: {}",
            closed.sequence + 1,
            closed.items,
            closed.text
        )
    }));
    lines
}

fn last_decision(decision: &v1::Decision) -> String {
    let total_ns: u64 = decision.stages.iter().map(|stage| stage.duration_ns).sum();
    let at = decision.placement.unwrap_or_default();
    let pose = match decision.pose {
        0 => String::new(),
        pose => format!("in pose {pose} "),
    };
    let load = decision.load.as_deref().map_or_else(String::new, |load| {
        format!(
            ", on {} with {:.2} of {:.2} kg",
            load.item_id, load.estimated_kg, load.carries_kg
        )
    });
    format!(
        "step {:<4} {} ({}) {pose}at yaw {} cell ({}, {}) height {}, value {:.2}{load}, {:.2} ms",
        decision.step,
        decision.item_id,
        decision.object,
        at.yaw,
        at.x,
        at.y,
        at.resting_height,
        decision.value,
        total_ns as f64 / 1e6
    )
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let shown =
            "session  s: 1 packed, 0 waiting, 1 set aside, 0 gone, all packed but 1 set aside";
        assert_eq!(progress(&session), shown);
        assert!(containers(&session).is_empty());
        session.containers.push(container("right", false, "r"));
        session.closed = vec![v1::ClosedContainer {
            container: "right".to_owned(),
            items: 7,
            text: "it is full".to_owned(),
            ..v1::ClosedContainer::default()
        }];
        let shown = [
            "open     left #2: 1 items, right #2: waits for an empty one",
            "closed   right #1 with 7 items: it is full",
        ];
        assert_eq!(containers(&session), shown);
    }

    #[test]
    fn a_held_cell_says_why() {
        let cell = Cell::new("c1").unwrap();
        let hold = v1::Hold {
            reason: "a door is open".to_owned(),
        };
        let mut view = CellView {
            state: Some(v1::CellState {
                hold: Some(hold),
                ..v1::CellState::default()
            }),
            ..CellView::default()
        };
        assert!(picture(&cell, &view).contains("HELD     a door is open"));
        view.state = Some(v1::CellState::default());
        assert!(!picture(&cell, &view).contains("HELD"));
    }

    #[test]
    fn a_decision_is_shown_with_its_pose_and_with_what_it_loads() {
        let mut decision = v1::Decision {
            item_id: "i".to_owned(),
            object: "mug".to_owned(),
            ..v1::Decision::default()
        };
        assert!(last_decision(&decision).contains("i (mug) at yaw 0"));
        decision.pose = 2;
        decision.load = Some(Box::new(v1::Load {
            item_id: "base".to_owned(),
            estimated_kg: 0.15,
            carries_kg: 0.2,
        }));
        let line = last_decision(&decision);
        for part in [
            "i (mug) in pose 2 at yaw 0",
            "value 0.00, on base with 0.15 of 0.20 kg, ",
        ] {
            assert!(line.contains(part), "{line}");
        }
    }
}
