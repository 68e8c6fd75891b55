//! Any cloud, mapped: a heightmap of the container, or a refusal.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ppnpack_packing::kernel::grid::Grid;
use ppnpack_perception::mapper::Mapper;
use ppnpack_perception::settings::MapperSettings;
use ppnpack_wire::{MAX_CLOUD_BYTES, convert, decode, v1};

fuzz_target!(|data: &[u8]| {
    let Ok(message) = decode::<v1::PointCloud>(data, MAX_CLOUD_BYTES) else {
        return;
    };
    let Ok(cloud) = convert::cloud::read(&message) else {
        return;
    };
    let grid = Grid::reference();
    let mut mapper =
        Mapper::new(&grid, MapperSettings::default()).expect("the defaults are possible");
    let points = cloud.points();
    let mapped = mapper
        .map(points, cloud.container_from_sensor())
        .expect("heights are finite");
    assert!(mapped.unknown_cells <= grid.nx() * grid.ny());
});
