//! The points of a PCD file.

use nalgebra::Point3;

use super::header::{Coordinate, Header};
use super::{lzf, refused};
use crate::error::FormatError;
use crate::text::{number, points, words};

/// Maximum number of bytes of compressed points once they are unpacked.
const MAX_UNPACKED_BYTES: usize = 2 << 30;

/// Reads one point a line, numbers apart by spaces.
pub(super) fn ascii(header: &Header, body: &[u8]) -> Result<Vec<Point3<f32>>, FormatError> {
    // Each number has a digit and what separates it from the next.
    check_length(header, body.len().saturating_add(1), 2 * header.numbers)?;
    let one = format!("point of {} numbers", header.numbers);
    let point = |line: &[u8]| {
        let words: Vec<&[u8]> = words(line).collect();
        let side = |coordinate: &Coordinate| Some(number(words.get(coordinate.column)?)? as f32);
        let [x, y, z] = header.coordinates.each_ref().map(side);
        let point = Point3::new(x?, y?, z?);
        (words.len() == header.numbers).then_some(point)
    };
    points(body, header.points, [&one, "points"], point).map_err(FormatError::pcd)
}

/// Reads one point after another.
pub(super) fn binary(header: &Header, body: &[u8]) -> Result<Vec<Point3<f32>>, FormatError> {
    check_length(header, body.len(), header.stride)?;
    let mut points_m = Vec::with_capacity(header.points);
    for bytes in body.chunks_exact(header.stride).take(header.points) {
        let side = |coordinate: &Coordinate| {
            let end = coordinate.offset + coordinate.size;
            value(bytes.get(coordinate.offset..end).unwrap_or(&[]))
        };
        let [x, y, z] = &header.coordinates;
        points_m.push(Point3::new(side(x), side(y), side(z)));
    }
    Ok(points_m)
}

/// Reads one field after another, each for all points, packed together.
pub(super) fn compressed(header: &Header, body: &[u8]) -> Result<Vec<Point3<f32>>, FormatError> {
    let (packed_bytes, rest) = count(body)?;
    let (unpacked_bytes, rest) = count(rest)?;
    let expected = header.points.saturating_mul(header.stride);
    if unpacked_bytes != expected || unpacked_bytes > MAX_UNPACKED_BYTES {
        return refused(format_args!(
            "its {} points have {expected} bytes, but {unpacked_bytes} are packed; at most {MAX_UNPACKED_BYTES} are \
             possible",
            header.points
        ));
    }
    let packed = rest.get(..packed_bytes).ok_or_else(|| {
        FormatError::pcd(format_args!(
            "it announces {packed_bytes} packed bytes, but has {}",
            rest.len()
        ))
    })?;
    let unpacked = lzf::unpack(packed, unpacked_bytes)
        .ok_or_else(|| FormatError::pcd("its packed points are damaged"))?;
    let [xs, ys, zs] = header.coordinates.map(|coordinate| {
        let from = coordinate.offset * header.points;
        let to = from + coordinate.size * header.points;
        let column = unpacked.get(from..to).unwrap_or(&[]);
        column.chunks_exact(coordinate.size).map(value)
    });
    let points = xs.zip(ys).zip(zs);
    Ok(points.map(|((x, y), z)| Point3::new(x, y, z)).collect())
}

/// Reads a little-endian number of 4 or 8 bytes.
fn value(bytes: &[u8]) -> f32 {
    if let Ok(bytes) = bytes.try_into() {
        f32::from_le_bytes(bytes)
    } else if let Ok(bytes) = bytes.try_into() {
        f64::from_le_bytes(bytes) as f32
    } else {
        f32::NAN
    }
}

/// Reads a count of four bytes; gives it with what follows.
fn count(bytes: &[u8]) -> Result<(usize, &[u8]), FormatError> {
    let (count, rest) = bytes
        .split_first_chunk::<4>()
        .ok_or_else(|| FormatError::pcd("it ends before its points"))?;
    Ok((u32::from_le_bytes(*count) as usize, rest))
}

/// Refuses more points than a file can hold, before there is memory for them.
fn check_length(header: &Header, bytes: usize, least_bytes: usize) -> Result<(), FormatError> {
    let points = header.points;
    match points.saturating_mul(least_bytes) {
        needed if needed > bytes => refused(format_args!(
            "it announces {points} points, which take {needed} bytes at least, but has {bytes}"
        )),
        _ => Ok(()),
    }
}
