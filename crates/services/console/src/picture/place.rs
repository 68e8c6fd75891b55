//! A container: its state, its heightmap, its items.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use nalgebra::Isometry3;
use ppnpack_packing::kernel::grid::{Grid, Units};
use ppnpack_wire::{WireError, convert, v1};
use serde_json::{Value, json};

use super::decision::load_part;
use super::history::History;
use super::pose::PosePart;
use super::words;
use crate::shapes::ShapeId;

/// The heightmap of a container, and how far it is to be trusted.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SeenContainer {
    pub(super) grid: Grid,
    heights: Vec<Units>,
    pub(super) state_number: u64,
    pub(super) doubts: Vec<String>,
    unknown_cells: u32,
}

impl SeenContainer {
    /// Reads a heightmap.
    ///
    /// # Errors
    /// [`WireError`] where its scene is missing or impossible.
    pub(crate) fn read(heightmap: &v1::Heightmap) -> Result<Self, WireError> {
        let (grid, scene) = convert::scene::read_required("scene", heightmap.scene.as_ref())?;
        let quality = heightmap.quality.as_ref();
        let doubts = quality.into_iter().flat_map(|quality| &quality.doubts);
        Ok(Self {
            heights: scene.heightmap().heights().to_vec(),
            grid,
            state_number: heightmap.state_number,
            doubts: doubts.map(|doubt| doubt.message.clone()).collect(),
            unknown_cells: quality.map_or(0, |quality| quality.unknown_cells),
        })
    }

    pub(super) fn volume_m3(&self) -> f64 {
        self.grid.container().volume_m3()
    }

    /// Gives the share of the volume that lies below the surface; unknown cells count as empty.
    fn filled(&self) -> f64 {
        let rim = self.grid.rim();
        let known = self.heights.iter().filter(|height| **height <= rim);
        known.map(|height| f64::from(*height)).sum::<f64>() / self.grid.voxel_count()
    }
}

/// An item that lies in a container.
#[derive(Debug, Clone)]
pub(super) struct LyingItem<'a> {
    pub(super) item_id: &'a str,
    pub(super) object: &'a str,
    pub(super) shape: Option<ShapeId>,
    pub(super) container_from_shape: Option<Isometry3<f64>>,
    pub(super) is_inside: bool,
    /// The step that it was decided in.
    pub(super) step: Option<u64>,
    pub(super) session_item: Option<&'a v1::SessionItem>,
}

impl LyingItem<'_> {
    pub(super) fn part(&self) -> Value {
        let inspection = self.session_item.and_then(|item| item.inspection.as_ref());
        let load = self.session_item.and_then(|item| item.load.as_deref());
        json!({
            "item_id": self.item_id,
            "object": self.object,
            "shape": self.shape.map(|shape| shape.to_string()),
            "container_from_shape": self.container_from_shape.as_ref().map(PosePart::from),
            "is_inside": self.is_inside,
            "step": self.step,
            "inspection": inspection.and_then(inspected),
            "load": load.map(load_part),
        })
    }
}

fn inspected(inspection: &v1::Inspection) -> Option<Value> {
    let kind = inspection.kind();
    (kind != v1::InspectionKind::Unspecified).then(|| {
        json!({
            "kind": words::short(kind.as_str_name(), "INSPECTION_KIND_"),
            "slide_m": inspection.slide_m,
            "tilt_rad": inspection.tilt_rad,
            "reason": inspection.reason,
        })
    })
}

/// How much of a container items fill.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Content {
    pub(super) items: usize,
    pub(super) without_volume: usize,
    /// The sum of the volumes that are known, in cubic metres.
    pub(super) volume_m3: f64,
}

#[derive(Debug, Default)]
pub(super) struct Place {
    pub(super) state: Option<v1::CellState>,
    /// The time when the state was heard, in milliseconds since 1970.
    pub(super) state_at_ms: u64,
    pub(super) seen: Option<SeenContainer>,
    seen_at_ms: u64,
    /// The time since which the heightmaps show an earlier state than the bridge tells, in
    /// milliseconds since 1970.
    pub(super) behind_since_ms: Option<u64>,
    history: History,
}

impl Place {
    pub(super) fn hear_state(&mut self, at_ms: u64, state: v1::CellState) {
        self.state = Some(state);
        self.state_at_ms = at_ms;
        self.compare(at_ms);
    }

    /// Takes in a heightmap; one that shows the same is not shown again.
    pub(super) fn see(&mut self, at_ms: u64, seen: SeenContainer) {
        if self.seen.as_ref() != Some(&seen) {
            self.seen = Some(seen);
            self.seen_at_ms = at_ms;
        }
        self.compare(at_ms);
    }

    fn compare(&mut self, at_ms: u64) {
        let told = self.state.as_ref().map_or(0, |state| state.state_number);
        let seen = self.seen.as_ref().map_or(0, |seen| seen.state_number);
        // A sensor that does not know the state says 0.
        if seen == 0 || seen >= told {
            self.behind_since_ms = None;
        } else {
            self.behind_since_ms.get_or_insert(at_ms);
        }
    }

    /// Gives the reason why it is held, where it is.
    pub(super) fn held(&self) -> Option<&str> {
        let hold = self.state.as_ref()?.hold.as_ref()?;
        Some(&hold.reason)
    }

    pub(super) fn hold_ids(&self) -> impl Iterator<Item = &str> {
        let holds = self.state.iter().flat_map(|state| &state.holds);
        holds.map(|hold| hold.id.as_str())
    }

    pub(super) fn executing(&self) -> Option<&str> {
        let id = &self.state.as_ref()?.executing_placement_id;
        (!id.is_empty()).then_some(id)
    }

    /// Gives the share of its volume that items fill, where its size is known.
    fn utilisation(&self, content: &Content) -> Option<f64> {
        let seen = self.seen.as_ref()?;
        Some(content.volume_m3 / seen.volume_m3())
    }

    /// Notes how full it is now, or that this is not known while a volume is not.
    pub(super) fn note(&mut self, at_ms: u64, content: &Content) {
        if let Some(utilisation) = self.utilisation(content) {
            let is_known = content.without_volume == 0;
            self.history.note(at_ms, is_known.then_some(utilisation));
        }
    }

    /// Begins the figures of another session.
    pub(super) fn begin(&mut self) {
        self.history.clear();
    }

    pub(super) fn state_part(&self) -> Option<Value> {
        let state = self.state.as_ref()?;
        Some(json!({
            "state_number": state.state_number,
            "held": self.held(),
            "executing": self.executing(),
            "is_simulated": state.is_simulated,
            "heard_ms": self.state_at_ms,
        }))
    }

    pub(super) fn heightmap_part(&self) -> Option<Value> {
        let seen = self.seen.as_ref()?;
        let size = seen.grid.container();
        let resolution = seen.grid.resolution();
        let heights = seen.heights.iter();
        let bytes: Vec<u8> = heights.flat_map(|height| height.to_le_bytes()).collect();
        Some(json!({
            "nx": seen.grid.nx(),
            "ny": seen.grid.ny(),
            "cell_m": resolution.cell_m(),
            "height_unit_m": resolution.height_unit_m(),
            "size_m": [size.x_m, size.y_m, size.z_m],
            "rim_units": seen.grid.rim(),
            "heights": STANDARD.encode(bytes),
            "state_number": seen.state_number,
            "doubts": seen.doubts,
            "unknown_cells": seen.unknown_cells,
            "at_ms": self.seen_at_ms,
        }))
    }

    pub(super) fn figures_part(&self, content: &Content) -> Value {
        json!({
            "utilisation": self.utilisation(content),
            "items": content.items,
            "items_without_volume": content.without_volume,
            "filled": self.seen.as_ref().map(SeenContainer::filled),
            "history": self.history,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::seen;
    use super::*;

    fn state(state_number: u64) -> v1::CellState {
        v1::CellState {
            state_number,
            ..v1::CellState::default()
        }
    }

    #[test]
    fn heights_are_sixteen_bits_in_the_order_of_the_wire() {
        let mut place = Place::default();
        assert!(place.heightmap_part().is_none());
        place.see(7, seen(1, 75));
        let part = place.heightmap_part().unwrap();
        let bytes = STANDARD.decode(part["heights"].as_str().unwrap()).unwrap();
        assert_eq!(bytes.len(), 2 * 32 * 32);
        let at = 2 * (32 + 2);
        assert_eq!(u16::from_le_bytes([bytes[at], bytes[at + 1]]), 75);
        let figures = place.figures_part(&Content::default());
        let filled = figures["filled"].as_f64().unwrap();
        assert!((filled - 0.5 / 1024.0).abs() < 1e-12);
    }

    #[test]
    fn a_picture_of_an_earlier_state_is_behind_until_a_later_one_comes() {
        let mut place = Place::default();
        place.see(1, seen(4, 0));
        place.hear_state(2, state(4));
        assert_eq!(place.behind_since_ms, None);
        place.hear_state(3, state(5));
        place.hear_state(4, state(6));
        assert_eq!(place.behind_since_ms, Some(3));
        place.see(5, seen(6, 0));
        assert_eq!(place.behind_since_ms, None);
        place.see(6, seen(0, 0));
        assert_eq!(place.behind_since_ms, None, "the sensor does not know it");
    }

    #[test]
    fn utilisation_is_the_share_of_the_containers_volume() {
        let mut place = Place::default();
        let content = Content {
            items: 2,
            without_volume: 1,
            volume_m3: 0.32 * 0.32 * 0.3 / 4.0,
        };
        assert!(place.figures_part(&content)["utilisation"].is_null());
        place.see(1, seen(1, 0));
        let figures = place.figures_part(&content);
        let utilisation = figures["utilisation"].as_f64().unwrap();
        assert!((utilisation - 0.25).abs() < 1e-12);
        place.note(2, &content);
        let known = Content {
            without_volume: 0,
            ..content
        };
        place.note(3, &known);
        let history = &place.figures_part(&content)["history"];
        assert_eq!(
            *history,
            json!([[2, null], [3, 0.25]]),
            "a gap, and no zero"
        );
    }
}
