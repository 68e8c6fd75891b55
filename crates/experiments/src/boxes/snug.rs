//! The one-step policy *snug* on the compact heightmap: a placement's value is a weighted sum of
//! few whole numbers. It plays the roll-outs.

use super::bin::Bin;
use super::rules::Setting;
use super::support::stands;
use super::surface::{Placed, SIDE, Sides, Surface};

/// Chooses placements that lose little space below, touch much beside, and level their tops.
///
/// The weights say what each part of a value counts; values are the better the lower they are. They
/// were found by hill climbing from guesses, by the volume that it packs of 1,200 sequences of
/// another generator than the [instances'](super::source::Instance).
#[derive(Debug, Clone, Copy)]
pub(super) struct Snug {
    setting: Setting,
    /// The resting height, in cells.
    resting: i32,
    /// The height of the box as it lies, in cells.
    height: i32,
    /// The volume below the box that nothing can reach any more, in cells cubed.
    lost: i32,
    /// Half the faces at its sides, in cells squared.
    sides: i32,
    /// The faces at its sides that touch boxes or walls, in cells squared; they lower the value.
    touching: i32,
    /// The length along which its top is level with the one beside it, in cells; lowers the value.
    level: i32,
    /// The area of a top at the rim, in cells squared; it lowers the value.
    rim: i32,
    /// The distance from the origin's corner along both axes, in cells; it lowers the value.
    corner: i32,
}

impl Snug {
    pub(super) fn new(setting: Setting) -> Self {
        match setting {
            Setting::Stable => Self {
                setting,
                resting: 8,
                height: 0,
                lost: 2,
                sides: 0,
                touching: 5,
                level: 7,
                rim: 7,
                corner: 1,
            },
            Setting::Free => Self {
                setting,
                resting: 4,
                height: 11,
                lost: 5,
                sides: -33,
                touching: 7,
                level: 13,
                rim: 1,
                corner: 2,
            },
        }
    }

    /// The best placement of a box that stands by itself; of equals the first by orientation, x, y.
    pub(super) fn choose(&self, surface: &Surface, arriving: Sides) -> Option<Placed> {
        let mut best: Option<(i32, Placed)> = None;
        self.visit(surface, arriving, |value, placed, is_flat| {
            let is_better = best.is_none_or(|(least, _)| value < least);
            if is_better && self.may_stand(surface, &placed, is_flat) {
                best = Some((value, placed));
            }
        });
        best.map(|(_, placed)| placed)
    }

    /// All placements of a box that stands by itself, in the order of [`Self::choose`].
    pub(super) fn ranked(&self, surface: &Surface, arriving: Sides) -> Vec<Placed> {
        let mut ranked = Vec::new();
        self.visit(surface, arriving, |value, placed, is_flat| {
            if self.may_stand(surface, &placed, is_flat) {
                ranked.push((value, placed));
            }
        });
        ranked.sort_by_key(|(value, _)| *value);
        ranked.into_iter().map(|(_, placed)| placed).collect()
    }

    pub(super) fn best(&self, bin: &Bin, arriving: Sides) -> Option<Placed> {
        let mut ranked = self.ranked(bin.surface(), arriving).into_iter();
        ranked.find(|placed| bin.accepts(placed))
    }

    /// Visits placements below the rim: value, place, and whether all of the bottom touches.
    fn visit(&self, surface: &Surface, arriving: Sides, mut look: impl FnMut(i32, Placed, bool)) {
        for sides in self.setting.orientations(arriving) {
            for x in 0..=SIDE - sides.x {
                for y in 0..=SIDE - sides.y {
                    let (z, sum) = surface.below(sides, x, y);
                    if z + sides.z > SIDE {
                        continue;
                    }
                    let placed = Placed { sides, x, y, z };
                    // The volume below that is empty, in cells cubed.
                    let under = sides.floor_cells() * u32::from(z);
                    let lost = under as i32 - i32::from(sum);
                    let value = self.value(surface, &placed, lost);
                    look(value, placed, lost == 0);
                }
            }
        }
    }

    /// The volume that it packs of a future until a box fits nowhere, in cells cubed.
    pub(super) fn play_out(&self, mut surface: Surface, future: &[Sides]) -> u32 {
        let mut volume = 0;
        for arriving in future {
            let Some(placed) = self.choose(&surface, *arriving) else {
                break;
            };
            surface.place(&placed);
            volume += arriving.volume();
        }
        volume
    }

    fn may_stand(&self, surface: &Surface, placed: &Placed, is_flat: bool) -> bool {
        is_flat || !self.setting.asks_for_stability() || stands(surface, placed)
    }

    fn value(&self, surface: &Surface, placed: &Placed, lost: i32) -> i32 {
        let Placed { sides, x, y, z } = *placed;
        let [x, y, z] = [x, y, z].map(i32::from);
        let [nx, ny, height] = [sides.x, sides.y, sides.z].map(i32::from);
        let rim = match placed.top() {
            SIDE => nx * ny,
            _ => 0,
        };
        let beside = Beside::of(surface, placed);
        self.resting * z + self.height * height + self.lost * lost + self.sides * (nx + ny) * height
            - self.corner * (x + y)
            - self.touching * beside.touching
            - self.level * beside.level
            - self.rim * rim
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Beside {
    /// The faces of its cells that touch boxes or walls at its sides.
    touching: i32,
    /// The cells beside it that are as high as its top.
    level: i32,
}

impl Beside {
    fn of(surface: &Surface, placed: &Placed) -> Self {
        let Placed { sides, x, y, .. } = *placed;
        let inside = |at: u8| (at < SIDE).then_some(at);
        let (before_x, after_x) = (x.checked_sub(1), inside(x + sides.x));
        let (before_y, after_y) = (y.checked_sub(1), inside(y + sides.y));
        let mut found = Self::default();
        for along in y..y + sides.y {
            for beside in [before_x, after_x] {
                found.add(placed, beside.map(|x| surface.height(x, along)));
            }
        }
        for along in x..x + sides.x {
            for beside in [before_y, after_y] {
                found.add(placed, beside.map(|y| surface.height(along, y)));
            }
        }
        found
    }

    /// Adds a cell of this height, or of a wall where there is none.
    fn add(&mut self, placed: &Placed, height: Option<u8>) {
        let covered = match height {
            Some(height) => height.saturating_sub(placed.z).min(placed.sides.z),
            None => placed.sides.z,
        };
        self.touching += i32::from(covered);
        self.level += i32::from(height == Some(placed.top()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CUBE: Sides = Sides { x: 2, y: 2, z: 2 };

    #[test]
    fn what_is_beside_a_box_is_counted_at_walls_and_boxes() {
        let mut surface = Surface::empty();
        let at = |x, y, z| Placed {
            sides: CUBE,
            x,
            y,
            z,
        };
        let beside = |surface: &Surface, placed: Placed| {
            let Beside { touching, level } = Beside::of(surface, &placed);
            (touching, level)
        };
        assert_eq!(beside(&surface, at(4, 4, 0)), (0, 0));
        assert_eq!(beside(&surface, at(0, 8, 0)), (8, 0));
        surface.place(&at(0, 0, 0));
        assert_eq!(beside(&surface, at(2, 0, 0)), (8, 2));
        assert_eq!(beside(&surface, at(2, 1, 0)), (2, 1));
        assert_eq!(beside(&surface, at(2, 0, 1)), (6, 0));
    }

    #[test]
    fn the_best_is_the_first_of_the_ranking() {
        let mut surface = Surface::empty();
        let arriving = Sides { x: 1, y: 3, z: 5 };
        for setting in [Setting::Stable, Setting::Free] {
            let snug = Snug::new(setting);
            for _ in 0..4 {
                let ranked = snug.ranked(&surface, arriving);
                let best = snug.choose(&surface, arriving).unwrap();
                assert_eq!(ranked.first(), Some(&best));
                surface.place(&best);
            }
        }
    }

    #[test]
    fn a_future_is_played_until_a_box_fits_nowhere() {
        let large = Sides { x: 5, y: 5, z: 5 };
        let future = [large; 20];
        let snug = Snug::new(Setting::Stable);
        assert_eq!(snug.play_out(Surface::empty(), &future), 1000);
        assert_eq!(snug.play_out(Surface::empty(), &future[..3]), 375);
    }
}
