//! The first cut: which objects, poses and yaws are worth a closer look.

use nalgebra::{Point2, Translation3, UnitQuaternion, Vector3};

use crate::object::{LibraryObject, PoseTemplate};
use crate::outline::{Outline, UpperSurface};
use crate::refinement::{Start, distinct};
use crate::samples::{spread, yaws_rad};

/// Maximum difference of outlines of templates that go on: some eight deviations in each number.
const MOST_OUTLINE_DIFFERENCE: f64 = 400.0;
/// Number of the cluster's cells that heights are compared at.
const CELLS: usize = 110;
/// Maximum difference of a height, in metres.
const MOST_DIFFERENCE_M: f32 = 0.012;
/// Number of yaws that are tried.
const YAWS: usize = 60;
/// Maximum number of yaws of one template that go on.
const YAWS_EACH: usize = 3;
/// Minimum distance from a better yaw of those that go on, in steps.
const APART: usize = 3;

/// Finds objects at a place and yaw that are most like a cluster, best first, of as many objects in
/// resting poses as asked for.
pub(crate) fn hypotheses<'library>(
    objects: &'library [LibraryObject],
    seen: &UpperSurface,
    outline: &Outline,
    count: usize,
) -> Vec<Start<'library>> {
    let all = objects.iter();
    let all = all.flat_map(|object| object.poses.iter().map(move |template| (object, template)));
    let all =
        all.map(|(object, template)| (template.outline.difference(outline), object, template));
    let mut templates: Vec<(f64, &LibraryObject, &PoseTemplate)> = all
        .filter(|(difference, ..)| *difference <= MOST_OUTLINE_DIFFERENCE)
        .collect();
    templates.sort_by(|a, b| a.0.total_cmp(&b.0));
    templates.truncate(count);
    // Some covered cells from the outline's centre, with their heights.
    let covered = seen.covered();
    let covered = covered.map(|(place, height_m)| (place - outline.centre.coords, height_m));
    let places = spread(&covered.collect::<Vec<_>>(), CELLS);
    let each = templates.iter();
    let each = each.flat_map(|(_, object, template)| best_yaws(object, template, outline, &places));
    let mut found: Vec<(f32, Start<'_>)> = each.collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.into_iter().map(|(_, start)| start).collect()
}

/// Finds the yaws at which a template's heights are most like those seen, with the mean difference,
/// in metres.
fn best_yaws<'library>(
    object: &'library LibraryObject,
    template: &PoseTemplate,
    outline: &Outline,
    places: &[(Point2<f64>, f32)],
) -> Vec<(f32, Start<'library>)> {
    let differences_m = yaws_rad(YAWS).map(|yaw_rad| {
        let (sin, cos) = yaw_rad.sin_cos();
        let differences_m = places.iter().map(|(place, height_m)| {
            // The template is turned by the yaw; so the place is turned back.
            let back = Point2::new(cos * place.x + sin * place.y, cos * place.y - sin * place.x);
            let difference_m = template.surface.at(&back) - height_m;
            difference_m.abs().min(MOST_DIFFERENCE_M)
        });
        let sum_m: f32 = differences_m.sum();
        (yaw_rad, sum_m / places.len().max(1) as f32)
    });
    let mut yaws: Vec<(usize, (f64, f32))> = differences_m.enumerate().collect();
    yaws.sort_by(|(_, a), (_, b)| a.1.total_cmp(&b.1));
    let is_near = |(one, _): &(usize, (f64, f32)), (other, _): &(usize, (f64, f32))| {
        let apart = one.abs_diff(*other);
        apart.min(YAWS - apart) < APART
    };
    let place = Translation3::new(outline.centre.x, outline.centre.y, 0.0);
    let chosen = distinct(yaws, YAWS_EACH, is_near).into_iter();
    let found = chosen.map(|(_, (yaw_rad, difference_m))| {
        let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad);
        let support_from_item = place * yaw * template.support_from_item;
        (difference_m, (object, support_from_item))
    });
    found.collect()
}
