//! The points themselves: copied without the padding of rows, and turned round.

use super::fields::Number;
use super::message::PointCloud2;
use crate::decode::MAX_POINT_BYTES;
use crate::error::WireError;
use crate::limits::{checked, count};

/// The rows of a cloud within its data.
#[derive(Debug)]
pub(super) struct Rows<'a> {
    data: &'a [u8],
    /// Bytes of the points of a row.
    bytes: usize,
    /// Bytes from one row to the next.
    step: usize,
    /// Bytes of all points.
    all: usize,
}

impl<'a> Rows<'a> {
    /// The rows of a cloud, whose data have to be one point after the other, or rows of `row_step`
    /// bytes of which the last may lack its padding. Where no row is padded, `row_step` does not
    /// matter: many drivers do not set it.
    pub(super) fn of(message: &PointCloud2<'a>) -> Result<Self, WireError> {
        let found = message.data.len() as u128;
        let [width, height] = [message.width, message.height].map(u128::from);
        let [point_step, row_step] = [message.point_step, message.row_step].map(u128::from);
        let row = width * point_step;
        let is_whole = found == row * height;
        let is_padded = row_step >= row
            && (found == row_step * height || height > 0 && found == row_step * (height - 1) + row);
        let needed = format_args!(
            "{height} rows of {width} points of {point_step} bytes are needed, in rows of {row_step} bytes if they are \
             padded"
        );
        let (field, found) = ("PointCloud2.data", format_args!("{found} bytes"));
        checked(field, found, is_whole || is_padded, needed)?;
        let size = |bytes: u128| usize::try_from(bytes).unwrap_or(usize::MAX);
        let (bytes, step) = if is_whole {
            (message.data.len(), message.data.len())
        } else {
            (size(row), size(row_step))
        };
        let all = size(row * height);
        count(field, all, 0..=MAX_POINT_BYTES)?;
        Ok(Self {
            data: message.data,
            bytes,
            step: step.max(1),
            all,
        })
    }

    /// The points, one after the other.
    pub(super) fn copy(&self) -> Vec<u8> {
        let mut points = Vec::with_capacity(self.all);
        for row in self.data.chunks(self.step) {
            points.extend_from_slice(row.get(..self.bytes).unwrap_or(row));
        }
        points
    }
}

/// Turns numbers of points round, from big-endian to little-endian.
pub(super) fn swap(points: &mut [u8], stride: usize, numbers: &[Number]) {
    let is_word = |number: &Number| number.bytes == 4 && number.offset.is_multiple_of(4);
    if stride.is_multiple_of(4) && numbers.iter().all(is_word) {
        // The common case. Words that no field names are turned round too: nobody reads them.
        let words = points.as_chunks_mut::<4>().0.iter_mut();
        return words.for_each(|word| word.reverse());
    }
    for point in points.chunks_exact_mut(stride.max(1)) {
        for number in numbers {
            match number.bytes {
                2 => reverse::<2>(point, number.offset),
                4 => reverse::<4>(point, number.offset),
                8 => reverse::<8>(point, number.offset),
                _ => {}
            }
        }
    }
}

fn reverse<const BYTES: usize>(point: &mut [u8], offset: usize) {
    let from = point.get_mut(offset..);
    if let Some(number) = from.and_then(|from| from.first_chunk_mut::<BYTES>()) {
        number.reverse();
    }
}
