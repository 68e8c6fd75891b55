//! Clouds of ROS 2 of any layout, against a plain way to make and read them.

use nalgebra::Isometry3;
use ppnpack_wire::convert::cloud;
use ppnpack_wire::ros::{PointCloud2, PointField, Stamp, datatype, to_cloud};
use proptest::prelude::*;

use crate::payload::payload;

/// A field as a layout has it.
#[derive(Debug, Clone)]
struct Field {
    name: String,
    offset: usize,
    datatype: u8,
    count: u32,
}

impl Field {
    fn size(&self) -> usize {
        match self.datatype {
            datatype::INT8 | datatype::UINT8 | datatype::BOOLEAN => 1,
            datatype::INT16 | datatype::UINT16 => 2,
            datatype::INT32 | datatype::UINT32 | datatype::FLOAT32 => 4,
            _ => 8,
        }
    }

    fn is_kept(&self) -> bool {
        self.count == 1 && self.datatype <= datatype::FLOAT64
    }
}

/// Fields one after the other in any order, with gaps or without, and the bytes of a point.
fn layouts() -> impl Strategy<Value = (Vec<Field>, usize)> {
    let coordinate = || prop_oneof![4 => Just(datatype::FLOAT32), 1 => Just(datatype::FLOAT64)];
    let other = (1_u8..=11, prop_oneof![4 => Just(1_u32), 1 => 2_u32..5]);
    let others = proptest::collection::vec(other, 0..6);
    (coordinate(), coordinate(), coordinate(), others)
        .prop_flat_map(|(x, y, z, others)| {
            let mut fields = vec![
                ("x".to_owned(), x, 1),
                ("y".to_owned(), y, 1),
                ("z".to_owned(), z, 1),
            ];
            let named = others.into_iter().enumerate();
            fields.extend(named.map(|(index, (kind, count))| (format!("f{index}"), kind, count)));
            let gap = prop_oneof![3 => Just(0_usize), 1 => 0_usize..9];
            let gaps = proptest::collection::vec(gap, fields.len() + 1);
            (Just(fields).prop_shuffle(), gaps)
        })
        .prop_map(|(fields, gaps)| {
            let mut end = 0;
            let mut laid = Vec::new();
            for ((name, datatype, count), gap) in fields.into_iter().zip(&gaps) {
                let field = Field {
                    name,
                    offset: end + gap,
                    datatype,
                    count,
                };
                end = field.offset + field.size() * count as usize;
                laid.push(field);
            }
            (laid, end + gaps[gaps.len() - 1])
        })
}

/// A cloud as a driver would make it, point by point, and what it means.
#[derive(Debug)]
struct Made {
    stamp: Stamp,
    frame_id: String,
    height: usize,
    width: usize,
    fields: Vec<Field>,
    is_bigendian: bool,
    stride: usize,
    padding: usize,
    data: Vec<u8>,
    is_dense: bool,
    /// Of each point, of each field, the bytes of its first number, the least significant first.
    values: Vec<Vec<Vec<u8>>>,
}

impl Made {
    fn message(&self) -> PointCloud2<'_> {
        let number = |number: usize| u32::try_from(number).unwrap();
        let fields = self.fields.iter().map(|field| PointField {
            name: &field.name,
            offset: number(field.offset),
            datatype: field.datatype,
            count: field.count,
        });
        PointCloud2 {
            stamp: self.stamp,
            frame_id: &self.frame_id,
            height: number(self.height),
            width: number(self.width),
            fields: fields.collect(),
            is_bigendian: self.is_bigendian,
            point_step: number(self.stride),
            row_step: number(self.width * self.stride + self.padding),
            data: &self.data,
            is_dense: self.is_dense,
        }
    }
}

fn clouds() -> impl Strategy<Value = Made> {
    let size = (
        0_usize..5,
        0_usize..7,
        prop_oneof![Just(0_usize), 1_usize..9],
    );
    let bytes = proptest::collection::vec(any::<u8>(), 1..600);
    let flags = (any::<bool>(), any::<bool>(), any::<bool>());
    let head = (any::<i32>(), 0_u32..1_000_000_000, "[a-zä_/]{0,12}");
    (layouts(), size, bytes, flags, head).prop_map(
        |((fields, stride), (height, width, padding), bytes, flags, (sec, nanosec, frame_id))| {
            let (is_bigendian, is_dense, has_short_end) = flags;
            let mut random = bytes.iter().copied().cycle();
            let mut data = Vec::new();
            let mut values = Vec::new();
            for _ in 0..height {
                for _ in 0..width {
                    let mut point: Vec<u8> = random.by_ref().take(stride).collect();
                    let mut of_point = Vec::new();
                    for field in &fields {
                        let number = &mut point[field.offset..field.offset + field.size()];
                        let mut value = number.to_vec();
                        if is_bigendian {
                            value.reverse();
                        }
                        of_point.push(value);
                    }
                    data.extend(point);
                    values.push(of_point);
                }
                data.extend(random.by_ref().take(padding));
            }
            if has_short_end {
                data.truncate(data.len().saturating_sub(padding));
            }
            Made {
                stamp: Stamp { sec, nanosec },
                frame_id,
                height,
                width,
                fields,
                is_bigendian,
                stride,
                padding,
                data,
                is_dense,
                values,
            }
        },
    )
}

/// The number that a coordinate's bytes are.
fn coordinate(value: &[u8]) -> f32 {
    match value.try_into() {
        Ok(single) => f32::from_le_bytes(single),
        Err(_) => f64::from_le_bytes(value.try_into().unwrap()) as f32,
    }
}

fn bits(value: f32) -> Option<u32> {
    (!value.is_nan()).then(|| value.to_bits())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn any_layout_is_read_as_it_was_made(made in clouds(), is_big_endian in any::<bool>()) {
        let payload = payload(&made.message(), is_big_endian);
        let message = PointCloud2::read(&payload).unwrap();
        prop_assert_eq!(&message, &made.message());

        let converted = to_cloud(&message, 1, &Isometry3::identity()).unwrap();
        let stride = converted.point_stride as usize;
        let stamp = made.stamp;
        let expected_ns = i128::from(stamp.sec) * 1_000_000_000 + i128::from(stamp.nanosec);
        prop_assert_eq!(i128::from(converted.captured_at_ns), expected_ns);
        prop_assert_eq!(stride, made.stride);
        prop_assert_eq!(converted.data.len(), made.values.len() * stride);

        let cloud = cloud::read(&converted).unwrap();
        let index = |name: &str| made.fields.iter().position(|field| field.name == name).unwrap();
        let axes = [index("x"), index("y"), index("z")];
        for (point, values) in cloud.points().zip(&made.values) {
            let made = axes.map(|axis| coordinate(&values[axis]));
            // What is at the lens is a hole.
            let made = if made == [0.0; 3] { [f32::NAN; 3] } else { made };
            for (found, made) in point.iter().zip(made) {
                prop_assert_eq!(bits(*found), bits(made));
            }
        }
        for (index, field) in made.fields.iter().enumerate() {
            let named = converted.fields.iter().find(|kept| kept.name == field.name);
            prop_assert_eq!(named.is_some(), field.is_kept(), "{}", field.name);
            let Some(named) = named else { continue };
            prop_assert_eq!(named.offset as usize, field.offset);
            for (point, values) in converted.data.chunks(stride).zip(&made.values) {
                prop_assert_eq!(&point[field.offset..field.offset + field.size()], &values[index]);
            }
        }
    }

    #[test]
    fn changed_payloads_are_read_or_refused(
        made in clouds(),
        is_big_endian in any::<bool>(),
        changes in proptest::collection::vec((any::<proptest::sample::Index>(), any::<u8>()), 0..6),
        length in proptest::option::of(any::<proptest::sample::Index>()),
    ) {
        let mut payload = payload(&made.message(), is_big_endian);
        for (at, byte) in changes {
            let at = at.index(payload.len());
            payload[at] = byte;
        }
        if let Some(length) = length {
            payload.truncate(length.index(payload.len()));
        }
        let Ok(message) = PointCloud2::read(&payload) else {
            return Ok(());
        };
        if let Ok(converted) = to_cloud(&message, 1, &Isometry3::identity()) {
            let points = u64::from(message.width) * u64::from(message.height);
            prop_assert_eq!(cloud::read(&converted).unwrap().len() as u64, points);
        }
    }

    #[test]
    fn random_bytes_are_read_or_refused(payload in proptest::collection::vec(any::<u8>(), 0..200)) {
        let plain = [[0, 1, 0, 0].as_slice(), &payload].concat();
        for payload in [payload, plain] {
            if let Ok(message) = PointCloud2::read(&payload) {
                let _converted = to_cloud(&message, 1, &Isometry3::identity());
            }
        }
    }
}
