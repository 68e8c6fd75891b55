//! Fill of the open containers of a session.

use ppnpack_packing::kernel::grid::ContainerSize;
use ppnpack_packing::streams::closing::Fill;
use ppnpack_protocol::session::Session;

use crate::shapes::ItemShapes;

/// Gives the share of an open container that is filled, without items whose shape is not known any
/// more.
pub(crate) fn fill(
    session: &Session,
    shapes: &mut ItemShapes,
    name: &str,
    size: ContainerSize,
) -> Fill {
    let volumes_m3 = session.packed_in(name).filter_map(|item| {
        let shape = shapes.shape(item).ok()?;
        Some(shape.item.mesh_volume_m3())
    });
    Fill::of(volumes_m3.sum(), size)
}

/// Gives the open containers by the share of them that is filled, the greatest first; equal ones in
/// the order of the cell.
pub(crate) fn open_by_fullness(
    session: &Session,
    shapes: &mut ItemShapes,
    size: impl Fn(&str) -> Option<ContainerSize>,
) -> Vec<String> {
    let containers = session.containers().iter();
    let open = containers.filter(|container| container.is_open);
    let names: Vec<String> = open.map(|container| container.container.clone()).collect();
    if names.len() < 2 {
        return names;
    }
    let open = names.into_iter().map(|name| {
        let fill = size(&name).map(|size| fill(session, shapes, &name, size));
        (fill.map_or(0.0, |fill| fill.percent()), name)
    });
    let mut open: Vec<(f64, String)> = open.collect();
    open.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    open.into_iter().map(|(_, name)| name).collect()
}
