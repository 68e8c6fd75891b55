//! Cells that are marked, and what they enclose.

use crate::layers::neighbours;

/// Marks in rows of `ny` cells.
#[derive(Debug, Clone)]
pub(super) struct Mask {
    nx: usize,
    ny: usize,
    marks: Vec<bool>,
}

impl Mask {
    pub(super) fn new(nx: usize, ny: usize) -> Self {
        Self {
            nx,
            ny,
            marks: vec![false; nx * ny],
        }
    }

    pub(super) fn set(&mut self, x: usize, y: usize) {
        if let Some(mark) = self.marks.get_mut(x * self.ny + y)
            && y < self.ny
        {
            *mark = true;
        }
    }

    pub(super) fn get(&self, x: usize, y: usize) -> bool {
        y < self.ny && self.marks.get(x * self.ny + y).copied().unwrap_or(false)
    }

    /// Gives the cells marked, and those that touch them across edges and corners.
    pub(super) fn grown(&self) -> Self {
        let mut grown = Self::new(self.nx, self.ny);
        let marked = self
            .marks
            .iter()
            .enumerate()
            .filter(|(_, is_marked)| **is_marked);
        for near in marked.flat_map(|(cell, _)| neighbours(cell, self.marks.len(), self.ny)) {
            grown.set(near / self.ny, near % self.ny);
        }
        grown
    }

    /// Finds the holes: cells without a mark, connected across edges, from which no way leads to
    /// the border.
    pub(super) fn holes(&self) -> Vec<Vec<(usize, usize)>> {
        let is_border =
            |(x, y): &(usize, usize)| *x == 0 || *y == 0 || *x + 1 == self.nx || *y + 1 == self.ny;
        let mut visited = self.clone();
        let mut holes = Vec::new();
        for (x, y) in (0..self.nx).flat_map(|x| (0..self.ny).map(move |y| (x, y))) {
            if visited.get(x, y) {
                continue;
            }
            let region = visited.flood(x, y);
            if !region.iter().any(is_border) {
                holes.push(region);
            }
        }
        holes
    }

    /// Marks all cells without a mark that are connected to one, and gives them.
    fn flood(&mut self, x: usize, y: usize) -> Vec<(usize, usize)> {
        self.set(x, y);
        let mut region = vec![(x, y)];
        let mut next = 0;
        while let Some((x, y)) = region.get(next).copied() {
            next += 1;
            let around = [
                (x.wrapping_sub(1), y),
                (x + 1, y),
                (x, y.wrapping_sub(1)),
                (x, y + 1),
            ];
            for (x, y) in around {
                if x < self.nx && y < self.ny && !self.get(x, y) {
                    self.set(x, y);
                    region.push((x, y));
                }
            }
        }
        region
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mask(rows: &[&str]) -> Mask {
        let mut mask = Mask::new(rows.len(), rows[0].len());
        for (x, row) in rows.iter().enumerate() {
            for (y, mark) in row.bytes().enumerate() {
                if mark == b'#' {
                    mask.set(x, y);
                }
            }
        }
        mask
    }

    #[test]
    fn a_ring_encloses_a_hole_and_one_with_a_gap_does_not() {
        let ring = mask(&[".....", ".###.", ".#.#.", ".###.", "....."]);
        assert_eq!(ring.holes(), [vec![(2, 2)]]);
        let corners = mask(&[".....", "..#..", ".#.#.", "..#..", "....."]);
        assert_eq!(corners.holes(), [vec![(2, 2)]], "corners touch");
        let open = mask(&[".....", ".###.", ".#...", ".###.", "....."]);
        assert!(open.holes().is_empty());
        assert!(mask(&["###", "#.."]).holes().is_empty(), "at the border");
        assert!(Mask::new(0, 0).holes().is_empty());
    }

    #[test]
    fn growing_closes_gaps() {
        let open = mask(&[
            ".......", ".#####.", ".#...#.", ".#.....", ".#...#.", ".#####.", ".......",
        ]);
        assert!(open.holes().is_empty());
        assert_eq!(open.grown().holes(), [vec![(3, 3)]]);
    }
}
