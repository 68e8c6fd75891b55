//! What a step may take of memory.

use std::ops::Range;

use crate::common::{self, announcement, cell, soon};
use nalgebra::Vector3;
use ppnpack_packing::grid::GridSettings;
use ppnpack_packing::heightmap::Surface;
use ppnpack_packing::item::{Item, ViewSurfaces};
use ppnpack_packing::trial::TrialSettings;
use ppnpack_planner::{CellSettings, Where};
use ppnpack_service::embedded;
use ppnpack_service::rpc::{self, Client, Incoming};
use ppnpack_wire::convert;
use ppnpack_wire::keys::Service;
use ppnpack_wire::v1::{self, PlanResult, Status};

/// Items that can be chosen from.
const BUFFER: usize = 300;

/// Items in one request.
const AT_ONCE: usize = 100;

/// A fine grid.
fn fine() -> GridSettings {
    GridSettings {
        cell_m: 0.0025,
        yaws: 16,
        ..GridSettings::default()
    }
}

/// A box of 40 cells a side at each yaw.
fn block() -> v1::Item {
    let view = ViewSurfaces {
        origin_from_corner_m: Vector3::new(0.05, 0.05, 0.0),
        ..ViewSurfaces::of_cells(40, 40, vec![20; 40 * 40], vec![0; 40 * 40])
    };
    convert::item::write(&Item::new("block", vec![view; 16], 0.0001).unwrap())
}

#[test]
fn a_step_that_needs_more_memory_than_is_set_is_refused_by_name_and_smaller_ones_are_planned() {
    let hub = embedded::hub().unwrap();
    let perception = embedded::process(&hub, Service::Perception, "perception-1").unwrap();
    let grid = fine().build().unwrap();
    let heightmap = move |incoming: Incoming<v1::HeightmapRequest>| {
        let surface = Surface::empty(&grid);
        common::show(incoming, &grid, surface, 1);
    };
    let _perception = rpc::listen(&perception, None, heightmap).unwrap();
    for evaluate in [Where::InProcess, Where::Services] {
        let mut settings = CellSettings {
            grid: fine(),
            evaluate,
            search_mib: 2,
            ..crate::common::coarse()
        };
        settings.method.buffer = BUFFER;
        settings.method.trial = TrialSettings::off();
        let _planner = common::start(&hub, &common::settings(settings), &[]);
        let client = Client::new(&embedded::session(&hub).unwrap());
        common::begin(&client);
        let announce = |items: Range<usize>| {
            let items = items.map(|item| announcement(&format!("item-{item}"), block()));
            let announce = v1::AnnounceRequest {
                items: items.collect(),
                ..v1::AnnounceRequest::default()
            };
            client.call(&cell(), announce, soon()).unwrap();
        };
        announce(0..1);
        let planned = client.call(&cell(), v1::PlanRequest::default(), soon());
        let decision = planned.unwrap().decision.unwrap();
        let mut not_placed = common::placed(&decision, 1);
        let outcome = not_placed.outcome.as_mut().unwrap();
        outcome.kind = v1::OutcomeKind::NotPlaced.into();
        client.call(&cell(), not_placed, soon()).unwrap();

        for first in (1..BUFFER).step_by(AT_ONCE) {
            announce(first..BUFFER.min(first + AT_ONCE));
        }
        let planned = client.call(&cell(), v1::PlanRequest::default(), soon());
        let refused = planned.unwrap_err();
        assert_eq!(refused.status(), Some(Status::Invalid), "{refused}");
        assert!(refused.to_string().contains("search_mib"), "{refused}");
        for item in 1..BUFFER {
            let withdraw = v1::WithdrawRequest {
                item_id: format!("item-{item}"),
                ..v1::WithdrawRequest::default()
            };
            client.call(&cell(), withdraw, soon()).unwrap();
        }
        let planned = client.call(&cell(), v1::PlanRequest::default(), soon());
        assert_eq!(planned.unwrap().result(), PlanResult::Decided);
    }
}
