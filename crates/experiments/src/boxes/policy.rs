//! One-step policies on the compact heightmap: a placement's value is a weighted sum of few whole numbers. They play the
//! roll-outs.

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

use super::rules::Setting;
use super::support::stands;
use super::surface::{Placed, SIDE, Sides, Surface, Windows};

/// A policy by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Policy {
    /// Deepest bottom-left, as the engine's
    Dbl,
    /// Heightmap minimisation, as the engine's
    Hm,
    /// Little space lost below the box, a low top, much touched at the sides
    Snug,
}

/// What each part of a value counts; values are the better the lower they are.
#[derive(Debug, Clone, Copy, Default)]
struct Weights {
    /// The resting height, in cells.
    resting: i32,
    /// The height of the top, in cells.
    top: i32,
    /// The volume under the top over the box's bottom, in cells cubed.
    column: i32,
    /// The volume below the box that nothing can reach any more, in cells cubed.
    lost: i32,
    /// The faces at its sides that touch boxes or walls, in cells squared; they lower the value.
    touching: i32,
    /// The distance from the origin's corner along both axes, in cells.
    corner: i32,
}

impl Policy {
    /// On the grid of the benchmark, the engine's weights per cell of height are five times those per cell of floor.
    fn weights(self) -> Weights {
        match self {
            Self::Dbl => Weights {
                resting: 5,
                corner: 1,
                ..Weights::default()
            },
            Self::Hm => Weights {
                column: 5,
                corner: 1,
                ..Weights::default()
            },
            Self::Snug => Weights {
                lost: 5,
                top: 10,
                touching: 5,
                corner: 1,
                ..Weights::default()
            },
        }
    }

    /// The best placement of a box that stands, each box by itself; of equal ones the first by orientation, x, y.
    pub(super) fn choose(
        self,
        surface: &Surface,
        arriving: Sides,
        setting: Setting,
    ) -> Option<Placed> {
        let mut best: Option<(i32, Placed)> = None;
        self.visit(surface, arriving, setting, |value, placed, is_flat| {
            let is_better = best.is_none_or(|(least, _)| value < least);
            if is_better && may_stand(surface, &placed, setting, is_flat) {
                best = Some((value, placed));
            }
        });
        best.map(|(_, placed)| placed)
    }

    /// All placements of a box that stand, each box by itself, the best first, in the order of [`Self::choose`].
    pub(super) fn ranked(
        self,
        surface: &Surface,
        arriving: Sides,
        setting: Setting,
    ) -> Vec<Placed> {
        let mut ranked = Vec::new();
        self.visit(surface, arriving, setting, |value, placed, is_flat| {
            if may_stand(surface, &placed, setting, is_flat) {
                ranked.push((value, placed));
            }
        });
        ranked.sort_by_key(|(value, _)| *value);
        ranked.into_iter().map(|(_, placed)| placed).collect()
    }

    /// Looks at every placement below the rim: its value, where, and whether all of the bottom touches something.
    fn visit(
        self,
        surface: &Surface,
        arriving: Sides,
        setting: Setting,
        mut look: impl FnMut(i32, Placed, bool),
    ) {
        let weights = self.weights();
        for sides in setting.orientations(arriving) {
            let below = Below {
                resting: surface.resting_heights(sides),
                sums: surface.height_sums(sides),
            };
            for x in 0..=SIDE - sides.x {
                for y in 0..=SIDE - sides.y {
                    let z = below.resting.at(x, y);
                    if z + sides.z > SIDE {
                        continue;
                    }
                    let placed = Placed { sides, x, y, z };
                    let lost = below.lost(&placed);
                    let value = weights.value(surface, &placed, lost);
                    look(value, placed, lost == 0);
                }
            }
        }
    }

    /// The volume that it packs of a future into what is there, until a box fits nowhere, in cells cubed.
    pub(super) fn play_out(self, mut surface: Surface, future: &[Sides], setting: Setting) -> u32 {
        let mut volume = 0;
        for arriving in future {
            let Some(placed) = self.choose(&surface, *arriving, setting) else {
                break;
            };
            surface.place(&placed);
            volume += arriving.volume();
        }
        volume
    }
}

fn may_stand(surface: &Surface, placed: &Placed, setting: Setting, is_flat: bool) -> bool {
    is_flat || !setting.asks_for_stability() || stands(surface, placed)
}

/// What is below the bottoms of a box in one orientation.
struct Below {
    resting: Windows,
    sums: Windows,
}

impl Below {
    /// The volume below a placed box that is empty, in cells cubed.
    fn lost(&self, placed: &Placed) -> i32 {
        let under = placed.sides.floor_cells() * u32::from(placed.z);
        under as i32 - i32::from(self.sums.at(placed.x, placed.y))
    }
}

impl Weights {
    fn value(&self, surface: &Surface, placed: &Placed, lost: i32) -> i32 {
        let [x, y, z, top] = [placed.x, placed.y, placed.z, placed.top()].map(i32::from);
        let touching = match self.touching {
            0 => 0,
            weight => weight * touching_sides(surface, placed),
        };
        let column = placed.sides.floor_cells() as i32 * top;
        self.resting * z
            + self.top * top
            + self.column * column
            + self.lost * lost
            + self.corner * (x + y)
            - touching
    }
}

/// The faces of a box's cells at its sides that touch boxes or walls.
fn touching_sides(surface: &Surface, placed: &Placed) -> i32 {
    let Placed { sides, x, y, z } = *placed;
    let touched = |beside: Option<(u8, u8)>| match beside {
        Some((x, y)) => surface.height(x, y).saturating_sub(z).min(sides.z),
        None => sides.z,
    };
    let inside = |at: u8| (at < SIDE).then_some(at);
    let (before_x, after_x) = (x.checked_sub(1), inside(x + sides.x));
    let (before_y, after_y) = (y.checked_sub(1), inside(y + sides.y));
    let mut faces = 0;
    for along in y..y + sides.y {
        for beside in [before_x, after_x] {
            faces += i32::from(touched(beside.map(|x| (x, along))));
        }
    }
    for along in x..x + sides.x {
        for beside in [before_y, after_y] {
            faces += i32::from(touched(beside.map(|y| (along, y))));
        }
    }
    faces
}

#[cfg(test)]
mod tests {
    use super::*;

    const CUBE: Sides = Sides { x: 2, y: 2, z: 2 };

    #[test]
    fn faces_are_counted_at_walls_and_boxes() {
        let mut surface = Surface::empty();
        let at = |x, y, z| Placed {
            sides: CUBE,
            x,
            y,
            z,
        };
        assert_eq!(touching_sides(&surface, &at(4, 4, 0)), 0);
        assert_eq!(touching_sides(&surface, &at(0, 8, 0)), 8);
        surface.place(&at(0, 0, 0));
        assert_eq!(touching_sides(&surface, &at(2, 0, 0)), 8);
        assert_eq!(touching_sides(&surface, &at(2, 1, 0)), 2);
        assert_eq!(touching_sides(&surface, &at(2, 0, 1)), 6);
    }

    #[test]
    fn the_best_is_the_first_of_the_ranking() {
        let mut surface = Surface::empty();
        let arriving = Sides { x: 1, y: 3, z: 5 };
        for setting in [Setting::Stable, Setting::Free] {
            for policy in [Policy::Dbl, Policy::Hm, Policy::Snug] {
                for _ in 0..4 {
                    let ranked = policy.ranked(&surface, arriving, setting);
                    let best = policy.choose(&surface, arriving, setting).unwrap();
                    assert_eq!(ranked.first(), Some(&best));
                    surface.place(&best);
                }
            }
        }
    }

    #[test]
    fn a_future_is_played_until_a_box_fits_nowhere() {
        let large = Sides { x: 5, y: 5, z: 5 };
        let future = [large; 20];
        let packed = Policy::Snug.play_out(Surface::empty(), &future, Setting::Stable);
        assert_eq!(packed, 1000);
        let packed = Policy::Snug.play_out(Surface::empty(), &future[..3], Setting::Stable);
        assert_eq!(packed, 375);
    }
}
