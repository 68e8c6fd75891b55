//! Support of a box.

use super::surface::{LONGEST, Placed, Surface};

/// Margin of support, in cells: nearer to the edge a box topples.
const MARGIN: f64 = 1e-6;

/// Lines between the cells of a box's bottom, across x.
const LINES: usize = LONGEST as usize + 1;

/// The convex hull of the cells of a box's bottom that touch, seen from the box's corner.
///
/// It is held as the reach of touching cells along each line between rows: its corners are ends.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct SupportArea {
    reaches: [Option<Reach>; LINES],
}

/// From where to where cells reach along y.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Reach {
    low: u8,
    high: u8,
}

impl SupportArea {
    /// The area that a box rests on: cells as high as its bottom, which on the floor are all.
    pub(super) fn of(surface: &Surface, placed: &Placed) -> Self {
        let mut area = Self::default();
        for (x, y) in touching(surface, placed) {
            area.add(x - placed.x, y - placed.y);
        }
        area
    }

    fn add(&mut self, x: u8, y: u8) {
        let lines = self.reaches.iter_mut().skip(usize::from(x)).take(2);
        for reach in lines {
            let Reach { low, high } = reach.unwrap_or(Reach { low: y, high: y });
            *reach = Some(Reach {
                low: low.min(y),
                high: high.max(y + 1),
            });
        }
    }

    /// Whether a point over the bottom, in cells from its corner, is inside the hull, off its edge.
    pub(super) fn contains(&self, x: f64, y: f64) -> bool {
        let lines = || {
            let reaches = (0_u8..).zip(&self.reaches);
            reaches.filter_map(|(at, reach)| Some((f64::from(at), (*reach)?)))
        };
        let (mut lowest, mut highest) = (f64::INFINITY, f64::NEG_INFINITY);
        for (before, low_reach) in lines().filter(|(at, _)| *at < x - MARGIN) {
            for (after, high_reach) in lines().filter(|(at, _)| *at > x + MARGIN) {
                let share = (x - before) / (after - before);
                let between = |a: u8, b: u8| f64::from(a) + share * (f64::from(b) - f64::from(a));
                lowest = lowest.min(between(low_reach.low, high_reach.low));
                highest = highest.max(between(low_reach.high, high_reach.high));
            }
        }
        if lowest > highest {
            return false;
        }
        for (_, reach) in lines().filter(|(at, _)| (*at - x).abs() <= MARGIN) {
            lowest = lowest.min(f64::from(reach.low));
            highest = highest.max(f64::from(reach.high));
        }
        lowest < y - MARGIN && y + MARGIN < highest
    }
}

pub(super) fn touching(surface: &Surface, placed: &Placed) -> impl Iterator<Item = (u8, u8)> {
    let is_touched = move |(x, y): &(u8, u8)| surface.height(*x, *y) == placed.z;
    placed.cells().filter(is_touched)
}

/// Whether a box alone stands where it is placed: its middle is over what it rests on.
pub(super) fn stands(surface: &Surface, placed: &Placed) -> bool {
    let middle = |side: u8| f64::from(side) / 2.0;
    let area = SupportArea::of(surface, placed);
    area.contains(middle(placed.sides.x), middle(placed.sides.y))
}

#[cfg(test)]
mod tests {
    use nalgebra::Point2;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::super::surface::Sides;
    use super::*;

    /// Whether a point is left of every line through two corners of cells with none on its right.
    fn is_inside_hull(cells: &[(u8, u8)], point: Point2<f64>) -> bool {
        let corner = |x: u8, y: u8| Point2::new(f64::from(x), f64::from(y));
        let corners = cells.iter().flat_map(|(x, y)| {
            [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(dx, dy)| corner(x + dx, y + dy))
        });
        let corners: Vec<Point2<f64>> = corners.collect();
        let turn = |a: &Point2<f64>, b: &Point2<f64>, c: &Point2<f64>| (b - a).perp(&(c - a));
        let mut edges = 0;
        for a in &corners {
            for b in corners.iter().filter(|b| *b != a) {
                if corners.iter().all(|c| turn(a, b, c) >= 0.0) {
                    edges += 1;
                    if turn(a, b, &point) <= 1e-9 {
                        return false;
                    }
                }
            }
        }
        edges > 0
    }

    #[test]
    fn a_point_is_inside_where_it_is_left_of_every_edge_of_the_hull() {
        let mut random = ChaCha8Rng::seed_from_u64(2);
        let mut inside = 0;
        for _ in 0..2_000 {
            let mut area = SupportArea::default();
            let mut cells = Vec::new();
            for _ in 0..random.random_range(0..7) {
                let cell = (
                    random.random_range(0..LONGEST),
                    random.random_range(0..LONGEST),
                );
                cells.push(cell);
                area.add(cell.0, cell.1);
            }
            let [x, y] = [0; 2].map(|_| f64::from(random.random_range(0..=20_u8)) / 4.0);
            let expected = is_inside_hull(&cells, Point2::new(x, y));
            assert_eq!(area.contains(x, y), expected, "{cells:?} ({x}, {y})");
            inside += usize::from(expected);
        }
        assert!(inside > 200, "{inside}");
    }

    #[test]
    fn a_box_stands_on_the_floor_and_not_on_a_tip() {
        let sides = |x, y, z| Sides { x, y, z };
        let mut surface = Surface::empty();
        let at = |sides, z| Placed {
            sides,
            x: 3,
            y: 4,
            z,
        };
        assert!(stands(&surface, &at(sides(1, 1, 5), 0)));
        surface.place(&at(sides(1, 1, 2), 0));
        assert!(stands(&surface, &at(sides(1, 1, 3), 2)));
        assert!(!stands(&surface, &at(sides(2, 2, 3), 2)));
        assert!(!stands(&surface, &at(sides(5, 1, 3), 2)));
    }
}
