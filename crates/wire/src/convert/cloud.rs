//! Point clouds, read where they lie.

use nalgebra::{Isometry3, Point3};

use super::pose;
use crate::decode::MAX_POINT_BYTES;
use crate::error::WireError;
use crate::limits::count;
use crate::v1;
use crate::v1::NumericType;

/// Maximum number of bytes from one point to the next.
const MAX_STRIDE: usize = 1024;

/// Size of a point as [`write`] lays it out.
const POINT_BYTES: usize = 12;

/// Maximum size of a sensor's name, in bytes.
const MAX_SENSOR_NAME: usize = 64;

pub(crate) const MAX_FIELDS: usize = 32;

/// A cloud whose layout is checked, so that its points can be looked at one by one.
#[derive(Debug, Clone)]
pub struct Cloud<'a> {
    message: &'a v1::PointCloud,
    layout: Layout,
}

/// The message of a cloud whose layout is checked.
#[derive(Debug, Clone)]
pub struct CheckedCloud {
    message: v1::PointCloud,
    layout: Layout,
}

/// The layout of the points in the data, and the pose of the sensor.
#[derive(Debug, Clone, Copy)]
struct Layout {
    container_from_sensor: Isometry3<f64>,
    stride: usize,
    coordinates: [Coordinate; 3],
}

/// The place of a coordinate within a point.
#[derive(Debug, Clone, Copy)]
struct Coordinate {
    offset: usize,
    is_double: bool,
}

impl Coordinate {
    /// Reads the coordinate of a point; one beyond all of `f32` is infinite, a hole.
    fn of(self, point: &[u8]) -> f32 {
        let from = point.get(self.offset..).unwrap_or(&[]);
        let read = match self.is_double {
            true => from
                .first_chunk()
                .map(|bytes| f64::from_le_bytes(*bytes) as f32),
            false => from.first_chunk().map(|bytes| f32::from_le_bytes(*bytes)),
        };
        read.unwrap_or(f32::NAN)
    }

    /// Multiplies the coordinate of a point.
    fn scale(self, point: &mut [u8], factor: f64) {
        let from = point.get_mut(self.offset..).unwrap_or(&mut []);
        if self.is_double {
            if let Some(bytes) = from.first_chunk_mut() {
                *bytes = (f64::from_le_bytes(*bytes) * factor).to_le_bytes();
            }
        } else if let Some(bytes) = from.first_chunk_mut() {
            let scaled = f64::from(f32::from_le_bytes(*bytes)) * factor;
            *bytes = (scaled as f32).to_le_bytes();
        }
    }
}

impl CheckedCloud {
    /// Checks a cloud's layout.
    ///
    /// # Errors
    /// As [`read`].
    pub fn new(message: v1::PointCloud) -> Result<Self, WireError> {
        let layout = check(&message)?;
        Ok(Self { message, layout })
    }

    /// Gives the cloud.
    pub fn cloud(&self) -> Cloud<'_> {
        Cloud {
            message: &self.message,
            layout: self.layout,
        }
    }
}

impl<'a> Cloud<'a> {
    /// Gives the points in the sensor's frame, in metres. Those with a coordinate that is not
    /// finite are holes; so are those at the lens, with which many drivers fill holes.
    pub fn points(&self) -> impl ExactSizeIterator<Item = Point3<f32>> + Clone + use<'a> {
        let [x, y, z] = self.layout.coordinates;
        let points = self.message.data.chunks_exact(self.layout.stride);
        points.map(move |point| {
            let point = Point3::new(x.of(point), y.of(point), z.of(point));
            if point == Point3::origin() {
                Point3::new(f32::NAN, f32::NAN, f32::NAN)
            } else {
                point
            }
        })
    }

    /// The message that the cloud lies in.
    pub fn message(&self) -> &'a v1::PointCloud {
        self.message
    }

    /// Counts the points, holes among them.
    pub fn len(&self) -> usize {
        self.message.data.len() / self.layout.stride
    }

    /// Says whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.message.data.is_empty()
    }

    /// The pose of the sensor.
    pub fn container_from_sensor(&self) -> &Isometry3<f64> {
        &self.layout.container_from_sensor
    }

    /// The number of the cloud among those of the sensor, from 1.
    pub fn sequence(&self) -> u64 {
        self.message.sequence
    }

    /// The state of the cell when it was captured; 0 where the sensor does not know it.
    pub fn state_number(&self) -> u64 {
        self.message.state_number
    }

    /// The time of its capture, in nanoseconds since 1970.
    pub fn captured_at_ns(&self) -> i64 {
        self.message.captured_at_ns
    }
}

/// Takes a cloud to metres whose numbers are of a unit of so many metres.
///
/// # Errors
/// As [`read`].
pub fn to_metres(message: &mut v1::PointCloud, unit_m: f64) -> Result<(), WireError> {
    let layout = check(message)?;
    for point in message.data.chunks_exact_mut(layout.stride) {
        for coordinate in layout.coordinates {
            coordinate.scale(point, unit_m);
        }
    }
    Ok(())
}

/// Checks a cloud's layout.
///
/// # Errors
/// [`WireError`] where the pose, the stride, a field or the size of the data is impossible.
pub fn read(message: &v1::PointCloud) -> Result<Cloud<'_>, WireError> {
    let layout = check(message)?;
    Ok(Cloud { message, layout })
}

fn check(message: &v1::PointCloud) -> Result<Layout, WireError> {
    if message.sequence == 0 {
        return Err(WireError::invalid("cloud.sequence", "it counts from 1"));
    }
    count("cloud.sensor", message.sensor.len(), 0..=MAX_SENSOR_NAME)?;
    let stride = usize::try_from(message.point_stride).unwrap_or(usize::MAX);
    count("cloud.point_stride", stride, 1..=MAX_STRIDE)?;
    count("cloud.fields", message.fields.len(), 0..=MAX_FIELDS)?;
    for field in &message.fields {
        check_field(field, stride)?;
    }
    let bytes = message.data.len();
    count("cloud.data", bytes, 0..=MAX_POINT_BYTES)?;
    if !bytes.is_multiple_of(stride) {
        let reason = format_args!("{bytes} bytes are no whole number of points of {stride} bytes");
        return Err(WireError::invalid("cloud.data", reason));
    }
    let sensor = message.container_from_sensor.as_ref();
    let coordinate = |name| coordinate(message, name);
    Ok(Layout {
        container_from_sensor: pose::read_required("cloud.container_from_sensor", sensor)?,
        stride,
        coordinates: [coordinate("x")?, coordinate("y")?, coordinate("z")?],
    })
}

fn check_field(field: &v1::PackedField, stride: usize) -> Result<(), WireError> {
    let size = match field.r#type() {
        NumericType::Unspecified => {
            let reason = format_args!("{} is no type that is known", field.r#type);
            return Err(WireError::invalid("cloud.fields.type", reason));
        }
        NumericType::Uint8 | NumericType::Int8 => 1,
        NumericType::Uint16 | NumericType::Int16 => 2,
        NumericType::Uint32 | NumericType::Int32 | NumericType::Float32 => 4,
        NumericType::Float64 => 8,
    };
    let end = u64::from(field.offset) + size;
    if end > stride as u64 {
        let reason = format_args!("a field ends at byte {end} of a point of {stride}");
        return Err(WireError::invalid("cloud.fields.offset", reason));
    }
    Ok(())
}

fn coordinate(message: &v1::PointCloud, name: &str) -> Result<Coordinate, WireError> {
    let mut named = message.fields.iter().filter(|field| field.name == name);
    let (Some(field), None) = (named.next(), named.next()) else {
        let reason = format_args!("one field '{name}' is needed");
        return Err(WireError::invalid("cloud.fields", reason));
    };
    let is_double = match field.r#type() {
        NumericType::Float32 => false,
        NumericType::Float64 => true,
        _ => {
            let reason = format_args!("field '{name}' has to be a FLOAT32 or FLOAT64");
            return Err(WireError::invalid("cloud.fields.type", reason));
        }
    };
    Ok(Coordinate {
        offset: field.offset as usize,
        is_double,
    })
}

/// The time and place of a cloud's capture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Capture {
    /// The number of the cloud among those of the sensor, from 1.
    pub sequence: u64,
    /// The time, in nanoseconds since 1970.
    pub captured_at_ns: i64,
    /// The state of the cell; 0 where it is not known.
    pub state_number: u64,
    /// The pose of the sensor.
    pub container_from_sensor: Isometry3<f64>,
}

/// Writes a cloud of points in the sensor's frame, in metres.
pub fn write(capture: &Capture, points: &[Point3<f32>]) -> v1::PointCloud {
    let field = |name: &str, offset: u32| v1::PackedField {
        name: name.to_owned(),
        offset,
        r#type: NumericType::Float32.into(),
    };
    let mut data = vec![0; points.len() * POINT_BYTES];
    let slots = data.as_chunks_mut::<POINT_BYTES>().0;
    for (slot, point) in slots.iter_mut().zip(points) {
        let coordinates = slot.as_chunks_mut().0.iter_mut().zip(&point.coords);
        coordinates.for_each(|(bytes, coordinate)| *bytes = coordinate.to_le_bytes());
    }
    v1::PointCloud {
        cell: String::new(),
        sequence: capture.sequence,
        captured_at_ns: capture.captured_at_ns,
        state_number: capture.state_number,
        container_from_sensor: Some(pose::write(&capture.container_from_sensor)),
        point_stride: POINT_BYTES as u32,
        fields: vec![field("x", 0), field("y", 4), field("z", 8)],
        data,
        sensor: String::new(),
    }
}
