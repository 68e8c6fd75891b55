//! Poses in which an object rests on a flat floor.

#![allow(
    clippy::indexing_slicing,
    reason = "facets and triangles are numbered by the vectors that hold them"
)]

use std::collections::HashMap;
use std::f64::consts::TAU;

use nalgebra::{Point3, UnitQuaternion, Vector3};

use crate::hull::{hull, sides};
use crate::mesh::Mesh;
use crate::object::RestingPose;

/// Triangles of the hull within this angle of each other make one facet to stand on, in radians.
const COPLANAR_RAD: f64 = 0.01;

/// Poses less likely than this are left out.
const MIN_PROBABILITY: f64 = 0.001;

/// The poses in which a mesh rests, the most probable first; none where the mesh has no volume.
///
/// An object lands on a facet of its hull with the probability of the facet's solid angle seen from
/// the centre of mass, and rolls over edges until the centre of mass is above the facet it lies on.
/// Poses of less than 0.1 % are left out unless there is no other.
pub fn resting_poses(mesh: &Mesh, centre_of_mass_m: &Point3<f64>) -> Vec<RestingPose> {
    let Some(hull) = hull(&mesh.vertices) else {
        return Vec::new();
    };
    let facets = facets(&hull, centre_of_mass_m);
    let mut share = vec![0.0; facets.len()];
    for (start, facet) in facets.iter().enumerate() {
        share[rest(&facets, start)] += facet.solid_angle / (2.0 * TAU);
    }
    let mut poses: Vec<RestingPose> = facets
        .iter()
        .zip(share)
        .map(|(facet, probability)| RestingPose {
            rotation: downwards(&facet.normal),
            probability,
        })
        .collect();
    poses.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    let likely = poses
        .iter()
        .take_while(|pose| pose.probability >= MIN_PROBABILITY)
        .count();
    poses.truncate(likely.max(1));
    poses
}

/// The facet on which an object rests that lands on facet `start`.
fn rest(facets: &[Facet], start: usize) -> usize {
    let mut at = start;
    // Each roll lowers the centre of mass, so no facet comes twice, but for rounding.
    for _ in 0..facets.len() {
        match facets[at].roll {
            Some(next) => at = next,
            None => break,
        }
    }
    at
}

/// The shortest turn that makes a direction point down.
fn downwards(normal: &Vector3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between(normal, &-Vector3::z()).unwrap_or_else(|| {
        UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
    })
}

/// A flat part of a hull.
struct Facet {
    normal: Vector3<f64>,
    /// Solid angle of the facet seen from the centre of mass, in steradians.
    solid_angle: f64,
    /// Facet on which an object rolls that lies on this one; `None` where it rests.
    roll: Option<usize>,
}

fn facets(hull: &Mesh, centre: &Point3<f64>) -> Vec<Facet> {
    let corners: Vec<[Point3<f64>; 3]> = hull.corners().collect();
    let areas: Vec<Vector3<f64>> = corners
        .iter()
        .map(|[a, b, c]| (b - a).cross(&(c - a)))
        .collect();
    let triangle_of: HashMap<(u32, u32), usize> = hull
        .triangles
        .iter()
        .enumerate()
        .flat_map(|(triangle, corners)| sides(*corners).map(|side| (side, triangle)))
        .collect();
    let neighbours = |triangle: usize| {
        let sides = sides(hull.triangles[triangle]);
        sides.map(|(from, to)| (from, to, triangle_of.get(&(to, from)).copied()))
    };
    let members = grouped(&areas, |triangle| {
        neighbours(triangle).map(|(_, _, other)| other)
    });
    let mut facet_of = vec![0; corners.len()];
    for (facet, members) in members.iter().enumerate() {
        members
            .iter()
            .for_each(|triangle| facet_of[*triangle] = facet);
    }
    let facet = |(facet, members): (usize, &Vec<usize>)| {
        let area: Vector3<f64> = members.iter().map(|triangle| areas[*triangle]).sum();
        let normal = area.try_normalize(0.0).unwrap_or_else(Vector3::z);
        let border = members
            .iter()
            .flat_map(|triangle| neighbours(*triangle))
            .filter_map(|(from, to, other)| {
                let neighbour = facet_of[other?];
                let ends = (
                    *hull.vertices.get(from as usize)?,
                    *hull.vertices.get(to as usize)?,
                );
                (neighbour != facet).then_some((ends, neighbour))
            });
        Facet {
            normal,
            solid_angle: members
                .iter()
                .map(|triangle| solid_angle(&corners[*triangle], centre))
                .sum(),
            roll: roll(border, &normal, centre),
        }
    };
    members.iter().enumerate().map(facet).collect()
}

/// Groups of connected triangles that face nearly the same way, each around its largest.
fn grouped(
    areas: &[Vector3<f64>],
    neighbours: impl Fn(usize) -> [Option<usize>; 3],
) -> Vec<Vec<usize>> {
    let mut largest_first: Vec<usize> = (0..areas.len()).collect();
    largest_first.sort_by(|a, b| areas[*b].norm().total_cmp(&areas[*a].norm()));
    let mut free = vec![true; areas.len()];
    let mut groups = Vec::new();
    for seed in largest_first {
        if !free[seed] {
            continue;
        }
        free[seed] = false;
        let mut group = vec![seed];
        let mut next = 0;
        while let Some(triangle) = group.get(next).copied() {
            next += 1;
            for other in neighbours(triangle).into_iter().flatten() {
                // A triangle without area has no direction of its own.
                let flat = areas[other].norm() <= 1e-9 * areas[seed].norm();
                if free[other] && (flat || areas[seed].angle(&areas[other]) < COPLANAR_RAD) {
                    free[other] = false;
                    group.push(other);
                }
            }
        }
        groups.push(group);
    }
    groups
}

/// The neighbour that an object rolls to: over the nearest edge that the centre of mass is beyond.
fn roll(
    border: impl Iterator<Item = ((Point3<f64>, Point3<f64>), usize)>,
    normal: &Vector3<f64>,
    centre: &Point3<f64>,
) -> Option<usize> {
    let beyond = border.filter_map(|((from, to), neighbour)| {
        let along = to - from;
        let outward = along.cross(normal).try_normalize(0.0)?;
        let out = (centre - from).dot(&outward);
        // The projection onto the facet, and from there to the nearest point of the edge.
        let projected = centre - normal * (centre - from).dot(normal);
        let share = (projected - from).dot(&along) / along.norm_squared();
        let nearest = from + along * share.clamp(0.0, 1.0);
        (out > 1e-9).then(|| (nalgebra::distance(&projected, &nearest), neighbour))
    });
    beyond
        .min_by(|(a, _), (b, _)| a.total_cmp(b))
        .map(|(_, neighbour)| neighbour)
}

/// The solid angle of a triangle seen from a point, in steradians (Van Oosterom and Strackee).
fn solid_angle(corners: &[Point3<f64>; 3], from: &Point3<f64>) -> f64 {
    let [a, b, c] = corners.map(|corner| corner - from);
    let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
    let determinant = a.dot(&b.cross(&c)).abs();
    let divisor = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
    2.0 * determinant.atan2(divisor)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mass::mass_properties;
    use crate::shapes::{ball, cube};

    fn poses(mesh: &Mesh) -> Vec<RestingPose> {
        resting_poses(mesh, &mass_properties(mesh, 400.0).centre_of_mass_m)
    }

    #[test]
    fn a_cube_rests_on_each_face_alike() {
        let poses = poses(&cube(0.1));
        assert_eq!(poses.len(), 6);
        for pose in &poses {
            assert!((pose.probability - 1.0 / 6.0).abs() < 1e-9);
            let turned = cube(0.1).transformed(&nalgebra::convert(pose.rotation));
            let extents = turned.bounds().unwrap().extents_m();
            assert!((extents.z - 0.1).abs() < 1e-9);
        }
    }

    #[test]
    fn a_tall_box_seldom_stands() {
        let mesh = Mesh::cuboid([0.3, 0.0, -1.0], [0.32, 0.03, -0.8]);
        let poses = poses(&mesh);
        assert_eq!(poses.len(), 6);
        let height = |pose: &RestingPose| {
            let turned = mesh.transformed(&nalgebra::convert(pose.rotation));
            turned.bounds().unwrap().extents_m().z
        };
        assert!((height(&poses[0]) - 0.02).abs() < 1e-9);
        assert!((height(&poses[5]) - 0.2).abs() < 1e-9);
        assert!(poses[5].probability < 0.02);
    }

    #[test]
    fn a_leaning_column_does_not_stand() {
        let mut mesh = Mesh::cuboid([0.0; 3], [0.1, 0.1, 0.3]);
        mesh.vertices
            .iter_mut()
            .for_each(|vertex| vertex.x += vertex.z);
        let poses = poses(&mesh);
        assert_eq!(poses.len(), 4);
        for pose in poses {
            assert!(
                (pose.rotation * Vector3::z()).z.abs() < 0.9,
                "it stands on an end"
            );
        }
    }

    #[test]
    fn probabilities_add_up() {
        let sum: f64 = poses(&ball(0.05, 12, 9))
            .iter()
            .map(|pose| pose.probability)
            .sum();
        assert!((sum - 1.0).abs() < 1e-9, "{sum}");
        assert!(resting_poses(&Mesh::default(), &Point3::origin()).is_empty());
    }
}
