//! The built-in household set as a catalogue.

#![allow(clippy::unwrap_used, reason = "a panic is a failing test")]

use std::collections::BTreeSet;

use ppnpack_catalogue::cache::CacheDir;
use ppnpack_catalogue::catalogue::{Catalogue, Settings};
use ppnpack_catalogue::report::inspect;
use ppnpack_packing::kernel::grid::Resolution;

#[test]
fn the_built_in_set_loads_without_repairs() {
    let directory = tempfile::tempdir().unwrap();
    let settings = Settings {
        cache: CacheDir::At(directory.path().to_owned()),
        ..Settings::default()
    };
    let source = ppnpack_household::builtin();
    let resolution = Resolution::reference();
    let catalogue = Catalogue::load(&source, &settings, &resolution, &|_, _| ()).unwrap();
    let names = catalogue.objects.iter().map(|it| &it.model.name);
    let names: BTreeSet<_> = names.collect();
    assert_eq!((names.len(), catalogue.len()), (96, 96));
    for report in inspect(&source, &settings).unwrap() {
        let repairs = report.outcome.unwrap().repairs;
        assert!(repairs.is_empty(), "{:?}: {repairs:?}", report.path);
    }
    let volumes_m3 = catalogue.objects.iter().map(|it| it.model.volume_m3);
    assert!(volumes_m3.is_sorted());
}

#[test]
fn every_object_stands_on_the_ground_in_the_middle_and_fits_the_container() {
    for object in ppnpack_household::OBJECTS.iter() {
        let bounds = object.mesh.bounds().unwrap();
        for (extent_m, most_m) in bounds.extents_m().iter().zip([0.32, 0.32, 0.30]) {
            assert!(*extent_m < most_m, "{} is {extent_m} m long", object.name);
        }
        assert_eq!(bounds.lowest.z, 0.0, "{}", object.name);
        let touching = object.mesh.vertices.iter().filter(|v| v.z == 0.0).count();
        assert!(touching >= 3, "{}", object.name);
        let middle = nalgebra::center(&bounds.lowest, &bounds.highest);
        assert!(middle.xy().coords.amax() < 1e-6, "{}", object.name);
    }
}
