//! The processes of a stack together.

use std::collections::BTreeMap;
use std::net::TcpListener;
use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow, ensure};
use ppnpack_service::alive::Alive;
use ppnpack_service::configuration::{Endpoints, ZenohSettings};
use ppnpack_service::rpc::Client;
use ppnpack_wire::keys::{Cell, Instance, Service};
use zenoh::Wait;

use crate::cell::CellClient;
use crate::process::{Process, Signal, beside};

/// The maximum time for a service to start: it reads the catalogue and warms up the network.
const START_LIMIT: Duration = Duration::from_secs(60);

/// The paper's grid, on which steps are quick.
pub(crate) const COARSE: &str = "cell_m=0.01,yaws=4";

/// The paper's objective alone, with nothing set aside.
const PUBLISHED: &str = "weights={},scene_value={weight=0.0},set_aside=0";

/// The parts and settings of a stack.
#[derive(Debug, Clone)]
pub(crate) struct Options {
    pub(crate) cells: Vec<String>,
    /// Whether there is a ppn service, and the planner asks it.
    pub(crate) has_network: bool,
    /// The planner's setting `evaluate`: `services`, or its default, `in-process`.
    pub(crate) evaluate: &'static str,
    /// Further settings per service, as for `--set`.
    pub(crate) settings: Vec<(Service, String)>,
    /// Variables in the environment of every process.
    pub(crate) environment: Vec<(String, String)>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            cells: vec!["cell-1".to_owned()],
            has_network: false,
            evaluate: "services",
            settings: Vec::new(),
            environment: Vec::new(),
        }
    }
}

/// A running stack. Its processes end with it; its folder stays where the test fails.
pub(crate) struct Stack {
    // Dropped first: clients before those they talk to.
    session: zenoh::Session,
    processes: BTreeMap<String, Process>,
    pub(crate) endpoint: String,
    cells: Vec<String>,
    /// The folder of stores, journals and logs.
    pub(crate) folder: tempfile::TempDir,
}

impl Stack {
    /// Starts a stack and waits until all of it is ready.
    pub(crate) fn start(options: &Options) -> Result<Self> {
        let folder = tempfile::tempdir()?;
        let endpoint = format!("tcp/127.0.0.1:{}", free_port()?);
        let router = vec![
            format!("zenoh.listen=[\"{endpoint}\"]"),
            "admin.listen=127.0.0.1:0".to_owned(),
        ];
        let log = folder.path().join("router.log");
        let router = start("ppnpack-router", router, options, &log)?;
        let processes = BTreeMap::from([("router".to_owned(), router)]);
        let session = connect(&endpoint)?;
        let mut stack = Self {
            session,
            processes,
            endpoint,
            cells: options.cells.clone(),
            folder,
        };
        let network = options.has_network.then_some(Service::Ppn);
        let services = [Service::Heuristic].into_iter().chain(network);
        let others = [Service::Perception, Service::Bridge, Service::Planner];
        for service in services.chain(others) {
            stack.add(service, 1, options)?;
        }
        let names: Vec<String> = stack.processes.keys().cloned().collect();
        for name in names {
            stack.wait_ready(&name)?;
        }
        Ok(stack)
    }

    /// Starts one more instance of a service, with files of its own, as by mistake; gives its name.
    pub(crate) fn add_second(&mut self, service: Service, options: &Options) -> Result<String> {
        self.add(service, 2, options)?;
        Ok(format!("{service}-2"))
    }

    /// Starts the operator's page on a port of the system's choice, and waits until it is served;
    /// gives the page.
    #[cfg(test)]
    pub(crate) fn add_console(
        &mut self,
        index: usize,
        options: &Options,
    ) -> Result<crate::http::Page> {
        self.add(Service::Console, index, options)?;
        let name = format!("{}-{index}", Service::Console);
        self.wait_ready(&name)?;
        let log = self.log(&name)?;
        let url = log.rsplit_once("http://").map(|(_, rest)| rest);
        let address = url.and_then(|url| url.split(['"', ' ', '\n']).next());
        let address = address.with_context(|| format!("{name} tells no address: {log}"))?;
        Ok(crate::http::Page::at(address.parse()?))
    }

    fn add(&mut self, service: Service, index: usize, options: &Options) -> Result<()> {
        let name = format!("{service}-{index}");
        let mut settings = vec![
            format!("instance={name}"),
            format!("zenoh.connect=[\"{}\"]", self.endpoint),
            "admin.listen=127.0.0.1:0".to_owned(),
            "log.format=human".to_owned(),
        ];
        let path = |file: &str| {
            let file = match index {
                1 => format!("{file}.redb"),
                _ => format!("{file}-{index}.redb"),
            };
            self.folder.path().join(file).display().to_string()
        };
        let cells = |of_each: &str| {
            let cells = options.cells.iter();
            let cells: Vec<String> = cells.map(|cell| format!("{cell}={{{of_each}}}")).collect();
            format!("service.cells={{{}}}", cells.join(","))
        };
        match service {
            Service::Planner => {
                settings.push(format!("service.store={}", path("sessions")));
                let from = match options.has_network {
                    true => "{from=\"network\",percent=5.0,coarsening={cells=1,yaws=1}}",
                    false => "{from=\"all\"}",
                };
                let evaluate = options.evaluate;
                let method = format!("evaluate=\"{evaluate}\",proposals={from}");
                settings.push(cells(&format!("{method},{COARSE},{PUBLISHED}")));
            }
            Service::Perception => settings.push(format!("service.grid={{{COARSE}}}")),
            Service::Bridge => {
                settings.push(format!("service.journal={}", path("bridge")));
                settings.push(cells(""));
            }
            Service::Console => settings.push("service.listen=127.0.0.1:0".to_owned()),
            _ => {}
        }
        let own = options.settings.iter().filter(|(of, _)| *of == service);
        settings.extend(own.map(|(_, setting)| setting.clone()));
        let log = self.folder.path().join(format!("{name}.log"));
        let process = start(&format!("ppnpack-{service}"), settings, options, &log)?;
        self.processes.insert(name, process);
        Ok(())
    }

    /// A session of the stack's own.
    pub(crate) fn session(&self) -> &zenoh::Session {
        &self.session
    }

    pub(crate) fn cell(&self, index: usize) -> Result<CellClient> {
        let name = self.cells.get(index).context("there is no such cell")?;
        Ok(CellClient::new(
            Client::new(&self.session),
            Cell::new(name)?,
        ))
    }

    /// The names of all instances, and of the router.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.processes.keys().map(String::as_str)
    }

    /// Gives the resident memory of an instance, in MiB.
    pub(crate) fn resident_mib(&self, name: &str) -> Result<f64> {
        let id = self.processes.get(name).and_then(Process::id);
        let id = id.with_context(|| format!("{name} does not run"))?;
        let status = std::fs::read_to_string(format!("/proc/{id}/status"))?;
        let line = status.lines().find(|line| line.starts_with("VmRSS:"));
        let kib = line.and_then(|line| line.split_whitespace().nth(1));
        let kib: f64 = kib.context("the system tells no VmRSS")?.parse()?;
        Ok(kib / 1024.0)
    }

    pub(crate) fn log(&self, name: &str) -> Result<String> {
        let path = self.folder.path().join(format!("{name}.log"));
        Ok(std::fs::read_to_string(path)?)
    }

    /// The admin port of an instance, once it is open.
    #[cfg(test)]
    pub(crate) fn admin(&self, name: &str) -> Result<std::net::SocketAddr> {
        let log = self.log(name)?;
        let address = log.rsplit_once("admin port open address=");
        let address = address.and_then(|(_, rest)| rest.split_whitespace().next());
        let address = address.with_context(|| format!("{name} tells no admin port: {log}"))?;
        Ok(address.parse()?)
    }

    /// Waits until an instance has ended by itself, with an error.
    #[cfg(test)]
    pub(crate) fn wait_failed(&mut self, name: &str) -> Result<()> {
        let status = self.process(name)?.wait()?;
        ensure!(
            !status.success(),
            "{name} ended with {status}: {}",
            self.log(name)?
        );
        Ok(())
    }

    /// Sends a signal to an instance, such as `planner-1`, or to the `router`.
    pub(crate) fn signal(&mut self, name: &str, signal: Signal) -> Result<()> {
        let process = self.process(name)?;
        process.send(signal)?;
        if matches!(signal, Signal::SIGKILL | Signal::SIGTERM) {
            let status = process.wait()?;
            ensure!(
                signal == Signal::SIGKILL || status.success(),
                "{name} ended with {status}: {}",
                self.log(name)?
            );
        }
        Ok(())
    }

    pub(crate) fn restart(&mut self, name: &str) -> Result<()> {
        let process = self.process(name)?;
        ensure!(process.id().is_none(), "{name} runs already");
        process.start()
    }

    pub(crate) fn kill(&mut self, name: &str) -> Result<()> {
        self.signal(name, Signal::SIGKILL)?;
        self.restart(name)
    }

    fn process(&mut self, name: &str) -> Result<&mut Process> {
        let process = self.processes.get_mut(name);
        process.with_context(|| format!("there is no {name}"))
    }

    /// Waits until an instance is alive and ready.
    pub(crate) fn wait_ready(&self, name: &str) -> Result<()> {
        let (service, instance) = name.rsplit_once('-').unwrap_or((name, "1"));
        let service = Service::ALL.iter().find(|known| known.as_str() == service);
        let service = *service.with_context(|| format!("{name} is no service"))?;
        let instance = Instance::new(&format!("{service}-{instance}"))?;
        let deadline = Instant::now() + START_LIMIT;
        let alive = Alive::watch(&self.session, service)?;
        alive.wait(deadline, |alive| alive.contains(&instance));
        let client = Client::new(&self.session);
        loop {
            match client.health(service, &instance, deadline) {
                Ok(health) if health.is_ready => return Ok(()),
                Ok(health) if Instant::now() > deadline => {
                    return Err(anyhow!(
                        "{name} is not ready: {:?}\n{}",
                        health.checks,
                        self.log(name)?
                    ));
                }
                // Ready is polled: there is no event for it.
                Ok(_) => std::thread::sleep(Duration::from_millis(10)),
                Err(error) => return Err(anyhow!("{name}: {error}\n{}", self.log(name)?)),
            }
        }
    }
}

/// Starts a program with these settings, and the options' environment.
fn start(program: &str, settings: Vec<String>, options: &Options, log: &Path) -> Result<Process> {
    let settings = settings.into_iter();
    let arguments = settings.flat_map(|setting| ["--set".to_owned(), setting]);
    let (program, arguments) = (beside(program)?, arguments.collect());
    let mut process = Process::new(program, arguments, &options.environment, log);
    process.start()?;
    Ok(process)
}

/// A session of its own with a router.
pub(crate) fn connect(endpoint: &str) -> Result<zenoh::Session> {
    let settings = ZenohSettings {
        connect: Some(Endpoints(vec![endpoint.to_owned()])),
        ..ZenohSettings::default()
    };
    let config = settings.to_zenoh()?;
    let deadline = Instant::now() + START_LIMIT;
    loop {
        match zenoh::open(config.clone()).wait() {
            Ok(session) => return Ok(session),
            Err(error) if Instant::now() > deadline => {
                return Err(anyhow!("the router does not answer: {error}"));
            }
            // The router's process has only just begun.
            Err(_) => std::thread::sleep(Duration::from_millis(20)),
        }
    }
}

/// A port that was free a moment ago: the router needs one that it can be started on again.
fn free_port() -> Result<u16> {
    Ok(TcpListener::bind("127.0.0.1:0")?.local_addr()?.port())
}
