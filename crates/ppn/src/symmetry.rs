//! The symmetries of a packing problem: a mirrored container and mirrored items have mirrored solutions.

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
    /// How many there are.
    pub(crate) const COUNT: usize = 8;

    /// The symmetry of a number; 0 changes nothing.
    pub(crate) fn of(number: usize) -> Self {
        Self {
            mirror_x: number & 1 != 0,
            mirror_y: number & 2 != 0,
            swap: number & 4 != 0,
        }
    }

    /// The size of what has this size.
    pub(crate) fn size(self, Cells { nx, ny }: Cells) -> Cells {
        if self.swap {
            Cells { nx: ny, ny: nx }
        } else {
            Cells { nx, ny }
        }
    }

    /// Where a cell of a map of `size` lies in the map's image.
    pub(crate) fn cell(self, (x, y): (usize, usize), size: Cells) -> (usize, usize) {
        self.corner((x, y), Cells { nx: 1, ny: 1 }, size)
    }

    /// Where the lowest corner of a footprint lies in the image of a map of `size`.
    pub(crate) fn corner(
        self,
        (x, y): (usize, usize),
        footprint: Cells,
        size: Cells,
    ) -> (usize, usize) {
        let mirror = |is_mirrored: bool, at: usize, footprint: usize, cells: usize| {
            if is_mirrored {
                cells.saturating_sub(footprint + at)
            } else {
                at
            }
        };
        let x = mirror(self.mirror_x, x, footprint.nx, size.nx);
        let y = mirror(self.mirror_y, y, footprint.ny, size.ny);
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
            let mut seen = std::collections::BTreeSet::new();
            for x in 0..size.nx {
                for y in 0..size.ny {
                    let (x, y) = symmetry.cell((x, y), size);
                    assert!(x < image.nx && y < image.ny);
                    assert!(seen.insert((x, y)));
                }
            }
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
