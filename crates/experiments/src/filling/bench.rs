//! An empty container to pack by a way: who plans for it, and its simulated cell.

use std::sync::Arc;

use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_cli::failure::{OrInput, OrRun, Outcome};
use ppnpack_cli::options::{CatalogueOptions, load};
use ppnpack_packing::check::BoxedCheck;
use ppnpack_packing::grid::Grid;
use ppnpack_packing::method::Method;
use ppnpack_packing::plan::Planner;
use ppnpack_physics::packing_cell::{Sampling, SimulatedPackingCell};
use ppnpack_physics::settings::CellSettings;
use ppnpack_physics::trial;
use ppnpack_physics::twin::TwinSettings;
use ppnpack_physics::view::CameraSettings;

use super::Way;
use super::apart::Apart;

/// The objects of a catalogue as a way packs them.
pub(crate) fn catalogue(options: &CatalogueOptions, way: &Way) -> Outcome<Arc<Catalogue>> {
    let mut settings = options.settings();
    settings.poses = way.poses;
    let resolution = way.grid.resolution().or_input()?;
    load(&options.source(), &settings, &resolution).map(Arc::new)
}

/// An empty container, who plans for it, and its cell.
pub(crate) struct Bench {
    pub(crate) grid: Grid,
    pub(crate) planner: Planner,
    pub(crate) cell: SimulatedPackingCell,
}

impl Bench {
    /// The seed is that of everything that is random.
    pub(crate) fn new(way: &Way, catalogue: &Catalogue, seed: u64, apart: &Apart) -> Outcome<Self> {
        Self::with_check(way, catalogue, seed, apart, None)
    }

    /// One in which placements must pass a check more.
    pub(crate) fn with_check(
        way: &Way,
        catalogue: &Catalogue,
        seed: u64,
        apart: &Apart,
        check: Option<BoxedCheck>,
    ) -> Outcome<Self> {
        let grid: Grid = way.grid.build().or_input()?;
        let method = Method {
            seed,
            ..way.method.clone().for_poses(way.poses)
        };
        let known = CellSettings {
            container: grid.container(),
            seed,
            ..CellSettings::robot()
        };
        let pool = trial::pool(way.threads).or_run()?;
        let trial =
            trial::check(method.trial, &method.loads, TwinSettings::of(&known), pool).or_input()?;
        let planner = method.build_with(
            &grid,
            method.proposer(&grid, None)?,
            check.into_iter().chain(trial),
            1,
        )?;
        let real = apart.cell(known);
        let cell = SimulatedPackingCell::new(real, &grid, catalogue, Sampling::Greatest);
        let mut cell = cell
            .or_input()?
            .with_pose_error(apart.pose_error)
            .with_mass_error(apart.mass);
        if let Some(camera) = way.camera {
            cell = cell
                .with_cameras(&CameraSettings { seed, ..camera })
                .or_input()?;
        }
        Ok(Self {
            planner,
            cell,
            grid,
        })
    }
}
