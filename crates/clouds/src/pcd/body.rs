//! The points of a PCD file.

use nalgebra::Point3;

use super::header::{Coordinate, Header};
use super::lzf;
use crate::error::FormatError;
use crate::number::number;

/// The most bytes that compressed points have once they are unpacked.
const MAX_UNPACKED_BYTES: usize = 2 << 30;

/// One point a line, numbers apart by spaces.
pub(super) fn ascii(header: &Header, body: &[u8]) -> Result<Vec<Point3<f32>>, FormatError> {
    // Each number has a digit and what separates it from the next.
    check_length(header, body.len().saturating_add(1), 2 * header.numbers)?;
    let mut points_m = Vec::with_capacity(header.points);
    let lines = body.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii);
    for line in lines.filter(|line| !line.is_empty()).take(header.points) {
        points_m.push(ascii_point(header, line)?);
    }
    if points_m.len() < header.points {
        return Err(FormatError::pcd(format_args!(
            "it ends after {} of {} points",
            points_m.len(),
            header.points
        )));
    }
    Ok(points_m)
}

fn ascii_point(header: &Header, line: &[u8]) -> Result<Point3<f32>, FormatError> {
    let refused = || {
        FormatError::pcd(format_args!(
            "'{}' is no point of {} numbers",
            String::from_utf8_lossy(line.get(..100).unwrap_or(line)),
            header.numbers
        ))
    };
    let text = std::str::from_utf8(line).map_err(|_| refused())?;
    let mut sides_m = [f32::NAN; 3];
    let mut numbers = 0;
    for (column, word) in text.split_ascii_whitespace().enumerate() {
        numbers += 1;
        let coordinates = header.coordinates.iter().zip(&mut sides_m);
        for (coordinate, side_m) in coordinates {
            if coordinate.column == column {
                *side_m = number(word).ok_or_else(refused)?;
            }
        }
    }
    if numbers == header.numbers {
        Ok(Point3::from(sides_m))
    } else {
        Err(refused())
    }
}

/// One point after another.
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

/// One field after another, each for all points, packed together.
pub(super) fn compressed(header: &Header, body: &[u8]) -> Result<Vec<Point3<f32>>, FormatError> {
    let (packed_bytes, rest) = count(body)?;
    let (unpacked_bytes, rest) = count(rest)?;
    let expected = header.points.saturating_mul(header.stride);
    if unpacked_bytes != expected || unpacked_bytes > MAX_UNPACKED_BYTES {
        return Err(FormatError::pcd(format_args!(
            "its {} points have {expected} bytes, but {unpacked_bytes} are packed; at most {MAX_UNPACKED_BYTES} are \
             possible",
            header.points
        )));
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

/// A little-endian number of 4 or 8 bytes.
fn value(bytes: &[u8]) -> f32 {
    if let Ok(bytes) = bytes.try_into() {
        f32::from_le_bytes(bytes)
    } else if let Ok(bytes) = bytes.try_into() {
        f64::from_le_bytes(bytes) as f32
    } else {
        f32::NAN
    }
}

/// A count of four bytes, and what follows it.
fn count(bytes: &[u8]) -> Result<(usize, &[u8]), FormatError> {
    let (count, rest) = bytes
        .split_first_chunk::<4>()
        .ok_or_else(|| FormatError::pcd("it ends before its points"))?;
    Ok((u32::from_le_bytes(*count) as usize, rest))
}

/// Refuses more points than a file can hold, before there is memory for them.
fn check_length(header: &Header, bytes: usize, least_bytes: usize) -> Result<(), FormatError> {
    let needed = header.points.saturating_mul(least_bytes);
    if needed <= bytes {
        return Ok(());
    }
    Err(FormatError::pcd(format_args!(
        "it announces {} points, which take {needed} bytes at least, but has {bytes}",
        header.points
    )))
}
