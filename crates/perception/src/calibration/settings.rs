//! Settings of a calibration.

use ppnpack_numbers::{SettingError, settings, within};
use ppnpack_packing::kernel::grid::ContainerSize;

settings! {
    /// Facts of a container, and limits of the points' residuals.
    pub struct CalibrationSettings with validate_numbers {
        /// The inner size where it is known, in metres: what is measured is checked against it, and
        /// only the pose is taken from the cloud. Where its sides differ, they decide which of them
        /// is x.
        pub size: Option<ContainerSize> = None,
        /// The measured size may differ from the known one by this along each side, in metres.
        pub size_tolerance_m: f64 = 0.005 => within("above 0 and at most 1 m", 1e-6..=1.0),
        /// x is the side nearest to the sensor's x axis turned by so many quarters,
        /// counter-clockwise from above; 0 to 3.
        pub quarter_turns: u8 = 0 => within("0 to 3", 0.0..=3.0),
        /// The container is at least this deep, in metres.
        pub least_depth_m: f64 = 0.03 => within("0.005 to 1 m", 0.005..=1.0),
        /// The root mean square of the residuals of floor, rim and walls is at most this, in
        /// metres, sensor noise included.
        pub largest_rms_m: f64 = 0.004 => within("above 0 and at most 1 m", 1e-6..=1.0),
        /// Walls are plane within this, in metres.
        pub largest_bow_m: f64 = 0.003 => within("above 0 and at most 1 m", 1e-6..=1.0),
        /// Sides are square, and floor and rim parallel, within this, in radians.
        pub largest_skew_rad: f64 = 0.0175 => within("above 0 and at most 0.5 rad", 1e-6..=0.5),
        /// The sensor looks at the container from within this angle of straight above, in radians.
        pub largest_view_angle_rad: f64 = 0.8 => within("0.1 to 0.9 rad", 0.1..=0.9),
        /// For the random choices.
        pub seed: u64 = 0,
    }
}

impl CalibrationSettings {
    /// Checks that every number is possible.
    pub fn validate(&self) -> Result<(), SettingError> {
        if let Some(size) = self.size {
            let side = within("0.01 to 3 m a side", 0.01..=3.0);
            let mut sides_m = [size.x_m, size.y_m, size.z_m].into_iter();
            sides_m.try_for_each(|side_m| side("size", side_m))?;
        }
        self.validate_numbers()
    }
}
