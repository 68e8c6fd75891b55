//! Convex pieces of a mesh, for physics.

mod merge;
mod vessel;

use std::panic::{AssertUnwindSafe, catch_unwind};

use nalgebra::{Point3, Vector3};
use parry3d::math::Vector;
use parry3d::transformation::vhacd::{VHACD, VHACDParameters};
use parry3d::transformation::voxelization::FillMode;

use self::merge::{MergeLimits, merged};
use self::vessel::vessel;
use crate::hull::{hull, simplified};
use crate::mesh::Mesh;
use crate::object::ConvexPiece;

pub use self::merge::MAX_PIECES;

/// The most vertices of a piece.
pub const MAX_PIECE_VERTICES: usize = 48;

/// A mesh that fills this share of its hull counts as convex.
const CONVEX_SHARE: f64 = 0.97;

/// Two pieces become one where that adds less than this share of the object's hull, or leaves all
/// of them together as close to the mesh as a convex one is to its hull.
const MERGE_SHARE: f64 = 0.002;

/// A simplified piece lies within this share of its size of the whole one, and within
/// [`TOLERANCE_M`].
const TOLERANCE_SHARE: f64 = 0.02;

/// The greatest distance between a simplified piece and the whole one, unless vertices run out.
const TOLERANCE_M: f64 = 0.001;

/// A mesh whose pieces hold this share of its hull as air may be a vessel, whose cut is looked for.
const HOLLOW_SHARE: f64 = 0.1;

/// Voxels along the longest side of the decomposed mesh.
const VOXELS: u32 = 40;

/// Between 1 and [`MAX_PIECES`] convex pieces that together approximate a mesh; none where it has
/// no volume.
///
/// A mesh that nearly fills its hull is one piece. Others are cut by V-HACD; its pieces, more than
/// asked for, are merged, the pair that adds the least volume first. Where much air is left in
/// them, the cut of a vessel into a floor and sectors of its wall replaces them if it holds less.
/// Deterministic.
pub fn convex_pieces(mesh: &Mesh) -> Vec<ConvexPiece> {
    pieces_of_volume(mesh, mesh.signed_volume_m3())
}

/// The [`convex_pieces`] of a mesh whose parts fill a volume, which may be less than it encloses
/// where they overlap.
pub(crate) fn pieces_of_volume(mesh: &Mesh, volume_m3: f64) -> Vec<ConvexPiece> {
    let Some(whole) = hull(&mesh.vertices) else {
        return Vec::new();
    };
    let hull_volume_m3 = whole.signed_volume_m3();
    let mut pieces = if volume_m3 >= CONVEX_SHARE * hull_volume_m3 {
        Vec::new()
    } else {
        let limits = MergeLimits {
            added_m3: MERGE_SHARE * hull_volume_m3,
            total_m3: volume_m3 + (1.0 - CONVEX_SHARE) * hull_volume_m3,
        };
        let pieces = merged(decomposed(mesh), &limits);
        let total_m3 = if pieces.is_empty() {
            hull_volume_m3
        } else {
            total_m3(&pieces)
        };
        let air_m3 = total_m3 - volume_m3;
        let hollow =
            (air_m3 > HOLLOW_SHARE * hull_volume_m3).then(|| vessel(mesh, volume_m3, total_m3));
        hollow.flatten().unwrap_or(pieces)
    };
    if pieces.is_empty() {
        pieces.push(whole);
    }
    pieces.into_iter().map(piece).collect()
}

fn total_m3(hulls: &[Mesh]) -> f64 {
    hulls.iter().map(Mesh::signed_volume_m3).sum()
}

/// A hull as a piece of at most [`MAX_PIECE_VERTICES`] vertices.
pub(crate) fn piece(hull_mesh: Mesh) -> ConvexPiece {
    let size_m = hull_mesh
        .bounds()
        .map_or(0.0, |bounds| bounds.extents_m().max());
    let tolerance_m = TOLERANCE_M.min(TOLERANCE_SHARE * size_m);
    ConvexPiece {
        vertices: simplified(hull_mesh, MAX_PIECE_VERTICES, tolerance_m).vertices,
    }
}

/// The hulls of the surface within each part that V-HACD cuts a mesh into; none where it fails.
fn decomposed(mesh: &Mesh) -> Vec<Mesh> {
    let Some(bounds) = mesh.bounds() else {
        return Vec::new();
    };
    let size_m = bounds.extents_m().max();
    if !size_m.is_finite() || size_m <= 0.0 {
        return Vec::new();
    }
    // parry's tolerances are meant for a size near one around the origin.
    let centre = nalgebra::center(&bounds.lowest, &bounds.highest);
    let scaled = |point: &Point3<f64>| {
        let scaled = ((point - centre) / size_m).cast::<f32>();
        Vector::new(scaled.x, scaled.y, scaled.z)
    };
    let unscaled =
        |point: &Vector| centre + Vector3::new(point.x, point.y, point.z).cast::<f64>() * size_m;
    let points: Vec<_> = mesh.vertices.iter().map(scaled).collect();
    let parameters = VHACDParameters {
        concavity: 0.005,
        resolution: VOXELS,
        // Cutting finer and merging leaves less air in the pieces than cutting to the number asked
        // for.
        max_convex_hulls: 2 * MAX_PIECES as u32,
        fill_mode: FillMode::FloodFill {
            detect_cavities: false,
        },
        ..VHACDParameters::default()
    };
    // It asserts and indexes where rounding defeats it, which depends on the mesh of a user. What
    // it leaves half done is its own.
    let parts = catch_unwind(AssertUnwindSafe(|| {
        VHACD::decompose(&parameters, &points, &mesh.triangles, true)
            .compute_primitive_intersections(&points, &mesh.triangles)
    }));
    parts
        .unwrap_or_default()
        .iter()
        .filter_map(|part| hull(&part.iter().map(unscaled).collect::<Vec<_>>()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Bounds;
    use crate::shapes::{ball, tube};

    fn volume_m3(pieces: &[ConvexPiece]) -> f64 {
        pieces
            .iter()
            .map(|piece| hull(&piece.vertices).unwrap().signed_volume_m3())
            .sum()
    }

    #[test]
    fn a_convex_mesh_is_one_piece() {
        let pieces = convex_pieces(&Mesh::cuboid([0.4, 0.0, 0.0], [0.5, 0.1, 0.1]));
        assert_eq!(pieces.len(), 1);
        assert_eq!(pieces[0].vertices.len(), 8);
        let pieces = convex_pieces(&ball(0.05, 40, 30));
        assert_eq!(pieces.len(), 1);
        assert!(pieces[0].vertices.len() <= MAX_PIECE_VERTICES);
    }

    #[test]
    fn a_tube_stays_hollow() {
        let mesh = tube(0.04, 0.037, 0.1, 40);
        let pieces = convex_pieces(&mesh);
        assert!((2..=MAX_PIECES).contains(&pieces.len()));
        let whole_m3 = hull(&mesh.vertices).unwrap().signed_volume_m3();
        assert!(volume_m3(&pieces) < 0.6 * whole_m3);
        // The axis is free.
        for height in 1..10 {
            let at = Point3::new(0.0, 0.0, f64::from(height) * 0.01);
            for piece in &pieces {
                let planes = crate::hull::planes(&hull(&piece.vertices).unwrap());
                assert!(
                    planes
                        .iter()
                        .any(|(normal, offset)| normal.dot(&at.coords) > *offset)
                );
            }
        }
    }

    #[test]
    fn many_parts_make_no_more_than_the_most_pieces() {
        let mut mesh = Mesh::default();
        for index in 0..20 {
            let at = [f64::from(index % 5), f64::from(index / 5), 0.0].map(|step| step * 0.03);
            mesh.append(&Mesh::cuboid(at, at.map(|side| side + 0.01)));
        }
        let pieces = convex_pieces(&mesh);
        assert_eq!(pieces.len(), MAX_PIECES);
        let points: Vec<_> = pieces
            .iter()
            .flat_map(|piece| piece.vertices.clone())
            .collect();
        let extents = Bounds::of(&points).unwrap().extents_m();
        assert!((extents - mesh.bounds().unwrap().extents_m()).norm() < 2e-3);
    }

    #[test]
    fn the_same_mesh_gives_the_same_pieces() {
        let mesh = tube(0.04, 0.03, 0.1, 24);
        assert_eq!(convex_pieces(&mesh), convex_pieces(&mesh));
        assert!(convex_pieces(&Mesh::default()).is_empty());
    }
}
