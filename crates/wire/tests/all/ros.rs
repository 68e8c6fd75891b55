//! Clouds of ROS 2 become the clouds that they are, or are refused with an error that names what is
//! wrong.

use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use ppnpack_wire::convert::cloud;
use ppnpack_wire::ros::{PointCloud2, PointField, Stamp, datatype, to_cloud};
use ppnpack_wire::{MAX_CLOUD_BYTES, WireError, v1};

use crate::payload::payload;
use crate::support::refused;

/// One point (1, 2, 0.5) in plain CDR, little-endian, byte for byte as the specification says.
#[rustfmt::skip]
const LITTLE: [u8; 121] = [
    0x00, 0x01, 0, 0, // PLAIN_CDR, little-endian, no options
    1, 0, 0, 0,   2, 0, 0, 0, // 1 s, 2 ns
    4, 0, 0, 0,   b'c', b'a', b'm', 0, // frame_id
    1, 0, 0, 0,   1, 0, 0, 0, // height, width
    3, 0, 0, 0, // fields
    2, 0, 0, 0,   b'x', 0, /* gap */ 0, 0,   0, 0, 0, 0,   7, /* gap */ 0, 0, 0,   1, 0, 0, 0,
    2, 0, 0, 0,   b'y', 0, /* gap */ 0, 0,   4, 0, 0, 0,   7, /* gap */ 0, 0, 0,   1, 0, 0, 0,
    2, 0, 0, 0,   b'z', 0, /* gap */ 0, 0,   8, 0, 0, 0,   7, /* gap */ 0, 0, 0,   1, 0, 0, 0,
    0, /* gap */ 0, 0, 0, // is_bigendian
    12, 0, 0, 0,   12, 0, 0, 0, // point_step, row_step
    12, 0, 0, 0,   0, 0, 0x80, 0x3f,   0, 0, 0, 0x40,   0, 0, 0, 0x3f, // data
    1, // is_dense
];

/// The same, big-endian, with big-endian points.
#[rustfmt::skip]
const BIG: [u8; 121] = [
    0x00, 0x00, 0, 0,
    0, 0, 0, 1,   0, 0, 0, 2,
    0, 0, 0, 4,   b'c', b'a', b'm', 0,
    0, 0, 0, 1,   0, 0, 0, 1,
    0, 0, 0, 3,
    0, 0, 0, 2,   b'x', 0, /* gap */ 0, 0,   0, 0, 0, 0,   7, /* gap */ 0, 0, 0,   0, 0, 0, 1,
    0, 0, 0, 2,   b'y', 0, /* gap */ 0, 0,   0, 0, 0, 4,   7, /* gap */ 0, 0, 0,   0, 0, 0, 1,
    0, 0, 0, 2,   b'z', 0, /* gap */ 0, 0,   0, 0, 0, 8,   7, /* gap */ 0, 0, 0,   0, 0, 0, 1,
    1, /* gap */ 0, 0, 0,
    0, 0, 0, 12,   0, 0, 0, 12,
    0, 0, 0, 12,   0x3f, 0x80, 0, 0,   0x40, 0, 0, 0,   0x3f, 0, 0, 0,
    1,
];

/// The bytes of the golden messages from which their lengths begin: frame_id, fields, the first
/// name, data.
const LENGTHS: [usize; 4] = [12, 28, 32, 104];

fn pose() -> Isometry3<f64> {
    let rotation = UnitQuaternion::from_euler_angles(3.0, 0.1, 0.2);
    Isometry3::from_parts(Translation3::new(0.1, 0.2, 0.9), rotation)
}

fn golden() -> PointCloud2<'static> {
    PointCloud2::read(&LITTLE).unwrap()
}

fn convert(message: &PointCloud2<'_>) -> Result<v1::PointCloud, WireError> {
    to_cloud(message, 7, &pose())
}

fn coordinates(made: &v1::PointCloud) -> Vec<[f32; 3]> {
    let cloud = cloud::read(made).unwrap();
    cloud.points().map(|point| point.coords.into()).collect()
}

/// The field that an error names.
fn named(error: &WireError) -> &'static str {
    match error {
        WireError::Missing { field } | WireError::Invalid { field, .. } => field,
        error => panic!("{error}"),
    }
}

#[test]
fn golden_messages_are_read_as_they_were_written() {
    let field = |name, offset| PointField {
        name,
        offset,
        datatype: datatype::FLOAT32,
        count: 1,
    };
    let little = PointCloud2 {
        stamp: Stamp { sec: 1, nanosec: 2 },
        frame_id: "cam",
        height: 1,
        width: 1,
        fields: vec![field("x", 0), field("y", 4), field("z", 8)],
        is_bigendian: false,
        point_step: 12,
        row_step: 12,
        data: &LITTLE[108..120],
        is_dense: true,
    };
    let big = PointCloud2 {
        is_bigendian: true,
        data: &BIG[108..120],
        ..little.clone()
    };
    assert_eq!(PointCloud2::read(&LITTLE), Ok(little.clone()));
    assert_eq!(PointCloud2::read(&BIG), Ok(big.clone()));
    assert_eq!(payload(&little, false), LITTLE);
    assert_eq!(payload(&big, true), BIG);
    for message in [little, big] {
        let made = convert(&message).unwrap();
        assert_eq!(coordinates(&made), [[1.0, 2.0, 0.5]]);
        assert_eq!(made.captured_at_ns, 1_000_000_002);
        assert_eq!((made.sequence, made.state_number), (7, 0));
        let read = cloud::read(&made).unwrap();
        assert_eq!(read.container_from_sensor(), &pose());
    }
}

#[test]
fn what_ends_early_is_refused_wherever_it_ends() {
    for payload in [LITTLE, BIG] {
        for length in 0..payload.len() {
            let error = PointCloud2::read(&payload[..length]).unwrap_err();
            assert!(error.to_string().contains("left"), "{length}: {error}");
        }
    }
}

#[test]
fn what_follows_the_message_is_not_looked_at() {
    let payload = [LITTLE.as_slice(), &[0xff; 1000]].concat();
    assert_eq!(PointCloud2::read(&payload), Ok(golden()));
}

#[test]
fn other_encodings_are_refused_by_name() {
    for (number, name) in [
        (2, "PL_CDR is"),
        (3, "PL_CDR is"),
        (4, "XML"),
        (6, "PLAIN_CDR2"),
        (7, "PLAIN_CDR2"),
        (9, "DELIMITED_CDR2"),
        (0x0b, "PL_CDR2"),
        (0x11, "PLAIN_CDR2"),
        (0x13, "PL_CDR2"),
        (0x15, "DELIMITED_CDR2"),
        (0x0101, "0x0101"),
    ] {
        let mut payload = LITTLE;
        payload[..2].copy_from_slice(&u16::to_be_bytes(number));
        let error = PointCloud2::read(&payload).unwrap_err();
        assert_eq!(named(&error), "encapsulation");
        assert!(error.to_string().contains(name), "{error}");
    }
}

#[test]
fn hostile_lengths_take_no_memory() {
    for at in LENGTHS {
        for length in [u32::MAX, u32::MAX - 3, 1 << 31, 1 << 27, 200] {
            for (mut payload, bytes) in
                [(LITTLE, length.to_le_bytes()), (BIG, length.to_be_bytes())]
            {
                payload[at..at + 4].copy_from_slice(&bytes);
                let taken = allocation_counter::measure(|| {
                    assert!(PointCloud2::read(&payload).is_err(), "{at}: {length}");
                });
                assert!(taken.bytes_max < 4096, "{at}: {} bytes", taken.bytes_max);
            }
        }
    }
    let sizes = [u32::MAX, 1 << 31, 1 << 16];
    for (width, height) in sizes
        .iter()
        .flat_map(|w| sizes.iter().map(move |h| (*w, *h)))
    {
        for (point_step, row_step) in [(u32::MAX, u32::MAX), (12, 0), (12, u32::MAX), (0, 0)] {
            let message = PointCloud2 {
                width,
                height,
                point_step,
                row_step,
                ..golden()
            };
            let taken = allocation_counter::measure(|| assert!(convert(&message).is_err()));
            assert!(taken.bytes_max < 4096, "{} bytes", taken.bytes_max);
        }
    }
}

#[test]
fn larger_ones_than_the_largest_cloud_are_not_looked_at() {
    let payload = vec![0; MAX_CLOUD_BYTES + 1];
    assert_eq!(
        PointCloud2::read(&payload),
        Err(WireError::TooLarge {
            message: "PointCloud2",
            bytes: MAX_CLOUD_BYTES + 1,
            limit: MAX_CLOUD_BYTES
        })
    );
}

#[test]
fn texts_and_truth_values_have_to_be_what_they_are() {
    let refused = |field: &str, at: usize, byte: u8| {
        let mut payload = LITTLE;
        payload[at] = byte;
        let error = PointCloud2::read(&payload).unwrap_err();
        assert_eq!(named(&error), field, "{error}");
    };
    refused("PointCloud2.header.frame_id", 19, b'!');
    refused("PointCloud2.header.frame_id", 17, 0xff);
    refused("PointCloud2.fields.name", 37, b'x');
    refused("PointCloud2.is_bigendian", 92, 2);
    refused("PointCloud2.is_dense", 120, 255);
    let long = "x".repeat(257);
    let long = PointCloud2 {
        frame_id: &long,
        ..golden()
    };
    let many = PointCloud2 {
        fields: vec![golden().fields[0]; 257],
        ..golden()
    };
    for (message, text) in [
        (long, "257 bytes where 256"),
        (many, "257 elements where at most 256"),
    ] {
        let error = PointCloud2::read(&payload(&message, false)).unwrap_err();
        assert!(error.to_string().contains(text), "{error}");
    }
}

/// Some write an empty text without its terminating zero.
#[test]
fn empty_texts_may_lack_their_zero() {
    for text in [&[0, 0, 0, 0][..], &[1, 0, 0, 0, 0, 0, 0, 0]] {
        let mut payload = LITTLE.to_vec();
        payload.splice(12..20, text.iter().copied());
        assert_eq!(PointCloud2::read(&payload).unwrap().frame_id, "");
    }
}

#[test]
fn impossible_clouds_are_refused_by_field() {
    refused! {
        &golden(), convert, it;
        "PointCloud2.header.stamp.nanosec" => it.stamp.nanosec = 1_000_000_000;
        "PointCloud2.data" => it.width = 2;
        "PointCloud2.data" => it.height = 0;
        "PointCloud2.data" => it.data = &it.data[..11];
        "PointCloud2.data" => (it.height, it.row_step) = (2, 11);
        "PointCloud2.fields.datatype" => it.fields[1].datatype = 0;
        "PointCloud2.fields.datatype" => it.fields[1].datatype = 12;
        "cloud.fields" => it.fields[1].datatype = datatype::INT64;
        "cloud.fields.type" => it.fields[1].datatype = datatype::INT32;
        "PointCloud2.fields.count" => it.fields[2].count = 2;
        "PointCloud2.fields.offset" => it.fields[2].offset = 9;
        "PointCloud2.fields.offset" => it.fields[2].offset = u32::MAX;
        "PointCloud2.fields.offset" => it.fields[2].offset = 6;
        "PointCloud2.fields.offset" => it.fields[2].offset = 4;
        "PointCloud2.fields.offset" => { it.fields[0].name = "normals"; it.fields[0].count = u32::MAX };
        "cloud.fields" => it.fields.truncate(2);
        "cloud.fields" => it.fields[2].name = "x";
        "cloud.fields" => it.fields[2].name = "Z";
        "cloud.fields" => it.fields.clear();
    }
    let error = to_cloud(&golden(), 0, &pose()).unwrap_err();
    assert_eq!(named(&error), "cloud.sequence");
    let far = Translation3::new(f64::NAN, 0.0, 0.0).into();
    let error = to_cloud(&golden(), 1, &far).unwrap_err();
    assert_eq!(named(&error), "cloud.container_from_sensor");
    // As many whole points of this size as so many bytes have room for.
    let of_points = |bytes: usize, room: usize| {
        let data = vec![0; room / bytes * bytes];
        convert(&PointCloud2 {
            point_step: u32::try_from(bytes).unwrap(),
            width: u32::try_from(room / bytes).unwrap(),
            data: &data,
            ..golden()
        })
    };
    let large = (128 << 20) + 12;
    assert_eq!(
        named(&of_points(1025, 1025).unwrap_err()),
        "cloud.point_stride"
    );
    assert!(of_points(16, large).is_ok());
    assert_eq!(
        named(&of_points(12, large).unwrap_err()),
        "PointCloud2.data"
    );
}

#[test]
fn clouds_may_be_empty() {
    for (width, height) in [(0, 1), (0, 0), (5, 0), (0, u32::MAX)] {
        let message = PointCloud2 {
            width,
            height,
            data: &[],
            ..golden()
        };
        assert!(convert(&message).unwrap().data.is_empty());
    }
}

/// Many drivers leave `row_step` at 0 or write something else into it, and others read their clouds
/// none the less.
#[test]
fn row_step_does_not_matter_where_no_row_is_padded() {
    let data = LITTLE[108..120].repeat(6);
    for row_step in [0, 12, 24, 36, 72, u32::MAX] {
        let message = PointCloud2 {
            width: 3,
            height: 2,
            row_step,
            data: &data,
            ..golden()
        };
        let made = convert(&message).unwrap();
        assert_eq!(coordinates(&made), [[1.0, 2.0, 0.5]; 6]);
    }
}

/// Some write the count of a single number as 0.
#[test]
fn a_count_of_nothing_is_one() {
    let mut message = golden();
    message.fields.iter_mut().for_each(|field| field.count = 0);
    assert_eq!(convert(&message), convert(&golden()));
}

#[test]
fn the_coordinates_are_kept_among_many_fields() {
    let names: Vec<String> = (0..100).map(|index| format!("field-{index}")).collect();
    let mut message = golden();
    let others = names.iter().map(|name| PointField {
        name,
        ..message.fields[0]
    });
    message.fields = others.chain(golden().fields).collect();
    let made = convert(&message).unwrap();
    let kept = made.fields.iter().map(|field| field.name.as_str());
    let kept: Vec<&str> = kept.collect();
    assert_eq!(kept[..4], ["x", "y", "z", "field-0"]);
    assert_eq!(kept.len(), 32);
    assert_eq!(coordinates(&made), [[1.0, 2.0, 0.5]]);
}

/// `rgb` as a number and `r`, `g`, `b` in its bytes: in little-endian points both can be seen, in
/// big-endian ones the first.
#[test]
fn fields_that_share_bytes_do_not_spoil_each_other() {
    let field = |name, offset, datatype| PointField {
        name,
        offset,
        datatype,
        count: 1,
    };
    let mut message = golden();
    message.point_step = 16;
    message.fields.extend([
        field("rgb", 12, datatype::FLOAT32),
        field("rgba", 12, datatype::UINT32),
        field("r", 12, datatype::UINT8),
    ]);
    let little = [&LITTLE[108..120], &[1, 2, 3, 4]].concat();
    let big = [&BIG[108..120], &[4, 3, 2, 1]].concat();
    let names = |made: &v1::PointCloud| -> Vec<String> {
        made.fields.iter().map(|field| field.name.clone()).collect()
    };
    message.data = &little;
    let made = convert(&message).unwrap();
    assert_eq!(names(&made), ["x", "y", "z", "rgb", "rgba", "r"]);
    assert_eq!(made.data, little);
    message.data = &big;
    message.is_bigendian = true;
    let made = convert(&message).unwrap();
    assert_eq!(names(&made), ["x", "y", "z", "rgb", "rgba"]);
    assert_eq!(made.data, little);
}
