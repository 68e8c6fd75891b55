//! Exact conservative rasterisation: the squares that a triangle passes over, and its heights
//! there.

use std::ops::Range;

use nalgebra::{Isometry3, Point2, Point3};

use super::mesh::{Bounds, Mesh};
use crate::kernel::heightmap::Surface;

/// How far a triangle must reach into a square to touch it, in metres.
///
/// A length of a whole number of squares covers that many, whatever its last bits.
pub const SLACK_M: f64 = 1e-6;

/// The slack never exceeds this share of a square.
const SLACK_SHARE: f64 = 0.01;

/// Squares in the plane: square `(x, y)` covers `[x, x + 1) x [y, y + 1)` pitches from the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Raster {
    /// The corner of square (0, 0), in metres.
    pub origin: Point2<f64>,
    /// The edge of a square, in metres.
    pub pitch_m: f64,
    /// Squares along x.
    pub nx: usize,
    /// Squares along y.
    pub ny: usize,
}

/// Calls `visit(x, y, lowest, highest)` for each square that a triangle's projection touches, with
/// the least and greatest z of the triangle within that square, in metres.
///
/// Exact: the range is that of the triangle clipped to the square, less [`SLACK_M`] along its
/// border. Squares outside and triangles that are not finite are left out; no square comes twice.
pub fn rasterise(
    triangle: &[Point3<f64>; 3],
    raster: &Raster,
    mut visit: impl FnMut(usize, usize, f64, f64),
) {
    let scale = 1.0 / raster.pitch_m;
    // x and y in pitches from the raster's origin, z in metres.
    let mut corners = triangle.map(|corner| {
        let x = (corner.x - raster.origin.x) * scale;
        let y = (corner.y - raster.origin.y) * scale;
        Point3::new(x, y, corner.z)
    });
    if !corners
        .iter()
        .all(|corner| (corner.x + corner.y + corner.z).is_finite())
    {
        return;
    }
    corners.sort_unstable_by(|a, b| a.x.total_cmp(&b.x));
    let [left, middle, right] = corners;
    let slack = (SLACK_M * scale).min(SLACK_SHARE);
    let sides = [
        Side::new(left, middle),
        Side::new(middle, right),
        Side::new(left, right),
    ];
    for x in touched(left.x, right.x, raster.nx, slack) {
        let strip = Strip::new(&sides, x as f64 + slack, (x + 1) as f64 - slack);
        let (front, back) = strip.range();
        for y in touched(front, back, raster.ny, slack) {
            let (lowest, highest) = strip.heights(y as f64 + slack, (y + 1) as f64 - slack);
            if lowest <= highest {
                visit(x, y, lowest, highest);
            }
        }
    }
}

/// Raises a surface to the upper envelope of a mesh in a pose: its frame in that of the surface,
/// whose origin is the corner of the first sample.
///
/// Parts beside the surface are left out; heights below 0 raise nothing.
pub fn raise_surface(mesh: &Mesh, pose: &Isometry3<f64>, surface: &mut Surface) {
    let raster = Raster {
        origin: Point2::origin(),
        pitch_m: surface.pitch_m(),
        nx: surface.nx(),
        ny: surface.ny(),
    };
    let posed = mesh.transformed(pose);
    let Some(bounds) = posed.bounds() else {
        return;
    };
    if is_covered(&bounds, &raster, surface) {
        return;
    }
    // Of a closed mesh what faces up covers the rest: little is then left to clip.
    for is_upper in [true, false] {
        for triangle in posed.corners() {
            if faces_up(&triangle) == is_upper && !is_covered(&around(&triangle), &raster, surface)
            {
                rasterise(&triangle, &raster, |x, y, _, highest| {
                    surface.raise(x, y, highest.max(0.0) as f32);
                });
            }
        }
    }
}

fn around([a, b, c]: &[Point3<f64>; 3]) -> Bounds {
    Bounds {
        lowest: a.inf(b).inf(c),
        highest: a.sup(b).sup(c),
    }
}

/// Whether the outer side of a triangle is seen from above.
fn faces_up([a, b, c]: &[Point3<f64>; 3]) -> bool {
    (b.xy() - a.xy()).perp(&(c.xy() - a.xy())) > 0.0
}

/// Whether all squares that a box may touch are at least as high, so that it raises none.
fn is_covered(bounds: &Bounds, raster: &Raster, surface: &Surface) -> bool {
    let Bounds { lowest, highest } = bounds;
    let scale = 1.0 / raster.pitch_m;
    let range = |from: f64, to: f64, origin: f64, count: usize| {
        touched((from - origin) * scale, (to - origin) * scale, count, 0.0)
    };
    let (mut xs, ys) = (
        range(lowest.x, highest.x, raster.origin.x, raster.nx),
        range(lowest.y, highest.y, raster.origin.y, raster.ny),
    );
    let highest_m = highest.z as f32;
    let heights_m = surface.heights_m();
    let is_lower = |x: usize, y: usize| {
        let height_m = heights_m.get(x * surface.ny() + y);
        height_m.is_some_and(|height_m| *height_m < highest_m)
    };
    !xs.any(|x| ys.clone().any(|y| is_lower(x, y)))
}

/// The unit intervals, less `slack` at both ends, that meet the interval between two coordinates.
fn touched(from: f64, to: f64, count: usize, slack: f64) -> Range<usize> {
    // Casts round towards 0 and saturate: a negative number becomes 0.
    (from + slack) as usize..ceil(to - slack).min(count)
}

/// Rounds up, negatives to 0; the library's may be a call.
fn ceil(value: f64) -> usize {
    let whole = value as usize;
    whole.saturating_add(usize::from((whole as f64) < value))
}

/// A side of a triangle, from the corner with the lesser x.
struct Side {
    from: Point3<f64>,
    to: Point3<f64>,
    /// Change of y and z per x.
    slopes: (f64, f64),
}

impl Side {
    fn new(from: Point3<f64>, to: Point3<f64>) -> Self {
        let along = to.x - from.x;
        // Without extent along x, no point but the ends is ever asked for.
        let per_x = if along > 0.0 { 1.0 / along } else { 0.0 };
        Self {
            from,
            to,
            slopes: ((to.y - from.y) * per_x, (to.z - from.z) * per_x),
        }
    }

    fn at(&self, x: f64) -> (f64, f64) {
        let along = x - self.from.x;
        (
            self.from.y + along * self.slopes.0,
            self.from.z + along * self.slopes.1,
        )
    }

    fn between(&self, low: f64, high: f64) -> Segment {
        if self.from.x > high || self.to.x < low {
            return Segment::NONE;
        }
        let from = if self.from.x < low {
            self.at(low)
        } else {
            (self.from.y, self.from.z)
        };
        let to = if self.to.x > high {
            self.at(high)
        } else {
            (self.to.y, self.to.z)
        };
        Segment::new(from, to)
    }
}

/// A segment of the border of a triangle's part within a strip, seen along x; y ascends.
struct Segment {
    from: (f64, f64),
    to: (f64, f64),
    slope: f64,
}

impl Segment {
    /// Lies in no square.
    const NONE: Self = Self {
        from: (f64::INFINITY, f64::INFINITY),
        to: (f64::NEG_INFINITY, f64::NEG_INFINITY),
        slope: 0.0,
    };

    fn new(one: (f64, f64), other: (f64, f64)) -> Self {
        let (from, to) = if one.0 <= other.0 {
            (one, other)
        } else {
            (other, one)
        };
        let along = to.0 - from.0;
        let slope = if along > 0.0 {
            (to.1 - from.1) / along
        } else {
            0.0
        };
        Self { from, to, slope }
    }

    fn at(&self, y: f64) -> f64 {
        self.from.1 + (y - self.from.0) * self.slope
    }
}

/// The border of a triangle's part between two x. The extremes of a plane over a convex region lie
/// on its border, so that no more is needed.
struct Strip([Segment; 5]);

impl Strip {
    fn new(sides: &[Side; 3], low: f64, high: f64) -> Self {
        let [left_middle, middle_right, left_right] = sides;
        let cut = |x: f64| {
            if x <= left_right.from.x || x >= left_right.to.x {
                return Segment::NONE;
            }
            let bent = if x < left_middle.to.x {
                left_middle
            } else {
                middle_right
            };
            Segment::new(left_right.at(x), bent.at(x))
        };
        Self([
            left_middle.between(low, high),
            middle_right.between(low, high),
            left_right.between(low, high),
            cut(low),
            cut(high),
        ])
    }

    fn range(&self) -> (f64, f64) {
        self.0.iter().fold(
            (f64::INFINITY, f64::NEG_INFINITY),
            |(front, back), segment| (front.min(segment.from.0), back.max(segment.to.0)),
        )
    }

    fn heights(&self, low: f64, high: f64) -> (f64, f64) {
        let mut range = (f64::INFINITY, f64::NEG_INFINITY);
        for segment in &self.0 {
            if segment.from.0 > high || segment.to.0 < low {
                continue;
            }
            let from = if segment.from.0 < low {
                segment.at(low)
            } else {
                segment.from.1
            };
            let to = if segment.to.0 > high {
                segment.at(high)
            } else {
                segment.to.1
            };
            range = (range.0.min(from.min(to)), range.1.max(from.max(to)));
        }
        range
    }
}
