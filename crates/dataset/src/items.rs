//! The heightmap pairs of a dataset's objects, so that training needs no meshes.
//!
//! | array | shape | |
//! |---|---|---|
//! | `sizes` | objects, yaws, 2 | cells of the footprint along x and y |
//! | `top`, `bottom` | all cells | of each object and yaw the cells of the footprint, row-major |

use std::sync::Arc;

use ppnpack_packing::kernel::grid::{MAX_CELLS, Units};
use ppnpack_packing::kernel::item::{Item, ItemView, ViewSurfaces};
use safetensors::{Dtype, SafeTensors};

use crate::arrays::{Arrays, numbers};
use crate::settings::Settings;

/// Packs the items, each with as many views as the grid has yaws.
pub(crate) fn arrays(items: &[Arc<Item>], yaws: usize) -> Arrays {
    let views = || items.iter().flat_map(|item| item.views());
    let sizes = views().flat_map(|view| [view.nx(), view.ny()]);
    let sizes = sizes.map(|cells| (cells as u32).to_le_bytes());
    let surface = |of: fn(&ItemView) -> &[Units]| {
        let heights = views().flat_map(of);
        heights.map(|height| height.to_le_bytes())
    };
    let cells = views().map(|view| view.nx() * view.ny()).sum();
    let mut arrays = Arrays::default();
    arrays.add("sizes", Dtype::U32, vec![items.len(), yaws, 2], sizes);
    arrays.add("top", Dtype::I16, vec![cells], surface(ItemView::top));
    arrays.add("bottom", Dtype::I16, vec![cells], surface(ItemView::bottom));
    arrays
}

/// Reads the items that the settings count; or gives what is wrong.
pub(crate) fn read(
    arrays: &SafeTensors<'_>,
    settings: &Settings,
) -> Result<Vec<Arc<Item>>, String> {
    let sizes = numbers(arrays, "sizes", Dtype::U32, u32::from_le_bytes)?;
    let top = numbers(arrays, "top", Dtype::I16, i16::from_le_bytes)?;
    let bottom = numbers(arrays, "bottom", Dtype::I16, i16::from_le_bytes)?;
    let (mut top, mut bottom) = (&top[..], &bottom[..]);
    let yaws = settings.grid.resolution().yaws().count();
    let (found, objects) = (sizes.len(), settings.objects as usize);
    if found != objects * yaws * 2 {
        return Err(format!(
            "it has {found} sizes for {objects} objects of {yaws} yaws"
        ));
    }
    let mut take = |size: &[u32]| {
        let (nx, ny) = match size {
            [nx, ny] => (*nx as usize, *ny as usize),
            _ => (0, 0),
        };
        if !(1..=MAX_CELLS).contains(&nx) || !(1..=MAX_CELLS).contains(&ny) {
            return Err(format!("a footprint has {nx} x {ny} cells"));
        }
        let (top, bottom) = (taken(&mut top, nx * ny)?, taken(&mut bottom, nx * ny)?);
        Ok(ViewSurfaces::of_cells(nx, ny, top, bottom))
    };
    let mut items = Vec::new();
    for (object, sizes) in sizes.chunks_exact(yaws * 2).enumerate() {
        let views = sizes.chunks_exact(2).map(&mut take);
        let views = views.collect::<Result<_, String>>()?;
        let item = Item::new(&format!("object {object}"), views, 0.0);
        items.push(Arc::new(item.map_err(|error| error.to_string())?));
    }
    Ok(items)
}

fn taken(rest: &mut &[Units], count: usize) -> Result<Vec<Units>, String> {
    let split = rest.split_at_checked(count);
    let (taken, after) = split.ok_or("its surfaces end too early")?;
    *rest = after;
    Ok(taken.to_vec())
}
