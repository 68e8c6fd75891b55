//! What a step may take of memory.

use crate::common::{self, Rig, announcement, not_placed};
use nalgebra::Vector3;
use ppnpack_packing::kernel::grid::GridSettings;
use ppnpack_packing::kernel::item::{Item, ViewSurfaces};
use ppnpack_planner::{CellSettings, Where};
use ppnpack_wire::convert;
use ppnpack_wire::v1::{self, Status};

const BUFFER: usize = 300;

/// A box of 40 cells a side at each yaw.
fn block(number: usize) -> v1::Announcement {
    let view = ViewSurfaces {
        origin_from_corner_m: Vector3::new(0.05, 0.05, 0.0),
        ..ViewSurfaces::of_cells(40, 40, vec![20; 40 * 40], vec![0; 40 * 40])
    };
    let block = Item::new("block", vec![view; 16], 0.0001).unwrap();
    announcement(&format!("item-{number}"), convert::item::write(&block))
}

#[test]
fn a_step_that_needs_more_memory_than_is_set_is_refused_by_name_and_smaller_ones_are_planned() {
    for evaluate in [Where::InProcess, Where::Services] {
        let mut settings = CellSettings {
            grid: GridSettings {
                cell_m: 0.0025,
                yaws: 16,
                ..GridSettings::default()
            },
            evaluate,
            search_mib: 2,
            ..common::untried()
        };
        settings.method.buffer = BUFFER;
        let rig = Rig::new(settings);
        rig.begin();
        rig.announce([block(0)]);
        let decision = rig.decision();
        rig.call(not_placed(&decision, decision.state_number));

        for first in [1, 100, 200] {
            rig.announce((first..first + 100).map(block));
        }
        rig.assert_refused(v1::PlanRequest::default(), Status::Invalid, "search_mib");
        for number in 1..BUFFER {
            rig.withdraw(&format!("item-{number}"));
        }
        rig.decision();
    }
}
