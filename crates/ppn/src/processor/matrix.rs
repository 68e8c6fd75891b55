//! Channels as rows of cells.

/// Cells that are computed together, at most. Rows are padded, so that as many may be read and written from any of a
/// row's cells.
pub(super) const TILE: usize = 32;

/// Rows of cells, one per channel.
#[derive(Debug, Default)]
pub(super) struct Matrix {
    width: usize,
    stride: usize,
    values: Vec<f32>,
    starts: Vec<usize>,
}

impl Matrix {
    /// Takes another shape, without an allocation where it fits. Values are left over from before; all must be written.
    pub(super) fn reshape(&mut self, rows: usize, width: usize) {
        self.width = width;
        self.stride = width.next_multiple_of(TILE) + TILE;
        self.values.resize(rows * self.stride, 0.0);
        self.starts.clear();
        self.starts.extend((0..rows).map(|row| row * self.stride));
    }

    pub(super) fn rows(&self) -> usize {
        self.starts.len()
    }

    /// The cells of a row.
    pub(super) fn width(&self) -> usize {
        self.width
    }

    pub(super) fn row(&self, row: usize) -> &[f32] {
        let start = row * self.stride;
        self.values.get(start..start + self.width).unwrap_or(&[])
    }

    pub(super) fn row_mut(&mut self, row: usize) -> &mut [f32] {
        let start = row * self.stride;
        let range = start..start + self.width;
        self.values.get_mut(range).unwrap_or(&mut [])
    }

    /// The tile of every row from the cell at `first` on.
    pub(super) fn tile(&self, first: usize) -> Inputs<'_> {
        Inputs {
            values: self.values.get(first..).unwrap_or(&[]),
            starts: &self.starts,
        }
    }

    /// As [`Self::tile`], to be written.
    pub(super) fn tile_mut(&mut self, first: usize) -> Outputs<'_> {
        Outputs {
            values: self.values.get_mut(first..).unwrap_or(&mut []),
            stride: self.stride,
        }
    }
}

/// One tile of each of many inputs; by default of none.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Inputs<'a> {
    pub(super) values: &'a [f32],
    /// Where each input's tile begins.
    pub(super) starts: &'a [usize],
}

/// One tile of each of many outputs, which lie `stride` apart.
#[derive(Debug)]
pub(super) struct Outputs<'a> {
    pub(super) values: &'a mut [f32],
    pub(super) stride: usize,
}
