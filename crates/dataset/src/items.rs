//! The items of a dataset in a file, so that training needs no meshes.
//!
//! ```text
//! 8 bytes  "PPNITEMS"
//! u32      version of the format, little-endian
//! u64      size before compression, in bytes, little-endian
//! ...      zstd of the items in postcard
//! ```

use std::sync::Arc;

use nalgebra::{Point2, Vector3};
use ppnpack_packing::grid::{MAX_CELLS, Units};
use ppnpack_packing::item::{Item, ItemView, ViewSurfaces};
use serde::{Deserialize, Serialize};

use crate::files::decompress;
use crate::settings::{FORMAT_VERSION, Settings};
use crate::shard::Flaw;

const MAGIC: &[u8; 8] = b"PPNITEMS";
const LEVEL: i32 = 12;

/// The most bytes of all items before compression.
const MAX_BYTES: u64 = 1 << 30;

/// An item; its finely sampled underside is left out.
#[derive(Debug, Serialize, Deserialize)]
struct Stored {
    name: String,
    mesh_volume_m3: f64,
    views: Vec<StoredView>,
}

#[derive(Debug, Serialize, Deserialize)]
struct StoredView {
    nx: u16,
    ny: u16,
    top: Vec<Units>,
    bottom: Vec<Units>,
    origin_from_corner_m: [f64; 3],
    centre_of_mass_m: [f64; 2],
}

/// The content of the items' file; gives what is wrong with them.
pub(crate) fn encode(items: &[Arc<Item>], settings: &Settings) -> Result<Vec<u8>, String> {
    let cell_m = settings.grid.resolution().cell_m();
    let mut stored = Vec::new();
    for item in items {
        let views = item.views().iter().map(|view| StoredView::of(view, cell_m));
        let record = Stored {
            name: item.name().to_string(),
            mesh_volume_m3: item.mesh_volume_m3(),
            views: views.collect::<Result<_, String>>()?,
        };
        stored = postcard::to_extend(&record, stored).map_err(|error| error.to_string())?;
    }
    if stored.len() as u64 > MAX_BYTES {
        return Err(format!("the items have more than {MAX_BYTES} bytes"));
    }
    let mut content = MAGIC.to_vec();
    content.extend(FORMAT_VERSION.to_le_bytes());
    content.extend((stored.len() as u64).to_le_bytes());
    content.extend(zstd::encode_all(&stored[..], LEVEL).map_err(|error| error.to_string())?);
    Ok(content)
}

/// The items of a file, which must be those that the settings count.
pub(crate) fn decode(content: &[u8], settings: &Settings) -> Result<Vec<Arc<Item>>, Flaw> {
    let header = content
        .strip_prefix(MAGIC)
        .and_then(|rest| rest.split_first_chunk::<4>())
        .and_then(|(version, rest)| Some((version, rest.split_first_chunk::<8>()?)));
    let Some((version, (bytes, packed))) = header else {
        return Err("it holds no items of a dataset".to_owned().into());
    };
    let version = u32::from_le_bytes(*version);
    if version != FORMAT_VERSION {
        return Err(Flaw::Version(u64::from(version)));
    }
    let bytes = u64::from_le_bytes(*bytes);
    if bytes > MAX_BYTES {
        return Err("its items are larger than they can be".to_owned().into());
    }
    let stored = decompress(packed, bytes)?;
    let (mut rest, mut items) = (&stored[..], Vec::new());
    while !rest.is_empty() {
        let taken = postcard::take_from_bytes::<Stored>(rest);
        let (record, after) =
            taken.map_err(|error| format!("an item cannot be decoded: {error}"))?;
        items.push(Arc::new(record.item(settings)?));
        rest = after;
    }
    if items.len() != settings.objects as usize {
        let (found, expected) = (items.len(), settings.objects);
        return Err(format!("it has {found} items instead of {expected}").into());
    }
    Ok(items)
}

impl StoredView {
    fn of(view: &ItemView, cell_m: f64) -> Result<Self, String> {
        let side = |cells: usize| u16::try_from(cells).map_err(|error| error.to_string());
        let centre = view.centre_of_mass_m(cell_m);
        Ok(Self {
            nx: side(view.nx())?,
            ny: side(view.ny())?,
            top: view.top().to_vec(),
            bottom: view.bottom().to_vec(),
            origin_from_corner_m: view.origin_from_corner_m().into(),
            centre_of_mass_m: [centre.x, centre.y],
        })
    }

    /// The surfaces; gives what is wrong.
    fn surfaces(self) -> Result<ViewSurfaces, String> {
        let (nx, ny) = (usize::from(self.nx), usize::from(self.ny));
        if !(1..=MAX_CELLS).contains(&nx) || !(1..=MAX_CELLS).contains(&ny) {
            return Err(format!("its footprint has {nx} x {ny} cells"));
        }
        let (origin, centre) = (&self.origin_from_corner_m, &self.centre_of_mass_m);
        if !origin.iter().chain(centre).all(|length| length.is_finite()) {
            return Err("a length is not finite".to_owned());
        }
        Ok(ViewSurfaces {
            nx,
            ny,
            top: self.top,
            bottom: self.bottom,
            underside: None,
            origin_from_corner_m: Vector3::from(self.origin_from_corner_m),
            centre_of_mass_m: Some(Point2::from(self.centre_of_mass_m)),
        })
    }
}

impl Stored {
    /// The item; gives what is wrong.
    fn item(self, settings: &Settings) -> Result<Item, String> {
        let name = self.name;
        let wrong = |what: String| format!("item {name}: {what}");
        let (found, yaws) = (self.views.len(), settings.grid.resolution().yaws().count());
        if found != yaws {
            return Err(wrong(format!("it has {found} yaws instead of {yaws}")));
        }
        if !self.mesh_volume_m3.is_finite() {
            return Err(wrong("its volume is not finite".to_owned()));
        }
        let views = self.views.into_iter().map(StoredView::surfaces);
        let views = views.collect::<Result<_, _>>().map_err(wrong)?;
        Item::new(&name, views, self.mesh_volume_m3).map_err(|error| error.to_string())
    }
}
