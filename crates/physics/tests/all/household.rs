//! Scanned household objects, concave ones among them, piled up in the container.

use std::sync::Arc;

use nalgebra::Isometry3;
use ppnpack_catalogue::build::{ModelSettings, model};
use ppnpack_catalogue::object::Model;
use ppnpack_catalogue::reader;
use ppnpack_catalogue::unit::LengthUnit;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_physics::cell::SimulatedCell;
use ppnpack_physics::settings::CellSettings;

fn scanned(file: &str) -> Option<Arc<Model>> {
    let path = crate::shared::shared("data/ycb_apc")?.join(file);
    let mesh = reader::read(&path, LengthUnit::Metres).unwrap();
    let (model, _) = model(file, mesh, &ModelSettings::default()).unwrap();
    Some(Arc::new(model))
}

#[test]
fn a_pile_of_scanned_objects_comes_to_rest_without_sinking_into_itself() {
    let files = [
        "64_025_mug.ply",
        "15_050_medium_clamp.ply",
        "46_011_banana.ply",
        "07_072-e_toy_airplane.ply",
        "03_032_knife.ply",
        "36_009_gelatin_box.ply",
    ];
    let models = files.iter().map(|file| scanned(file));
    let Some(models) = models.collect::<Option<Vec<_>>>() else {
        return;
    };
    let mut cell = SimulatedCell::new(CellSettings::default()).unwrap();
    let grid = Grid::reference();
    let mut fill_m = 0.0;
    for round in 0..2 {
        for model in &models {
            let bounds = model.mesh.bounds().unwrap();
            let middle = nalgebra::center(&bounds.lowest, &bounds.highest);
            let (x_m, y_m) = (0.16 - middle.x, 0.16 - middle.y + 0.03 * f64::from(round));
            let pose = Isometry3::translation(x_m, y_m, fill_m - bounds.lowest.z);
            let report = cell.place(model, &pose).unwrap();
            let is_sound = report.inside && cell.deepest_overlap_m() < 2e-3;
            assert!(is_sound, "{}: {report:?}", model.name);
            let surface = cell.scan_surface(&grid).unwrap();
            fill_m = f64::from(surface.heights_m().iter().copied().fold(0.0, f32::max));
        }
    }
    // Round things roll a while; ten phases are 3.75 s.
    let still = (0..10).any(|_| {
        cell.settle();
        cell.is_still()
    });
    assert!(still, "the pile does not come to rest");
    let overlap_m = cell.deepest_overlap_m();
    assert!(overlap_m < 1e-3, "{overlap_m} m");
}
