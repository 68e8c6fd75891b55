//! An arm: its kinematics, joint limits, collision shapes and gripper, standing in a cell.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

use crate::error::ParameterError;
use crate::joints::{JOINTS, JointAngles, JointLimits};
use crate::kinematics::{Kinematics, LINKS};
use crate::parameters::{ArmParameters, BaseParameters, GripperParameters};
use crate::shapes::Capsule;

/// A capsule fixed to a link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkCapsule {
    /// The link: 0 is the base, `n` what joint `n` turns.
    pub link: usize,
    /// The capsule in the link's frame.
    pub shape: Capsule,
}

/// An arm in a cell. Poses are in the container frame.
#[derive(Debug, Clone)]
pub struct Arm {
    name: String,
    payload_kg: f64,
    kinematics: Kinematics,
    limits: [JointLimits; JOINTS],
    pub(crate) container_from_base: Isometry3<f64>,
    base_from_container: Isometry3<f64>,
    capsules: Vec<LinkCapsule>,
    gripper: GripperParameters,
    reaches_m: [f64; JOINTS],
}

impl Arm {
    /// The arm that parameters describe.
    ///
    /// # Errors
    /// [`ParameterError::Value`] names the first field that is not possible.
    pub fn new(parameters: &ArmParameters) -> Result<Self, ParameterError> {
        parameters.validate()?;
        let kinematics = Kinematics::new(parameters);
        let origins = kinematics.stretched_origins_m();
        let capsules = parameters.capsules.iter().filter_map(|capsule| {
            let origin = origins.get(capsule.link)?;
            let in_link = |point: [f64; 3]| Point3::from(point) - origin;
            Some(LinkCapsule {
                link: capsule.link,
                shape: Capsule {
                    from: in_link(capsule.from_m),
                    to: in_link(capsule.to_m),
                    radius_m: capsule.radius_m,
                },
            })
        });
        let capsules: Vec<_> = capsules.collect();
        let container_from_base = container_from_base(&parameters.base);
        let reaches_m = reaches_m(&origins, &capsules, &parameters.gripper);
        Ok(Self {
            name: parameters.name.clone(),
            payload_kg: parameters.payload_kg,
            limits: parameters.joints.map(|joint| JointLimits::new(&joint)),
            base_from_container: container_from_base.inverse(),
            container_from_base,
            kinematics,
            capsules,
            gripper: parameters.gripper,
            reaches_m,
        })
    }

    /// The arm's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What the flange carries at most, gripper included, in kilograms.
    pub fn payload_kg(&self) -> f64 {
        self.payload_kg
    }

    /// Its kinematics in the base frame.
    pub fn kinematics(&self) -> &Kinematics {
        &self.kinematics
    }

    /// What each joint allows.
    pub fn limits(&self) -> &[JointLimits; JOINTS] {
        &self.limits
    }

    /// The gripper on its flange.
    pub fn gripper(&self) -> &GripperParameters {
        &self.gripper
    }

    /// The collision shapes, in the frames of their links.
    pub fn capsules(&self) -> &[LinkCapsule] {
        &self.capsules
    }

    /// The poses of all links, the base first, the flange last.
    pub fn container_from_links(&self, joints: &JointAngles) -> [Isometry3<f64>; LINKS] {
        let base_from_links = self.kinematics.base_from_links(joints);
        base_from_links.map(|base_from_link| self.container_from_base * base_from_link)
    }

    /// Where the cup's lip is.
    pub fn lip(&self, joints: &JointAngles) -> Point3<f64> {
        let flange = self.container_from_base * self.kinematics.base_from_flange(joints);
        flange * Point3::new(0.0, 0.0, self.gripper.length_m())
    }

    /// All joint angles, at most eight, that put the cup's lip at a point with the cup facing down and the flange
    /// turned by `yaw_rad` about the vertical; joint limits are not looked at.
    pub fn inverse(&self, lip: &Point3<f64>, yaw_rad: f64) -> Vec<JointAngles> {
        let up = Vector3::new(0.0, 0.0, self.gripper.length_m());
        let container_from_flange =
            Isometry3::from_parts(Translation3::from(lip.coords + up), facing_down(yaw_rad));
        self.kinematics
            .inverse(&(self.base_from_container * container_from_flange))
    }

    /// How much J6 turns for a flange facing down that is turned by `yaw_rad` about the vertical.
    pub(crate) fn flange_turn_rad(&self, yaw_rad: f64) -> f64 {
        -self.kinematics.flange_turn_sign() * yaw_rad
    }

    /// How far from each joint's origin any point of what it moves can be, in metres, whatever the angles.
    pub(crate) fn reaches_m(&self) -> &[f64; JOINTS] {
        &self.reaches_m
    }
}

/// The orientation of a flange whose z axis points down, turned about the vertical.
pub(crate) fn facing_down(yaw_rad: f64) -> UnitQuaternion<f64> {
    let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad);
    yaw * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
}

fn container_from_base(base: &BaseParameters) -> Isometry3<f64> {
    let rotation = UnitQuaternion::from_euler_angles(
        base.roll_deg.to_radians(),
        base.pitch_deg.to_radians(),
        base.yaw_deg.to_radians(),
    );
    Isometry3::from_parts(Translation3::from(base.position_m), rotation)
}

/// Chains the lengths outwards: no point gets further from a joint than along the stretched arm.
fn reaches_m(
    origins: &[Vector3<f64>; LINKS],
    capsules: &[LinkCapsule],
    gripper: &GripperParameters,
) -> [f64; JOINTS] {
    let widest = gripper.parts().into_iter().map(|(_, part)| part.radius_m);
    let tip_m = gripper.length_m() + widest.fold(0.0, f64::max);
    let of_link_m = |link: usize| {
        let capsules = capsules.iter().filter(|capsule| capsule.link == link);
        capsules
            .map(|capsule| {
                let Capsule { from, to, radius_m } = capsule.shape;
                from.coords.norm().max(to.coords.norm()) + radius_m
            })
            .fold(0.0, f64::max)
    };
    let mut reaches = [0.0; JOINTS];
    let mut beyond_m = tip_m;
    let mut next: Option<&Vector3<f64>> = None;
    for (index, reach) in reaches.iter_mut().enumerate().rev() {
        let origin = origins.get(index + 1);
        if let (Some(origin), Some(next)) = (origin, next) {
            beyond_m += (next - origin).norm();
        }
        beyond_m = beyond_m.max(of_link_m(index + 1));
        *reach = beyond_m;
        next = origin;
    }
    reaches
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arms;

    #[test]
    fn the_lip_of_a_solution_is_where_it_was_asked_for() {
        for name in arms::names() {
            let arm = arms::arm(name).unwrap();
            let wanted = Point3::new(0.2, 0.1, 0.3);
            let solutions = arm.inverse(&wanted, 0.3);
            assert!(!solutions.is_empty(), "{name}");
            for joints in solutions {
                assert!((arm.lip(&joints) - wanted).norm() < 1e-6, "{name}");
                let turned = joints.with_flange_turned(arm.flange_turn_rad(0.5));
                let [.., flange] = arm.container_from_links(&turned);
                assert!(flange.rotation.angle_to(&facing_down(0.8)) < 1e-6, "{name}");
            }
        }
    }
}
