//! The first cut: which objects, poses and yaws are worth a closer look.

use nalgebra::{Isometry3, Point2, Translation3, UnitQuaternion, Vector3};

use crate::object::{LibraryObject, PoseTemplate};
use crate::outline::{Outline, UpperSurface};
use crate::samples::yaws_rad;

/// What of a template is compared with a cluster.
struct CoarseSettings {
    /// Templates whose outlines differ by more do not go on: some eight deviations in each number.
    most_outline_difference: f64,
    /// Cells of the cluster that heights are compared at.
    cells: usize,
    /// A height counts as this different at most, in metres.
    most_difference_m: f32,
    /// Yaws that are tried.
    yaws: usize,
    /// The most yaws of one template that go on.
    yaws_each: usize,
    /// Yaws nearer than this to a better one do not go on, in steps.
    apart: usize,
}

const COARSE: CoarseSettings = CoarseSettings {
    most_outline_difference: 400.0,
    cells: 110,
    most_difference_m: 0.012,
    yaws: 60,
    yaws_each: 3,
    apart: 3,
};

/// An object in a resting pose at a place and yaw.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Hypothesis<'library> {
    pub(crate) object: &'library LibraryObject,
    pub(crate) support_from_item: Isometry3<f64>,
    /// The mean difference of heights, in metres.
    pub(crate) difference_m: f32,
}

/// How many templates and hypotheses go on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cut {
    pub(crate) templates: usize,
    pub(crate) hypotheses: usize,
}

/// The hypotheses most like a cluster, best first.
pub(crate) fn hypotheses<'library>(
    objects: &'library [LibraryObject],
    seen: &UpperSurface,
    outline: &Outline,
    cut: Cut,
) -> Vec<Hypothesis<'library>> {
    let mut templates: Vec<(f64, &LibraryObject, &PoseTemplate)> = Vec::new();
    for object in objects {
        for template in &object.poses {
            let difference = template.outline.difference(outline);
            if difference <= COARSE.most_outline_difference {
                templates.push((difference, object, template));
            }
        }
    }
    templates.sort_by(|a, b| a.0.total_cmp(&b.0));
    templates.truncate(cut.templates);
    let places = places(seen, outline);
    let mut found: Vec<Hypothesis<'_>> = templates
        .iter()
        .flat_map(|(_, object, template)| best_yaws(object, template, outline, &places))
        .collect();
    found.sort_by(|a, b| a.difference_m.total_cmp(&b.difference_m));
    found.truncate(cut.hypotheses);
    found
}

/// Some covered cells from the outline's centre, with their heights.
fn places(seen: &UpperSurface, outline: &Outline) -> Vec<(Point2<f64>, f32)> {
    let covered: Vec<_> = seen
        .covered()
        .map(|(place, height_m)| (place - outline.centre.coords, height_m))
        .collect();
    let step = covered.len() as f64 / COARSE.cells as f64;
    if step <= 1.0 {
        return covered;
    }
    let chosen =
        (0..COARSE.cells).filter_map(|number| covered.get((number as f64 * step) as usize));
    chosen.copied().collect()
}

/// The yaws at which a template's heights are most like those seen.
fn best_yaws<'library>(
    object: &'library LibraryObject,
    template: &PoseTemplate,
    outline: &Outline,
    places: &[(Point2<f64>, f32)],
) -> Vec<Hypothesis<'library>> {
    let differences_m = yaws_rad(COARSE.yaws).map(|yaw_rad| {
        let (sin, cos) = yaw_rad.sin_cos();
        let sum: f32 = places
            .iter()
            .map(|(place, height_m)| {
                // The template is turned by the yaw; so the place is turned back.
                let back =
                    Point2::new(cos * place.x + sin * place.y, cos * place.y - sin * place.x);
                (template.surface.at(&back) - height_m)
                    .abs()
                    .min(COARSE.most_difference_m)
            })
            .sum();
        (yaw_rad, sum / places.len().max(1) as f32)
    });
    let mut order: Vec<(usize, (f64, f32))> = differences_m.enumerate().collect();
    order.sort_by(|(_, a), (_, b)| a.1.total_cmp(&b.1));
    let mut chosen: Vec<usize> = Vec::with_capacity(COARSE.yaws_each);
    let mut found = Vec::with_capacity(COARSE.yaws_each);
    for (step, (yaw_rad, difference_m)) in order {
        let is_near = |other: &usize| {
            let apart = step.abs_diff(*other);
            apart.min(COARSE.yaws - apart) < COARSE.apart
        };
        if chosen.len() >= COARSE.yaws_each {
            break;
        }
        if chosen.iter().any(is_near) {
            continue;
        }
        chosen.push(step);
        let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad);
        let place = Translation3::new(outline.centre.x, outline.centre.y, 0.0);
        found.push(Hypothesis {
            object,
            support_from_item: place * yaw * template.support_from_item,
            difference_m,
        });
    }
    found
}
