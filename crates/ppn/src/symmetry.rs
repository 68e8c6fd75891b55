//! The symmetries of a packing problem: a mirrored container and mirrored items have mirrored
//! solutions.

/// A mirror image, perhaps turned by a quarter: eight in all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Symmetry {
    mirror_x: bool,
    mirror_y: bool,
    swap: bool,
}

/// A rectangle of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Cells {
    pub(crate) nx: usize,
    pub(crate) ny: usize,
}

impl Symmetry {
    pub(crate) const COUNT: usize = 8;

    /// Gives the symmetry of a number; 0 changes nothing.
    pub(crate) fn of(number: usize) -> Self {
        Self {
            mirror_x: number & 1 != 0,
            mirror_y: number & 2 != 0,
            swap: number & 4 != 0,
        }
    }

    /// Gives the size of the image of a map of this size.
    pub(crate) fn size(self, Cells { nx, ny }: Cells) -> Cells {
        if self.swap {
            Cells { nx: ny, ny: nx }
        } else {
            Cells { nx, ny }
        }
    }

    /// Gives the place of a cell of a map of `size` in the map's image.
    pub(crate) fn cell(self, (x, y): (usize, usize), size: Cells) -> (usize, usize) {
        self.corner((x, y), Cells { nx: 1, ny: 1 }, size)
    }

    /// Gives the lowest corner of a footprint in the image of a map of `size`.
    pub(crate) fn corner(
        self,
        (mut x, mut y): (usize, usize),
        footprint: Cells,
        size: Cells,
    ) -> (usize, usize) {
        if self.mirror_x {
            x = size.nx.saturating_sub(footprint.nx + x);
        }
        if self.mirror_y {
            y = size.ny.saturating_sub(footprint.ny + y);
        }
        if self.swap { (y, x) } else { (x, y) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_are_one_to_one() {
        let size = Cells { nx: 3, ny: 5 };
        for number in 0..Symmetry::COUNT {
            let symmetry = Symmetry::of(number);
            let image = symmetry.size(size);
            let cells = (0..size.nx).flat_map(|x| (0..size.ny).map(move |y| (x, y)));
            let images = cells.map(|cell| symmetry.cell(cell, size));
            let all = (0..image.nx).flat_map(|x| (0..image.ny).map(move |y| (x, y)));
            assert!(
                images
                    .collect::<std::collections::BTreeSet<_>>()
                    .into_iter()
                    .eq(all)
            );
        }
    }

    #[test]
    fn a_footprints_corner_is_the_lowest_of_its_cells() {
        let (size, footprint) = (Cells { nx: 7, ny: 6 }, Cells { nx: 2, ny: 3 });
        for number in 0..Symmetry::COUNT {
            let symmetry = Symmetry::of(number);
            let cells = (0..2).flat_map(|x| (0..3).map(move |y| (4 + x, 1 + y)));
            let images: Vec<_> = cells.map(|cell| symmetry.cell(cell, size)).collect();
            let lowest = (
                images.iter().map(|(x, _)| *x).min().unwrap(),
                images.iter().map(|(_, y)| *y).min().unwrap(),
            );
            assert_eq!(symmetry.corner((4, 1), footprint, size), lowest);
        }
    }
}
