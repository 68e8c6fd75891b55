//! The bin: the boxes in it, and whether one more may be placed.

use nalgebra::{Point2, Vector2};
use ppnpack_packing::checks::loads::bearing_shares;

use super::rules::Setting;
use super::support::{SupportArea, touching};
use super::surface::{CELLS, Placed, SIDE, Surface, index};

#[derive(Debug, Clone)]
struct Resting {
    placed: Placed,
    support: SupportArea,
    /// Contacts with other boxes; none on the floor.
    contacts: Vec<Contact>,
}

#[derive(Debug, Clone, Copy)]
struct Contact {
    x: u8,
    y: u8,
    below: usize,
}

/// Force on a box: its own weight and what it carries, for boxes of one density.
#[derive(Debug, Clone, Copy)]
struct Load {
    weight: f64,
    moment: Vector2<f64>,
}

impl Load {
    fn none() -> Self {
        Self {
            weight: 0.0,
            moment: Vector2::zeros(),
        }
    }

    fn add(&mut self, weight: f64, at: Point2<f64>) {
        self.weight += weight;
        self.moment += weight * at.coords;
    }

    /// Gives the point where all of it acts, in cells.
    fn middle(&self) -> Point2<f64> {
        Point2::from(self.moment / self.weight)
    }
}

#[derive(Debug, Clone)]
pub(super) struct Bin {
    setting: Setting,
    surface: Surface,
    boxes: Vec<Resting>,
    /// The index of the box on top of each cell.
    on_top: Vec<Option<usize>>,
}

impl Bin {
    pub(super) fn empty(setting: Setting) -> Self {
        Self {
            setting,
            surface: Surface::empty(),
            boxes: Vec::new(),
            on_top: vec![None; CELLS],
        }
    }

    pub(super) fn setting(&self) -> Setting {
        self.setting
    }

    pub(super) fn surface(&self) -> &Surface {
        &self.surface
    }

    pub(super) fn boxes(&self) -> impl ExactSizeIterator<Item = &Placed> {
        self.boxes.iter().map(|resting| &resting.placed)
    }

    /// The volume of the boxes in it, in cells cubed.
    pub(super) fn packed_volume(&self) -> u32 {
        self.boxes().map(|placed| placed.sides.volume()).sum()
    }

    /// Whether a box may be placed where it comes to rest: below the rim, and stable where asked.
    pub(super) fn accepts(&self, placed: &Placed) -> bool {
        let is_inside = placed.x + placed.sides.x <= SIDE && placed.y + placed.sides.y <= SIDE;
        let is_below_rim = placed.top() <= SIDE;
        let asks = self.setting.asks_for_stability();
        is_inside && is_below_rim && (!asks || self.is_stable_with(placed))
    }

    pub(super) fn place(&mut self, placed: &Placed) {
        let resting = self.resting(placed);
        for (x, y) in placed.cells() {
            if let Some(on_top) = self.on_top.get_mut(index(x, y)) {
                *on_top = Some(self.boxes.len());
            }
        }
        self.surface.place(placed);
        self.boxes.push(resting);
    }

    fn resting(&self, placed: &Placed) -> Resting {
        let contact = |(x, y): (u8, u8)| {
            let below = self.on_top.get(index(x, y)).copied().flatten()?;
            Some(Contact { x, y, below })
        };
        let is_on_floor = placed.z == 0;
        let touched = touching(&self.surface, placed).filter(|_| !is_on_floor);
        Resting {
            placed: *placed,
            support: SupportArea::of(&self.surface, placed),
            contacts: touched.filter_map(contact).collect(),
        }
    }

    /// Whether every box stands with this one in the bin: all that presses it down acts inside the
    /// hull of its contacts, over which it passes that on as a stiff body on soft ground.
    fn is_stable_with(&self, placed: &Placed) -> bool {
        let new = self.resting(placed);
        let mut loads = vec![Load::none(); self.boxes.len() + 1];
        // Whatever rests on a box was placed after it.
        for box_index in (0..loads.len()).rev() {
            let resting = self.boxes.get(box_index).unwrap_or(&new);
            let Some(load) = loads.get_mut(box_index) else {
                return false;
            };
            let Placed { sides, x, y, .. } = resting.placed;
            load.add(f64::from(sides.volume()), middle(&resting.placed));
            let load = *load;
            let at = load.middle();
            if !resting
                .support
                .contains(at.x - f64::from(x), at.y - f64::from(y))
            {
                return false;
            }
            if !resting.contacts.is_empty() && !pass_on(&load, &resting.contacts, &mut loads) {
                return false;
            }
        }
        true
    }
}

/// The middle of a box over the floor, in cells.
fn middle(placed: &Placed) -> Point2<f64> {
    let middle = |from: u8, side: u8| f64::from(from) + f64::from(side) / 2.0;
    Point2::new(
        middle(placed.x, placed.sides.x),
        middle(placed.y, placed.sides.y),
    )
}

/// Spreads a load over the boxes below; false where they do not bear it.
fn pass_on(load: &Load, contacts: &[Contact], loads: &mut [Load]) -> bool {
    let corners = contacts.iter().flat_map(|contact| {
        let corner =
            |dx: u8, dy: u8| Point2::new(f64::from(contact.x + dx), f64::from(contact.y + dy));
        [corner(0, 0), corner(0, 1), corner(1, 0), corner(1, 1)]
    });
    let corners: Vec<_> = corners.collect();
    let Some(shares) = bearing_shares(&corners, &load.middle()) else {
        return false;
    };
    let pressed = corners.chunks_exact(4).zip(shares.chunks_exact(4));
    for (contact, (corners, shares)) in contacts.iter().zip(pressed) {
        if let Some(below) = loads.get_mut(contact.below) {
            for (corner, share) in corners.iter().zip(shares) {
                below.add(share * load.weight, *corner);
            }
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::super::surface::Sides;
    use super::*;

    fn placed([x, y, z]: [u8; 3], [nx, ny, nz]: [u8; 3]) -> Placed {
        let sides = Sides {
            x: nx,
            y: ny,
            z: nz,
        };
        Placed { sides, x, y, z }
    }

    fn bin(boxes: &[([u8; 3], [u8; 3])]) -> Bin {
        let mut bin = Bin::empty(Setting::Stable);
        for (at, sides) in boxes {
            let placed = placed(*at, *sides);
            assert!(bin.accepts(&placed), "{placed:?}");
            bin.place(&placed);
        }
        bin
    }

    #[test]
    fn boxes_stand_where_all_that_presses_them_down_acts_over_what_they_rest_on() {
        const WIDE: ([u8; 3], [u8; 3]) = ([0, 0, 0], [2, 4, 1]);
        const PILLARS: [([u8; 3], [u8; 3]); 2] = [([0, 0, 0], [1, 1, 3]), ([4, 0, 0], [1, 1, 3])];
        const BRIDGE: ([u8; 3], [u8; 3]) = ([0, 0, 3], [5, 1, 1]);
        const FAR: [([u8; 3], [u8; 3]); 2] = [([0, 0, 0], [3, 2, 1]), ([0, 0, 1], [4, 2, 1])];
        const PLANK: [([u8; 3], [u8; 3]); 2] = [([0, 0, 0], [2, 2, 1]), ([0, 0, 1], [3, 2, 1])];
        let held = [&PLANK[..], &[([0, 0, 2], [1, 2, 5])]].concat();
        for (boxes, (at, sides), stands) in [
            // It overhangs no more than its middle, which is right above the edge in the second.
            (&[WIDE][..], ([0, 0, 1], [3, 4, 1]), true),
            (&[WIDE], ([0, 0, 1], [4, 4, 1]), false),
            (&[WIDE], ([1, 0, 1], [3, 4, 1]), false),
            (&PILLARS[..1], BRIDGE, false),
            (&PILLARS, BRIDGE, true),
            // 8 at 2 and 8 at 3.5 act at 2.75, and the foot ends at 3.
            (&FAR, ([3, 0, 2], [1, 2, 4]), true),
            // It would tip what it stands on: 6 at 1.5 and 8 at 2.5 act at 2.07, and the foot ends
            // at 2.
            (&PLANK, ([2, 0, 2], [1, 2, 4]), false),
            (&PLANK, ([0, 0, 2], [1, 2, 4]), true),
            // Weight at the other end: 6 at 1.5, 10 at 0.5 and 8 at 2.5 act at 1.42.
            (&held, ([2, 0, 2], [1, 2, 4]), true),
        ] {
            let placed = placed(at, sides);
            assert_eq!(bin(boxes).accepts(&placed), stands, "{boxes:?} {placed:?}");
        }
    }

    #[test]
    fn without_the_rule_all_stands() {
        let mut bin = Bin::empty(Setting::Free);
        bin.place(&placed([0, 0, 0], [1, 1, 3]));
        assert!(bin.accepts(&placed([0, 0, 3], [5, 5, 5])));
        assert!(!bin.accepts(&placed([0, 0, 3], [5, 5, 8])));
        assert!(!bin.accepts(&placed([6, 0, 0], [5, 5, 5])));
        assert_eq!(bin.packed_volume(), 3);
    }
}
