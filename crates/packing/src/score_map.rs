//! Scores of an item's placements, by where the item's footprint lies.

use crate::grid::Grid;

/// The lowest score of an item's placements per cell of the container, over all yaws. Lower is better; scores have no unit.
///
/// A cell `(x, y)` stands for the placements whose footprint's centre lies there: for a view of `nx` x `ny` cells, those whose corner is
/// `(x - nx / 2, y - ny / 2)`, halves rounded down.
#[derive(Debug, Clone)]
pub struct ScoreMap {
    nx: usize,
    ny: usize,
    /// Row-major: the score of cell `(x, y)` is at `x * ny + y`. NaN where there is none.
    scores: Vec<f32>,
}

impl ScoreMap {
    /// A map of a grid's cells without any score.
    pub fn empty(grid: &Grid) -> Self {
        Self {
            nx: grid.nx(),
            ny: grid.ny(),
            scores: vec![f32::NAN; grid.nx() * grid.ny()],
        }
    }

    /// Cells along x.
    pub fn nx(&self) -> usize {
        self.nx
    }

    /// Cells along y.
    pub fn ny(&self) -> usize {
        self.ny
    }

    /// The score of a cell; `None` where no placement has one, and outside the grid.
    pub fn get(&self, x: usize, y: usize) -> Option<f32> {
        if y >= self.ny {
            return None;
        }
        let score = self.scores.get(x * self.ny + y).copied();
        score.filter(|score| !score.is_nan())
    }

    /// Lowers a cell to at most `score`, which it gets where it has none; nothing happens outside the grid.
    pub fn lower(&mut self, x: usize, y: usize, score: f32) {
        if y < self.ny
            && let Some(lowest) = self.scores.get_mut(x * self.ny + y)
        {
            // Of a number and none, this is the number.
            *lowest = lowest.min(score);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_keeps_its_lowest_score() {
        let grid = Grid::reference();
        let mut map = ScoreMap::empty(&grid);
        assert_eq!((map.nx(), map.ny()), (grid.nx(), grid.ny()));
        for score in [0.5, -1.5, 2.0] {
            map.lower(3, 5, score);
        }
        // None of these is a cell.
        map.lower(3, grid.ny(), -9.0);
        map.lower(grid.nx(), 0, -9.0);
        let cells = (0..=grid.nx()).flat_map(|x| (0..=grid.ny()).map(move |y| (x, y)));
        for (x, y) in cells {
            let expected = ((x, y) == (3, 5)).then_some(-1.5);
            assert_eq!(map.get(x, y), expected, "({x}, {y})");
        }
    }
}
