//! Containers without physics, for streams.

use ppnpack_packing::episode::IdealCell;
use ppnpack_packing::grid::Grid;
use ppnpack_packing::objective::{Heuristic, Order};
use ppnpack_packing::plan::{Planner, StageError};
use ppnpack_packing::proposals::ProposeAll;
use ppnpack_packing::search::{Search, SearchSettings};
use ppnpack_packing::stability::PublishedStability;
use ppnpack_packing::stream::ContainerSupply;

/// Plans by a bounded search.
pub(crate) fn planner(grid: &Grid, heuristic: Heuristic) -> Planner {
    let settings = SearchSettings {
        heuristic,
        ..SearchSettings::default()
    };
    let search = Search::new(grid, &settings).unwrap().bounded();
    Planner::new(
        Box::new(ProposeAll),
        Box::new(search),
        vec![Box::new(PublishedStability::default())],
        Order::Balance,
        0,
    )
}

/// Brings empty containers.
pub(crate) struct Ideal;

impl ContainerSupply for Ideal {
    type Cell = IdealCell;

    fn next(&mut self, _number: usize, grid: &Grid) -> Result<(Planner, IdealCell), StageError> {
        let planner = planner(grid, Heuristic::Sdfm);
        Ok((planner, IdealCell::new(grid)))
    }
}
