//! The option of what sees a simulated cell.

use clap::Args;
use ppnpack_physics::packing_cell::Sampling;
use ppnpack_physics::view::CameraSettings;

use super::file;

/// What sees the container of a simulated cell.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Simulated cell")]
pub(super) struct ViewOptions {
    /// How the container is seen: `exact`, the greatest height in each cell; `middles`, the height at the middle of each,
    /// as a camera with one pixel per cell gives it; `camera`, a depth camera above with noise and dropouts; or by the
    /// cameras of a TOML file with `cameras` (1 or 2), `height_m`, `width_px`, `height_px` and
    /// `noise = { sigma_m, dropout, step_m }` [default: that of the conditions]
    #[arg(long, value_name = "VIEW|FILE", value_parser = parse_view)]
    view: Option<View>,
}

/// What sees the container.
#[derive(Debug, Clone, Copy, PartialEq)]
enum View {
    Scan(Sampling),
    Cameras(CameraSettings),
}

fn parse_view(text: &str) -> Result<View, String> {
    Ok(match text {
        "exact" => View::Scan(Sampling::Greatest),
        "middles" => View::Scan(Sampling::Middle),
        "camera" => View::Cameras(CameraSettings::default()),
        file => View::Cameras(file::settings(file).map_err(|error| {
            format!("none of exact, middles and camera, and no file of cameras: {error}")
        })?),
    })
}

impl ViewOptions {
    /// The cameras that are asked for; without any the container is scanned.
    pub(super) fn camera(&self, seed: u64) -> Option<CameraSettings> {
        match self.view {
            Some(View::Cameras(camera)) => Some(CameraSettings { seed, ..camera }),
            _ => None,
        }
    }

    /// The scan that is asked for.
    pub(super) fn scan(&self) -> Option<Sampling> {
        match self.view {
            Some(View::Scan(scan)) => Some(scan),
            _ => None,
        }
    }
}
