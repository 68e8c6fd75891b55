//! Forty evaluations of one object on one container by an independent implementation.
//!
//! `cases.npz` holds the arrays of all cases end to end, row-major.
#![allow(dead_code, reason = "each test uses some of these")]
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a panic in a test is a failing test"
)]

use std::fs::File;

use ndarray::{Array1, Array2, OwnedRepr};
use ndarray_npy::{NpzReader, ReadableElement};

/// Cells of the container along x and y.
const SIDE: usize = 32;

/// One object on one container; results are by the offset of its footprint.
pub(crate) struct Case {
    pub(crate) name: String,
    /// Index of the object's yaw.
    pub(crate) yaw: usize,
    /// Heights in units of 0.2 cm.
    pub(crate) container: Array2<i16>,
    pub(crate) top: Array2<i16>,
    pub(crate) bottom: Array2<i16>,
    pub(crate) height: i16,
    /// Resting heights; -1 where the object does not fit.
    pub(crate) drop: Array2<i16>,
    /// 1 where the published test accepts it.
    pub(crate) stable: Array2<u8>,
    /// Values with the balance term.
    pub(crate) sdf: Array2<f32>,
    pub(crate) dbl: Array2<f32>,
    pub(crate) hm: Array2<f32>,
}

/// An array whose entries are handed out from case to case.
struct Entries<T>(std::vec::IntoIter<T>);

impl<T: ReadableElement + Clone> Entries<T> {
    fn read(npz: &mut NpzReader<File>, name: &str) -> Self {
        let array: Array1<T> = npz.by_name::<OwnedRepr<T>, _>(name).unwrap();
        Self(array.into_raw_vec_and_offset().0.into_iter())
    }

    fn next(&mut self, count: usize) -> Vec<T> {
        let next: Vec<T> = self.0.by_ref().take(count).collect();
        assert_eq!(next.len(), count);
        next
    }

    fn map(&mut self, size: (usize, usize)) -> Array2<T> {
        Array2::from_shape_vec(size, self.next(size.0 * size.1)).unwrap()
    }
}

/// All cases.
pub(crate) fn cases() -> Vec<Case> {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../packing/tests/golden/cases.npz"
    );
    let mut npz = NpzReader::new(File::open(path).unwrap()).unwrap();
    let footprints: Array2<u16> = npz.by_name("footprint").unwrap();
    let mut yaws = Entries::<i16>::read(&mut npz, "yaw");
    let mut heights = Entries::<i16>::read(&mut npz, "height");
    let mut containers = Entries::<i16>::read(&mut npz, "container");
    let mut tops = Entries::<i16>::read(&mut npz, "object_top");
    let mut bottoms = Entries::<i16>::read(&mut npz, "object_bottom");
    let mut drops = Entries::<i16>::read(&mut npz, "drop");
    let mut stable = Entries::<u8>::read(&mut npz, "stable");
    let [mut sdf, mut dbl, mut hm] =
        ["sdf", "dbl", "hm"].map(|name| Entries::<f32>::read(&mut npz, name));
    let case = |(index, footprint): (usize, ndarray::ArrayView1<'_, u16>)| {
        let (nx, ny) = (usize::from(footprint[0]), usize::from(footprint[1]));
        let offsets = (SIDE + 1 - nx, SIDE + 1 - ny);
        Case {
            name: format!("case {index}"),
            yaw: yaws.next(1)[0] as usize,
            container: containers.map((SIDE, SIDE)),
            top: tops.map((nx, ny)),
            bottom: bottoms.map((nx, ny)),
            height: heights.next(1)[0],
            drop: drops.map(offsets),
            stable: stable.map(offsets),
            sdf: sdf.map(offsets),
            dbl: dbl.map(offsets),
            hm: hm.map(offsets),
        }
    };
    footprints.outer_iter().enumerate().map(case).collect()
}
