//! The published stability test.

use crate::checks::check::{Condition, Cost, Question};
use crate::kernel::grid::{ABSENT, Grid, Units};
use crate::kernel::heightmap::Heightmap;
use crate::kernel::item::ItemView;
use crate::kernel::placement::RestingPlacement;
use crate::kernel::polygon::SupportPolygon;
use crate::ranking::refusal::Cause;
use crate::ranking::step::StepInput;

/// Contact is counted over this height: 5 units of 0.2 cm in the paper.
const CONTACT_HEIGHT_M: f64 = 0.01;

/// The centre of mass must lie further inside the support polygon than this, in cells.
const MARGIN_CELLS: f64 = 0.5;

/// The test of the paper, for comparisons with it.
///
/// Near the floor the contact cells are those with material in the item's lowest centimetre; higher
/// up those with content within about a centimetre. The mean of the item's voxels must lie inside
/// their hull by more than half a cell: an item two cells wide never passes.
#[derive(Debug, Clone, Default)]
pub struct PublishedStability {
    polygon: SupportPolygon,
}

impl PublishedStability {
    /// Whether a view at a placement counts as stable.
    pub fn is_stable(
        &mut self,
        grid: &Grid,
        heightmap: &Heightmap,
        view: &ItemView,
        resting: &RestingPlacement,
    ) -> bool {
        self.depth_cells(grid, heightmap, view, resting) > MARGIN_CELLS
    }

    /// Gives the depth of the item's centre inside the hull of the contact cells, in cells. With `k`
    /// the resting height, `c` 5 units of 0.2 cm, `t` and `b` the item's surfaces and `h` the heightmap,
    /// contact is `b < c` for `k <= c`, else `b < min(c, t)` and `h > k - c - 1 + b`.
    pub fn depth_cells(
        &mut self,
        grid: &Grid,
        heightmap: &Heightmap,
        view: &ItemView,
        resting: &RestingPlacement,
    ) -> f64 {
        let contact = grid.resolution().units_below(CONTACT_HEIGHT_M);
        let height = resting.resting_height;
        let is_contact = |top: Units, bottom: Units, below: Units| {
            if height <= contact {
                bottom < contact
            } else {
                bottom < contact.min(top) && below > height - contact - 1 + bottom
            }
        };
        self.polygon.clear();
        let rows = view
            .top()
            .chunks_exact(view.ny())
            .zip(view.bottom().chunks_exact(view.ny()));
        for (x, (tops, bottoms)) in rows.enumerate() {
            let below = heightmap.row(resting.placement.x + x);
            let below = below.get(resting.placement.y..).unwrap_or(&[]);
            let below = below.get(..view.ny()).unwrap_or(&[]);
            let columns = tops.iter().zip(bottoms).zip(below);
            let are_contacts = columns.map(|((top, bottom), below)| {
                *bottom != ABSENT && is_contact(*top, *bottom, *below)
            });
            self.polygon.add_row(x, are_contacts, 1.0);
        }
        self.polygon.depth(view.centroid_cells())
    }
}

impl Condition for PublishedStability {
    const COST: Cost = Cost::Footprint;
    const CAUSE: Cause = Cause::UnstableByPublishedTest;

    fn is_met(&mut self, asked: &Question<'_>) -> bool {
        let StepInput { grid, scene, .. } = *asked.input;
        self.is_stable(grid, scene.heightmap(), asked.view, asked.at)
    }
}
