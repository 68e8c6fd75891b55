//! `ppnpack watch`: the cells in the terminal, as they work.

use std::collections::BTreeMap;
use std::io::{IsTerminal, Write};
use std::sync::mpsc::{self, Receiver, Sender};
use std::time::{Duration, Instant};

use clap::Args;
use ppnpack_service::stream::{self, Subscription};
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::v1::{self, ItemState};
use ppnpack_wire::{MAX_MESSAGE_BYTES, convert};
use prost::{Message, Name};

use crate::failure::{OrRun, Outcome};
use crate::stack::connect::ConnectOptions;

/// How often the picture is drawn at most.
const FRAME: Duration = Duration::from_millis(200);

/// Columns and rows that a heightmap is drawn in at most.
const PICTURE: (usize, usize) = (48, 16);

/// From empty to the rim.
const SHADES: [char; 5] = [' ', '░', '▒', '▓', '█'];

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

/// What a message changes in what is known of its cell.
type News = (Cell, Box<dyn FnOnce(&mut CellView) + Send>);

pub(crate) fn run(arguments: &WatchArguments) -> Outcome {
    let session = arguments.connection.open()?;
    let deadline = arguments.connection.deadline()?;
    let (tell, news) = mpsc::channel();
    let _subscriptions = (
        follow(&session, &tell, Stream::Session, |view| &mut view.session)?,
        follow(&session, &tell, Stream::State, |view| &mut view.state)?,
        follow(&session, &tell, Stream::Plan, |view| &mut view.decision)?,
        follow(&session, &tell, Stream::Heightmap, |view| {
            &mut view.heightmap
        })?,
    );
    let mut cells = BTreeMap::new();
    if arguments.once {
        while take(&news, deadline, &mut cells) {}
        return draw(&cells);
    }
    loop {
        draw(&cells)?;
        take(&news, Instant::now() + Duration::from_secs(1), &mut cells);
        let next = Instant::now() + FRAME;
        while take(&news, next, &mut cells) {}
    }
}

/// Takes in one message, where one comes until then.
fn take(news: &Receiver<News>, until: Instant, cells: &mut BTreeMap<Cell, CellView>) -> bool {
    let left = until.saturating_duration_since(Instant::now());
    let Ok((cell, change)) = news.recv_timeout(left) else {
        return false;
    };
    change(cells.entry(cell).or_default());
    true
}

/// Tells the messages of a stream of every cell; the newest stays in its place.
fn follow<M: Message + Name + Default + 'static>(
    session: &zenoh::Session,
    tell: &Sender<News>,
    stream: Stream,
    place: fn(&mut CellView) -> &mut Option<M>,
) -> Outcome<Subscription> {
    let tell = tell.clone();
    let take = move |cell, message: M| {
        // Nobody watches any more where this fails.
        let change = move |view: &mut CellView| *place(view) = Some(message);
        tell.send((cell, Box::new(change))).ok();
    };
    stream::subscribe(session, None, stream, MAX_MESSAGE_BYTES, take).or_run()
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
    }
    if let Some(decision) = &view.decision {
        lines.push(last_decision(decision));
        let reasons = decision.degraded.iter();
        lines.extend(reasons.map(|reason| format!("degraded {reason}")));
    }
    if let Some(heightmap) = &view.heightmap {
        let doubts = heightmap.quality.iter().flat_map(|quality| &quality.doubts);
        lines.extend(doubts.map(|doubt| format!("doubtful {}", doubt.message)));
        lines.extend(heights(heightmap));
    }
    lines.join("\n") + "\n"
}

fn progress(session: &v1::Session) -> String {
    let count = |state: ItemState| {
        let items = session.items.iter();
        items.filter(|item| item.state() == state).count()
    };
    let end = match session.end() {
        v1::SessionEnd::Unspecified => String::new(),
        v1::SessionEnd::AllPacked => ", all packed".to_owned(),
        v1::SessionEnd::NothingFits => ", nothing fits any more".to_owned(),
        v1::SessionEnd::Failed => format!(", failed: {}", session.failure),
    };
    format!(
        "session  {}: {} packed, {} waiting, {} gone{end}",
        session.session_id,
        count(ItemState::Packed),
        count(ItemState::Waiting),
        count(ItemState::Gone)
    )
}

fn last_decision(decision: &v1::Decision) -> String {
    let total_ns: u64 = decision.stages.iter().map(|stage| stage.duration_ns).sum();
    let at = decision.placement.unwrap_or_default();
    format!(
        "step {:<4} {} ({}) at yaw {} cell ({}, {}) height {}, value {:.2}, {:.2} ms",
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

/// The heightmap, x to the right and y upwards; `?` where it is not known.
fn heights(heightmap: &v1::Heightmap) -> Vec<String> {
    let read = convert::scene::read_required("scene", heightmap.scene.as_ref());
    let Ok((grid, scene)) = read else {
        return vec!["heightmap cannot be read".to_owned()];
    };
    let (columns, rows) = (PICTURE.0.min(grid.nx()), PICTURE.1.min(grid.ny()));
    let shade = |column: usize, row: usize| {
        let x = column * grid.nx() / columns;
        let y = (rows - 1 - row) * grid.ny() / rows;
        let height = scene.heightmap().get(x, y).unwrap_or(0);
        if height > grid.rim() {
            return '?';
        }
        let index = usize::try_from(height).unwrap_or(0) * (SHADES.len() - 1);
        let index = index.div_ceil(usize::try_from(grid.rim()).unwrap_or(1).max(1));
        SHADES.get(index).copied().unwrap_or('?')
    };
    let line = |row: usize| {
        let shades: String = (0..columns).map(|column| shade(column, row)).collect();
        format!("  │{shades}│")
    };
    (0..rows).map(line).collect()
}
