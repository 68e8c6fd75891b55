//! Options of what sees a simulated cell.

use clap::Args;
use ppnpack_physics::view::{CameraSettings, NoiseModel};

use super::choice::{Choice, one_of};
use crate::length::{parse_distance, parse_length};

/// What sees the container of a simulated cell.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "View of the container")]
pub struct ViewOptions {
    /// What sees the container
    #[arg(long, value_parser = one_of(&VIEWS), default_value = "exact")]
    view: View,

    /// With --view camera: one above the middle of the container, or two beside it
    #[arg(long, value_name = "COUNT", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=2))]
    cameras: u8,

    /// With --view camera: how far above the floor
    #[arg(long, value_name = "LENGTH", default_value = "90cm", value_parser = parse_length, allow_hyphen_values = true)]
    camera_height: f64,

    /// With --view camera: the standard deviation of its noise
    #[arg(long, value_name = "LENGTH", default_value = "1mm", value_parser = parse_distance, allow_hyphen_values = true)]
    camera_noise: f64,

    /// With --view camera: the share of pixels that measure nothing, from 0 to 1
    #[arg(
        long,
        value_name = "SHARE",
        default_value_t = 0.05,
        allow_hyphen_values = true
    )]
    dropouts: f64,
}

/// What sees the container.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum View {
    Exact,
    Camera,
}

const VIEWS: [Choice<View>; 2] = [
    ("exact", View::Exact, "An exact scan from above"),
    (
        "camera",
        View::Camera,
        "Depth cameras above, with noise and dropouts",
    ),
];

impl ViewOptions {
    /// The cameras that are asked for; without any the container is scanned exactly.
    pub fn camera(&self, seed: u64) -> Option<CameraSettings> {
        (self.view == View::Camera).then(|| CameraSettings {
            cameras: self.cameras.into(),
            height_m: self.camera_height,
            noise: NoiseModel {
                sigma_m: self.camera_noise,
                dropout: self.dropouts,
                ..NoiseModel::default()
            },
            seed,
            ..CameraSettings::default()
        })
    }
}
