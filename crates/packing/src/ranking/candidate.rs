//! An item that a step may choose, with all that is known of it.

use std::sync::Arc;

use nalgebra::Isometry3;

use crate::kernel::item::Item;
use crate::scene::leaving::Stop;
use crate::scene::model::Model;

/// An item of the buffer that a step may choose, in one of the poses in which it may be packed.
///
/// An item in several poses is as many candidates of one `arrival`: the step that chooses one
/// chooses pose, place and yaw together, and the others are gone with it.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// The item's place in the sequence of arrivals, from 0.
    pub arrival: usize,
    /// Number of the item's pose: 0 is the offered one, others follow by falling probability.
    pub pose: usize,
    /// Its heightmaps.
    pub item: Arc<Item>,
    /// Its solid, in the frame of its heightmaps, where it is known.
    pub model: Option<Arc<Model>>,
    /// Mass in kilograms as told; without it the solid's counts.
    pub mass_kg: Option<f64>,
    /// Pose of the item as it waits.
    pub lying: Lying,
    /// Rules for packing it.
    pub rules: Rules,
    /// At which stop it leaves the container.
    pub stop: Stop,
}

impl Candidate {
    /// An item known by its heightmaps alone, which waits at the usual place and has no rules.
    pub fn new(arrival: usize, item: Arc<Item>) -> Self {
        Self {
            arrival,
            pose: 0,
            item,
            model: None,
            mass_kg: None,
            lying: Lying::default(),
            rules: Rules::default(),
            stop: Stop::default(),
        }
    }

    /// The same item, whose solid is known.
    #[must_use]
    pub fn with_model(mut self, model: Arc<Model>) -> Self {
        self.model = Some(model);
        self
    }

    /// Gives its mass in kilograms, where that was told or its solid is known.
    pub fn weighs_kg(&self) -> Option<f64> {
        let model = self.model.as_ref();
        self.mass_kg.or(model.map(|model| model.mass.mass_kg))
    }

    /// Items that arrive in this order, each in one pose.
    pub fn sequence(items: impl IntoIterator<Item = Arc<Item>>) -> Vec<Self> {
        let items = items.into_iter().enumerate();
        items
            .map(|(arrival, item)| Self::new(arrival, item))
            .collect()
    }

    /// A number that tells it from the other candidates of a sequence, for what is drawn at random;
    /// in the pose in which it is offered, that of its arrival.
    pub(crate) fn stream(&self) -> u64 {
        (self.arrival as u64) ^ (self.pose as u64).rotate_right(16)
    }
}

/// Rules for packing an item.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Rules {
    /// Nothing may be placed above it.
    pub is_fragile: bool,
    /// It must stand on the floor.
    pub is_bottom_only: bool,
    /// Its centre of mass has to be well inside what supports it.
    pub is_upright: bool,
    /// The greatest mass that may rest on it, in kilograms; without it the solid's limit counts.
    pub carries_kg: Option<f64>,
}

/// Pose of an item as it waits.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Lying {
    /// Its own frame in that of its heightmaps, where they are not the same.
    pub heightmap_from_item: Option<Isometry3<f64>>,
    /// Pose of its own frame, where known; otherwise it waits at the cell's usual place.
    pub waits_at: Option<Isometry3<f64>>,
}

impl Lying {
    /// Gives the pose of the item's own frame from that of its heightmaps' frame.
    pub fn own_frame(&self, container_from_heightmap: &Isometry3<f64>) -> Isometry3<f64> {
        let own = |from_item: Isometry3<f64>| container_from_heightmap * from_item;
        self.heightmap_from_item
            .map_or(*container_from_heightmap, own)
    }

    /// Gives the pose of its heightmaps' frame as it waits, where that is known.
    pub fn heightmap_frame(&self) -> Option<Isometry3<f64>> {
        let waits_at = self.waits_at?;
        let of_heightmaps = |from_item: Isometry3<f64>| waits_at * from_item.inverse();
        Some(self.heightmap_from_item.map_or(waits_at, of_heightmaps))
    }
}
