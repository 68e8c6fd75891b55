//! Pictures that several commands draw.

use nalgebra::Isometry3;
use ppnpack_packing::kernel::grid::{Grid, Units};
use ppnpack_packing::kernel::heightmap::Heightmap;
use ppnpack_packing::scene::model::mesh::Mesh;
use ppnpack_physics::settings::TakenBox;
use ppnpack_picture::{
    Camera, Colour, HeightField, Image, Item, PictureError, Scene3d, Size, TriangleMesh, heightmap,
    render,
};

use crate::report::Content;

/// Draws perception's heightmap as a PNG. What it does not know has a height of one unit above the
/// rim, and is grey.
pub fn perceived(title: &str, grid: &Grid, map: &Heightmap) -> anyhow::Result<Vec<u8>> {
    heights(title, grid, map, Some(grid.rim() + 1))
}

/// Draws a heightmap as a PNG; cells of the height `unknown` are grey.
pub fn heights(
    title: &str,
    grid: &Grid,
    map: &Heightmap,
    unknown: Option<Units>,
) -> anyhow::Result<Vec<u8>> {
    let unit_m = grid.resolution().height_unit_m();
    let heights_m = map
        .heights()
        .iter()
        .map(|height| match Some(*height) == unknown {
            true => f64::NAN,
            false => f64::from(*height) * unit_m,
        });
    let heights_m: Vec<f64> = heights_m.collect();
    let field = HeightField {
        nx: map.nx(),
        ny: map.ny(),
        cell_m: grid.resolution().cell_m(),
        heights_m: &heights_m,
        scale_top_m: Some(grid.container().z_m),
    };
    Ok(heightmap(title, &field)?.to_png()?)
}

/// Draws a packed container; colours go by the order of arrivals, and what is taken of it is grey.
///
/// # Errors
/// [`PictureError`] where there is too much in it.
pub fn packed<'a>(
    grid: &Grid,
    taken: &[TakenBox],
    preloaded: &[Content],
    contents: impl Iterator<Item = &'a (usize, Content)>,
    size: Size,
) -> Result<Image, PictureError> {
    let container = grid.container();
    let taken: Vec<Mesh> = taken.iter().map(|taken| taken.bounds().mesh()).collect();
    let fixed = taken.iter();
    let fixed = fixed.map(|mesh| posed(mesh, Isometry3::identity(), Colour::GREY));
    let preloaded = preloaded
        .iter()
        .map(|body| posed(&body.model.mesh, body.container_from_item, Colour::GREY));
    let items = contents.map(|(arrival, body)| {
        let colour = Colour::of_item(*arrival);
        posed(&body.model.mesh, body.container_from_item, colour)
    });
    let scene = Scene3d {
        items: fixed.chain(preloaded).chain(items).collect(),
        container_m: Some([container.x_m, container.y_m, container.z_m]),
    };
    render(&scene, &Camera::overlooking(&scene), size)
}

fn posed(mesh: &Mesh, world_from_item: Isometry3<f64>, colour: Colour) -> Item<'_> {
    let (vertices, triangles) = (&mesh.vertices, &mesh.triangles);
    Item {
        mesh: TriangleMesh {
            vertices,
            triangles,
        },
        world_from_item,
        colour,
    }
}
