//! The built-in household set as a catalogue.

#![allow(clippy::unwrap_used, reason = "a panic is a failing test")]

use std::collections::BTreeSet;
use std::time::Instant;

use ppnpack_catalogue::cache::CacheDir;
use ppnpack_catalogue::catalogue::{Catalogue, Settings};
use ppnpack_catalogue::report::inspect;
use ppnpack_packing::grid::Resolution;

#[test]
fn the_built_in_set_loads_without_repairs() {
    let directory = tempfile::tempdir().unwrap();
    let cache = CacheDir::At(directory.path().to_owned());
    let settings = Settings {
        cache,
        ..Settings::default()
    };
    let start = Instant::now();
    let source = ppnpack_household::builtin();
    let catalogue =
        Catalogue::load(&source, &settings, &Resolution::reference(), &|_, _| ()).unwrap();
    eprintln!(
        "{} built-in objects: cold {:?}",
        catalogue.len(),
        start.elapsed()
    );
    let start = Instant::now();
    let reports = inspect(&source, &settings).unwrap();
    eprintln!("warm {:?}", start.elapsed());
    let names: BTreeSet<_> = catalogue
        .objects
        .iter()
        .map(|object| &object.model.name)
        .collect();
    assert_eq!(names.len(), catalogue.len());
    assert!(!catalogue.is_empty());
    for report in reports {
        let repairs = report.outcome.unwrap().repairs;
        assert!(repairs.is_empty(), "{:?}: {repairs:?}", report.path);
    }
}
