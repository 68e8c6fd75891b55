//! PLY files, ASCII and binary: a header, then elements row by row. Readers of clouds and of meshes
//! share it.
//!
//! Memory is taken for what a file has, never for what its header announces.

use crate::text::{number, quoted, words};

/// A type of number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Number {
    /// 1 byte, with a sign.
    I8,
    /// 1 byte.
    U8,
    /// 2 bytes, with a sign.
    I16,
    /// 2 bytes.
    U16,
    /// 4 bytes, with a sign.
    I32,
    /// 4 bytes.
    U32,
    /// 4 bytes, with a fraction.
    F32,
    /// 8 bytes, with a fraction.
    F64,
}

/// A property of an element.
#[derive(Debug, Clone, PartialEq)]
pub struct Property {
    /// Its name, such as `x`.
    pub name: String,
    /// The type of its number or numbers.
    pub number: Number,
    /// The type of a list's length; `None` where it is a single number.
    pub length: Option<Number>,
}

/// A kind of rows that a file announces, such as `vertex`.
#[derive(Debug, Clone, PartialEq)]
pub struct Element {
    /// Its name.
    pub name: String,
    /// Its rows.
    pub count: usize,
    /// The properties of each row, in their order.
    pub properties: Vec<Property>,
}

/// The part of a file that is not read yet.
#[derive(Debug)]
pub struct Body<'a> {
    encoding: Encoding,
    rest: &'a [u8],
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// Reads a header. Comments are of any bytes.
///
/// # Errors
/// The line that is wrong.
pub fn header(content: &[u8]) -> Result<(Vec<Element>, Body<'_>), String> {
    let mut rest = content;
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    if next_line(&mut rest).is_none_or(|line| line != b"ply") {
        return Err("its first line is not 'ply'".to_owned());
    }
    loop {
        let line = next_line(&mut rest).ok_or("its header has no line 'end_header'")?;
        let wrong = || format!("its header has the line '{}'", quoted(line));
        let words: Vec<&[u8]> = words(line).take(6).collect();
        match words[..] {
            [] | [b"comment" | b"obj_info", ..] => {}
            [b"format", format, ..] => {
                encoding = Some(match format {
                    b"ascii" => Encoding::Ascii,
                    b"binary_little_endian" => Encoding::LittleEndian,
                    b"binary_big_endian" => Encoding::BigEndian,
                    _ => return Err(wrong()),
                });
            }
            [b"element", name, count] => elements.push(Element {
                name: quoted(name),
                count: quoted(count).parse().map_err(|_| wrong())?,
                properties: Vec::new(),
            }),
            [b"property", ref kind @ .., name] => {
                let length = match kind {
                    [b"list", length, _] => Some(Number::named(length).ok_or_else(wrong)?),
                    [_] => None,
                    _ => return Err(wrong()),
                };
                let number = kind.last().and_then(|number| Number::named(number));
                let property = Property {
                    name: quoted(name),
                    number: number.ok_or_else(wrong)?,
                    length,
                };
                let element = elements.last_mut().ok_or_else(wrong)?;
                element.properties.push(property);
            }
            [b"end_header"] => break,
            _ => return Err(wrong()),
        }
    }
    let encoding = encoding.ok_or("its header has no line 'format'")?;
    Ok((elements, Body { encoding, rest }))
}

impl Body<'_> {
    /// Reads the rows of the next element: `visit` is given the numbers of each property, one for
    /// what is no list.
    ///
    /// # Errors
    /// The row that is wrong, or a count that the file cannot hold.
    pub fn rows(
        &mut self,
        element: &Element,
        mut visit: impl FnMut(&[Vec<f64>]),
    ) -> Result<(), String> {
        let Element { name, count, .. } = element;
        let bytes = self.rest.len();
        let properties = element.properties.iter();
        let least = properties.map(|property| match self.encoding {
            // A digit and what separates it from the next.
            Encoding::Ascii => 2,
            _ => property.length.unwrap_or(property.number).bytes(),
        });
        // One byte more, since the last line of an ASCII file need not end.
        if count.saturating_mul(least.sum::<usize>().max(1)) > bytes + 1 {
            return Err(format!(
                "its header announces {count} elements '{name}', more than its {bytes} bytes can hold"
            ));
        }
        let mut row = vec![Vec::new(); element.properties.len()];
        for index in 0..*count {
            row.iter_mut().for_each(Vec::clear);
            if self.encoding == Encoding::Ascii {
                let line = loop {
                    match next_line(&mut self.rest) {
                        Some([]) => {}
                        Some(line) => break line,
                        None => return Err(format!("it ends after {index} of {count} '{name}'")),
                    }
                };
                let mut words = words(line);
                let read = fill(element, &mut row, |kind| kind.of_text(words.next()?));
                if read.is_none() || words.next().is_some() {
                    return Err(format!("'{}' is no {name}", quoted(line)));
                }
            } else {
                let is_big = self.encoding == Encoding::BigEndian;
                fill(element, &mut row, |kind| {
                    kind.of_bytes(&mut self.rest, is_big)
                })
                .ok_or_else(|| format!("it ends after {index} of {count} '{name}'"))?;
            }
            visit(&row);
        }
        Ok(())
    }
}

/// Fills a row with what `next` gives; `None` where it gives less.
fn fill(
    element: &Element,
    row: &mut [Vec<f64>],
    mut next: impl FnMut(Number) -> Option<f64>,
) -> Option<()> {
    for (property, values) in element.properties.iter().zip(row) {
        let count = match property.length {
            Some(length) => next(length).filter(|count| *count >= 0.0)? as usize,
            None => 1,
        };
        for _ in 0..count {
            values.push(next(property.number)?);
        }
    }
    Some(())
}

impl Number {
    fn named(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    fn of_text(self, word: &[u8]) -> Option<f64> {
        let value = number(word)?;
        Some(match self {
            Self::F32 => f64::from(value as f32),
            _ => value,
        })
    }

    fn of_bytes(self, bytes: &mut &[u8], is_big: bool) -> Option<f64> {
        fn take<const COUNT: usize>(bytes: &mut &[u8], is_big: bool) -> Option<[u8; COUNT]> {
            let (first, rest) = bytes.split_first_chunk()?;
            *bytes = rest;
            let mut first = *first;
            if is_big {
                first.reverse();
            }
            Some(first)
        }
        Some(match self {
            Self::I8 => i8::from_le_bytes(take(bytes, is_big)?).into(),
            Self::U8 => u8::from_le_bytes(take(bytes, is_big)?).into(),
            Self::I16 => i16::from_le_bytes(take(bytes, is_big)?).into(),
            Self::U16 => u16::from_le_bytes(take(bytes, is_big)?).into(),
            Self::I32 => i32::from_le_bytes(take(bytes, is_big)?).into(),
            Self::U32 => u32::from_le_bytes(take(bytes, is_big)?).into(),
            Self::F32 => f32::from_le_bytes(take(bytes, is_big)?).into(),
            Self::F64 => f64::from_le_bytes(take(bytes, is_big)?),
        })
    }
}

/// Takes the next line, without the blanks around it.
fn next_line<'a>(rest: &mut &'a [u8]) -> Option<&'a [u8]> {
    if rest.is_empty() {
        return None;
    }
    let end = rest.iter().position(|byte| *byte == b'\n');
    let (line, after) = rest.split_at(end.map_or(rest.len(), |end| end + 1));
    *rest = after;
    Some(line.trim_ascii())
}
