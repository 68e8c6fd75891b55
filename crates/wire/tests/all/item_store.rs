//! Items are kept by their id, within a bound.

use ppnpack_wire::item_id::ItemId;
use ppnpack_wire::item_store::{ItemStore, MissingItems};
use ppnpack_wire::v1;
use prost::Message;

/// A cube; all have messages of the same size.
fn cube(name: char) -> v1::Item {
    v1::Item {
        name: name.to_string(),
        views: vec![v1::ItemView {
            nx: 1,
            ny: 1,
            top: vec![3, 0],
            bottom: vec![0, 0],
            origin_from_corner: Some(v1::Vector3::default()),
            ..Default::default()
        }],
        mesh_volume_m3: 0.0,
    }
}

fn ids(items: &[v1::Item]) -> Vec<ItemId> {
    items.iter().map(ItemId::of).collect()
}

fn names(items: &[std::sync::Arc<ppnpack_packing::kernel::item::Item>]) -> Vec<String> {
    items.iter().map(|item| item.name().to_string()).collect()
}

#[test]
fn items_come_in_the_order_of_their_ids_and_need_not_be_sent_again() {
    let cubes = ['a', 'b', 'c'].map(cube);
    let mut store = ItemStore::new(1 << 20);
    let mut wanted = ids(&cubes);
    wanted.reverse();
    let found = store.resolve(&cubes, &wanted).unwrap().unwrap();
    assert_eq!(names(&found), ["c", "b", "a"]);
    let again = store.resolve(&[], &wanted).unwrap().unwrap();
    assert!(
        found
            .iter()
            .zip(&again)
            .all(|(found, again)| std::sync::Arc::ptr_eq(found, again))
    );
}

#[test]
fn items_that_are_not_known_are_named() {
    let mut store = ItemStore::new(1 << 20);
    let cubes = ['a', 'b'].map(cube);
    let missing = store.resolve(&cubes[..1], &ids(&cubes)).unwrap();
    assert_eq!(missing.unwrap_err(), MissingItems(ids(&cubes[1..])));
}

#[test]
fn an_impossible_item_is_refused_and_not_kept() {
    let mut store = ItemStore::new(1 << 20);
    let mut bad = cube('a');
    bad.views[0].top.clear();
    assert!(store.resolve(std::slice::from_ref(&bad), &[]).is_err());
    assert!(store.get(ItemId::of(&bad)).is_none());
}

#[test]
fn the_item_longest_unused_makes_room() {
    let cubes = ['a', 'b', 'c'].map(cube);
    let mut store = ItemStore::new(2 * cubes[0].encoded_len());
    let [a, b, c] = cubes.each_ref().map(ItemId::of);
    store.add(&cubes[0]).unwrap();
    store.add(&cubes[1]).unwrap();
    store.get(a).unwrap();
    store.add(&cubes[2]).unwrap();
    assert_eq!(
        [a, b, c].map(|id| store.get(id).is_some()),
        [true, false, true]
    );
}

#[test]
fn a_request_is_served_from_a_store_that_is_too_small_for_it() {
    let cubes = ['a', 'b', 'c'].map(cube);
    let mut store = ItemStore::new(cubes[0].encoded_len());
    let found = store.resolve(&cubes, &ids(&cubes)).unwrap().unwrap();
    assert_eq!(names(&found), ["a", "b", "c"]);
}
