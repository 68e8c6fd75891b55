//! The thread of a cell: makes heightmaps of its clouds.

use std::sync::Arc;
use std::sync::mpsc::SyncSender;

use ppnpack_perception::mapper::{Mapped, Mapper};
use ppnpack_service::process::Process;
use ppnpack_wire::convert::cloud::{self, Cloud};
use ppnpack_wire::convert::scene;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::v1;

use crate::counts::{Counts, Fate};
use crate::desk::Mail;
use crate::order::CloudOrder;
use crate::slot::{Arrived, Outlet};
use crate::streams::Streams;

/// Makes heightmaps of a cell's clouds.
pub(crate) struct Worker {
    pub(crate) cell: Cell,
    pub(crate) mapper: Mapper,
    pub(crate) order: CloudOrder,
    /// Drawn at random when the service starts.
    pub(crate) epoch: u64,
    pub(crate) sequence: u64,
    pub(crate) desk: SyncSender<Mail>,
    pub(crate) counts: Arc<Counts>,
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
        while let Some(arrived) = clouds.take() {
            if let Some((heightmap, mapped)) = self.look_at(&arrived) {
                self.counts.count(Fate::Mapped);
                streams.tell(&heightmap, self.mapper.grid(), &mapped.scene);
                // Without a desk the service is ending.
                self.desk
                    .send(Mail::Heightmap(self.cell.clone(), heightmap))
                    .ok();
            }
        }
    }

    /// The heightmap of a cloud that is news and well-formed.
    fn look_at(&mut self, arrived: &Arrived) -> Option<(v1::Heightmap, Mapped)> {
        let cloud = match cloud::read(&arrived.cloud) {
            Ok(cloud) => cloud,
            Err(error) => {
                self.counts.refuse(&self.cell, Fate::Malformed, &error);
                return None;
            }
        };
        if !self
            .order
            .accept(cloud.state_number(), cloud.sequence(), arrived.at)
        {
            self.counts.count(Fate::Late);
            return None;
        }
        match self
            .mapper
            .map(cloud.points(), cloud.container_from_sensor())
        {
            Ok(mapped) => Some((self.write(arrived, &cloud, &mapped), mapped)),
            Err(error) => {
                self.counts.refuse(&self.cell, Fate::Failed, &error);
                None
            }
        }
    }

    fn write(&mut self, arrived: &Arrived, cloud: &Cloud<'_>, mapped: &Mapped) -> v1::Heightmap {
        self.sequence += 1;
        let grid = self.mapper.grid();
        let count = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
        v1::Heightmap {
            id: Some(v1::HeightmapId {
                epoch: self.epoch,
                sequence: self.sequence,
            }),
            state_number: cloud.state_number(),
            captured_at_ns: cloud.captured_at_ns(),
            scene: Some(scene::write(grid, &mapped.scene)),
            quality: Some(v1::HeightmapQuality {
                points_inside: mapped.tally.inside,
                unknown_cells: count(mapped.unknown_cells),
                cells: count(grid.nx() * grid.ny()),
                processing_ns: u64::try_from(arrived.at.elapsed().as_nanos()).unwrap_or(u64::MAX),
            }),
        }
    }
}
