//! The shapes of items, as the records of planned steps tell them.

use std::collections::BTreeMap;

use nalgebra::Isometry3;
use ppnpack_wire::v1;

use super::pose;
use crate::shapes::{self, ShapeId};

/// Maximum of items, and of objects, before all shapes are forgotten and learnt anew.
const MOST_KEPT: usize = 10_000;

/// The shape of an item in one of its resting poses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ItemShape {
    pub(super) shape: ShapeId,
    /// The item's own frame in that of the shape, where they are not the same.
    shape_from_item: Option<Isometry3<f64>>,
}

impl ItemShape {
    /// Gives the shape that an item was announced with: its heightmaps, where planners planned with
    /// them.
    fn as_announced(item: &v1::SessionItem) -> Option<Self> {
        Some(Self {
            shape: shapes::id(&item.shape)?,
            shape_from_item: pose::read(item.heightmap_from_item.as_ref()),
        })
    }

    /// Gives the frame of the shape from that of the item.
    pub(super) fn placed(&self, container_from_item: &Isometry3<f64>) -> Isometry3<f64> {
        container_from_item * self.shape_from_item.unwrap_or_default().inverse()
    }
}

/// The shapes of items, by their resting poses.
type Poses<T> = BTreeMap<u32, T>;

/// The shapes of the items of a session.
#[derive(Debug, Default)]
pub(super) struct KnownShapes {
    /// The session that the items are of: another one may use their ids for others.
    session_id: String,
    by_item: BTreeMap<String, Poses<ItemShape>>,
    /// The shapes by names of objects; `None` where items of one name have several.
    by_object: BTreeMap<String, Poses<Option<ItemShape>>>,
}

impl KnownShapes {
    /// Takes in the shapes that a record names. Gives one of each of its items.
    pub(super) fn learn(&mut self, record: &v1::PlanningRecord) -> Vec<ShapeId> {
        if record.session_id != self.session_id || self.by_item.len() > MOST_KEPT {
            self.session_id.clone_from(&record.session_id);
            self.by_item.clear();
        }
        if self.by_object.len() > MOST_KEPT {
            self.by_object.clear();
        }
        let items = record.items.iter();
        items
            .filter_map(|item| self.learn_item(item, record))
            .collect()
    }

    fn learn_item(
        &mut self,
        item: &v1::RecordedItem,
        record: &v1::PlanningRecord,
    ) -> Option<ShapeId> {
        let candidates = record.candidates.iter();
        let candidates = candidates.filter(|held| held.arrival == item.arrival);
        let poses = self.by_item.entry(item.item_id.clone()).or_default();
        let objects = self.by_object.entry(item.object.clone()).or_default();
        for held in candidates {
            let id = shapes::id(&held.solid).or_else(|| shapes::id(&held.item));
            let Some(shape) = id else {
                continue;
            };
            let known = ItemShape {
                shape,
                shape_from_item: pose::read(held.heightmap_from_item.as_ref()),
            };
            poses.insert(held.pose, known);
            let of_object = objects.entry(held.pose).or_insert(Some(known));
            *of_object = of_object.filter(|other| *other == known);
        }
        poses.values().next().map(|known| known.shape)
    }

    /// Gives the shape of an item of a session in a pose.
    pub(super) fn of_item(
        &self,
        session_id: &str,
        item: &v1::SessionItem,
        pose: u32,
    ) -> Option<ItemShape> {
        let named = self.named(session_id, &item.item_id, &item.object, pose);
        named.or_else(|| ItemShape::as_announced(item).filter(|_| pose == 0))
    }

    /// Gives the shape of an item in a pose, where a record told of it or of one of the same
    /// object.
    pub(super) fn named(
        &self,
        session_id: &str,
        item_id: &str,
        object: &str,
        pose: u32,
    ) -> Option<ItemShape> {
        let own = (session_id == self.session_id)
            .then(|| self.by_item.get(item_id)?.get(&pose))
            .flatten();
        own.copied()
            .or_else(|| *self.by_object.get(object)?.get(&pose)?)
    }

    /// Gives a shape of an item that waits, in the first of its poses that is known.
    pub(super) fn of_waiting(&self, session_id: &str, item: &v1::SessionItem) -> Option<ShapeId> {
        let poses = self.by_item.get(&item.item_id);
        let poses = poses.filter(|_| session_id == self.session_id);
        let first = poses.and_then(|poses| poses.values().next());
        let known = first.map(|known| known.shape);
        known.or_else(|| Some((*self.by_object.get(&item.object)?.values().next()?)?.shape))
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::record;
    use super::*;

    fn id(shape: u8) -> ShapeId {
        shapes::id(&[shape; 32]).unwrap()
    }

    #[test]
    fn an_item_has_the_shape_that_a_record_of_its_session_told_of_it_or_its_object() {
        let mut known = KnownShapes::default();
        let named = known.learn(&record("s", &[("i-1", "mug", 1), ("i-2", "pan", 2)]));
        assert_eq!(named, [id(1), id(2)]);
        let shape = |known: &KnownShapes, session: &str, item: &str, object: &str| {
            known.named(session, item, object, 0).map(|it| it.shape)
        };
        assert_eq!(shape(&known, "s", "i-1", "mug"), Some(id(1)));
        let other = shape(&known, "s", "i-9", "mug");
        assert_eq!(other, Some(id(1)), "one of the same object");
        assert_eq!(shape(&known, "s", "i-9", "cup"), None);
        assert_eq!(known.named("s", "i-1", "mug", 1), None, "of another pose");
        // In the next session the same id may be another item's.
        known.learn(&record("t", &[("i-2", "mug", 1)]));
        let before = shape(&known, "s", "i-2", "pan");
        assert_eq!(before, Some(id(2)), "by its object");
        assert_eq!(shape(&known, "t", "i-2", "pan"), Some(id(1)));
    }

    #[test]
    fn a_name_that_several_shapes_have_tells_none() {
        let mut known = KnownShapes::default();
        known.learn(&record(
            "s",
            &[("i-1", "unknown", 1), ("i-2", "unknown", 2)],
        ));
        assert_eq!(known.named("s", "i-3", "unknown", 0), None);
        known.learn(&record("s", &[("i-1", "unknown", 1)]));
        assert_eq!(known.named("s", "i-3", "unknown", 0), None);
        let own = known.named("s", "i-2", "unknown", 0).unwrap();
        assert_eq!(own.shape, id(2));
    }

    #[test]
    fn a_session_without_end_does_not_fill_the_memory() {
        let mut known = KnownShapes::default();
        for number in 0..=MOST_KEPT + 1 {
            let item_id = format!("i-{number}");
            known.learn(&record("s", &[(item_id.as_str(), "mug", 1)]));
        }
        assert_eq!(known.by_item.len(), 1);
        assert_eq!(known.named("s", "i-0", "mug", 0).unwrap().shape, id(1));
    }

    #[test]
    fn an_item_that_no_record_told_of_has_the_shape_that_it_was_announced_with() {
        let item = v1::SessionItem {
            item_id: "i-1".to_owned(),
            shape: vec![5; 32],
            ..v1::SessionItem::default()
        };
        let known = KnownShapes::default();
        assert_eq!(known.of_item("s", &item, 0).unwrap().shape, id(5));
        assert_eq!(known.of_item("s", &item, 1), None);
        assert_eq!(known.of_waiting("s", &item), None);
    }
}
