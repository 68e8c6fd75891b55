//! What the tests of the planner share: a cell, blocks, a perception that shows what a test says.

pub(crate) mod containers;
pub(crate) mod rig;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use nalgebra::Vector3;
use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_packing::grid::{Grid, GridSettings};
use ppnpack_packing::heightmap::{Scene, Surface};
use ppnpack_packing::item::{Item, ViewSurfaces};
use ppnpack_packing::method::{Method, Stability};
use ppnpack_packing::trial::TrialSettings;
use ppnpack_planner::{CellSettings, PlannerService, Settings};
use ppnpack_service::embedded::{self, Hub};
use ppnpack_service::rpc::{Client, Done, Incoming};
use ppnpack_wire::convert;
use ppnpack_wire::keys::{Cell, Service};
use ppnpack_wire::v1;

/// The cell of all tests.
pub(crate) fn cell() -> Cell {
    Cell::new("cell-1").unwrap()
}

/// A deadline that nothing here is late for.
pub(crate) fn soon() -> Instant {
    Instant::now() + Duration::from_secs(20)
}

/// The paper's grid, on which tests are quick, and by the paper's objective what there is room for.
pub(crate) fn coarse() -> CellSettings {
    CellSettings {
        grid: GridSettings::from(&Grid::reference()),
        method: method(),
        set_aside: 0,
        ..CellSettings::default()
    }
}

/// The paper's objective, and tries within what counts as steady.
pub(crate) fn method() -> Method {
    let mut trial = TrialSettings::default();
    trial.limits.tilt_rad = 30.0_f64.to_radians();
    trial.limits.slide_m = 0.02;
    Method {
        stability: Stability::None,
        trial,
        ..Method::published()
    }
}

/// A planner with that one cell.
pub(crate) fn settings(cell: CellSettings) -> Settings {
    Settings {
        cells: BTreeMap::from([("cell-1".to_owned(), cell)]),
        ..Settings::default()
    }
}

/// Begins a session, called `s`.
pub(crate) fn begin(client: &Client) {
    let begin = v1::BeginRequest {
        session_id: "s".to_owned(),
        ..v1::BeginRequest::default()
    };
    client.call(&cell(), begin, soon()).unwrap();
}

pub(crate) fn start(
    hub: &Hub,
    settings: &Settings,
    catalogues: &[Arc<Catalogue>],
) -> Box<PlannerService> {
    let process = embedded::process(hub, Service::Planner, "planner-1").unwrap();
    Box::new(ppnpack_planner::start(&process, settings, catalogues).unwrap())
}

/// A box with a square floor of so many cells a side, 4 cm high, of which no more is known.
pub(crate) fn square(name: &str, cells: usize, mesh_volume_m3: f64) -> v1::Item {
    let middle_m = cells as f64 * 0.01 / 2.0;
    let columns = cells * cells;
    let view = ViewSurfaces {
        origin_from_corner_m: Vector3::new(middle_m, middle_m, 0.0),
        ..ViewSurfaces::of_cells(cells, cells, vec![20; columns], vec![0; columns])
    };
    convert::item::write(&Item::new(name, vec![view; 4], mesh_volume_m3).unwrap())
}

/// A block of 6 x 6 cells.
pub(crate) fn block() -> v1::Item {
    square("block", 6, 0.0001)
}

/// An item of which the shape is told.
pub(crate) fn announcement(item_id: &str, item: v1::Item) -> v1::Announcement {
    v1::Announcement {
        item_id: item_id.to_owned(),
        shape: Some(v1::announcement::Shape::Item(item)),
        ..v1::Announcement::default()
    }
}

/// Answers with a heightmap of a state of the cell.
pub(crate) fn show(
    incoming: Incoming<v1::HeightmapRequest>,
    grid: &Grid,
    surface: Surface,
    state_number: u64,
) {
    let scene = Scene::from_surface(grid, surface).unwrap();
    let heightmap = v1::Heightmap {
        id: Some(v1::HeightmapId {
            epoch: 1,
            sequence: state_number,
        }),
        state_number,
        scene: Some(convert::scene::write(grid, &scene)),
        ..v1::Heightmap::default()
    };
    let reply = v1::HeightmapReply {
        heightmap: Some(heightmap),
        ..v1::HeightmapReply::default()
    };
    incoming.reply(reply, Done::default());
}

/// Answers with a heightmap of a state of the cell, or of the later one that is asked for.
pub(crate) fn show_from(
    incoming: Incoming<v1::HeightmapRequest>,
    grid: &Grid,
    surface: Surface,
    state_number: u64,
) {
    let state_number = state_number.max(incoming.message().least_state_number);
    show(incoming, grid, surface, state_number);
}

/// Reports a decision's item as placed, and found as planned, in a state of the cell.
pub(crate) fn placed(decision: &v1::Decision, state_number: u64) -> v1::ReportRequest {
    placed_and(decision, state_number, true)
}

/// Reports a decision's item as placed as planned; whether it was found so or is only assumed to be.
pub(crate) fn placed_and(
    decision: &v1::Decision,
    state_number: u64,
    is_found: bool,
) -> v1::ReportRequest {
    v1::ReportRequest {
        decision_id: decision.decision_id.clone(),
        outcome: Some(v1::Outcome {
            placement_id: decision.decision_id.clone(),
            item_id: decision.item_id.clone(),
            kind: v1::OutcomeKind::Placed.into(),
            container_from_item: decision.container_from_item,
            is_inside: true,
            state_number,
            is_found,
            ..v1::Outcome::default()
        }),
        ..v1::ReportRequest::default()
    }
}

/// The items that reasons are given for.
pub(crate) fn ids(reasons: &[v1::ItemReason]) -> Vec<&str> {
    let ids = reasons.iter().map(|reason| reason.item_id.as_str());
    ids.collect()
}
