//! What the network scored, for people to look at.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a panic in a test is a failing test"
)]

use std::sync::mpsc::{Receiver, Sender, channel, sync_channel};
use std::time::{Duration, Instant};

use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::{Heightmap, Scene};
use ppnpack_packing::item::{Item, ViewSurfaces};
use ppnpack_packing::score_map::ScoreMap;
use ppnpack_packing::step::StageError;
use ppnpack_ppn_service::{Network, PpnService, ScoredItems, ScoredStep, Scorer, Settings};
use ppnpack_service::Process;
use ppnpack_service::embedded::{self, Hub};
use ppnpack_service::rpc::Client;
use ppnpack_service::stream::{self, Publisher, Subscription};
use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::keys::{Cell, Service, Stream};
use ppnpack_wire::{MAX_MESSAGE_BYTES, convert, debug, v1};

const PATIENCE: Duration = Duration::from_secs(20);

/// Proposes nothing, scores one cell of each item, and says of each step whether its scores were wanted.
struct Told(Sender<bool>);

struct ToldScorer {
    grid: Grid,
    wanted: Sender<bool>,
}

impl Network for Told {
    fn model(&self) -> &str {
        "told"
    }

    fn open(&self, grid: &Grid) -> Result<Box<dyn Scorer>, StageError> {
        Ok(Box::new(ToldScorer {
            grid: grid.clone(),
            wanted: self.0.clone(),
        }))
    }
}

impl Scorer for ToldScorer {
    fn best(&mut self, steps: &[ScoredStep<'_>]) -> Vec<Result<ScoredItems, StageError>> {
        let score = |step: &ScoredStep<'_>| -> Result<ScoredItems, StageError> {
            self.wanted.send(step.wants_scores)?;
            let maps = (0..step.items.len()).map(|index| {
                let mut map = ScoreMap::empty(&self.grid);
                map.lower(1, 2, index as f32);
                map
            });
            Ok(ScoredItems {
                best: vec![Vec::new(); step.items.len()],
                scores: step.wants_scores.then(|| maps.collect()),
            })
        };
        steps.iter().map(score).collect()
    }
}

/// A running service, and who asks it and reads its scores.
struct Rig {
    wanted: Receiver<bool>,
    client: Client,
    reader: Process,
    _service: PpnService,
    process: Process,
    _hub: Hub,
}

fn cell() -> Cell {
    Cell::new("cell-1").unwrap()
}

impl Rig {
    fn new(debug_streams: bool) -> Self {
        let hub = embedded::hub().unwrap();
        let process = embedded::process(&hub, Service::Ppn, "ppn-1").unwrap();
        let (sender, wanted) = channel();
        let settings = Settings {
            debug_streams,
            ..Settings::default()
        };
        let network = Box::new(Told(sender));
        let service = ppnpack_ppn_service::start(&process, &settings, network).unwrap();
        let reader = embedded::process(&hub, Service::Planner, "reader").unwrap();
        Self {
            wanted,
            client: Client::new(reader.session()),
            reader,
            _service: service,
            process,
            _hub: hub,
        }
    }

    /// Asks for proposals. Says whether the scores were wanted.
    fn ask(&self) -> bool {
        let grid = Grid::reference();
        let view = ViewSurfaces::of_cells(2, 2, vec![10; 4], vec![0; 4]);
        let item = Item::new("block", vec![view; 4], 0.0).unwrap();
        let item = convert::item::write(&item);
        let scene = Scene::from_heightmap(Heightmap::empty(&grid));
        let request = v1::ProposeRequest {
            scene: Some(convert::scene::write(&grid, &scene)),
            item_ids: vec![ItemId::of(&item).to_bytes(); 2],
            items: vec![item],
            percent: 5.0,
            ..v1::ProposeRequest::default()
        };
        let asked = self
            .client
            .call(&cell(), request, Instant::now() + PATIENCE);
        assert_eq!(asked.unwrap().proposals.len(), 2);
        self.wanted.recv_timeout(PATIENCE).unwrap()
    }

    /// Reads the scores, until the subscription is dropped.
    fn read(&self) -> (Subscription, Receiver<debug::Grid>) {
        let (sender, grids) = sync_channel(16);
        let subscription = stream::subscribe(
            self.reader.session(),
            Some(&cell()),
            Stream::DebugScores,
            MAX_MESSAGE_BYTES,
            move |_, grid: debug::Grid| drop(sender.try_send(grid)),
        );
        (subscription.unwrap(), grids)
    }
}

/// Does something until something else has come of it.
fn until<T>(what: &str, mut attempt: impl FnMut() -> Option<T>) -> T {
    let deadline = Instant::now() + PATIENCE;
    loop {
        assert!(Instant::now() < deadline, "{what}");
        if let Some(came) = attempt() {
            return came;
        }
    }
}

#[test]
fn scores_are_made_and_published_while_somebody_reads_them() {
    let rig = Rig::new(true);
    for _ in 0..3 {
        assert!(!rig.ask(), "nobody reads them");
    }
    let (subscription, grids) = rig.read();
    let soon = Duration::from_millis(50);
    let debug::Foxglove(grid) = until("scores are published", || {
        rig.ask();
        grids.recv_timeout(soon).ok()
    });
    assert_eq!(grid.frame_id, "cell-1/container");
    let fields = grid.fields.iter().map(|field| field.name.as_str());
    assert_eq!(fields.collect::<Vec<_>>(), ["best", "block", "2 block"]);
    let at = 2 * grid.row_stride as usize + grid.cell_stride as usize;
    let floats: Vec<u8> = [0.0_f32, 0.0, 1.0].map(f32::to_le_bytes).concat();
    assert_eq!(grid.data.get(at..at + 12), Some(&*floats));

    drop(subscription);
    until("nobody reads them any more", || (!rig.ask()).then_some(()));
    assert!(!rig.ask());
}

#[test]
fn where_debug_streams_are_off_no_scores_are_made() {
    let rig = Rig::new(false);
    let (_subscription, grids) = rig.read();
    // Once something has come, the service's session knows of the reader.
    let other = Publisher::new(&rig.process, &cell(), Stream::DebugScores).unwrap();
    until("the reader is known", || {
        other.put(&debug::Grid::default()).unwrap();
        grids.recv_timeout(Duration::from_millis(50)).ok()
    });
    until("the publisher knows of it, too", || {
        other.has_readers().then_some(())
    });
    assert!(!rig.ask());
}
