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
    /// The link: 0 is the base, `n` is turned by joint `n`.
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
    /// Makes the arm that parameters describe.
    ///
    /// # Errors
    /// [`ParameterError::Value`] names the first field that is not possible.
    pub fn new(parameters: &ArmParameters) -> Result<Self, ParameterError> {
        parameters.validate()?;
        let kinematics = Kinematics::new(parameters);
        let origins = kinematics.stretched_origins_m();
        let capsules = parameters.capsules.iter().filter_map(|capsule| {
            let origin = origins.get(capsule.link)?;
            let shape = Capsule {
                from: Point3::from(capsule.from_m) - origin,
                to: Point3::from(capsule.to_m) - origin,
                radius_m: capsule.radius_m,
            };
            let link = capsule.link;
            Some(LinkCapsule { link, shape })
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

    /// Gives the arm's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Gives the most that the flange carries, gripper included, in kilograms.
    pub fn payload_kg(&self) -> f64 {
        self.payload_kg
    }

    /// Gives its kinematics in the base frame.
    pub fn kinematics(&self) -> &Kinematics {
        &self.kinematics
    }

    /// Gives the limits of each joint.
    pub fn limits(&self) -> &[JointLimits; JOINTS] {
        &self.limits
    }

    /// Gives the gripper on its flange.
    pub fn gripper(&self) -> &GripperParameters {
        &self.gripper
    }

    /// Gives the collision shapes, in the frames of their links.
    pub fn capsules(&self) -> &[LinkCapsule] {
        &self.capsules
    }

    /// Gives the poses of all links, the base first, the flange last.
    pub fn container_from_links(&self, joints: &JointAngles) -> [Isometry3<f64>; LINKS] {
        let base_from_links = self.kinematics.base_from_links(joints);
        base_from_links.map(|base_from_link| self.container_from_base * base_from_link)
    }

    /// Gives the place of the cup's lip.
    pub fn lip(&self, joints: &JointAngles) -> Point3<f64> {
        let flange = self.container_from_base * self.kinematics.base_from_flange(joints);
        flange * Point3::new(0.0, 0.0, self.gripper.length_m())
    }

    /// Finds all joint angles, at most eight, that put the cup's lip at a point with the cup facing
    /// down and the flange turned by `yaw_rad` about the vertical; joint limits are not looked at.
    pub fn inverse(&self, lip: &Point3<f64>, yaw_rad: f64) -> Vec<JointAngles> {
        let up = Vector3::new(0.0, 0.0, self.gripper.length_m());
        let at = Translation3::from(lip.coords + up);
        let container_from_flange = Isometry3::from_parts(at, facing_down(yaw_rad));
        let base_from_flange = self.base_from_container * container_from_flange;
        self.kinematics.inverse(&base_from_flange)
    }

    /// Gives the turn of J6 for a flange facing down that is turned by `yaw_rad` about the
    /// vertical.
    pub(crate) fn flange_turn_rad(&self, yaw_rad: f64) -> f64 {
        -self.kinematics.flange_turn_sign() * yaw_rad
    }

    /// Bounds the distance from each joint's origin to any point that it moves, in metres, whatever
    /// the angles.
    pub(crate) fn reaches_m(&self) -> &[f64; JOINTS] {
        &self.reaches_m
    }
}

/// Gives the orientation of a flange whose z axis points down, turned about the vertical.
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
        let reaches_m = capsules.map(|LinkCapsule { shape, .. }| {
            shape.from.coords.norm().max(shape.to.coords.norm()) + shape.radius_m
        });
        reaches_m.fold(0.0, f64::max)
    };
    let mut reaches = [0.0; JOINTS];
    let mut beyond_m = tip_m;
    let [.., flange] = origins;
    let mut next = flange;
    let links = origins.iter().enumerate().skip(1);
    for (reach, (link, origin)) in reaches.iter_mut().zip(links).rev() {
        beyond_m = (beyond_m + (next - origin).norm()).max(of_link_m(link));
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
