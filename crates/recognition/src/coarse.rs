//! The first cut: which objects, poses and yaws are worth a closer look.

use nalgebra::{Isometry3, Point2, Translation3, UnitQuaternion, Vector3};

use crate::library::{Library, PoseTemplate};
use crate::outline::{Outline, UpperSurface};

/// Yaws that are tried.
const YAWS: usize = 60;

/// Cells of the cluster that heights are compared at.
const CELLS: usize = 110;

/// A height counts as this different at most, in metres.
const MAX_DIFFERENCE_M: f32 = 0.012;

/// Templates whose outlines differ by more do not go on: some eight deviations in each number.
const MAX_OUTLINE_DIFFERENCE: f64 = 400.0;

/// The most yaws of one template that go on.
const YAWS_EACH: usize = 3;

/// Yaws nearer than this to a better one do not go on, in steps.
const APART: usize = 3;

/// An object in a resting pose at a place and yaw.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Hypothesis {
    pub(crate) object: usize,
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
pub(crate) fn hypotheses(
    library: &Library,
    seen: &UpperSurface,
    outline: &Outline,
    cut: Cut,
) -> Vec<Hypothesis> {
    let mut templates: Vec<(f64, usize, &PoseTemplate)> = Vec::new();
    for (object, entry) in library.objects.iter().enumerate() {
        for template in &entry.poses {
            let difference = template.outline.difference(outline);
            if difference <= MAX_OUTLINE_DIFFERENCE {
                templates.push((difference, object, template));
            }
        }
    }
    templates.sort_by(|a, b| a.0.total_cmp(&b.0));
    templates.truncate(cut.templates);
    let places = places(seen, outline);
    let mut found: Vec<Hypothesis> = templates
        .iter()
        .flat_map(|(_, object, template)| best_yaws(*object, template, outline, &places))
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
    let step = covered.len() as f64 / CELLS as f64;
    if step <= 1.0 {
        return covered;
    }
    let chosen = (0..CELLS).filter_map(|number| covered.get((number as f64 * step) as usize));
    chosen.copied().collect()
}

/// The yaws at which a template's heights are most like those seen.
fn best_yaws(
    object: usize,
    template: &PoseTemplate,
    outline: &Outline,
    places: &[(Point2<f64>, f32)],
) -> Vec<Hypothesis> {
    let differences: Vec<f32> = (0..YAWS)
        .map(|step| {
            let (sin, cos) = yaw_rad(step).sin_cos();
            let sum: f32 = places
                .iter()
                .map(|(place, height_m)| {
                    // The template is turned by the yaw; so the place is turned back.
                    let back =
                        Point2::new(cos * place.x + sin * place.y, cos * place.y - sin * place.x);
                    (template.surface.at(&back) - height_m)
                        .abs()
                        .min(MAX_DIFFERENCE_M)
                })
                .sum();
            sum / places.len().max(1) as f32
        })
        .collect();
    let mut order: Vec<(usize, f32)> = differences.into_iter().enumerate().collect();
    order.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut chosen: Vec<usize> = Vec::with_capacity(YAWS_EACH);
    let mut found = Vec::with_capacity(YAWS_EACH);
    for (step, difference_m) in order {
        let is_near = |other: &usize| {
            let apart = step.abs_diff(*other);
            apart.min(YAWS - apart) < APART
        };
        if chosen.len() >= YAWS_EACH {
            break;
        }
        if chosen.iter().any(is_near) {
            continue;
        }
        chosen.push(step);
        let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad(step));
        let place = Translation3::new(outline.centre.x, outline.centre.y, 0.0);
        found.push(Hypothesis {
            object,
            support_from_item: place * yaw * template.support_from_item,
            difference_m,
        });
    }
    found
}

fn yaw_rad(step: usize) -> f64 {
    std::f64::consts::TAU * step as f64 / YAWS as f64
}
