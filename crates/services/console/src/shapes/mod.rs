//! The shapes of items, asked of planners and kept as pages draw them.

mod prefetch;

use std::collections::{HashMap, HashSet};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use axum::body::Bytes;
use nalgebra::Vector3;
use ppnpack_packing::kernel::grid::Resolution;
use ppnpack_packing::kernel::item::ItemView;
use ppnpack_packing::scene::model::mesh::Mesh;
use ppnpack_service::rpc::{CallError, Client};
use ppnpack_service::shapes;
use ppnpack_service::sync::lock;
use ppnpack_wire::keys::Cell;
use ppnpack_wire::{convert, v1};

use crate::directory::Directory;
pub(crate) use prefetch::{Prefetcher, Wanted};

/// Names a shape by its content.
pub(crate) type ShapeId = blake3::Hash;

/// How long a planner may take to answer: it plans a step before.
const PATIENCE: Duration = Duration::from_secs(3);

/// Maximum of bytes that are kept, as they are sent, before all is forgotten and asked for anew.
const MOST_KEPT_BYTES: usize = 64 << 20;

#[derive(Debug)]
pub(crate) struct KnownShape {
    /// The mesh as it is sent: see [`encode`].
    pub(crate) triangles: Bytes,
    /// Its volume, in cubic metres, where it is known.
    pub(crate) volume_m3: Option<f64>,
}

#[derive(Debug)]
pub(crate) enum ShapeError {
    /// The planner does not have it, or not any more.
    Unknown,
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

    pub(crate) fn kept(&self, id: &ShapeId) -> Option<Arc<KnownShape>> {
        lock(&self.kept).shapes.get(id).cloned()
    }

    /// Gives a shape, kept or asked for. It waits for the planner.
    pub(crate) fn get(&self, cell: &Cell, id: &ShapeId) -> Result<Arc<KnownShape>, ShapeError> {
        if let Some(known) = self.kept(id) {
            return Ok(known);
        }
        self.fetch(cell, &HashSet::from([*id]))
            .map_err(ShapeError::Call)?;
        self.kept(id).ok_or(ShapeError::Unknown)
    }

    /// Asks a cell's planner for these, and waits for it. A shape that it does not have is left
    /// out.
    fn fetch(&self, cell: &Cell, ids: &HashSet<ShapeId>) -> Result<(), CallError> {
        let resolution = self.directory.resolution(cell);
        let ids = ids.iter().map(|id| id.as_bytes().to_vec());
        let deadline = Instant::now() + PATIENCE;
        let keep = |shape: v1::Shape| {
            let named = id(&shape.id);
            if let Some((id, known)) = named.zip(read(shape, resolution.as_ref())) {
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
        let mut kept = lock(&self.kept);
        if kept.bytes > MOST_KEPT_BYTES {
            *kept = Kept::default();
        }
        kept.bytes += known.triangles.len();
        // Two pages may have asked for it at the same time.
        if let Some(before) = kept.shapes.insert(id, Arc::new(known)) {
            kept.bytes -= before.triangles.len();
        }
    }
}

/// Reads the id in these bytes; `None` where they are not 32, as where a message names no shape.
pub(crate) fn id(bytes: &[u8]) -> Option<ShapeId> {
    ShapeId::from_slice(bytes).ok()
}

/// Reads a shape; `None` where it is malformed, or heightmaps whose cells are of unknown size. An
/// item that has nothing but heightmaps is drawn as its box.
fn read(shape: v1::Shape, resolution: Option<&Resolution>) -> Option<KnownShape> {
    let (mesh, volume_m3) = match shape.shape? {
        v1::shape::Shape::Solid(solid) => {
            let model = convert::solid::read(&solid).ok()?;
            (model.mesh, Some(model.volume_m3))
        }
        v1::shape::Shape::Item(item) => {
            let item = convert::item::read(&item).ok()?;
            let volume_m3 = item.mesh_volume_m3();
            let boxed = box_of(item.views().first()?, resolution?);
            (boxed, (volume_m3 > 0.0).then_some(volume_m3))
        }
    };
    Some(KnownShape {
        triangles: encode(&mesh).into(),
        volume_m3,
    })
}

/// Gives the box of an item, in the frame of its heightmaps.
fn box_of(view: &ItemView, resolution: &Resolution) -> Mesh {
    let extents_m = [
        view.nx() as f64 * resolution.cell_m(),
        view.ny() as f64 * resolution.cell_m(),
        f64::from(view.height()) * resolution.height_unit_m(),
    ];
    let lowest_m = -view.origin_from_corner_m();
    let highest_m = lowest_m + Vector3::from(extents_m);
    Mesh::cuboid(lowest_m.into(), highest_m.into())
}

/// Writes a mesh in little-endian numbers: how many vertices and triangles there are (`u32`), x, y
/// and z of each vertex in metres (`f32`), and the three vertices of each triangle (`u32`).
fn encode(mesh: &Mesh) -> Vec<u8> {
    let (vertices, triangles) = (&mesh.vertices, &mesh.triangles);
    let mut bytes = Vec::with_capacity(8 + 12 * (vertices.len() + triangles.len()));
    for count in [vertices.len(), triangles.len()] {
        // A message that a mesh comes in has room for far fewer.
        let count = u32::try_from(count).unwrap_or(u32::MAX);
        bytes.extend(count.to_le_bytes());
    }
    for vertex in vertices {
        let coordinates = vertex.coords.iter();
        bytes.extend(coordinates.flat_map(|metres| (*metres as f32).to_le_bytes()));
    }
    for triangle in triangles {
        bytes.extend(triangle.iter().flat_map(|vertex| vertex.to_le_bytes()));
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mesh_takes_twelve_bytes_for_each_vertex_and_triangle() {
        let bytes = encode(&Mesh::cuboid([0.0; 3], [0.5, 1.0, 2.0]));
        assert_eq!(bytes.len(), 8 + 12 * (8 + 12));
        let number = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        assert_eq!((number(0), number(4)), (8, 12));
        // The second vertex is that of the greatest x.
        assert_eq!(f32::from_bits(number(8 + 12)), 0.5);
        let mut indices = (8 + 12 * 8..bytes.len()).step_by(4);
        assert!(indices.all(|at| number(at) < 8));
    }
}
