//! The header of a PCD file.

use nalgebra::Point3;

use super::{body, refused};
use crate::error::FormatError;

/// Maximum length of a header, in bytes.
const MAX_HEADER_BYTES: usize = 1 << 16;

/// Maximum number of fields of a point.
const MAX_FIELDS: usize = 256;

/// Maximum number of bytes of a point, and of numbers of a field.
const MAX_POINT_BYTES: usize = 1 << 16;

/// A reader of the points that follow a header.
type ReadBody = fn(&Header, &[u8]) -> Result<Vec<Point3<f32>>, FormatError>;

/// A header that is possible: the fields `x`, `y` and `z` are there, and the counts agree.
pub(super) struct Header {
    pub(super) width: usize,
    pub(super) points: usize,
    pub(super) read_body: ReadBody,
    pub(super) coordinates: [Coordinate; 3],
    /// Bytes of a point.
    pub(super) stride: usize,
    /// Numbers of a point, of all fields.
    pub(super) numbers: usize,
}

/// The place of a coordinate in a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Coordinate {
    /// In bytes.
    pub(super) offset: usize,
    /// In numbers, as they stand in a line.
    pub(super) column: usize,
    /// Its bytes, 4 or 8.
    pub(super) size: usize,
}

/// Gives the lines of a header without comments and empty ones, each with where the next begins.
pub(super) fn lines(content: &[u8]) -> impl Iterator<Item = (&[u8], usize)> {
    let head = content.get(..MAX_HEADER_BYTES).unwrap_or(content);
    let mut end = 0;
    let lines = head
        .split_inclusive(|byte| *byte == b'\n')
        .map(move |line| {
            end += line.len();
            (line.trim_ascii(), end)
        });
    lines.filter(|(line, _)| !line.is_empty() && !line.starts_with(b"#"))
}

/// The entries of a header as they stand there.
#[derive(Debug, Default)]
struct Entries<'a> {
    fields: Vec<&'a str>,
    sizes: Vec<&'a str>,
    types: Vec<&'a str>,
    counts: Vec<&'a str>,
    width: Option<usize>,
    height: Option<usize>,
    points: Option<usize>,
}

impl Header {
    /// Reads a header; gives it with what follows it.
    pub(super) fn parse(content: &[u8]) -> Result<(Self, &[u8]), FormatError> {
        let mut entries = Entries::default();
        for (line, end) in lines(content) {
            let line =
                std::str::from_utf8(line).map_err(|_| FormatError::pcd("its header is no text"))?;
            let mut words = line.split_ascii_whitespace();
            let keyword = words.next().unwrap_or("");
            let values: Vec<&str> = words.collect();
            if keyword != "DATA" {
                entries.take(keyword, values)?;
                continue;
            }
            let read_body = match values.as_slice() {
                ["ascii"] => body::ascii,
                ["binary"] => body::binary,
                ["binary_compressed"] => body::compressed,
                _ => return refused(format_args!("'{line}' is no DATA that is known")),
            };
            let header = entries.header(read_body)?;
            return Ok((header, content.get(end..).unwrap_or(&[])));
        }
        refused("its header has no line DATA")
    }
}

impl<'a> Entries<'a> {
    fn take(&mut self, keyword: &str, values: Vec<&'a str>) -> Result<(), FormatError> {
        match keyword {
            "FIELDS" | "COLUMNS" => self.fields = values,
            "SIZE" => self.sizes = values,
            "TYPE" => self.types = values,
            "COUNT" => self.counts = values,
            "WIDTH" => self.width = Some(one_number(keyword, &values)?),
            "HEIGHT" => self.height = Some(one_number(keyword, &values)?),
            "POINTS" => self.points = Some(one_number(keyword, &values)?),
            "VERSION" | "VIEWPOINT" => {}
            _ => {
                let reason = format_args!("its header has a line '{keyword}', which is not known");
                return refused(reason);
            }
        }
        Ok(())
    }

    fn header(&self, read_body: ReadBody) -> Result<Header, FormatError> {
        let (width, points) = self.shape()?;
        let fields = self.fields.len();
        if !(1..=MAX_FIELDS).contains(&fields) {
            let reason = format_args!("it has {fields} FIELDS: 3 to {MAX_FIELDS} are possible");
            return refused(reason);
        }
        for (name, found, may_lack) in [
            ("SIZE", self.sizes.len(), false),
            ("TYPE", self.types.len(), false),
            ("COUNT", self.counts.len(), true),
        ] {
            if found != fields && !(may_lack && found == 0) {
                return refused(format_args!(
                    "it has {fields} FIELDS, but {name} of {found}"
                ));
            }
        }
        let mut found = [None; 3];
        let (mut stride, mut numbers) = (0, 0);
        for (index, name) in self.fields.iter().enumerate() {
            let (kind, size, count) = self.field(index)?;
            if let Some(place) = ["x", "y", "z"].iter().position(|side| side == name)
                && let Some(coordinate) = found.get_mut(place)
            {
                if coordinate.is_some() {
                    return refused(format_args!("it has two fields '{name}'"));
                }
                if kind != "F" || count != 1 {
                    let reason = format_args!("its field '{name}' is not one number of TYPE F");
                    return refused(reason);
                }
                *coordinate = Some(Coordinate {
                    offset: stride,
                    column: numbers,
                    size,
                });
            }
            stride += size * count;
            numbers += count;
        }
        if stride > MAX_POINT_BYTES {
            return refused(format_args!(
                "its points have {stride} bytes where at most {MAX_POINT_BYTES} are possible"
            ));
        }
        let [Some(x), Some(y), Some(z)] = found else {
            return refused("it lacks one of the fields x, y and z");
        };
        Ok(Header {
            width,
            points,
            read_body,
            coordinates: [x, y, z],
            stride,
            numbers,
        })
    }

    /// Gives the points in a row, and all points.
    fn shape(&self) -> Result<(usize, usize), FormatError> {
        let width = self.width.or(self.points);
        let width = width.ok_or_else(|| FormatError::pcd("its header has no line WIDTH"))?;
        let product = width.checked_mul(self.height.unwrap_or(1));
        let points = product.unwrap_or(usize::MAX);
        FormatError::check_points(points)?;
        match self.points {
            Some(announced) if announced != points => refused(format_args!(
                "POINTS is {announced}, but WIDTH times HEIGHT is {points}"
            )),
            _ => Ok((width, points)),
        }
    }

    /// Gives the type of a field's numbers, the bytes of each and their count.
    fn field(&self, index: usize) -> Result<(&'a str, usize, usize), FormatError> {
        let text = |values: &[&'a str]| values.get(index).copied();
        let size = text(&self.sizes).unwrap_or("");
        let kind = text(&self.types).unwrap_or("");
        let count = text(&self.counts).unwrap_or("1");
        let is_possible = match kind {
            "F" => matches!(size, "4" | "8"),
            "I" | "U" => matches!(size, "1" | "2" | "4" | "8"),
            _ => false,
        };
        if !is_possible {
            let reason = format_args!("a field of TYPE '{kind}' and SIZE '{size}' is not known");
            return refused(reason);
        }
        let count: usize = one_number("COUNT", &[count])?;
        if count > MAX_POINT_BYTES {
            return refused(format_args!(
                "a field has COUNT {count} where at most {MAX_POINT_BYTES} is possible"
            ));
        }
        Ok((kind, one_number("SIZE", &[size])?, count))
    }
}

fn one_number(keyword: &str, values: &[&str]) -> Result<usize, FormatError> {
    let text = values.join(" ");
    let refused = |_| FormatError::pcd(format_args!("{keyword} '{text}' is no count"));
    text.parse().map_err(refused)
}
