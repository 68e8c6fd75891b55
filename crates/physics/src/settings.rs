//! The settings of a simulated cell; their defaults are the reference experiment's.

use std::f64::consts::PI;
use std::ops::Bound;

use ppnpack_numbers::{SettingError, settings, within};
use ppnpack_packing::kernel::grid::ContainerSize;
use ppnpack_packing::scene::model::mesh::Bounds;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// The most steps of one settling phase.
const MAX_SETTLE_STEPS: f64 = 1e6;

settings! {
    /// Everything the simulated cell depends on.
    pub struct CellSettings {
        /// The container's inner size.
        pub container: ContainerSize = ContainerSize::REFERENCE,
        /// Its walls and floor.
        pub walls: WallSettings = WallSettings::default(),
        /// Space that is taken from the start, as by a divider or by what lies there.
        #[serde(skip_serializing_if = "Vec::is_empty")]
        pub taken: Vec<TakenBox> = Vec::new(),
        /// Friction and restitution of what touches.
        pub contact: ContactSettings = ContactSettings::default(),
        /// Height and errors with which items are let go.
        pub release: ReleaseSettings = ReleaseSettings::default(),
        /// The longest that bodies are given to settle after a release, in seconds of simulated
        /// time.
        ///
        /// A phase ends early when all bodies are asleep, since nothing would move any more. The
        /// reference's 0.375 s (the 180 steps at 480 Hz of the paper's published code, where the
        /// paper says 0.25 s) can end in motion; a few seconds let everything come to rest.
        pub settle_time_s: f64 = 0.375,
        /// What is read from the poses at the end.
        pub outcome: OutcomeSettings = OutcomeSettings::default(),
        /// The numerical integration.
        pub solver: SolverSettings = SolverSettings::default(),
        /// Seed of the release jitter; without jitter nothing is random.
        pub seed: u64 = 0,
    }
}

settings! {
    /// The container's walls and floor. The walls end at the rim.
    ///
    /// They are thick enough that a body cannot pass their middle within a step: an item released
    /// 12 cm above its place at the rim reaches the floor at 2.9 m/s, which is 6 mm per step of
    /// 1/480 s.
    pub struct WallSettings with validate as "walls." {
        /// Thickness of the walls, outwards, in metres.
        pub thickness_m: f64 = 0.02 => within("at least 1 mm and at most 1 m", 1e-3..=1.0),
        /// Thickness of the floor, downwards, in metres.
        pub floor_thickness_m: f64 = 0.05 => within("at least 1 mm and at most 1 m", 1e-3..=1.0),
    }
}

/// A box in the container that nothing moves, by two of its corners, in metres in the container
/// frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TakenBox {
    /// The corner of least coordinates.
    pub from_m: [f64; 3],
    /// The corner of greatest coordinates.
    pub to_m: [f64; 3],
}

impl TakenBox {
    /// Its extent.
    pub fn bounds(&self) -> Bounds {
        Bounds {
            lowest: self.from_m.into(),
            highest: self.to_m.into(),
        }
    }

    fn validate(&self) -> Result<(), SettingError> {
        let [from, to] = ["taken.from_m", "taken.to_m"];
        for (from_m, to_m) in self.from_m.into_iter().zip(self.to_m) {
            within("between -10 and 10 m", -10.0..=10.0)(from, from_m)?;
            within("above from_m and at most 10 m", above(from_m, 10.0))(to, to_m)?;
        }
        Ok(())
    }
}

/// Rule by which the coefficients of two touching surfaces combine into one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Combine {
    /// Their mean: equal surfaces have the pair's coefficient.
    Average,
    /// Their product, as in Bullet.
    Multiply,
    /// The lesser.
    Min,
    /// The greater.
    Max,
}

settings! {
    /// Friction and restitution.
    ///
    /// The reference's coefficients, combined as its engine combines them: 0.25 between items, 0.15
    /// at walls and floor.
    pub struct ContactSettings with validate as "contact." {
        /// Friction coefficient of items.
        pub item_friction: f64 = 0.5 => within("between 0 and 10", 0.0..=10.0),
        /// Friction coefficient of walls and floor.
        pub wall_friction: f64 = 0.3 => within("between 0 and 10", 0.0..=10.0),
        /// Rule by which two friction coefficients combine.
        pub friction_combine: Combine = Combine::Multiply,
        /// Restitution of items, walls and floor: 0 does not bounce, 1 bounces back to where it
        /// came from.
        pub restitution: f64 = 0.0 => within("between 0 and 1", 0.0..=1.0),
    }
}

settings! {
    /// Release of items: from rest, above their planned pose, displaced by the robot's error.
    pub struct ReleaseSettings with validate as "release." {
        /// Height above the planned pose at which an item is let go, in metres.
        pub height_m: f64 = 0.12 => within("between 0 and 2 m", 0.0..=2.0),
        /// Standard deviation of the horizontal error, per axis, in metres.
        pub jitter_m: f64 = 0.0 => within("between 0 and 0.1 m", 0.0..=0.1),
        /// Standard deviation of the error in yaw, in radians.
        pub jitter_yaw_rad: f64 = 0.0 => within("between 0 and pi", 0.0..=PI),
    }
}

settings! {
    /// Thresholds of the reported outcome.
    pub struct OutcomeSettings with validate as "outcome." {
        /// An item counts as toppled when it tilts by more than this, in radians.
        pub topple_rad: f64 = 30.0_f64.to_radians() => within("between 0 and pi", 0.0..=PI),
        /// A body is taken out of the simulation when its centre of mass is this far below the
        /// floor's upper face or outside the walls' outer faces, in metres.
        pub lost_margin_m: f64 = 0.05 => within("between 0 and 10 m", 0.0..=10.0),
    }
}

settings! {
    /// The numerical integration. By default it takes 960 substeps a second; the reference takes
    /// 480 steps.
    pub struct SolverSettings with validate as "solver." {
        /// Time per step, in seconds.
        pub timestep_s: f64 = 1.0 / 480.0
            => within("above 0 and at most 0.05 s", above(1e-6, 0.05)),
        /// Gravitational acceleration, downwards, in m/s^2.
        pub gravity_m_s2: f64 = 9.8 => within("between 0 and 100 m/s^2", 0.0..=100.0),
        /// Substeps per step: more of them make contacts stiffer.
        pub substeps: usize = 2 => within("between 1 and 64", 1.0..=64.0),
        /// Sweeps over all contacts per substep. With few, the corners of a box take its impact
        /// unevenly, and it slides away from where it lands: dropped from 12 cm on another box, by
        /// up to 2 mm with four substeps of three sweeps, by 4 mm with two of two.
        pub sweeps: usize = 2 => within("between 1 and 64", 1.0..=64.0),
        /// The size of typical items, in metres: the contact tolerances (prediction, correction,
        /// recycling) scale with it.
        pub length_scale_m: f64 = 0.1 => within("between 1 mm and 10 m", 1e-3..=10.0),
        /// A body may fall asleep while its fastest point is slower than this, in m/s.
        pub sleep_speed_m_s: f64 = 0.01 => within("between 0 and 1 m/s", 0.0..=1.0),
        /// Time for which a group of touching bodies has to be that slow to fall asleep, in
        /// seconds.
        pub sleep_time_s: f64 = 0.1 => within("above 0 and at most 60 s", above(0.0, 60.0)),
    }
}

impl CellSettings {
    /// Gives the settings of a robot that lays items down: let go 1 cm above their place, given up
    /// to 2 s to come to rest. Contacts are solved for three times as often as in the reference, as
    /// what is asked of it is what stays and what it carries.
    pub fn robot() -> Self {
        let mut robot = Self::default();
        robot.release.height_m = 0.01;
        robot.solver.substeps = 4;
        robot.solver.sweeps = 3;
        robot.settle_time_s = 2.0;
        robot
    }

    /// Checks that every number is possible.
    ///
    /// # Errors
    /// [`SettingError`] names the first that is not.
    pub fn validate(&self) -> Result<(), SettingError> {
        let side = within("above 1 mm and at most 10 m", above(1e-3, 10.0));
        side("the container's x side", self.container.x_m)?;
        side("the container's y side", self.container.y_m)?;
        side("the container's height", self.container.z_m)?;
        self.container.validate_shape()?;
        self.walls.validate()?;
        within("at most 100", 0.0..=100.0)("taken", self.taken.len() as f64)?;
        self.taken.iter().try_for_each(TakenBox::validate)?;
        self.contact.validate()?;
        self.release.validate()?;
        self.outcome.validate()?;
        self.solver.validate()?;
        let steps = within("between 1 and a million", 0.5..=MAX_SETTLE_STEPS);
        let wanted = self.settle_time_s / self.solver.timestep_s;
        steps("the steps of a settling phase", wanted)
    }

    /// Replaces what another value has, object by object: what is left out stays.
    ///
    /// # Errors
    /// The first of `over` that is no setting.
    pub fn overlaid(&self, over: Value) -> Result<Self, serde_json::Error> {
        let mut settings = serde_json::to_value(self)?;
        overlay(&mut settings, over);
        serde_json::from_value(settings)
    }

    /// The most steps of a settling phase.
    pub(crate) fn settle_steps(&self) -> usize {
        let steps = self.settle_time_s / self.solver.timestep_s;
        steps.round().clamp(1.0, MAX_SETTLE_STEPS) as usize
    }
}

fn overlay(base: &mut Value, over: Value) {
    match (base, over) {
        (Value::Object(base), Value::Object(over)) => {
            for (name, value) in over {
                overlay(base.entry(name).or_insert(Value::Null), value);
            }
        }
        (base, over) => *base = over,
    }
}

/// A range without its lower end.
fn above(lowest: f64, highest: f64) -> (Bound<f64>, Bound<f64>) {
    (Bound::Excluded(lowest), Bound::Included(highest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_is_the_reference() {
        let settings = CellSettings::default();
        settings.validate().unwrap();
        assert_eq!(settings.settle_steps(), 180);
    }

    #[test]
    fn impossible_numbers_are_named() {
        let refused = |change: fn(&mut CellSettings)| {
            let mut settings = CellSettings::default();
            change(&mut settings);
            settings.validate().unwrap_err().to_string()
        };
        assert!(refused(|s| s.container.x_m = -0.3).contains("x side"));
        assert!(refused(|s| s.container.z_m = f64::NAN).contains("height"));
        assert!(refused(|s| s.container.draft_rad = 1.0).contains("draft"));
        assert!(refused(|s| s.contact.item_friction = -1.0).contains("friction"));
        assert!(refused(|s| s.solver.timestep_s = 0.0).contains("timestep_s"));
        assert!(refused(|s| s.solver.substeps = 0).contains("substeps"));
        assert!(refused(|s| s.settle_time_s = f64::INFINITY).contains("steps"));
    }
}
