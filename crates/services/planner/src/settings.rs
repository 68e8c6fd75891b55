//! What can be set.

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::path::PathBuf;

use ppnpack_packing::closing::ClosingRules;
use ppnpack_packing::containers::ContainerChoice;
use ppnpack_packing::grid::{ContainerSize, Grid, GridSettings};
use ppnpack_packing::method::{Method, ProposalSource};
use ppnpack_packing::orders::ContainerRules;
use ppnpack_packing::search::Search;
use ppnpack_physics::twin::TwinSettings;
use ppnpack_robot::error::ParameterError;
use ppnpack_robot::station::{ArmStation, StationSettings};
use ppnpack_service::ServiceSettings;
use ppnpack_service::configuration::in_range;
use ppnpack_wire::keys::{Cell, KeyError};
use serde::{Deserialize, Serialize};

use crate::store::Store;

/// Settings of the planner service.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// The cells, by their names.
    pub cells: BTreeMap<String, CellSettings>,
    /// The file that keeps the sessions; in memory where none is given, and then lost with the process.
    pub store: Option<PathBuf>,
    /// The objects that can be announced by name: `builtin`, or a folder of meshes.
    pub catalogue: String,
    /// Requests that wait for a cell at most; more are refused.
    pub queue: usize,
    /// The most that the heightmaps may take that items of one session were announced with, in MiB as they are encoded. An
    /// announcement with more is refused.
    pub shapes_mib: usize,
    /// Where viewers of Foxglove's protocol connect; nowhere where none is given. There is no access control: other machines see the
    /// cells where this is not a loopback address.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view: Option<SocketAddr>,
}

/// The most items that a session may set aside.
const MAX_SET_ASIDE: usize = 10_000;

/// The most alternatives that a decision tells.
pub(crate) const MAX_ALTERNATIVES: usize = 64;

/// The most resting poses of an object.
const MAX_POSES: usize = 6;

/// The most candidates that a heuristic service takes.
const MAX_CANDIDATES: usize = 1_000;

/// A cell and how it is packed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CellSettings {
    /// The container and its grid; the keys stand among the others.
    #[serde(flatten)]
    pub grid: GridSettings,
    /// How it is packed; the keys stand among the others. `all` and `bounded` proposals are the same here.
    #[serde(flatten)]
    pub method: Method,
    /// Its containers, where it has several that are packed at the same time, by the names under which bridge and perception serve
    /// them; where none is given, it has one, which has the cell's own name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub containers: BTreeMap<String, ContainerSettings>,
    /// Which of the open containers an item goes into.
    pub choice: ContainerChoice,
    /// What a container may hold, by what is said of the items' orders, groups and masses.
    pub rules: ContainerRules,
    /// How many containers are open, and which one is opened next.
    pub opening: OpeningSettings,
    /// When a container is closed.
    pub closing: ClosingSettings,
    /// The arm that has to be able to make the placements; where there is none, that is not checked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub arm: Option<StationSettings>,
    /// The twin of the cell that placements are tried in; its container is that of the grid.
    pub twin: TwinSettings,
    /// Where placements are evaluated.
    pub evaluate: Where,
    /// The longest that the network may take for a step, in seconds, before the search goes on without it.
    pub propose_limit_s: f64,
    /// The longest that a heuristic service may take for a page of placements, in seconds, before its part is searched
    /// here. A step may need several pages.
    pub evaluate_limit_s: f64,
    /// A heightmap whose cloud came longer ago than this, in seconds, is not planned on.
    pub heightmap_age_limit_s: f64,
    /// The longest that a cloud may be on its way from a sensor that does not know the cell's state, in seconds: what
    /// comes sooner after a report may show what was before.
    pub sensor_latency_s: f64,
    /// The most items that a session may set aside for the next container, as nothing in the buffer has a valid
    /// placement, where the request that begins it says nothing else.
    pub set_aside: usize,
    /// How many valid placements beside the chosen one a decision of the automatic mode tells, for people to compare; each is searched
    /// for and checked like the chosen one.
    pub alternatives: usize,
    /// In how many resting poses an object of the catalogue may be packed at most: as the catalogue has it, then the most
    /// probable others. Whoever brings items to the robot has to be able to turn them into these. An announcement may allow
    /// fewer, or name those that it allows.
    pub poses: usize,
    /// Whether perception is asked after each placement how the item lies, and the session is corrected by that.
    pub inspect: bool,
    /// The longest that the bridge may take to carry out a placement in automatic mode, in seconds.
    pub place_limit_s: f64,
    /// The most memory that a search in the planner may take, in MiB; a step that needs more is refused.
    pub search_mib: usize,
}

/// One of the containers of a cell, where it is otherwise than the cell says.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ContainerSettings {
    /// Its inner size.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub container: Option<ContainerSize>,
    /// The arm, as it stands to this container.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub arm: Option<StationSettings>,
}

/// How many of a cell's containers are open, and which of those that stand ready is opened next, by what waits.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OpeningSettings {
    /// How many are open at most, where not all are: the others stand ready, and which one is opened is chosen by its size. A request
    /// may open more.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub most: Option<usize>,
    /// How full containers are expected to become, in percent: the smallest is opened in which so much takes what waits.
    pub expected_percent: f64,
}

impl Default for OpeningSettings {
    fn default() -> Self {
        Self {
            most: None,
            expected_percent: 40.0,
        }
    }
}

/// When a container is closed without a request that says so.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ClosingSettings {
    /// Whether the bridge brings an empty container for each that is closed so. In automatic mode the fullest is closed then where
    /// nothing in the buffer has a valid placement; otherwise the automatic mode ends.
    pub renews: bool,
    /// By which rules; the keys stand beside. With `order_complete`, announce all of an order before the last of it is packed, or how many
    /// items it has.
    #[serde(flatten)]
    pub rules: ClosingRules,
    /// The longest that an order is waited for of which fewer items were announced than it is said to have, in seconds since the last of
    /// them; then no more are expected. Where it is not given, they are waited for until a request says that none comes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub order_wait_s: Option<f64>,
}

/// A container of a cell, and how it is planned.
#[derive(Debug, Clone)]
pub(crate) struct ContainerPlan {
    /// As sessions have it; empty where it is the cell itself.
    pub(crate) name: String,
    /// Under which bridge and perception serve it.
    pub(crate) address: Cell,
    /// The cell's, with its own size and arm.
    pub(crate) settings: CellSettings,
}

/// Where placements are evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Where {
    /// By the heuristic services, or in the planner where that is sooner: on a coarse grid a search takes less than
    /// the way to a service and back. The decisions are the same.
    Fastest,
    /// By the heuristic services that are alive, all together.
    Services,
    /// In the planner itself.
    InProcess,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            cells: BTreeMap::from([("cell-1".to_owned(), CellSettings::default())]),
            store: None,
            catalogue: ppnpack_household::BUILTIN.to_owned(),
            queue: 64,
            shapes_mib: 64,
            view: None,
        }
    }
}

impl Default for CellSettings {
    fn default() -> Self {
        Self {
            grid: GridSettings::default(),
            method: Method::default(),
            containers: BTreeMap::new(),
            choice: ContainerChoice::default(),
            rules: ContainerRules::default(),
            opening: OpeningSettings::default(),
            closing: ClosingSettings::default(),
            arm: None,
            twin: TwinSettings::default(),
            evaluate: Where::Fastest,
            propose_limit_s: 0.5,
            evaluate_limit_s: 1.0,
            heightmap_age_limit_s: 5.0,
            sensor_latency_s: 0.5,
            set_aside: 0,
            alternatives: 0,
            poses: 1,
            inspect: false,
            place_limit_s: 120.0,
            search_mib: 256,
        }
    }
}

impl CellSettings {
    /// The containers of the cell of this name.
    ///
    /// # Errors
    /// [`KeyError`] where one has a name that keys cannot have.
    pub(crate) fn container_plans(&self, cell: &Cell) -> Result<Vec<ContainerPlan>, KeyError> {
        if self.containers.is_empty() {
            return Ok(vec![ContainerPlan {
                name: String::new(),
                address: cell.clone(),
                settings: self.clone(),
            }]);
        }
        let containers = self.containers.iter().map(|(name, own)| {
            Ok(ContainerPlan {
                name: name.clone(),
                address: Cell::new(name)?,
                settings: self.with(own),
            })
        });
        containers.collect()
    }

    /// Those of a cell that has this container alone.
    fn with(&self, own: &ContainerSettings) -> Self {
        let mut alone = Self {
            containers: BTreeMap::new(),
            opening: OpeningSettings::default(),
            ..self.clone()
        };
        alone.grid.container = own.container.unwrap_or(self.grid.container);
        alone.arm = own.arm.clone().or(alone.arm);
        alone
    }

    /// The arm, where there is one.
    pub(crate) fn station(&self) -> Result<Option<ArmStation>, ParameterError> {
        self.arm.as_ref().map(ArmStation::new).transpose()
    }

    /// The most bytes that a search may take.
    pub(crate) fn search_bytes(&self) -> usize {
        self.search_mib << 20
    }

    fn validate_opening(&self) -> Result<(), String> {
        let OpeningSettings {
            most,
            expected_percent,
        } = self.opening;
        in_range("opening.expected_percent", expected_percent, 1.0..=100.0)?;
        let containers = self.containers.len();
        match most {
            Some(most) if !(1..containers).contains(&most) => Err(format!(
                "opening.most: {most}, and the cell has {}: give at least 1 and less than that, or leave it out",
                match containers {
                    0 | 1 => "one container, which is open".to_owned(),
                    containers =>
                        format!("{containers} containers, of which all may be open without it"),
                }
            )),
            _ => Ok(()),
        }
    }

    fn validate_rules(&self) -> Result<(), String> {
        let rules = &self.rules;
        if let Some(most_kg) = rules.most_kg {
            in_range("rules.most_kg", most_kg, 0.001..=1e6)?;
        }
        if let Some(expected_m3) = rules.expected_m3 {
            in_range("rules.expected_m3", expected_m3, 1e-9..=1e3)?;
        }
        if let Some((a, b)) = rules.contradiction() {
            return Err(format!(
                "rules.together: {a} and {b} are in rules.apart, too, and could never be packed: leave one of the pairs out"
            ));
        }
        if let Some(wait_s) = self.closing.order_wait_s {
            in_range("closing.order_wait_s", wait_s, 0.001..=1e6)?;
        }
        match (rules.certainty_percent, rules.spread_m3, rules.expected_m3) {
            (None, Some(_), _) => {
                let remedy = "rules.spread_m3: it says nothing without a certainty: set rules.certainty_percent, or leave it out";
                return Err(remedy.to_owned());
            }
            (Some(_), Some(_), None) => {
                let remedy =
                    "rules.spread_m3: of what is not given: set rules.expected_m3, or leave it out";
                return Err(remedy.to_owned());
            }
            (Some(percent), spread_m3, _) => {
                in_range("rules.certainty_percent", percent, 1.0..=99.9)?;
                in_range("rules.spread_m3", spread_m3.unwrap_or_default(), 0.0..=1e3)?;
            }
            (None, None, _) => {}
        }
        let possible = self.closing.rules.validate(rules, self.choice);
        possible.map_err(|error| error.to_string())
    }

    /// Whether a search has room for what every one takes.
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
        if method.arm_time.is_on() && self.arm.is_none() {
            let remedy = "arm_time: there is no arm that takes time: set arm, or leave it out";
            return Err(remedy.to_owned());
        }
        let twin = self.twin.validate();
        twin.map_err(|error| error.to_string())?;
        in_range("buffer", method.buffer, 1..=MAX_CANDIDATES)?;
        set_aside_in_range(self.set_aside)?;
        in_range("alternatives", self.alternatives, 0..=MAX_ALTERNATIVES)?;
        in_range("poses", self.poses, 1..=MAX_POSES)?;
        self.validate_opening()?;
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

/// Checks how many items a session may set aside.
pub(crate) fn set_aside_in_range(limit: usize) -> Result<(), String> {
    in_range("set_aside", limit, 0..=MAX_SET_ASIDE)
}

impl Settings {
    /// Each container is of one cell alone.
    fn validate_containers(&self) -> Result<(), String> {
        let mut names: Vec<&String> = self.cells.keys().collect();
        for (cell, settings) in &self.cells {
            for (name, own) in &settings.containers {
                let at = format!("cells.{cell}.containers.{name}");
                Cell::new(name).map_err(|error| format!("{at}: {error}"))?;
                if names.contains(&name) {
                    return Err(format!(
                        "{at}: another cell or container has this name: each container needs one of its own"
                    ));
                }
                names.push(name);
                let possible = settings.with(own).validate();
                possible.map_err(|error| format!("{at}.{error}"))?;
            }
        }
        Ok(())
    }
}

impl ServiceSettings for Settings {
    fn validate(&self) -> Result<(), String> {
        for (name, cell) in &self.cells {
            Cell::new(name).map_err(|error| error.to_string())?;
            cell.validate()
                .map_err(|error| format!("cells.{name}.{error}"))?;
        }
        self.validate_containers()?;
        in_range("queue", self.queue, 1..=65_536)?;
        in_range("shapes_mib", self.shapes_mib, 1..=65_536)
    }

    fn after_restore(&self) -> Result<String, String> {
        let path = self.store.as_deref();
        let path = path.ok_or("service.store is not given: there is nothing to be restored")?;
        let ended = Store::after_restore(path).map_err(|error| error.to_string())?;
        let list = ended.join(", ");
        Ok(format!("sessions that somebody has to look at: {list}"))
    }
}

#[cfg(test)]
mod tests {
    use ppnpack_packing::objective::Weights;

    use super::*;

    #[test]
    fn a_search_has_room_for_what_every_one_takes() {
        let mut cell = CellSettings::default();
        cell.grid.cell_m = 0.000_5;
        cell.search_mib = 1;
        let refused = cell.validate().unwrap_err();
        assert!(refused.starts_with("search_mib"), "{refused}");
        let least_mib = refused.split_whitespace().find_map(|word| {
            let number = word.trim_end_matches(',');
            number.parse().ok()
        });
        cell.search_mib = least_mib.unwrap();
        cell.validate().unwrap();
    }

    #[test]
    fn the_keys_of_grid_and_method_stand_among_the_others() {
        let text = "cell_m = 0.02\nbuffer = 3\nyaws = 2\ninspect = true\nweights = { distance = 2 }\n\
                    proposals = { from = \"random\", percent = 5 }";
        let cell: CellSettings = toml::from_str(text).unwrap();
        assert_eq!(
            (cell.grid.cell_m, cell.grid.yaws, cell.inspect),
            (0.02, 2, true)
        );
        let expected = Method {
            buffer: 3,
            weights: Weights {
                distance: 2.0,
                ..Weights::default()
            },
            proposals: ProposalSource::Random { percent: 5.0 },
            ..Method::default()
        };
        assert_eq!(cell.method, expected);
        assert_eq!(
            cell.grid.height_unit_m,
            GridSettings::default().height_unit_m
        );
        let written = toml::to_string(&cell).unwrap();
        let table: toml::Table = toml::from_str(&written).unwrap();
        assert!(table.contains_key("cell_m") && !table.contains_key("grid"));
        assert!(table.contains_key("stability") && !table.contains_key("method"));
        assert_eq!(toml::from_str::<CellSettings>(&written).unwrap(), cell);
        for unknown in [
            "cel_m = 0.02",
            "grid = 1",
            "cell_m = 0.02\nbufer = 3",
            "proposals = { from = \"random\", percent = 5, coarsening = { cells = 1, yaws = 1 } }",
        ] {
            let error = toml::from_str::<CellSettings>(unknown).unwrap_err();
            assert!(error.to_string().contains("unknown field"), "{error}");
        }
    }

    #[test]
    fn proposals_that_give_items_up_early_are_refused() {
        let cell: CellSettings =
            toml::from_str("proposals = { from = \"tries\", yaws = 3, positions = 9 }").unwrap();
        assert_eq!(cell.method.proposals, ProposalSource::PUBLISHED_TRIES);
        let refused = cell.validate().unwrap_err();
        assert!(refused.starts_with("proposals: `tries`"), "{refused}");
    }

    #[test]
    fn how_placements_are_tried_is_set_for_each_cell() {
        let cell: CellSettings = toml::from_str("trial = { tries_per_item = 7 }").unwrap();
        assert_eq!(cell.method.trial.tries_per_item, 7);
        assert_eq!(cell.validate(), Ok(()));
        let cell: CellSettings = toml::from_str("look_ahead = { futures = 1001 }").unwrap();
        let refusal = cell.validate().unwrap_err();
        assert!(refusal.contains("futures"), "{refusal}");
        let text = "[trial]\nlimits = { tilt_rad = 9.0 }";
        let cell: CellSettings = toml::from_str(text).unwrap();
        let refusal = cell.validate().unwrap_err();
        assert!(refusal.contains("tilt limit"), "{refusal}");
    }

    #[test]
    fn no_more_items_may_be_set_aside_than_is_possible() {
        let cell: CellSettings = toml::from_str("set_aside = 10000").unwrap();
        assert_eq!(cell.validate(), Ok(()));
        let cell = CellSettings {
            set_aside: 10_001,
            ..cell
        };
        let refusal = cell.validate().unwrap_err();
        assert!(refusal.contains("set_aside"), "{refusal}");
        assert_eq!(CellSettings::default().set_aside, 0);
    }

    #[test]
    fn as_many_poses_are_possible_as_the_services_take_candidates() {
        let with_poses = |poses: usize, buffer: usize| {
            let text = format!("poses = {poses}\nbuffer = {buffer}");
            let cell: CellSettings = toml::from_str(&text).unwrap();
            cell.validate()
        };
        assert_eq!(CellSettings::default().poses, 1);
        assert_eq!(with_poses(1, 1_000), Ok(()));
        assert_eq!(with_poses(6, 166), Ok(()));
        for (poses, buffer) in [(0, 5), (7, 5), (6, 167)] {
            let refusal = with_poses(poses, buffer).unwrap_err();
            assert!(refusal.contains("poses"), "{refusal}");
        }
    }

    #[test]
    fn time_counts_where_there_is_an_arm() {
        let validated = |text: &str| {
            let cell: CellSettings = toml::from_str(text).unwrap();
            cell.validate()
        };
        let weight = "scene_value = { weight = 30.0 }\narm_time = { litres_per_s = 0.01 }";
        assert_eq!(validated(&format!("{weight}\narm = {{}}")), Ok(()));
        assert!(validated(weight).unwrap_err().contains("set arm"));
        for (text, part) in [
            ("arm_time = { litres_per_s = -1.0 }", "no weight"),
            (
                "arm_time = { litres_per_s = 0.01 }\narm = {}",
                "set scene_value",
            ),
            ("arm_time = { among = 1 }", "among"),
        ] {
            let refused = validated(text).unwrap_err();
            assert!(refused.contains(part), "{refused}");
        }
    }

    #[test]
    fn closing_rules_that_do_not_go_together_are_refused_with_what_to_do() {
        let validated = |text: &str| {
            let cell: CellSettings = toml::from_str(text).unwrap();
            cell.validate()
        };
        let possible = "rules = { expected_m3 = 0.01, spread_m3 = 0.001, certainty_percent = 80 }\n\
                        closing = { renews = true, none_of_last = 12, least_fill_percent = 40, rest_of_order = true }";
        assert_eq!(validated(possible), Ok(()));
        let cell: CellSettings = toml::from_str(possible).unwrap();
        let written = toml::to_string(&cell).unwrap();
        assert_eq!(toml::from_str::<CellSettings>(&written).unwrap(), cell);
        for (text, remedy) in [
            (
                "choice = \"best\"\nclosing = { none_of_last = 12 }",
                "set choice to",
            ),
            ("closing = { none_of_last = 0 }", "at least 1"),
            ("closing = { fill_percent = 101 }", "1 to 100 percent"),
            (
                "closing = { least_fill_percent = 80, fill_percent = 70 }",
                "no more than that",
            ),
            (
                "closing = { rest_of_order = true }",
                "set rules.certainty_percent",
            ),
            ("closing = { order_complete = true }", "set rules.sharing"),
            (
                "rules = { expected_m3 = 0.01, spread_m3 = 0.001 }",
                "set rules.certainty_percent",
            ),
            (
                "rules = { certainty_percent = 80, spread_m3 = 0.001 }",
                "set rules.expected_m3",
            ),
            (
                "rules = { certainty_percent = 100 }",
                "rules.certainty_percent",
            ),
        ] {
            let refused = validated(text).unwrap_err();
            assert!(refused.contains(remedy), "{refused}");
        }
        let unknown = toml::from_str::<CellSettings>("closing = { none_of_the_last = 3 }");
        let unknown = unknown.unwrap_err().to_string();
        assert!(unknown.contains("none_of_the_last"), "{unknown}");
    }

    #[test]
    fn an_unknown_arm_is_refused_with_the_names_there_are() {
        let refusal = |change: fn(&mut StationSettings)| {
            let mut station = StationSettings::default();
            change(&mut station);
            let cell = CellSettings {
                arm: Some(station),
                ..CellSettings::default()
            };
            let settings = Settings {
                cells: BTreeMap::from([("cell-1".to_owned(), cell)]),
                ..Settings::default()
            };
            settings.validate().unwrap_err()
        };
        let unknown = refusal(|station| station.arm = "r2d2".to_owned());
        for part in ["cells.cell-1.arm", "r2d2", "nachi-mz07l"] {
            assert!(unknown.contains(part), "{unknown}");
        }
        let file = refusal(|station| station.arm = "no/such/arm.toml".to_owned());
        assert!(file.contains("no/such/arm.toml"), "{file}");
        let place = refusal(|station| station.pick.position_m[2] = f64::NAN);
        assert!(place.contains("pick.position_m[2]"), "{place}");
        let cell = refusal(|station| station.cell.clearance_m = -1.0);
        assert!(cell.contains("clearance_m"), "{cell}");
    }
}
