use ppnpack_packing::kernel::grid::GridSettings;
use ppnpack_packing::kernel::objective::Weights;
use ppnpack_packing::planning::method::{Method, ProposalSource};
use ppnpack_robot::station::StationSettings;

use super::*;

#[test]
fn a_search_has_room_for_what_every_one_takes() {
    let mut cell = CellSettings::default();
    cell.grid.cell_m = 0.000_5;
    cell.search_mib = 1;
    let refused = cell.validate().unwrap_err();
    assert!(refused.starts_with("search_mib"), "{refused}");
    let least_mib = refused.split_whitespace().find_map(|word| {
        let number = word.trim_end_matches(',');
        number.parse().ok()
    });
    cell.search_mib = least_mib.unwrap();
    cell.validate().unwrap();
}

#[test]
fn the_keys_of_grid_and_method_stand_among_the_others() {
    let text = "cell_m = 0.02\nbuffer = 3\nyaws = 2\ninspect = true\nweights = { distance = 2 }\n\
                proposals = { from = \"random\", percent = 5 }";
    let cell: CellSettings = toml::from_str(text).unwrap();
    assert_eq!(
        (cell.grid.cell_m, cell.grid.yaws, cell.inspect),
        (0.02, 2, Some(true))
    );
    let expected = Method {
        buffer: 3,
        weights: Some(Weights {
            distance: 2.0,
            ..Weights::default()
        }),
        proposals: ProposalSource::Random { percent: 5.0 },
        ..Method::default()
    };
    assert_eq!(cell.method, expected);
    assert_eq!(
        cell.grid.height_unit_m,
        GridSettings::default().height_unit_m
    );
    let written = toml::to_string(&cell).unwrap();
    let table: toml::Table = toml::from_str(&written).unwrap();
    assert!(table.contains_key("cell_m") && !table.contains_key("grid"));
    assert!(table.contains_key("stability") && !table.contains_key("method"));
    assert_eq!(toml::from_str::<CellSettings>(&written).unwrap(), cell);
    for unknown in [
        "cel_m = 0.02",
        "grid = 1",
        "cell_m = 0.02\nbufer = 3",
        "proposals = { from = \"random\", percent = 5, coarsening = { cells = 1, yaws = 1 } }",
    ] {
        let error = toml::from_str::<CellSettings>(unknown).unwrap_err();
        assert!(error.to_string().contains("unknown field"), "{error}");
    }
}

#[test]
fn what_is_not_possible_is_refused_with_its_name() {
    let validated = |text: &str| {
        let cell: CellSettings = toml::from_str(text).unwrap();
        cell.validate()
    };
    for possible in [
        "",
        "trial = { tries_per_item = 7 }",
        "set_aside = 10000",
        "poses = 1\nbuffer = 1000",
        "poses = 6\nbuffer = 166",
        "rules = { sharing = \"one-order\" }\n\
         closing = { renews = true, fill_percent = 80, order_complete = true }",
    ] {
        assert_eq!(validated(possible), Ok(()));
        let cell: CellSettings = toml::from_str(possible).unwrap();
        let written = toml::to_string(&cell).unwrap();
        assert_eq!(toml::from_str::<CellSettings>(&written).unwrap(), cell);
    }
    for (text, named) in [
        (
            "proposals = { from = \"tries\", yaws = 3, positions = 9 }",
            "proposals: `tries`",
        ),
        ("trial = { limits = { tilt_rad = 9.0 } }", "tilt limit"),
        ("set_aside = 10001", "set_aside"),
        ("poses = 0", "poses"),
        ("poses = 7", "poses"),
        ("poses = 6\nbuffer = 167", "lower poses or buffer"),
        ("closing = { fill_percent = 101 }", "1 to 100 percent"),
        ("closing = { order_complete = true }", "set rules.sharing"),
    ] {
        let refused = validated(text).unwrap_err();
        assert!(refused.contains(named), "{refused}");
    }
    let unknown = toml::from_str::<CellSettings>("closing = { none_of_last = 3 }");
    let unknown = unknown.unwrap_err().to_string();
    assert!(unknown.contains("none_of_last"), "{unknown}");
}

#[test]
fn an_unknown_arm_is_refused_with_the_names_there_are() {
    let refusal = |change: fn(&mut StationSettings)| {
        let mut station = StationSettings::default();
        change(&mut station);
        let cell = CellSettings {
            arm: Some(station),
            ..CellSettings::default()
        };
        let settings = Settings {
            cells: BTreeMap::from([("cell-1".to_owned(), cell)]),
            ..Settings::default()
        };
        settings.validate().unwrap_err()
    };
    let unknown = refusal(|station| station.arm = "r2d2".to_owned());
    for part in ["cells.cell-1.arm", "r2d2", "nachi-mz07l"] {
        assert!(unknown.contains(part), "{unknown}");
    }
    let file = refusal(|station| station.arm = "no/such/arm.toml".to_owned());
    assert!(file.contains("no/such/arm.toml"), "{file}");
    let place = refusal(|station| station.pick.position_m[2] = f64::NAN);
    assert!(place.contains("pick.position_m[2]"), "{place}");
    let cell = refusal(|station| station.cell.clearance_m = -1.0);
    assert!(cell.contains("clearance_m"), "{cell}");
}
