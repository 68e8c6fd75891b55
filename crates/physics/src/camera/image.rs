//! Depth images, and what is made of them.

use nalgebra::{Isometry3, Point3};
use ppnpack_numbers::require;
use ppnpack_packing::grid::Grid;
use ppnpack_packing::heightmap::{Scene, Surface};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::{DepthCamera, DepthNoise};
use crate::error::PhysicsError;

/// What a depth camera sees.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthImage {
    camera: DepthCamera,
    depths_m: Vec<f32>,
}

/// Points that a camera sees.
#[derive(Debug, Clone, PartialEq)]
pub struct PointCloud {
    /// The points in the camera frame, in metres, in the order of the pixels; pixels that see nothing are left out.
    pub points_m: Vec<Point3<f32>>,
    /// Where the camera is.
    pub container_from_camera: Isometry3<f64>,
}

impl DepthImage {
    pub(super) fn new(camera: DepthCamera, depths_m: Vec<f32>) -> Self {
        Self { camera, depths_m }
    }

    /// The camera that it was seen by.
    pub fn camera(&self) -> &DepthCamera {
        &self.camera
    }

    /// The depths along the camera's z axis in metres, row by row; NaN where nothing is seen.
    pub fn depths_m(&self) -> &[f32] {
        &self.depths_m
    }

    /// The depth at column `u` of row `v`, in metres; `None` where nothing is seen and outside the image.
    pub fn depth_m(&self, u: usize, v: usize) -> Option<f32> {
        if u >= self.camera.width_px {
            return None;
        }
        let depth_m = self.depths_m.get(v * self.camera.width_px + u)?;
        (!depth_m.is_nan()).then_some(*depth_m)
    }

    /// The image as a noisy sensor would give it; equal seeds give equal noise.
    ///
    /// # Errors
    /// [`PhysicsError::Setting`] where the noise is impossible.
    pub fn with_noise(&self, noise: &DepthNoise, seed: u64) -> Result<Self, PhysicsError> {
        noise.validate()?;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let noisy = self
            .depths_m
            .iter()
            .map(|depth_m| noise.apply(*depth_m, &mut random));
        Ok(Self {
            camera: self.camera.clone(),
            depths_m: noisy.collect(),
        })
    }

    /// The points seen.
    pub fn to_point_cloud(&self) -> PointCloud {
        PointCloud {
            points_m: self.points_m().map(|point| point.cast()).collect(),
            container_from_camera: self.camera.container_from_camera,
        }
    }

    /// The surface of the container's content as far as it was seen: each sample is the highest point in its square,
    /// and a square that no pixel saw takes the highest of its nearest seen neighbours.
    ///
    /// Points within `wall_margin_m` of the walls' inner faces, or beyond them, are left out: they may show the wall
    /// itself. 0.5 mm suffices without noise, some standard deviations with it.
    ///
    /// # Errors
    /// [`PhysicsError::NothingSeen`] where no pixel sees the grid, [`PhysicsError::Setting`] for an impossible margin.
    pub fn to_surface(&self, grid: &Grid, wall_margin_m: f64) -> Result<Surface, PhysicsError> {
        let is_margin = |margin: f64| margin >= 0.0;
        require(
            "the margin to the walls",
            wall_margin_m,
            "at least 0 m",
            is_margin,
        )?;
        let empty = Surface::empty(grid);
        let (nx, ny, pitch_m) = (empty.nx(), empty.ny(), empty.pitch_m());
        let container = grid.container();
        let is_within =
            |value: f64, side_m: f64| (wall_margin_m..=side_m - wall_margin_m).contains(&value);
        let mut heights_m: Vec<Option<f32>> = vec![None; nx * ny];
        for point in self.points_m() {
            let point = self.camera.container_from_camera * point;
            if !is_within(point.x, container.x_m) || !is_within(point.y, container.y_m) {
                continue;
            }
            let [x, y] = [point.x, point.y].map(|value| (value / pitch_m) as usize);
            // A container that is no multiple of the cell has a strip beside the grid.
            if x < nx
                && y < ny
                && let Some(height_m) = heights_m.get_mut(x * ny + y)
            {
                let seen_m = point.z.max(0.0) as f32;
                *height_m = Some(height_m.map_or(seen_m, |other| other.max(seen_m)));
            }
        }
        let heights_m = filled(heights_m, nx, ny).ok_or(PhysicsError::NothingSeen)?;
        Ok(Surface::from_metres(nx, ny, pitch_m, heights_m)?)
    }

    /// The scene made of [`to_surface`](Self::to_surface): the surface and its heightmap.
    ///
    /// # Errors
    /// As [`to_surface`](Self::to_surface).
    pub fn to_scene(&self, grid: &Grid, wall_margin_m: f64) -> Result<Scene, PhysicsError> {
        Ok(Scene::from_surface(
            grid,
            self.to_surface(grid, wall_margin_m)?,
        )?)
    }

    /// The points seen, in the camera frame, in metres.
    fn points_m(&self) -> impl Iterator<Item = Point3<f64>> + '_ {
        let rows = self.depths_m.chunks_exact(self.camera.width_px).enumerate();
        rows.flat_map(move |(v, row)| {
            let seen = row
                .iter()
                .enumerate()
                .filter(|(_, depth_m)| !depth_m.is_nan());
            seen.map(move |(u, depth_m)| {
                self.camera
                    .unproject(u as f64, v as f64, f64::from(*depth_m))
            })
        })
    }
}

impl PointCloud {
    /// The points in the container frame, in metres.
    pub fn in_container_m(&self) -> impl Iterator<Item = Point3<f64>> + '_ {
        self.points_m
            .iter()
            .map(|point| self.container_from_camera * point.cast::<f64>())
    }
}

/// Fills what was not seen from the outside inwards, each with the highest of its eight neighbours; `None` where
/// nothing was seen at all.
///
/// What hides a square from a camera above is most often the higher of its neighbours, and space that is taken for
/// full costs less than an item that is pressed into another.
fn filled(mut heights_m: Vec<Option<f32>>, nx: usize, ny: usize) -> Option<Vec<f32>> {
    if heights_m.iter().all(Option::is_none) {
        return None;
    }
    let mut unseen: Vec<usize> = heights_m
        .iter()
        .enumerate()
        .filter_map(|(index, height_m)| height_m.is_none().then_some(index))
        .collect();
    while !unseen.is_empty() {
        let highest_neighbour_m = |index: &usize| {
            let (x, y) = (index / ny, index % ny);
            let rows = x.saturating_sub(1)..(x + 2).min(nx);
            rows.flat_map(|x| (y.saturating_sub(1)..(y + 2).min(ny)).map(move |y| x * ny + y))
                .filter_map(|neighbour| heights_m.get(neighbour).copied().flatten())
                .reduce(f32::max)
        };
        let found: Vec<(usize, Option<f32>)> = unseen
            .iter()
            .map(|index| (*index, highest_neighbour_m(index)))
            .collect();
        unseen.clear();
        for (index, height_m) in found {
            match (height_m, heights_m.get_mut(index)) {
                (Some(height_m), Some(place)) => *place = Some(height_m),
                _ => unseen.push(index),
            }
        }
    }
    heights_m.into_iter().collect()
}
