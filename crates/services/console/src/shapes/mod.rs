//! The shapes of items, asked of planners and kept as pages draw them.

mod columns;
mod encode;
mod id;
mod prefetch;

use std::collections::{BTreeSet, HashMap};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use axum::body::Bytes;
use ppnpack_packing::item::ItemView;
use ppnpack_service::rpc::{CallError, Client};
use ppnpack_service::shapes;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::{convert, v1};

use crate::directory::{CellSize, Directory};
pub(crate) use id::ShapeId;
pub(crate) use prefetch::{Prefetcher, Wanted};

/// How long a planner may take to answer: it plans a step before.
const PATIENCE: Duration = Duration::from_secs(3);

/// How much is kept, in bytes as it is sent, before all is forgotten and asked for anew.
const MOST_KEPT_BYTES: usize = 64 << 20;

/// Cells of the largest footprint whose columns are drawn: each takes up to half a kilobyte.
const MOST_COLUMNS: usize = 1 << 17;

/// A shape.
#[derive(Debug)]
pub(crate) struct KnownShape {
    /// As it is sent: see [`encode`](encode::encode).
    pub(crate) triangles: Bytes,
    /// Its volume, in cubic metres, where it is known.
    pub(crate) volume_m3: Option<f64>,
}

/// Why a shape is not to be had.
#[derive(Debug)]
pub(crate) enum ShapeError {
    /// The planner does not have it, or not any more.
    Unknown,
    /// The planner did not answer.
    Call(CallError),
}

/// Shapes by their ids.
pub(crate) struct ShapeStore {
    client: Client,
    directory: Arc<Directory>,
    kept: Mutex<Kept>,
}

#[derive(Default)]
struct Kept {
    shapes: HashMap<ShapeId, Arc<KnownShape>>,
    bytes: usize,
}

impl ShapeStore {
    pub(crate) fn new(client: Client, directory: Arc<Directory>) -> Self {
        Self {
            client,
            directory,
            kept: Mutex::default(),
        }
    }

    /// A shape, where it is kept.
    pub(crate) fn kept(&self, id: &ShapeId) -> Option<Arc<KnownShape>> {
        self.lock().shapes.get(id).cloned()
    }

    /// A shape, kept or asked for. It waits for the planner.
    pub(crate) fn get(&self, cell: &Cell, id: &ShapeId) -> Result<Arc<KnownShape>, ShapeError> {
        if let Some(known) = self.kept(id) {
            return Ok(known);
        }
        self.fetch(cell, &BTreeSet::from([*id]))
            .map_err(ShapeError::Call)?;
        self.kept(id).ok_or(ShapeError::Unknown)
    }

    /// Asks a cell's planner for these. It waits for the planner; what that does not have is left out.
    fn fetch(&self, cell: &Cell, ids: &BTreeSet<ShapeId>) -> Result<(), CallError> {
        let size = self.directory.cell_size(cell);
        let ids = ids.iter().map(|id| id.as_bytes().to_vec());
        let deadline = Instant::now() + PATIENCE;
        let keep = |shape: v1::Shape| {
            let id = ShapeId::of_bytes(&shape.id);
            if let Some((id, known)) = id.zip(read(shape, size)) {
                self.keep(id, known);
            }
        };
        let unknown = shapes::fetch(&self.client, cell, ids, deadline, keep)?;
        if unknown > 0 {
            tracing::debug!(%cell, unknown, "shapes that the planner does not have");
        }
        Ok(())
    }

    fn keep(&self, id: ShapeId, known: KnownShape) {
        let mut kept = self.lock();
        if kept.bytes > MOST_KEPT_BYTES {
            *kept = Kept::default();
        }
        kept.bytes += known.triangles.len();
        // Two pages may have asked for it at the same time.
        if let Some(before) = kept.shapes.insert(id, Arc::new(known)) {
            kept.bytes -= before.triangles.len();
        }
    }

    fn lock(&self) -> MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A shape as it is kept; `None` where it is malformed, or heightmaps that are too large, or whose cells are of a size that is not known.
fn read(shape: v1::Shape, size: Option<CellSize>) -> Option<KnownShape> {
    match shape.shape? {
        v1::shape::Shape::Solid(solid) => {
            let model = convert::solid::read(&solid).ok()?;
            Some(KnownShape {
                triangles: encode::encode(&model.mesh).into(),
                volume_m3: Some(model.volume_m3),
            })
        }
        v1::shape::Shape::Item(item) => {
            let item = convert::item::read(&item).ok()?;
            let volume_m3 = item.mesh_volume_m3();
            let is_drawn = |view: &&ItemView| view.nx() * view.ny() <= MOST_COLUMNS;
            let view = item.views().first().filter(is_drawn)?;
            Some(KnownShape {
                triangles: encode::encode(&columns::mesh(view, size?)).into(),
                volume_m3: (volume_m3 > 0.0).then_some(volume_m3),
            })
        }
    }
}
