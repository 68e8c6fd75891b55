//! The actor of a cell: makes heightmaps of its clouds.

use std::convert::Infallible;
use std::sync::Arc;
use std::time::{Duration, Instant};

use ppnpack_packing::kernel::heightmap::HeightmapError;
use ppnpack_perception::doubts::Doubt;
use ppnpack_perception::mapper::{Mapped, Mapper};
use ppnpack_service::actor::{Actor, Address};
use ppnpack_service::process::Process;
use ppnpack_service::stream::{Arrived, Publisher};
use ppnpack_wire::convert::cloud::CheckedCloud;
use ppnpack_wire::convert::scene;
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::v1::{self, DoubtKind};

use crate::counts::{Counts, Fate};
use crate::delay::Delays;
use crate::heightmaps;
use crate::inspect;
use crate::order::CloudOrder;
use crate::room::Held;
use crate::round::Round;
use crate::router::Clouds;
use crate::settings::Settings;

/// Time without clouds after which silence is told.
const SILENCE: Duration = Duration::from_secs(10);

/// Refusal of a cloud of a sensor that repeats itself. No noise is twice the same.
const REPEATED: &str = "its points are those of the cloud before, to the bit: the sensor or its driver is stuck; \
                        a simulated one without noise needs noise_m = 0";

pub(crate) struct Worker {
    cell: Cell,
    clouds: Clouds,
    mapper: Mapper,
    orders: Vec<CloudOrder>,
    delays: Vec<Delays>,
    /// The digest of the last points of each sensor, where sensors have noise.
    digests: Option<Vec<Option<blake3::Hash>>>,
    round: Round<News>,
    /// The state that the last heightmap shows.
    state_number: u64,
    /// Drawn at random when the service starts.
    epoch: u64,
    sequence: u64,
    /// Hash of the settings that decide what heightmaps say.
    fingerprint: u64,
    heightmaps: Publisher<v1::Heightmap>,
    outputs: Outputs,
    /// When silence is told; `None` once it is.
    silent_at: Option<Instant>,
}

#[derive(Clone)]
pub(crate) struct Outputs {
    pub(crate) heightmaps: Address<heightmaps::Message>,
    /// Clouds for the inspection of placed items.
    pub(crate) inspected: Option<inspect::Clouds>,
    pub(crate) counts: Arc<Counts>,
}

/// A cloud that is newer than those before of its sensor.
type News = Arrived<Held<CheckedCloud>>;

impl Actor for Worker {
    type Message = Infallible;

    fn handle(&mut self, message: Infallible) {
        match message {}
    }

    fn tick(&mut self) {
        let now = Instant::now();
        let clouds = self.clouds.take();
        if !clouds.is_empty() {
            self.silent_at = Some(now + SILENCE);
        } else if self.silent_at.is_some_and(|at| at <= now) {
            self.silent_at = None;
            let silent_s = SILENCE.as_secs();
            tracing::warn!(cell = %self.cell, silent_s, "no clouds come any more");
        }
        for (sensor, arrived) in clouds {
            self.take(sensor, arrived);
        }
    }

    fn next_tick(&self) -> Option<Instant> {
        self.silent_at
    }
}

impl Worker {
    /// Makes the actor of a cell, or says why the cell cannot be served. Takes long where the grid
    /// is fine, and waits for Zenoh.
    pub(crate) fn new(
        process: &Process,
        settings: &Settings,
        cell: &Cell,
        epoch: u64,
        clouds: Clouds,
        outputs: Outputs,
    ) -> Result<Self, String> {
        let grid = settings.grid_of(cell);
        let grid = grid.ok_or("it is not among the cells served")?.build();
        let grid = grid.map_err(|error| error.to_string())?;
        let mapper = Mapper::new(&grid, settings.mapper.clone());
        let sensors = settings.sensors_of(cell).count();
        let order = CloudOrder::new(settings.sensor_restart_after());
        let heightmaps = Publisher::new(process, cell, Stream::Heightmap);
        let unnoticed = settings.mapper.unnoticed().join("; ");
        if !unnoticed.is_empty() {
            tracing::info!(%cell, unnoticed, "doubts that are off: docs/perception.md sets them for a real camera");
        }
        Ok(Self {
            cell: cell.clone(),
            clouds,
            mapper: mapper.map_err(|error| error.to_string())?,
            orders: vec![order; sensors],
            delays: vec![Delays::default(); sensors],
            digests: (settings.mapper.noise_m > 0.0).then(|| vec![None; sensors]),
            round: Round::new(sensors),
            state_number: 0,
            epoch,
            sequence: 0,
            fingerprint: settings.fingerprint_of(cell),
            heightmaps: heightmaps.map_err(|error| error.to_string())?,
            outputs,
            silent_at: Some(Instant::now() + SILENCE),
        })
    }

    /// Takes a cloud, and publishes a heightmap where it is the last of its round.
    fn take(&mut self, sensor: usize, arrived: Arrived<Held<v1::PointCloud>>) {
        let Some(news) = self.accept(sensor, arrived) else {
            return;
        };
        let state_number = news.message.cloud().state_number();
        let counts = Arc::clone(&self.outputs.counts);
        if self.round.put(sensor, state_number, news).is_some() {
            counts.count(Fate::Replaced);
        }
        let Some(clouds) = self.round.take(state_number) else {
            return;
        };
        let (heightmap, mapped) = match self.map(state_number, &clouds) {
            Ok(mapped) => (self.write(&clouds, &mapped), mapped),
            Err(error) => return counts.refuse(&self.cell, Fate::Failed, &error),
        };
        for _ in &clouds {
            counts.count(Fate::Mapped);
        }
        if let Some(quality) = &heightmap.quality {
            counts.doubt(&self.cell, &quality.doubts);
        }
        // There before the heightmap: who has seen that one can ask how an item lies. Not in a
        // doubtful scene.
        let first = clouds.into_iter().next();
        let first = first.filter(|_| mapped.doubts.is_empty());
        if let (Some(inspected), Some(first)) = (&self.outputs.inspected, first) {
            inspected.put(self.cell.clone(), first.message);
        }
        // Nothing depends on it: heightmaps can be asked for.
        if let Err(error) = self.heightmaps.put(&heightmap) {
            tracing::warn!(cell = %self.cell, %error, "heightmap not published");
        }
        // Who answers requests is gone only where the service is ending.
        let message = heightmaps::Message::New(self.cell.clone(), heightmap);
        self.outputs.heightmaps.send(message).ok();
    }

    /// Gives a cloud that is well-formed and newer than those before of its sensor, as one that
    /// came when it should have.
    fn accept(&mut self, sensor: usize, arrived: Arrived<Held<v1::PointCloud>>) -> Option<News> {
        let counts = &self.outputs.counts;
        let news = arrived
            .map(|cloud| cloud.read(CheckedCloud::new))
            .transpose()
            .inspect_err(|error| counts.refuse(&self.cell, Fate::Malformed, error));
        let news = news.ok()?;
        let cloud = news.message.cloud();
        let (state_number, sequence) = (cloud.state_number(), cloud.sequence());
        let order = self.orders.get_mut(sensor);
        if !order.is_some_and(|order| order.accept(state_number, sequence, news.at)) {
            counts.count(Fate::Late);
            return None;
        }
        let captured_at_ns = cloud.captured_at_ns();
        let digests = self.digests.as_mut();
        if let Some(last) = digests.and_then(|digests| digests.get_mut(sensor)) {
            let digest = blake3::hash(&cloud.message().data);
            if last.replace(digest) == Some(digest) {
                counts.refuse(&self.cell, Fate::Repeated, &REPEATED);
                return None;
            }
        }
        let delays = self.delays.get_mut(sensor)?;
        let were_known = delays.are_known();
        let at = delays.undelayed(captured_at_ns, news.at);
        if !were_known && delays.are_known() {
            tracing::info!(cell = %self.cell, sensor, "clouds that are held up are noticed from now on");
        }
        Some(Arrived { at, ..news })
    }

    fn map(&mut self, state_number: u64, clouds: &[News]) -> Result<Mapped, HeightmapError> {
        if state_number != self.state_number {
            self.state_number = state_number;
            self.mapper.changed();
        }
        self.mapper.clear();
        for news in clouds {
            let cloud = news.message.cloud();
            self.mapper
                .add(cloud.points(), cloud.container_from_sensor());
        }
        self.mapper.finish()
    }

    fn write(&mut self, clouds: &[News], mapped: &Mapped) -> v1::Heightmap {
        self.sequence += 1;
        let grid = self.mapper.grid();
        let news = clouds.iter();
        let captured_at_ns = news.map(|news| news.message.cloud().captured_at_ns());
        let first_at = clouds.iter().map(|news| news.at).min();
        let processing = first_at.map_or(Duration::ZERO, |at| at.elapsed());
        v1::Heightmap {
            id: Some(v1::HeightmapId {
                epoch: self.epoch,
                sequence: self.sequence,
            }),
            cell: self.cell.to_string(),
            settings: self.fingerprint,
            state_number: self.state_number,
            captured_at_ns: captured_at_ns.min().unwrap_or_default(),
            scene: Some(scene::write(grid, &mapped.scene)),
            quality: Some(v1::HeightmapQuality {
                points_inside: mapped.tally.inside,
                unknown_cells: count(mapped.unknown_cells),
                cells: count(grid.nx() * grid.ny()),
                processing_ns: u64::try_from(processing.as_nanos()).unwrap_or(u64::MAX),
                points_measured: mapped.tally.measured,
                points_alone: mapped.tally.alone,
                unseen_samples: count(mapped.unseen_samples),
                moved_cells: count(mapped.moved_cells),
                clouds: count(clouds.len() * mapped.clouds),
                doubts: mapped.doubts.iter().map(write_doubt).collect(),
            }),
        }
    }
}

fn write_doubt(doubt: &Doubt) -> v1::Doubt {
    let kind = match doubt {
        Doubt::LittleSeen { .. } => DoubtKind::LittleSeen,
        Doubt::RimAway { .. } => DoubtKind::RimAway,
        Doubt::AboveRim { .. } => DoubtKind::AboveRim,
        Doubt::Intrusion { .. } => DoubtKind::Intrusion,
        Doubt::NotStill { .. } => DoubtKind::NotStill,
        // One that the protocol has no name for yet.
        _ => DoubtKind::Unspecified,
    };
    v1::Doubt {
        kind: kind.into(),
        message: doubt.to_string(),
    }
}

fn count(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}
