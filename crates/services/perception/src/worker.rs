//! The thread of a cell: makes heightmaps of its clouds.

use std::sync::Arc;
use std::sync::mpsc::SyncSender;
use std::time::Duration;

use ppnpack_packing::heightmap::HeightmapError;
use ppnpack_perception::mapper::{Mapped, Mapper};
use ppnpack_service::process::Process;
use ppnpack_wire::WireError;
use ppnpack_wire::convert::{cloud, scene};
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1;

use crate::counts::{Counts, Fate};
use crate::desk::Mail;
use crate::doubts;
use crate::inspect;
use crate::order::CloudOrder;
use crate::round::{Round, first_at};
use crate::slot::{Arrived, Outlet, Taken};
use crate::streams::Streams;

/// Silence is told after this long.
const SILENCE: Duration = Duration::from_secs(10);

/// Makes heightmaps of a cell's clouds.
pub(crate) struct Worker {
    pub(crate) cell: Cell,
    pub(crate) mapper: Mapper,
    /// Of each sensor.
    pub(crate) orders: Vec<CloudOrder>,
    pub(crate) round: Round,
    /// The state that the last heightmap shows.
    pub(crate) state_number: u64,
    /// Drawn at random when the service starts.
    pub(crate) epoch: u64,
    pub(crate) sequence: u64,
    pub(crate) desk: SyncSender<Mail>,
    /// Where items that were placed can be inspected.
    pub(crate) inspected: Option<inspect::Inlet>,
    pub(crate) counts: Arc<Counts>,
}

/// Why no heightmap was made.
#[derive(Debug, thiserror::Error)]
enum MapError {
    #[error(transparent)]
    Cloud(#[from] WireError),
    #[error(transparent)]
    Heightmap(#[from] HeightmapError),
}

impl Worker {
    /// Works until no more clouds can come.
    pub(crate) fn run(mut self, process: &Process, has_debug_streams: bool, clouds: &Outlet) {
        // Declared on this thread: Zenoh's own, on which the first cloud came, must not wait for Zenoh.
        let streams = match Streams::new(process, &self.cell, has_debug_streams) {
            Ok(streams) => streams,
            Err(error) => {
                tracing::error!(cell = %self.cell, %error, "the cell is not served");
                return;
            }
        };
        let mut is_silent = false;
        loop {
            match clouds.take(SILENCE) {
                Taken::Clouds(clouds) => {
                    is_silent = false;
                    for cloud in clouds {
                        self.take(cloud, &streams);
                    }
                }
                Taken::Nothing if is_silent => {}
                Taken::Nothing => {
                    is_silent = true;
                    let silent_s = SILENCE.as_secs();
                    tracing::warn!(cell = %self.cell, silent_s, "no clouds come any more");
                }
                Taken::End => return,
            }
        }
    }

    /// Takes a cloud, and publishes a heightmap where it is the last of its round.
    fn take(&mut self, arrived: Arrived, streams: &Streams) {
        if !self.is_news(&arrived) {
            return;
        }
        let Some(clouds) = self.round.take(arrived) else {
            return;
        };
        let (heightmap, mapped) = match self.map(&clouds) {
            Ok(mapped) => (self.write(&clouds, &mapped), mapped),
            Err(error) => return self.counts.refuse(&self.cell, Fate::Failed, &error),
        };
        clouds.iter().for_each(|_| self.counts.count(Fate::Mapped));
        if let Some(quality) = &heightmap.quality {
            self.counts.doubt(&self.cell, &quality.doubts);
        }
        // There before the heightmap: who has seen that one can ask how an item lies. Not in a doubtful scene.
        let first = clouds
            .into_iter()
            .next()
            .filter(|_| mapped.doubts.is_empty());
        if let (Some(inlet), Some(first)) = (&self.inspected, first) {
            inlet.put(&self.cell, first.cloud);
        }
        streams.tell(&heightmap, self.mapper.grid(), &mapped.scene);
        // Without a desk the service is ending.
        self.desk
            .send(Mail::Heightmap(self.cell.clone(), heightmap))
            .ok();
    }

    /// Whether a cloud is well-formed and newer than those before of its sensor.
    fn is_news(&mut self, arrived: &Arrived) -> bool {
        let cloud = match cloud::read(&arrived.cloud) {
            Ok(cloud) => cloud,
            Err(error) => {
                self.counts.refuse(&self.cell, Fate::Malformed, &error);
                return false;
            }
        };
        let order = self.orders.get_mut(arrived.sensor);
        let is_news = order
            .is_some_and(|order| order.accept(cloud.state_number(), cloud.sequence(), arrived.at));
        if !is_news {
            self.counts.count(Fate::Late);
        }
        is_news
    }

    /// What the clouds of a round show.
    fn map(&mut self, clouds: &[Arrived]) -> Result<Mapped, MapError> {
        let state_number = state_number(clouds);
        if state_number != self.state_number {
            self.state_number = state_number;
            self.mapper.changed();
        }
        self.mapper.clear();
        for arrived in clouds {
            let cloud = cloud::read(&arrived.cloud)?;
            self.mapper
                .add(cloud.points(), cloud.container_from_sensor());
        }
        Ok(self.mapper.finish()?)
    }

    fn write(&mut self, clouds: &[Arrived], mapped: &Mapped) -> v1::Heightmap {
        self.sequence += 1;
        let grid = self.mapper.grid();
        let captured_at_ns = clouds.iter().map(|arrived| arrived.cloud.captured_at_ns);
        let processing = first_at(clouds).elapsed();
        v1::Heightmap {
            id: Some(v1::HeightmapId {
                epoch: self.epoch,
                sequence: self.sequence,
            }),
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
                doubts: mapped.doubts.iter().map(doubts::write).collect(),
            }),
        }
    }
}

/// The state that clouds of a round show.
fn state_number(clouds: &[Arrived]) -> u64 {
    clouds
        .first()
        .map_or(0, |arrived| arrived.cloud.state_number)
}

fn count(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}
