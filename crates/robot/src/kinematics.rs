//! Forward and inverse kinematics of an arm in its base frame. Only this module knows the
//! kinematics library.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use rs_opw_kinematics::glam::{DQuat, DVec3};
use rs_opw_kinematics::kinematic_traits::{Kinematics as _, Pose};
use rs_opw_kinematics::kinematics_impl::OPWKinematics;
use rs_opw_kinematics::parameters::opw_kinematics::Parameters;

use crate::joints::{JOINTS, JointAngles};
use crate::parameters::ArmParameters;

/// Frames that capsules are fixed to: the base and what each joint turns.
pub const LINKS: usize = JOINTS + 1;

/// The kinematics of a six-axis arm with an ortho-parallel basis and a spherical wrist.
#[derive(Debug, Clone)]
pub struct Kinematics {
    solver: OPWKinematics,
    signs: [f64; JOINTS],
    zeros_rad: [f64; JOINTS],
    /// Offsets from each link's frame to the next, in metres.
    steps_m: [Vector3<f64>; JOINTS],
}

impl Kinematics {
    /// Makes the kinematics that checked parameters describe.
    pub(crate) fn new(parameters: &ArmParameters) -> Self {
        let lengths = parameters.geometry;
        let zeros_rad = parameters.joints.map(|joint| joint.zero_deg.to_radians());
        let solver = OPWKinematics::new(Parameters {
            a1: lengths.a1_m,
            a2: lengths.a2_m,
            b: lengths.b_m,
            c1: lengths.c1_m,
            c2: lengths.c2_m,
            c3: lengths.c3_m,
            c4: lengths.c4_m,
            offsets: zeros_rad,
            sign_corrections: parameters.joints.map(|joint| joint.sign),
            dof: 6,
        });
        Self {
            solver,
            signs: parameters.joints.map(|joint| f64::from(joint.sign)),
            zeros_rad,
            steps_m: [
                Vector3::new(0.0, 0.0, lengths.c1_m),
                Vector3::new(lengths.a1_m, lengths.b_m, 0.0),
                Vector3::new(0.0, 0.0, lengths.c2_m),
                Vector3::new(lengths.a2_m, 0.0, 0.0),
                Vector3::new(0.0, 0.0, lengths.c3_m),
                Vector3::new(0.0, 0.0, lengths.c4_m),
            ],
        }
    }

    /// Gives the flange's pose in the base frame; its z axis points out of the flange.
    pub fn base_from_flange(&self, joints: &JointAngles) -> Isometry3<f64> {
        let [.., flange] = self.base_from_links(joints);
        flange
    }

    /// Gives the poses of all links in the base frame, the base first, the flange last.
    pub fn base_from_links(&self, joints: &JointAngles) -> [Isometry3<f64>; LINKS] {
        let [j1, j2, j3, j4, j5, j6] = self.model_angles_rad(joints);
        let [s1, s2, s3, s4, s5, s6] = self.steps_m;
        let step = |offset: Vector3<f64>, axis, angle_rad| {
            let rotation = UnitQuaternion::from_axis_angle(&axis, angle_rad);
            Isometry3::from_parts(Translation3::from(offset), rotation)
        };
        let (y, z) = (Vector3::y_axis(), Vector3::z_axis());
        let link_1 = step(s1, z, j1);
        let link_2 = link_1 * step(s2, y, j2);
        let link_3 = link_2 * step(s3, y, j3);
        let link_4 = link_3 * step(s4, z, j4);
        let link_5 = link_4 * step(s5, y, j5);
        let link_6 = link_5 * step(s6, z, j6);
        let base = Isometry3::identity();
        [base, link_1, link_2, link_3, link_4, link_5, link_6]
    }

    /// Gives the origin of each link's frame in the base frame with the arm stretched straight up;
    /// no frame is turned then.
    pub(crate) fn stretched_origins_m(&self) -> [Vector3<f64>; LINKS] {
        let mut origins = [Vector3::zeros(); LINKS];
        let mut sum = Vector3::zeros();
        for (origin, step) in origins.iter_mut().skip(1).zip(&self.steps_m) {
            sum += step;
            *origin = sum;
        }
        origins
    }

    /// Finds all joint angles, up to eight, that put the flange at a pose, each within half a turn
    /// of 0; joint limits are not looked at. None where the pose is out of reach.
    pub fn inverse(&self, base_from_flange: &Isometry3<f64>) -> Vec<JointAngles> {
        let translation = base_from_flange.translation.vector;
        let Quaternion { coords } = *base_from_flange.rotation.quaternion();
        let rotation = DQuat::from_xyzw(coords.x, coords.y, coords.z, coords.w);
        let translation = DVec3::new(translation.x, translation.y, translation.z);
        let Ok(pose) = Pose::try_from_parts(translation, rotation) else {
            return Vec::new();
        };
        let solutions = self.solver.inverse(&pose);
        solutions.into_iter().map(JointAngles::new).collect()
    }

    /// Gives the angle of the wrist's bend J5 in the model: 0 where the forearm and the flange are
    /// in line.
    pub(crate) fn wrist_bend_rad(&self, joints: &JointAngles) -> f64 {
        let [_, _, _, _, bend, _] = self.model_angles_rad(joints);
        bend
    }

    /// Gives the sign of J6's change for a turn of the flange about its own axis.
    pub(crate) fn flange_turn_sign(&self) -> f64 {
        let [.., sign] = self.signs;
        sign
    }

    /// Gives the angles that the model counts from the arm stretched straight up.
    fn model_angles_rad(&self, joints: &JointAngles) -> [f64; JOINTS] {
        let mut angles = *joints.as_array();
        let corrections = self.signs.iter().zip(&self.zeros_rad);
        for (angle, (sign, zero_rad)) in angles.iter_mut().zip(corrections) {
            *angle = *angle * sign - zero_rad;
        }
        angles
    }
}
