//! One packing, step by step: a container, a sequence of items seen through a buffer, and which
//! placements are possible.

use std::sync::Arc;

use nalgebra::Isometry3;
use ppnpack_catalogue::object::CatalogueObject;
use ppnpack_packing::checks::stability::PublishedStability;
use ppnpack_packing::kernel::grid::{ABSENT, Grid, Units};
use ppnpack_packing::kernel::heightmap::Heightmap;
use ppnpack_packing::kernel::item::Item;
use ppnpack_packing::kernel::placement::{Placement, RestingPlacement};
use ppnpack_packing::kernel::resting::RestingHeights;
use ppnpack_packing::scene::model::Model;
use ppnpack_physics::cell::SimulatedCell;
use ppnpack_physics::error::PhysicsError;
use ppnpack_physics::settings::CellSettings;
use ppnpack_physics::view::{CameraSettings, CameraView};
use ppnpack_picture::{
    self as picture, Camera, Colour, Image, PictureError, Scene3d, Size, TriangleMesh, render,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::cell::scanned;
use crate::evaluation::{OUTSIDE, write_everywhere};
use crate::placement::lay;

/// The settings that packings of a kind share.
pub(crate) struct Setup {
    pub(crate) grid: Grid,
    pub(crate) objects: Vec<CatalogueObject>,
    /// The surfaces of each object as observed.
    pub(crate) maps: Vec<PaddedMaps>,
    /// The number of items that a step may choose from.
    pub(crate) buffer: usize,
    /// The number of items that arrive in all.
    pub(crate) items: usize,
    /// Whether what the published stability test refuses is not possible.
    pub(crate) is_tested: bool,
    /// The cell that items are released in; without one they stay where they come to rest.
    pub(crate) cell: Option<CellSettings>,
    /// The cameras that see it; without any it is scanned exactly.
    pub(crate) camera: Option<CameraSettings>,
    /// The greatest height that is observed; what is higher counts as this high.
    pub(crate) greatest: Units,
}

/// An item's surfaces as observed: padded to the grid, one after another per yaw; without material
/// 0 above and -1 below. What does not fit on the grid is cut off.
pub(crate) struct PaddedMaps {
    top: Vec<Units>,
    bottom: Vec<Units>,
}

impl PaddedMaps {
    pub(crate) fn of(grid: &Grid, item: &Item) -> Self {
        let cells = grid.nx() * grid.ny();
        let mut maps = Self {
            top: vec![0; item.views().len() * cells],
            bottom: vec![ABSENT; item.views().len() * cells],
        };
        for (yaw, view) in item.views().iter().enumerate() {
            let inside = |x: usize, y: usize| x < grid.nx() && y < grid.ny();
            for (x, y, lower, upper) in view.cells().filter(|(x, y, ..)| inside(*x, *y)) {
                let index = yaw * cells + x * grid.ny() + y;
                let places = maps.top.get_mut(index).zip(maps.bottom.get_mut(index));
                if let Some((top, bottom)) = places {
                    (*top, *bottom) = (upper, lower);
                }
            }
        }
        maps
    }
}

impl Setup {
    /// Gives the numbers of yaws, and of cells along x and y.
    pub(crate) fn shape(&self) -> [usize; 3] {
        let yaws = self.grid.resolution().yaws().count();
        [yaws, self.grid.nx(), self.grid.ny()]
    }

    /// Counts the cells of the container.
    pub(crate) fn cells(&self) -> usize {
        self.grid.nx() * self.grid.ny()
    }

    /// Counts the actions of a slot of the buffer: one per yaw and cell.
    pub(crate) fn per_slot(&self) -> usize {
        self.shape().iter().product()
    }

    /// Counts the actions.
    pub(crate) fn actions(&self) -> usize {
        self.buffer * self.per_slot()
    }

    fn volume_m3(&self) -> f64 {
        self.grid.container().volume_m3()
    }

    /// Makes the view of a packing with this seed, where cameras see it.
    fn view(&self, seed: u64) -> Result<Option<CameraView>, PhysicsError> {
        let camera = self.camera.filter(|_| self.cell.is_some());
        let view = camera.map(|camera| {
            let seed = camera.seed.wrapping_add(seed);
            CameraView::new(&CameraSettings { seed, ..camera }, &self.grid)
        });
        view.transpose()
    }
}

/// The arrays of what is observed: those of all packings, or the parts that one of them writes.
pub(crate) struct Observed<Heights, Mask> {
    /// [nx, ny]
    pub(crate) heightmap: Heights,
    /// [slot, yaw, nx, ny]
    pub(crate) top: Heights,
    /// The same.
    pub(crate) bottom: Heights,
    /// The same.
    pub(crate) resting: Heights,
    /// The same.
    pub(crate) mask: Mask,
}

/// The observation of one packing, in the arrays of all.
pub(crate) type ObservedIn<'a> = Observed<&'a mut [Units], &'a mut [i8]>;

/// The outcome of a step.
#[derive(Default, Clone, Copy)]
pub(crate) struct Stepped {
    /// The change of the packed share of the container's volume.
    pub(crate) reward: f64,
    /// Whether nothing can be placed any more, or the action was not possible.
    pub(crate) is_over: bool,
    /// Whether the action was possible.
    pub(crate) is_valid: bool,
}

/// A container as it is packed.
pub(crate) struct Packing {
    setup: Arc<Setup>,
    random: ChaCha8Rng,
    /// Objects that are still to arrive, the last one next.
    arriving: Vec<usize>,
    /// The object in each slot of the buffer.
    slots: Vec<Option<usize>>,
    heightmap: Heightmap,
    cell: Option<SimulatedCell>,
    view: Option<CameraView>,
    /// What lies there, and where, without a cell.
    lying: Vec<(Arc<Model>, Isometry3<f64>)>,
    resting: RestingHeights,
    stability: PublishedStability,
    /// The height at which the item would come to rest, by action.
    heights: Vec<Units>,
    /// 1 where an action is possible, else 0.
    mask: Vec<i8>,
    packed_m3: f64,
    packed: usize,
    is_over: bool,
}

impl Packing {
    /// Makes an empty container; nothing arrives before the first reset.
    pub(crate) fn new(setup: Arc<Setup>, seed: u64) -> Result<Self, PhysicsError> {
        let cell = setup.cell.clone().map(SimulatedCell::new).transpose()?;
        Ok(Self {
            random: ChaCha8Rng::seed_from_u64(seed),
            arriving: Vec::new(),
            slots: vec![None; setup.buffer],
            heightmap: Heightmap::empty(&setup.grid),
            cell,
            view: setup.view(seed)?,
            lying: Vec::new(),
            resting: RestingHeights::new(&setup.grid),
            stability: PublishedStability::default(),
            heights: vec![OUTSIDE; setup.actions()],
            mask: vec![0; setup.actions()],
            packed_m3: 0.0,
            packed: 0,
            is_over: true,
            setup,
        })
    }

    /// Begins anew, with the stream of random numbers of a seed where one is given, and with these
    /// objects, in this order, in place of random ones.
    pub(crate) fn reset(
        &mut self,
        seed: Option<u64>,
        objects: Option<&[usize]>,
    ) -> Result<(), PhysicsError> {
        if let Some(seed) = seed {
            self.random = ChaCha8Rng::seed_from_u64(seed);
            self.view = self.setup.view(seed)?;
        }
        let known = self.setup.objects.len();
        let mut draw = || self.random.random_range(0..known);
        let mut arriving = match objects {
            Some(objects) => objects.to_vec(),
            None => (0..self.setup.items).map(|_| draw()).collect(),
        };
        arriving.reverse();
        self.arriving = arriving;
        for slot in &mut self.slots {
            *slot = self.arriving.pop();
        }
        self.heightmap = Heightmap::empty(&self.setup.grid);
        if let Some(cell) = &mut self.cell {
            cell.reset();
        }
        if let Some(view) = &mut self.view {
            view.clear();
        }
        self.lying.clear();
        (self.packed_m3, self.packed) = (0.0, 0);
        self.refresh();
        Ok(())
    }

    /// Says whether it is over, so that a reset is next.
    pub(crate) fn is_over(&self) -> bool {
        self.is_over
    }

    /// Counts the items in the container.
    pub(crate) fn packed(&self) -> usize {
        self.packed
    }

    /// Gives the share of the container's volume that they fill.
    pub(crate) fn volume_share(&self) -> f64 {
        self.packed_m3 / self.setup.volume_m3()
    }

    /// Places an item. An action that is not possible ends the packing, and changes nothing.
    pub(crate) fn step(&mut self, action: i64) -> Result<Stepped, PhysicsError> {
        let share = self.volume_share();
        let is_valid = self.place(action)?;
        if is_valid {
            self.refresh();
        } else {
            self.is_over = true;
        }
        Ok(Stepped {
            reward: self.volume_share() - share,
            is_over: self.is_over,
            is_valid,
        })
    }

    /// Places the item of an action; says whether the action was possible.
    fn place(&mut self, action: i64) -> Result<bool, PhysicsError> {
        let setup = Arc::clone(&self.setup);
        let possible = self.possible(action).and_then(|(slot, at)| {
            let object = setup
                .objects
                .get(self.slots.get(slot).copied().flatten()?)?;
            let view = object.item.views().get(at.placement.yaw)?;
            let pose = object.item.container_from_item(&setup.grid, &at)?;
            Some((slot, at, object, view, pose))
        });
        let Some((slot, at, object, view, pose)) = possible else {
            return Ok(false);
        };
        match &mut self.cell {
            None => {
                lay(&mut self.heightmap, view, &at);
                self.packed += 1;
                self.packed_m3 += object.model.volume_m3;
                self.lying.push((Arc::clone(&object.model), pose));
            }
            Some(cell) => {
                cell.place(&object.model, &pose)?;
                let scene = scanned(cell, self.view.as_mut(), &setup.grid)?;
                let seen = scene.heightmap();
                let heights = seen.heights().iter().map(|it| *it.min(&setup.greatest));
                self.heightmap = Heightmap::from_units(seen.nx(), seen.ny(), heights.collect())?;
                let inside = || cell.contents().into_iter().filter(|body| body.inside);
                self.packed = inside().count();
                self.packed_m3 = inside().map(|body| body.model.volume_m3).sum();
            }
        }
        if let Some(slot) = self.slots.get_mut(slot) {
            *slot = self.arriving.pop();
        }
        Ok(true)
    }

    /// Gives the slot and the placement of an action that is possible.
    fn possible(&self, action: i64) -> Option<(usize, RestingPlacement)> {
        let action = usize::try_from(action).ok()?;
        self.mask.get(action).filter(|possible| **possible == 1)?;
        let [yaws, nx, ny] = self.setup.shape();
        let placement = Placement {
            yaw: action / (nx * ny) % yaws,
            x: action / ny % nx,
            y: action % ny,
        };
        let at = RestingPlacement {
            placement,
            resting_height: *self.heights.get(action)?,
        };
        Some((action / self.setup.per_slot(), at))
    }

    /// Finds out how high the items of the buffer would come to rest, and what is possible now.
    fn refresh(&mut self) {
        let Self {
            setup,
            slots,
            heightmap,
            stability,
            resting,
            heights,
            mask,
            ..
        } = self;
        let (grid, cells) = (&setup.grid, setup.cells());
        let object = |slot: &Option<usize>| slot.and_then(|index| setup.objects.get(index));
        let buffer = slots.iter().filter_map(object).map(|it| &*it.item);
        resting.update(heightmap, buffer);
        mask.fill(0);
        heights.fill(OUTSIDE);
        let masks = mask.chunks_exact_mut(setup.per_slot());
        let slots = slots.iter().zip(heights.chunks_exact_mut(setup.per_slot()));
        for (mask, (slot, heights)) in masks.zip(slots) {
            let Some(object) = object(slot) else {
                continue;
            };
            write_everywhere(grid, &object.item, resting, heights);
            let views = object.item.views().iter().zip(heights.chunks_exact(cells));
            let views = mask.chunks_exact_mut(cells).zip(views);
            for (yaw, (mask, (view, heights))) in views.enumerate() {
                let highest = grid.rim() - view.height();
                for (possible, height) in mask.iter_mut().zip(heights) {
                    *possible = i8::from((0..=highest).contains(height));
                }
                if setup.is_tested {
                    let refused =
                        |at: &RestingPlacement| !stability.is_stable(grid, heightmap, view, at);
                    leave_out(grid.ny(), yaw, mask, heights, refused);
                }
            }
        }
        self.is_over = !self.mask.contains(&1);
    }

    /// Writes down all that is observed.
    pub(crate) fn observe(&self, into: ObservedIn<'_>) {
        into.heightmap.copy_from_slice(self.heightmap.heights());
        into.mask.copy_from_slice(&self.mask);
        into.resting.copy_from_slice(&self.heights);
        let tops = into.top.chunks_exact_mut(self.setup.per_slot());
        let bottoms = into.bottom.chunks_exact_mut(self.setup.per_slot());
        for ((top, bottom), slot) in tops.zip(bottoms).zip(&self.slots) {
            match slot.and_then(|index| self.setup.maps.get(index)) {
                Some(maps) => {
                    top.copy_from_slice(&maps.top);
                    bottom.copy_from_slice(&maps.bottom);
                }
                None => {
                    top.fill(0);
                    bottom.fill(ABSENT);
                }
            }
        }
    }

    /// Draws what lies there.
    pub(crate) fn picture(&self, size: Size) -> Result<Image, PictureError> {
        let own = self.lying.iter().cloned().enumerate();
        let bodies = self.cell.iter().flat_map(SimulatedCell::contents);
        let bodies = bodies.map(|it| (it.id.index(), (it.model, it.container_from_item)));
        let lying: Vec<_> = own.chain(bodies).collect();
        let items = lying.iter().map(|(index, (model, pose))| picture::Item {
            mesh: TriangleMesh {
                vertices: &model.mesh.vertices,
                triangles: &model.mesh.triangles,
            },
            world_from_item: *pose,
            colour: Colour::of_item(*index),
        });
        let container = self.setup.grid.container();
        let scene = Scene3d {
            items: items.collect(),
            container_m: Some([container.x_m, container.y_m, container.z_m]),
        };
        render(&scene, &Camera::overlooking(&scene), size)
    }

    /// Gives the objects in the buffer, by slot; -1 where there is none.
    pub(crate) fn objects(&self) -> impl Iterator<Item = i64> {
        let slots = self.slots.iter();
        slots.map(|slot| slot.map_or(-1, |index| index as i64))
    }
}

/// Takes out of a mask what is refused, at one yaw.
fn leave_out(
    ny: usize,
    yaw: usize,
    mask: &mut [i8],
    heights: &[Units],
    mut is_refused: impl FnMut(&RestingPlacement) -> bool,
) {
    let possible = mask.iter_mut().zip(heights).enumerate();
    for (index, (possible, height)) in possible.filter(|(_, (possible, _))| **possible == 1) {
        let (x, y) = (index / ny, index % ny);
        let at = RestingPlacement {
            placement: Placement { yaw, x, y },
            resting_height: *height,
        };
        *possible = i8::from(!is_refused(&at));
    }
}
