use ppnpack_packing::grid::GridSettings;
use ppnpack_packing::method::{Method, ProposalSource, SET_ASIDE};
use ppnpack_packing::objective::Weights;
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
fn proposals_that_give_items_up_early_are_refused() {
    let cell: CellSettings =
        toml::from_str("proposals = { from = \"tries\", yaws = 3, positions = 9 }").unwrap();
    assert_eq!(cell.method.proposals, ProposalSource::PUBLISHED_TRIES);
    let refused = cell.validate().unwrap_err();
    assert!(refused.starts_with("proposals: `tries`"), "{refused}");
}

#[test]
fn how_placements_are_tried_is_set_for_each_cell() {
    let cell: CellSettings = toml::from_str("trial = { tries_per_item = 7 }").unwrap();
    assert_eq!(cell.method.trial.tries_per_item, 7);
    assert_eq!(cell.validate(), Ok(()));
    let text = "[trial]\nlimits = { tilt_rad = 9.0 }";
    let cell: CellSettings = toml::from_str(text).unwrap();
    let refusal = cell.validate().unwrap_err();
    assert!(refusal.contains("tilt limit"), "{refusal}");
}

#[test]
fn no_more_items_may_be_set_aside_than_is_possible() {
    let cell: CellSettings = toml::from_str("set_aside = 10000").unwrap();
    assert_eq!(cell.validate(), Ok(()));
    let cell = CellSettings {
        set_aside: 10_001,
        ..cell
    };
    let refusal = cell.validate().unwrap_err();
    assert!(refusal.contains("set_aside"), "{refusal}");
    assert_eq!(CellSettings::default().set_aside, SET_ASIDE);
}

#[test]
fn as_many_poses_are_possible_as_the_services_take_candidates() {
    let with_poses = |poses: usize, buffer: usize| {
        let text = format!("poses = {poses}\nbuffer = {buffer}");
        let cell: CellSettings = toml::from_str(&text).unwrap();
        cell.validate()
    };
    assert_eq!(CellSettings::default().poses, 1);
    assert_eq!(with_poses(1, 1_000), Ok(()));
    assert_eq!(with_poses(6, 166), Ok(()));
    for (poses, buffer) in [(0, 5), (7, 5), (6, 167)] {
        let refusal = with_poses(poses, buffer).unwrap_err();
        assert!(refusal.contains("poses"), "{refusal}");
    }
}

#[test]
fn closing_rules_that_do_not_go_together_are_refused_with_what_to_do() {
    let validated = |text: &str| {
        let cell: CellSettings = toml::from_str(text).unwrap();
        cell.validate()
    };
    let possible = "rules = { sharing = \"one-order\" }\n\
                    closing = { renews = true, fill_percent = 80, order_complete = true }";
    assert_eq!(validated(possible), Ok(()));
    let cell: CellSettings = toml::from_str(possible).unwrap();
    let written = toml::to_string(&cell).unwrap();
    assert_eq!(toml::from_str::<CellSettings>(&written).unwrap(), cell);
    for (text, remedy) in [
        ("closing = { fill_percent = 101 }", "1 to 100 percent"),
        ("closing = { order_complete = true }", "set rules.sharing"),
    ] {
        let refused = validated(text).unwrap_err();
        assert!(refused.contains(remedy), "{refused}");
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
