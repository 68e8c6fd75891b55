//! A cell and how it is packed.

use std::collections::BTreeMap;

use ppnpack_numbers::settings;
use ppnpack_packing::kernel::grid::{Grid, GridSettings};
use ppnpack_packing::planning::method::{Method, ProposalSource, SET_ASIDE};
use ppnpack_packing::ranking::search::Search;
use ppnpack_packing::streams::orders::ContainerRules;
use ppnpack_physics::twin::TwinSettings;
use ppnpack_robot::error::ParameterError;
use ppnpack_robot::station::{ArmStation, StationSettings};
use ppnpack_service::configuration::in_range;
use serde::{Deserialize, Serialize};

use super::containers::{ClosingSettings, ContainerSettings};

/// Maximum number of items that a session may set aside.
const MAX_SET_ASIDE: usize = 10_000;

/// Maximum number of alternatives that a decision tells.
pub(crate) const MAX_ALTERNATIVES: usize = 64;

/// Maximum number of resting poses of an object.
const MAX_POSES: usize = 6;

/// Maximum number of candidates that a heuristic service takes.
const MAX_CANDIDATES: usize = 1_000;

settings! {
    /// A cell and how it is packed.
    pub struct CellSettings {
        /// The container and its grid; the keys stand among the others.
        #[serde(flatten)]
        pub grid: GridSettings = GridSettings::default(),
        /// The packing method; its keys stand among the others. `all` and `bounded` are the same
        /// here.
        #[serde(flatten)]
        pub method: Method = Method::default(),
        /// Its containers, where several are packed at the same time, by the names under which
        /// bridge and perception serve them; where none is given, it has one, which has the cell's
        /// own name.
        #[serde(skip_serializing_if = "BTreeMap::is_empty")]
        pub containers: BTreeMap<String, ContainerSettings> = BTreeMap::new(),
        /// Rules for what a container may hold, by the items' orders, groups and masses.
        pub rules: ContainerRules = ContainerRules::default(),
        /// When a container is closed.
        pub closing: ClosingSettings = ClosingSettings::default(),
        /// The arm that has to be able to make the placements; without one that is not checked.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub arm: Option<StationSettings> = None,
        /// The twin of the cell that placements are tried in; its container is that of the grid.
        pub twin: TwinSettings = TwinSettings::default(),
        /// The place where placements are evaluated.
        pub evaluate: Where = Where::InProcess,
        /// Maximum time of the network for a step, in seconds, before the search goes on without
        /// it.
        pub propose_limit_s: f64 = 0.5,
        /// Maximum time of a heuristic service for a step, in seconds, before the planner searches.
        pub evaluate_limit_s: f64 = 1.0,
        /// Maximum age of the cloud of a heightmap that is planned on, in seconds.
        pub heightmap_age_limit_s: f64 = 5.0,
        /// Maximum time of a cloud on its way from a sensor that does not know the cell's state, in
        /// seconds: what comes sooner after a report may show what was before.
        pub sensor_latency_s: f64 = 0.5,
        /// Maximum number of items that a session may set aside for the next container, as nothing
        /// in the buffer has a valid placement, where the request that begins it says nothing else.
        pub set_aside: usize = SET_ASIDE,
        /// How many valid placements beside the chosen one a decision of the automatic mode tells,
        /// for people to compare; each is searched for and checked like the chosen one.
        pub alternatives: usize = 0,
        /// Maximum number of resting poses in which an object of the catalogue may be packed: as
        /// the catalogue has it, then the most probable others. Whoever brings items to the robot
        /// has to be able to turn them into these. An announcement may allow fewer, or name those
        /// that it allows.
        pub poses: usize = 1,
        /// Whether perception is asked after each placement how the item lies, and the session is
        /// corrected by that. Unset: for items that nobody found, where perception has a catalogue.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub inspect: Option<bool> = None,
        /// Whether nothing is planned on pictures that contradict what is believed to lie in the
        /// container: an item is not there, or something came up that is none.
        pub compare_content: bool = true,
        /// Maximum time of the bridge to carry out a placement in automatic mode, in seconds.
        pub place_limit_s: f64 = 120.0,
        /// Maximum memory of a search in the planner, in MiB; a step that needs more is refused.
        pub search_mib: usize = 256,
    }
}

/// A place where placements are evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Where {
    /// A heuristic service, which is asked once in a step. The decisions are the same.
    Services,
    /// The planner itself.
    InProcess,
}

impl CellSettings {
    pub(crate) fn station(&self) -> Result<Option<ArmStation>, ParameterError> {
        self.arm.as_ref().map(ArmStation::new).transpose()
    }

    pub(crate) fn search_bytes(&self) -> usize {
        self.search_mib << 20
    }

    fn validate_rules(&self) -> Result<(), String> {
        let rules = &self.rules;
        if let Some(most_kg) = rules.most_kg {
            in_range("rules.most_kg", most_kg, 0.001..=1e6)?;
        }
        if let Some((a, b)) = rules.contradiction() {
            return Err(format!(
                "rules.together: {a} and {b} are in rules.apart, too, and could never be packed: leave one of the pairs out"
            ));
        }
        let possible = self.closing.rules.validate(rules);
        possible.map_err(|error| error.to_string())
    }

    /// Checks that a search has room for what every one takes.
    fn validate_search(&self, grid: &Grid) -> Result<(), String> {
        in_range("search_mib", self.search_mib, 1..=65_536)?;
        let least_bytes = Search::least_bytes(grid, self.method.heuristic);
        if least_bytes <= self.search_bytes() {
            return Ok(());
        }
        let least_mib = least_bytes.div_ceil(1 << 20);
        Err(format!(
            "search_mib: a search on this grid takes at least {least_mib}, and {} are given",
            self.search_mib
        ))
    }

    /// Checks that all is possible, but for the containers.
    pub(crate) fn validate(&self) -> Result<(), String> {
        let grid = self.grid.build().map_err(|error| error.to_string())?;
        self.validate_search(&grid)?;
        self.station().map_err(|error| format!("arm: {error}"))?;
        let method = &self.method;
        let possible = method.validate();
        possible.map_err(|error| error.to_string())?;
        let twin = self.twin.validate();
        twin.map_err(|error| error.to_string())?;
        in_range("buffer", method.buffer, 1..=MAX_CANDIDATES)?;
        set_aside_in_range(self.set_aside)?;
        in_range("alternatives", self.alternatives, 0..=MAX_ALTERNATIVES)?;
        in_range("poses", self.poses, 1..=MAX_POSES)?;
        self.validate_rules()?;
        let candidates = method.buffer * self.poses;
        if candidates > MAX_CANDIDATES {
            return Err(format!(
                "poses: {} for each of {} items are {candidates} candidates where {MAX_CANDIDATES} are possible: lower \
                 poses or buffer",
                self.poses, method.buffer
            ));
        }
        if let ProposalSource::Network { model: Some(_), .. } = method.proposals {
            return Err("proposals: unknown field `model`: a ppn service has its own".to_owned());
        }
        if method.proposals.gives_up_early() {
            let why = "proposals: `tries` gives items up that may have a valid placement, so that a session ends early: it is \
                       for comparisons alone";
            return Err(why.to_owned());
        }
        let spans_s = [
            ("propose_limit_s", self.propose_limit_s),
            ("evaluate_limit_s", self.evaluate_limit_s),
            ("heightmap_age_limit_s", self.heightmap_age_limit_s),
            ("sensor_latency_s", self.sensor_latency_s),
            ("place_limit_s", self.place_limit_s),
        ];
        let mut spans_s = spans_s.into_iter();
        spans_s.try_for_each(|(name, span_s)| in_range(name, span_s, 0.001..=3600.0))
    }
}

pub(crate) fn set_aside_in_range(limit: usize) -> Result<(), String> {
    in_range("set_aside", limit, 0..=MAX_SET_ASIDE)
}
