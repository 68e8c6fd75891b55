//! The packing engine on the benchmark, with a grid of one cell a unit.

use std::collections::HashMap;
use std::sync::Arc;

use ppnpack_cli::failure::{OrRun, Outcome};
use ppnpack_packing::kernel::grid::{ContainerSize, Grid, Resolution, Units, Yaws};
use ppnpack_packing::kernel::heightmap::Heightmap;
use ppnpack_packing::kernel::item::{Item, ItemError, ViewSurfaces};
use ppnpack_packing::kernel::objective::{Heuristic, Order, Weights};
use ppnpack_packing::planning::valid::SearchError;
use ppnpack_packing::ranking::evaluator::Evaluator;
use ppnpack_packing::ranking::proposals::Proposals;
use ppnpack_packing::ranking::search::{Search, SearchSettings};
use ppnpack_packing::ranking::step::{Candidate, Evaluated, StepInput};
use ppnpack_packing::scene::Scene;

use super::bin::Bin;
use super::rules::Setting;
use super::surface::{Placed, SIDE, Sides, Surface};

/// Edge of a cell: a centimetre of the engine, in which the published weights are written.
const CELL_M: f64 = 0.01;

/// A box is placed as it comes, or turned by a quarter.
const YAWS: usize = 2;

pub(super) struct Engine {
    grid: Grid,
    search: Search,
    items: HashMap<Sides, Arc<Item>>,
}

impl Engine {
    /// A heuristic with the project's weights for items in as many poses as the setting has; the
    /// poses of a box compete with one another.
    pub(super) fn new(setting: Setting, heuristic: Heuristic) -> Outcome<Self> {
        let side_m = f64::from(SIDE) * CELL_M;
        let container = ContainerSize::cuboid(side_m, side_m, side_m);
        let yaws = Yaws::half_turn(YAWS).or_run()?;
        let resolution = Resolution::new(CELL_M, CELL_M, yaws).or_run()?;
        let grid = Grid::new(container, resolution).or_run()?;
        let some = Sides { x: 1, y: 1, z: 1 };
        let settings = SearchSettings {
            heuristic,
            order: Order::Balance,
            weights: Weights::for_poses(setting.poses(some).count()),
            ..SearchSettings::default()
        };
        Ok(Self {
            search: Search::new(&grid, &settings).or_run()?,
            grid,
            items: HashMap::new(),
        })
    }

    /// The placement of least value that the bin accepts; `None` where there is none.
    pub(super) fn choose(&mut self, bin: &Bin, arriving: Sides) -> Outcome<Option<Placed>> {
        let poses: Vec<Sides> = bin.setting().poses(arriving).collect();
        let candidates = poses.iter().enumerate().map(|(pose, sides)| {
            let item = self.item(*sides)?;
            Ok(Candidate {
                pose,
                ..Candidate::new(0, item)
            })
        });
        let candidates = candidates.collect::<Result<Vec<_>, ItemError>>().or_run()?;
        let scene = Scene::from_heightmap(heightmap(bin.surface())?);
        let input = StepInput::new(&self.grid, &scene, &candidates);
        let mut proposals = Proposals::default();
        candidates.iter().for_each(|_| proposals.push_all());
        let group: Vec<usize> = (0..candidates.len()).collect();
        let ranked = self.search.rank(&input, &group, &proposals);
        ranked.map_err(SearchError::Evaluate).or_run()?;
        loop {
            let next = self.search.next_best(&input);
            let Some(next) = next.map_err(SearchError::Evaluate).or_run()? else {
                return Ok(None);
            };
            let placed = placed(&poses, &next);
            if let Some(placed) = placed.filter(|placed| bin.accepts(placed)) {
                return Ok(Some(placed));
            }
        }
    }

    fn item(&mut self, sides: Sides) -> Result<Arc<Item>, ItemError> {
        if let Some(item) = self.items.get(&sides) {
            return Ok(Arc::clone(item));
        }
        let views = [sides, sides.turned()].map(|Sides { x, y, z }| {
            let [nx, ny] = [x, y].map(usize::from);
            let (top, bottom) = (vec![Units::from(z); nx * ny], vec![0; nx * ny]);
            ViewSurfaces::of_cells(nx, ny, top, bottom)
        });
        let volume_m3 = f64::from(sides.volume()) * CELL_M.powi(3);
        let item = Arc::new(Item::new("box", views.to_vec(), volume_m3)?);
        self.items.insert(sides, Arc::clone(&item));
        Ok(item)
    }
}

fn heightmap(surface: &Surface) -> Outcome<Heightmap> {
    let heights = surface.heights().map(Units::from).collect();
    let side = usize::from(SIDE);
    Heightmap::from_units(side, side, heights).or_run()
}

fn placed(poses: &[Sides], found: &Evaluated) -> Option<Placed> {
    let pose = poses.get(found.candidate)?;
    let at = found.resting.placement;
    Some(Placed {
        sides: if at.yaw == 0 { *pose } else { pose.turned() },
        x: u8::try_from(at.x).ok()?,
        y: u8::try_from(at.y).ok()?,
        z: u8::try_from(found.resting.resting_height).ok()?,
    })
}
