//! What the tests of the planner share: a planner of one cell, blocks, a perception that shows what
//! a test says.

mod messages;

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use ppnpack_catalogue::catalogue::Catalogue;
use ppnpack_packing::checks::trial::TrialSettings;
use ppnpack_packing::kernel::grid::{Grid, GridSettings};
use ppnpack_packing::kernel::heightmap::Surface;
use ppnpack_packing::planning::method::{Method, Stability};
use ppnpack_packing::scene::Scene;
use ppnpack_planner::{CellSettings, ContainerSettings, PlannerService, Settings};
use ppnpack_service::embedded::{self, Hub};
use ppnpack_service::rpc::{self, CallError, Client, Done, Incoming, Listener};
use ppnpack_service::{Process, Running, ServiceSettings};
use ppnpack_wire::convert;
use ppnpack_wire::keys::{Cell, Service};
use ppnpack_wire::rpc::Request;
use ppnpack_wire::v1::{self, PlanResult, Status};

pub(crate) use messages::{
    announce, announcement, block, carried_out, close, ended, ended_as, ids, line, not_placed,
    of_mass, of_order, open, placed, placed_and, square, state_reply, states,
};

pub(crate) fn cell() -> Cell {
    Cell::new("cell-1").unwrap()
}

/// A deadline that nothing here is late for.
pub(crate) fn soon() -> Instant {
    in_ms(20_000)
}

pub(crate) fn in_ms(span: u64) -> Instant {
    Instant::now() + Duration::from_millis(span)
}

/// The paper's grid, on which tests are quick, and by the paper's objective what there is room for.
/// A heightmap is shown until the next one is, whether it shows what was placed or not.
pub(crate) fn coarse() -> CellSettings {
    let mut trial = TrialSettings::default();
    trial.limits.tilt_rad = 30.0_f64.to_radians();
    trial.limits.slide_m = 0.02;
    CellSettings {
        grid: GridSettings::from(&Grid::reference()),
        method: Method {
            stability: Stability::None,
            trial,
            ..Method::published()
        },
        set_aside: 0,
        heightmap_age_limit_s: 600.0,
        compare_content: false,
        ..CellSettings::default()
    }
}

/// A cell in which nothing is tried: a twin would know better than what a test shows.
pub(crate) fn untried() -> CellSettings {
    let mut settings = coarse();
    settings.method.trial = TrialSettings::off();
    settings
}

/// Such a cell with two containers.
pub(crate) fn left_and_right() -> CellSettings {
    let containers = ["left", "right"].map(|name| (name.to_owned(), ContainerSettings::default()));
    CellSettings {
        containers: BTreeMap::from(containers),
        ..untried()
    }
}

pub(crate) fn settings(cell: CellSettings) -> Settings {
    Settings {
        cells: BTreeMap::from([("cell-1".to_owned(), cell)]),
        ..Settings::default()
    }
}

pub(crate) struct Seen {
    /// The state, or the later one that is asked for.
    pub(crate) state_number: u64,
    /// Whether it shows this state alone, whatever is asked for.
    pub(crate) is_stuck: bool,
    /// What lies in each container; `None` for nothing.
    pub(crate) surface: Option<Surface>,
    /// The container of which nothing is shown.
    pub(crate) hidden: &'static str,
}

impl Seen {
    fn nothing(state_number: u64, is_stuck: bool) -> Arc<Mutex<Self>> {
        Arc::new(Mutex::new(Self {
            state_number,
            is_stuck,
            surface: None,
            hidden: "none",
        }))
    }

    /// Shows so many cells, from this one on, in another state, as high as this.
    pub(crate) fn raise(&mut self, (x, y): (usize, usize), cells: usize, height_m: f32) {
        self.state_number += 1;
        let empty = || Surface::empty(&Grid::reference());
        let surface = self.surface.get_or_insert_with(empty);
        for x in 4 * x..4 * (x + cells) {
            for y in 4 * y..4 * (y + cells) {
                surface.raise(x, y, height_m);
            }
        }
    }

    fn show(&self, grid: &Grid, incoming: Incoming<v1::HeightmapRequest>) {
        if incoming.cell().as_str() == self.hidden {
            return incoming.refuse(Status::Unavailable, "it is hidden");
        }
        let surface = self.surface.clone();
        let surface = surface.unwrap_or_else(|| Surface::empty(grid));
        let state_number = match self.is_stuck {
            true => self.state_number,
            false => self.state_number.max(incoming.message().least_state_number),
        };
        show(incoming, grid, surface, state_number, state_number);
    }
}

/// Answers with a heightmap of a state of the cell.
pub(crate) fn show(
    incoming: Incoming<v1::HeightmapRequest>,
    grid: &Grid,
    surface: Surface,
    sequence: u64,
    state_number: u64,
) {
    let scene = Scene::from_surface(grid, surface).unwrap();
    let heightmap = v1::Heightmap {
        id: Some(v1::HeightmapId { epoch: 1, sequence }),
        state_number,
        scene: Some(convert::scene::write(grid, &scene)),
        ..v1::Heightmap::default()
    };
    let reply = v1::HeightmapReply {
        heightmap: Some(heightmap),
        ..v1::HeightmapReply::default()
    };
    incoming.reply(reply, Done::default());
}

/// A planner that keeps its sessions in a file, and a controller that asks it. Ends as planned when
/// it is dropped.
pub(crate) struct Rig {
    planner: Option<Box<PlannerService>>,
    settings: Settings,
    pub(crate) client: Client,
    pub(crate) seen: Arc<Mutex<Seen>>,
    services: Vec<(Process, Listener)>,
    pub(crate) hub: Hub,
    _folder: tempfile::TempDir,
}

impl Rig {
    pub(crate) fn new(cell: CellSettings) -> Self {
        Self::with_objects(cell, &[])
    }

    /// A planner with these objects, and a perception that sees each container, empty at first.
    pub(crate) fn with_objects(cell: CellSettings, catalogues: &[Arc<Catalogue>]) -> Self {
        let seen = Seen::nothing(2, false);
        let (grid, containers) = (cell.grid, cell.containers.clone());
        let shown = Arc::clone(&seen);
        let show = move |incoming: Incoming<v1::HeightmapRequest>| {
            let mut grid = grid;
            let own = containers.get(incoming.cell().as_str());
            grid.container = own.and_then(|own| own.container).unwrap_or(grid.container);
            let shown = shown.lock().unwrap();
            shown.show(&grid.build().unwrap(), incoming);
        };
        let mut rig = Self::shown_by(cell, catalogues, show);
        rig.seen = seen;
        rig
    }

    /// A planner whose perception answers so.
    pub(crate) fn shown_by(
        cell: CellSettings,
        catalogues: &[Arc<Catalogue>],
        show: impl Fn(Incoming<v1::HeightmapRequest>) + Send + Sync + 'static,
    ) -> Self {
        let hub = embedded::hub().unwrap();
        let folder = tempfile::tempdir().unwrap();
        let settings = Settings {
            store: Some(folder.path().join("sessions.redb")),
            ..settings(cell)
        };
        settings.validate().unwrap();
        let mut services = Vec::new();
        answer(&hub, &mut services, Service::Perception, show);
        Self {
            planner: Some(start(&hub, &settings, catalogues)),
            settings,
            client: Client::new(&embedded::session(&hub).unwrap()),
            seen: Seen::nothing(0, true),
            services,
            hub,
            _folder: folder,
        }
    }

    /// Has a service answer requests of a kind so.
    pub(crate) fn answer<R: Request>(
        &mut self,
        service: Service,
        work: impl Fn(Incoming<R>) + Send + Sync + 'static,
    ) {
        answer(&self.hub, &mut self.services, service, work);
    }

    /// Has a bridge answer requests of a kind so; `None` refuses one as stale.
    pub(crate) fn bridge_answers<R: Request>(
        &mut self,
        reply: impl Fn(&Incoming<R>) -> Option<R::Reply> + Send + Sync + 'static,
    ) {
        self.answer(Service::Bridge, move |incoming| match reply(&incoming) {
            Some(reply) => incoming.reply(reply, Done::default()),
            None => incoming.refuse(Status::Stale, "the cell is in another state"),
        });
    }

    /// Has a bridge say that the cell is in this state.
    pub(crate) fn bridge_says(
        &mut self,
        state: impl Fn() -> v1::CellState + Send + Sync + 'static,
    ) {
        self.bridge_answers(move |_: &Incoming<v1::CellStateRequest>| Some(state_reply(state())));
    }

    /// Has a bridge count the state up, to this one, where it is told of a change.
    pub(crate) fn bridge_counts_to(
        &mut self,
        state: impl Fn() -> v1::CellState + Send + Sync + 'static,
    ) {
        self.bridge_answers(move |_: &Incoming<v1::ChangedRequest>| {
            Some(v1::ChangedReply {
                state: Some(state()),
                ..v1::ChangedReply::default()
            })
        });
    }

    pub(crate) fn last_service_leaves(&mut self) {
        self.services.pop();
    }

    pub(crate) fn any_process(&self) -> &Process {
        &self.services[0].0
    }

    /// The planner anew, with other settings and these objects.
    pub(crate) fn restart(
        &mut self,
        catalogues: &[Arc<Catalogue>],
        change: impl FnOnce(&mut CellSettings),
    ) {
        self.finish();
        change(self.settings.cells.get_mut("cell-1").unwrap());
        self.planner = Some(start(&self.hub, &self.settings, catalogues));
    }

    fn finish(&mut self) {
        if let Some(planner) = self.planner.take() {
            planner.finish(soon()).unwrap();
        }
    }

    pub(crate) fn ask<R: Request>(&self, request: R) -> Result<R::Reply, CallError> {
        self.client.call(&cell(), request, soon())
    }

    pub(crate) fn call<R: Request>(&self, request: R) -> R::Reply {
        self.ask(request).unwrap()
    }

    /// Asserts that a request is refused with this status, for a reason that says this.
    pub(crate) fn assert_refused<R: Request>(&self, request: R, status: Status, says: &str) {
        let error = self.ask(request).map(drop).unwrap_err();
        assert_eq!(error.status(), Some(status), "{error}");
        assert!(error.to_string().contains(says), "{error}");
    }

    /// Why a plan that has so long is refused, in time, as something is not there.
    pub(crate) fn plan_unavailable(&self, span_ms: u64) -> String {
        let plan = || {
            let plan = v1::PlanRequest::default();
            self.client.call(&cell(), plan, in_ms(span_ms)).unwrap_err()
        };
        // On a busy machine an answer may come too late: one in time is enough.
        let mut refusals = (0..10).map(|_| plan());
        let error = refusals.find(|error| error.status().is_some()).unwrap();
        assert_eq!(error.status(), Some(Status::Unavailable), "{error}");
        error.to_string()
    }

    /// Begins a session, called `s`.
    pub(crate) fn begin(&self) {
        self.begin_as(v1::BeginRequest::default());
    }

    pub(crate) fn begin_automatic(&self) {
        self.begin_as(v1::BeginRequest {
            is_automatic: true,
            ..v1::BeginRequest::default()
        });
    }

    pub(crate) fn begin_as(&self, request: v1::BeginRequest) -> v1::Session {
        let request = v1::BeginRequest {
            session_id: "s".to_owned(),
            ..request
        };
        self.call(request).session.unwrap()
    }

    pub(crate) fn announce(&self, items: impl IntoIterator<Item = v1::Announcement>) {
        self.call(announce(items));
    }

    pub(crate) fn begin_with(&self, item_ids: &[&str]) {
        self.begin();
        self.announce(
            item_ids
                .iter()
                .map(|item_id| announcement(item_id, block())),
        );
    }

    pub(crate) fn withdraw(&self, item_id: &str) -> v1::Session {
        let request = v1::WithdrawRequest {
            item_id: item_id.to_owned(),
            ..v1::WithdrawRequest::default()
        };
        self.call(request).session.unwrap()
    }

    pub(crate) fn plan(&self) -> v1::PlanReply {
        self.call(v1::PlanRequest::default())
    }

    pub(crate) fn explain(&self, item_id: &str) -> v1::ExplainReply {
        self.call(v1::ExplainRequest {
            item_id: item_id.to_owned(),
            ..v1::ExplainRequest::default()
        })
    }

    pub(crate) fn decision(&self) -> v1::Decision {
        let reply = self.plan();
        assert_eq!(reply.result(), PlanResult::Decided, "{reply:?}");
        reply.decision.unwrap()
    }

    /// Plans a step, and reports it as placed; why nothing fits, where that is so.
    pub(crate) fn try_step(&self) -> Result<v1::Decision, Vec<v1::ItemReason>> {
        let reply = self.plan();
        let decision = reply.decision.ok_or(reply.reasons)?;
        self.call(placed(&decision, decision.state_number + 1));
        Ok(decision)
    }

    pub(crate) fn step(&self) -> v1::Decision {
        self.try_step().unwrap()
    }

    /// Reports a square box of so many cells a side as placed, and shows it; whether it was found
    /// or is only assumed to lie there.
    pub(crate) fn place_square(&self, decision: &v1::Decision, cells: usize, is_found: bool) {
        let state_number = self.show_square(decision, cells);
        self.call(placed_and(decision, state_number, is_found));
    }

    /// Shows a square box of so many cells a side where it was decided to be. Gives the state that
    /// it is shown in.
    pub(crate) fn show_square(&self, decision: &v1::Decision, cells: usize) -> u64 {
        let resting = decision.placement.as_ref().unwrap();
        let resting = convert::placement::read_resting(resting).unwrap();
        let at = resting.placement;
        let bottom_m = f32::from(resting.resting_height) * 0.002;
        let mut seen = self.seen.lock().unwrap();
        seen.raise((at.x, at.y), cells, bottom_m + 0.04);
        seen.state_number
    }

    /// Switches the automatic mode; on: a failure is acknowledged.
    pub(crate) fn switch(&self, is_automatic: bool) {
        self.call(v1::AutomaticRequest {
            is_automatic,
            failure_id: match is_automatic {
                true => self.session().failure_id,
                false => String::new(),
            },
            ..v1::AutomaticRequest::default()
        });
    }

    pub(crate) fn session(&self) -> v1::Session {
        self.call(v1::SessionRequest::default()).session.unwrap()
    }

    /// The session once this holds.
    pub(crate) fn session_once(&self, is_so: impl Fn(&v1::Session) -> bool) -> v1::Session {
        let until = soon();
        loop {
            let session = self.session();
            if is_so(&session) {
                return session;
            }
            assert!(
                Instant::now() < until,
                "it does not come to that: {session:?}"
            );
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// The session when its automatic mode has ended.
    pub(crate) fn ended(&self) -> v1::Session {
        self.session_once(|session| session.end != 0)
    }
}

impl Drop for Rig {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            self.finish();
        }
    }
}

fn start(hub: &Hub, settings: &Settings, catalogues: &[Arc<Catalogue>]) -> Box<PlannerService> {
    let process = embedded::process(hub, Service::Planner, "planner-1").unwrap();
    Box::new(ppnpack_planner::start(&process, settings, catalogues).unwrap())
}

fn answer<R: Request>(
    hub: &Hub,
    services: &mut Vec<(Process, Listener)>,
    service: Service,
    work: impl Fn(Incoming<R>) + Send + Sync + 'static,
) {
    let name = format!("{service}-{}", services.len());
    let process = embedded::process(hub, service, &name).unwrap();
    let listener = rpc::listen(&process, None, work).unwrap();
    services.push((process, listener));
}
