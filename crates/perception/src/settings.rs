//! Settings of the mapper.

use ppnpack_numbers::{SettingError, require, settings, within};
use ppnpack_packing::kernel::grid::Grid;

use crate::doubts::DoubtSettings;
use crate::still::StillSettings;

settings! {
    /// Settings of a [`Mapper`](crate::mapper::Mapper). The defaults are those for a sensor without
    /// noise.
    pub struct MapperSettings with validate_numbers {
        /// Points below the floor by at most this lie on the floor; those further below are left
        /// out. In metres.
        pub floor_tolerance_m: f64 = 0.01 => within("0 to 1 m", 0.0..=1.0),
        /// Points within this distance of the walls' inner faces, or beyond them, are left out:
        /// they may show the wall itself. In metres; some standard deviations of the sensor's
        /// noise.
        pub wall_margin_m: f64 = 0.0005 => within("0 to 1 m", 0.0..=1.0),
        /// The standard deviation of the sensor's noise along z, in metres. 0: every point counts
        /// as it is, and a sample has the height of its highest.
        pub noise_m: f64 = 0.0 => within("0 to 1 m", 0.0..=1.0),
        /// A point stands for the surface within this distance along x and y, in metres: half the
        /// distance between neighbouring points on the floor, and at most half a sample. What lies
        /// between them is seen then.
        pub point_radius_m: f64 = 0.0 => within("0 to 1 m", 0.0..=1.0),
        /// With noise, points that stand out above all around them count where there are at least
        /// this many.
        pub least_points: u32 = 3,
        /// Holes no wider than this along x and y are filled, in metres, where the samples around
        /// them are level.
        pub largest_hole_m: f64 = 0.0 => within("0 to 1 m", 0.0..=1.0),
        /// The samples around a hole are level where their heights differ by at most this, in
        /// metres: what hides a hole from the sensor stands up from what is beside it.
        pub level_m: f64 = 0.005 => within("0 to 1 m", 0.0..=1.0),
        /// Settings by which several clouds of a still scene make one heightmap.
        pub still: StillSettings = StillSettings::default(),
        /// Limits beyond which nothing is to be planned on the scene.
        pub doubts: DoubtSettings = DoubtSettings::default(),
    }
}

impl MapperSettings {
    /// Gives settings for a depth camera with this standard deviation of its noise, in metres, and
    /// points some 1.5 mm apart.
    pub fn of_camera(noise_m: f64) -> Self {
        Self {
            noise_m,
            wall_margin_m: 0.003,
            point_radius_m: 0.001,
            largest_hole_m: 0.005,
            ..Self::default()
        }
    }

    /// Says what stays unnoticed with these settings: each with the doubt that would tell it, and
    /// what leaves that off.
    pub fn unnoticed(&self) -> Vec<&'static str> {
        let doubts = &self.doubts;
        let does_not_look = doubts.least_rim_share == 0.0;
        let all = [
            (
                self.noise_m == 0.0,
                "a sensor that repeats itself (noise_m = 0)",
            ),
            (
                self.still.clouds <= 1,
                "what moves: NOT_STILL (still.clouds = 1)",
            ),
            (
                doubts.least_seen_share == 0.0,
                "half a picture: LITTLE_SEEN (doubts.least_seen_share = 0)",
            ),
            (
                does_not_look,
                "a container or a sensor that was moved: RIM_AWAY (doubts.least_rim_share = 0)",
            ),
            (
                !does_not_look && doubts.wall_thickness_m == 0.0,
                "a container that was turned or raised, or moved in a cloud without walls: RIM_AWAY \
                 (doubts.wall_thickness_m = 0)",
            ),
        ];
        let off = all.into_iter().filter(|(is_off, _)| *is_off);
        off.map(|(_, what)| what).collect()
    }

    /// Checks that every number is possible on a grid. At half a sample, a point is kept for four
    /// samples at most.
    pub fn validate_on(&self, grid: &Grid) -> Result<(), SettingError> {
        self.validate_numbers()?;
        self.still.validate()?;
        self.doubts.validate()?;
        let greatest_m = 0.5 * grid.resolution().surface_pitch_m();
        require(
            "point_radius_m",
            self.point_radius_m,
            "at most half the distance of the surface's samples",
            |radius_m| radius_m <= greatest_m,
        )
    }
}
