//! Records of runs.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct RunRecord {
    pub(super) items: Vec<ItemRecord>,
    pub(super) decisions: Vec<DecisionRecord>,
    /// How long the cell took for what, in seconds, once for each time:
    /// - `recognise`: from the cloud of the tray to what lies there;
    /// - `plan`: from the request to the decision;
    /// - `see`: from the end of a placement to the heightmap that shows it;
    /// - `inspect`: from the end of a placement to what the inspection says;
    /// - `simulate`: the simulation of the placement, which takes other times than an arm.
    pub(super) stages_s: BTreeMap<String, Vec<f64>>,
    /// The volume of the meshes that are inside the container at the end.
    pub(super) volume_m3: f64,
    /// Volume of the meshes over the container's floor up to the highest point of the content.
    pub(super) compactness: f64,
    /// The deepest that two items reach into each other at the end, in metres.
    pub(super) deepest_overlap_m: f64,
    /// Why nothing was planned any more, where the scene was doubtful.
    pub(super) doubt: Option<String>,
}

#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct DecisionRecord {
    /// Proposals, evaluation and checks, in seconds.
    pub(super) propose_s: f64,
    pub(super) evaluate_s: f64,
    pub(super) check_s: f64,
    /// The planned time of the arm's cycle, in seconds; 0 without an arm.
    pub(super) cycle_s: f64,
    pub(super) degraded: Vec<String>,
    /// Whether none of the proposals was valid, so that all placements were searched.
    pub(super) is_widened: bool,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct ItemRecord {
    pub(super) object: String,
    pub(super) is_known: bool,
    pub(super) seen_as: SeenAs,
    /// How often the arm tried to place it.
    pub(super) attempts: u32,
    pub(super) end: End,
    pub(super) found: Option<Found>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Found {
    /// Kind of the result, in the words of [`InspectionKind`](ppnpack_wire::v1::InspectionKind).
    pub(super) kind: String,
    /// How far the pose that was found is from the true one, modulo symmetry.
    pub(super) position_off_m: Option<f64>,
    pub(super) angle_off_rad: Option<f64>,
    pub(super) reason: String,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum SeenAs {
    Nothing,
    Unknown,
    Object {
        name: String,
        /// Modulo symmetry, where it is the right object.
        position_off_m: Option<f64>,
        angle_off_rad: Option<f64>,
    },
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum End {
    Waiting,
    /// In the container, as its outcome says.
    Placed {
        is_inside: bool,
        slide_m: f64,
        tilt_rad: f64,
        /// How far an item that lay there before was moved at most, in metres.
        disturbance_m: f64,
    },
    Refused {
        reason: String,
    },
    Lost {
        failure: String,
    },
}
