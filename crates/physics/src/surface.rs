//! The content's surface seen from above, computed anew only where bodies moved.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::Isometry3;
use ppnpack_catalogue::object::Model;
use ppnpack_catalogue::raster::raise_surface;
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::Surface;

use crate::outcome::{BodyId, BodyState};

/// What was scanned last, kept for the bodies that have not moved since.
#[derive(Clone, Default)]
pub(crate) struct SurfaceCache {
    scanned: Option<Grid>,
    bodies: BTreeMap<BodyId, Scanned>,
}

/// A body as it was scanned last.
#[derive(Clone)]
struct Scanned {
    /// Bodies are renumbered when a cell is emptied, so the number alone does not tell the model.
    model: Arc<Model>,
    container_from_item: Isometry3<f64>,
    /// None where it had moved: most that have will have moved again by the next scan.
    patch: Option<Arc<Patch>>,
}

/// The surface of one body in one pose: the rectangle of samples that it covers.
struct Patch {
    first_x: usize,
    first_y: usize,
    /// Samples along y.
    width: usize,
    /// Row-major; 0 where the body is absent.
    heights_m: Vec<f32>,
}

impl SurfaceCache {
    /// The surface of the bodies together.
    pub(crate) fn scan(&mut self, grid: &Grid, bodies: &[BodyState]) -> Surface {
        if self.scanned.as_ref() != Some(grid) {
            self.scanned = Some(grid.clone());
            self.bodies.clear();
        }
        let before = std::mem::take(&mut self.bodies);
        let mut surface = Surface::empty(grid);
        let mut moved: Vec<&BodyState> = Vec::new();
        for body in bodies {
            let known = before.get(&body.id).filter(|scanned| scanned.shows(body));
            let patch = known.map(|scanned| scanned.patch(grid));
            match &patch {
                Some(patch) => patch.raise(&mut surface),
                None => moved.push(body),
            }
            self.bodies.insert(body.id, Scanned::new(body, patch));
        }
        // From the top, as what is covered is not drawn.
        let height_m = |body: &BodyState| body.container_from_item.translation.z;
        moved.sort_by(|one, other| height_m(other).total_cmp(&height_m(one)));
        for body in moved {
            let pose = &body.container_from_item;
            raise_surface(&body.model.mesh, pose, &mut surface);
        }
        surface
    }
}

impl Scanned {
    fn new(body: &BodyState, patch: Option<Arc<Patch>>) -> Self {
        Self {
            model: Arc::clone(&body.model),
            container_from_item: body.container_from_item,
            patch,
        }
    }

    fn shows(&self, body: &BodyState) -> bool {
        Arc::ptr_eq(&self.model, &body.model)
            && self.container_from_item == body.container_from_item
    }

    fn patch(&self, grid: &Grid) -> Arc<Patch> {
        let pose = &self.container_from_item;
        let made = || Arc::new(Patch::new(grid, &self.model, pose));
        self.patch.clone().unwrap_or_else(made)
    }
}

impl Patch {
    fn new(grid: &Grid, model: &Model, container_from_item: &Isometry3<f64>) -> Self {
        let mut alone = Surface::empty(grid);
        raise_surface(&model.mesh, container_from_item, &mut alone);
        let rows = || alone.heights_m().chunks_exact(alone.ny());
        let is_covered = |height_m: &f32| *height_m > 0.0;
        let covers = |row: &[f32]| row.iter().any(is_covered);
        let first_x = rows().position(covers).unwrap_or(0);
        let past_x = rows().rposition(covers).map_or(0, |last| last + 1);
        let first_y = rows()
            .filter_map(|row| row.iter().position(is_covered))
            .min()
            .unwrap_or(0);
        let past_y = rows()
            .filter_map(|row| row.iter().rposition(is_covered))
            .max()
            .map_or(0, |last| last + 1);
        let width = past_y.saturating_sub(first_y);
        let covered = rows().take(past_x).skip(first_x);
        Self {
            first_x,
            first_y,
            width,
            heights_m: covered
                .flat_map(|row| row.iter().copied().skip(first_y).take(width))
                .collect(),
        }
    }

    fn raise(&self, surface: &mut Surface) {
        if self.width == 0 {
            return;
        }
        for (x, row) in self.heights_m.chunks_exact(self.width).enumerate() {
            for (y, height_m) in row.iter().enumerate() {
                surface.raise(self.first_x + x, self.first_y + y, *height_m);
            }
        }
    }
}
