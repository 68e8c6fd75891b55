//! The run of a process, from start to end.

mod arguments;
mod signals;

use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::sync_channel;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use ppnpack_wire::keys::Service;
use zenoh::Wait;

use crate::configuration::{
    AdminListen, Configuration, ConfigurationError, ServiceSettings, Sources,
};
use crate::error::ServiceError;
use crate::metrics::Metric;
use crate::process::{Core, Process, thread};
use crate::shutdown::Shutdown;
use crate::supervision::Supervisor;
use crate::telemetry::Telemetry;
use crate::{admin, logs, metrics, session};

use arguments::Arguments;

/// Exit code of a wrong command line or configuration (`EX_USAGE`).
const EXIT_USAGE: u8 = 64;

/// Maximum time for closing the session, and for sending the traces.
const CLOSING_TIMEOUT: Duration = Duration::from_secs(2);

/// Maximum time beyond its grace after which a service is left behind.
const GRACE_MARGIN: Duration = Duration::from_millis(500);

/// A started service. Dropping it undeclares everything and ends its threads.
pub trait Running: Send {
    /// Undeclares, and finishes what is in flight.
    ///
    /// # Errors
    /// The work that was left undone at the deadline, in words.
    fn finish(self: Box<Self>, deadline: Instant) -> Result<(), String>;
}

/// Waits for threads that were asked to end.
///
/// # Errors
/// Names those that still worked at the deadline, or panicked.
pub fn join(threads: Vec<JoinHandle<()>>, deadline: Instant) -> Result<(), String> {
    let mut left = Vec::new();
    for thread in threads {
        let name = thread.thread().name().unwrap_or("a thread").to_owned();
        let limit = deadline.saturating_duration_since(Instant::now());
        // A thread cannot be waited for with a limit: another one waits for it.
        match within(limit, move || thread.join().is_ok()) {
            Ok(Some(true)) => {}
            Ok(Some(false)) => left.push(format!("{name} panicked")),
            _ => left.push(format!("{name} was still working")),
        }
    }
    match left.is_empty() {
        true => Ok(()),
        false => Err(left.join(", ")),
    }
}

/// Runs a service: reads command line and configuration, serves until SIGTERM or SIGINT, and
/// finishes within its grace.
///
/// Exit codes: 0 done, 1 failed, 64 a wrong command line or configuration, which is found before
/// any port is opened.
pub fn main<S: ServiceSettings>(
    service: Service,
    start: impl FnOnce(&Process, S) -> anyhow::Result<Box<dyn Running>>,
) -> ExitCode {
    let arguments = match Arguments::read(service) {
        Ok(arguments) => arguments,
        Err(error) => {
            error.print().ok();
            return ExitCode::from(if error.use_stderr() { EXIT_USAGE } else { 0 });
        }
    };
    let configuration = match load::<S>(service, &arguments) {
        Ok(configuration) => configuration,
        Err(error) => {
            eprintln!("ppnpack-{service}: {error}");
            return ExitCode::from(EXIT_USAGE);
        }
    };
    let done: anyhow::Result<String> = if arguments.validate_config {
        Ok("the configuration is valid".to_owned())
    } else if arguments.print_config {
        configuration.to_toml().map_err(anyhow::Error::new)
    } else if arguments.after_restore {
        let restored = configuration.service.after_restore();
        restored.map_err(anyhow::Error::msg)
    } else {
        match run(service, configuration, start) {
            Ok(code) => return code,
            Err(error) => Err(error.into()),
        }
    };
    match done {
        Ok(text) => {
            println!("{}", text.trim_end());
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("ppnpack-{service}: {error}");
            ExitCode::FAILURE
        }
    }
}

fn load<S: ServiceSettings>(
    service: Service,
    arguments: &Arguments,
) -> Result<Configuration<S>, ConfigurationError> {
    let variables = std::env::vars_os().filter_map(|(name, value)| {
        let value = value.to_string_lossy().into_owned();
        Some((name.into_string().ok()?, value))
    });
    let sources = Sources {
        file: arguments.config.as_deref(),
        environment: variables.collect(),
        assignments: &arguments.set,
    };
    Configuration::load(service, &sources)
}

fn run<S: ServiceSettings>(
    service: Service,
    configuration: Configuration<S>,
    start: impl FnOnce(&Process, S) -> anyhow::Result<Box<dyn Running>>,
) -> Result<ExitCode, ServiceError> {
    let (instance, hash) = (configuration.instance()?, configuration.hash());
    let supervisor = Supervisor::new(Shutdown::default());
    let core = Arc::new(Core::new(service, instance, hash, supervisor));
    let telemetry = Telemetry::start(&configuration.telemetry, &core)?;
    logs::init(&configuration.log, telemetry.layer())?;
    let code = match run_logged(&core, configuration, start) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            tracing::error!("{error:#}");
            ExitCode::FAILURE
        }
    };
    telemetry.finish(CLOSING_TIMEOUT);
    Ok(code)
}

fn run_logged<S: ServiceSettings>(
    core: &Arc<Core>,
    configuration: Configuration<S>,
    start: impl FnOnce(&Process, S) -> anyhow::Result<Box<dyn Running>>,
) -> anyhow::Result<()> {
    metrics::install()?;
    for (of, end_s) in configuration.zenoh.tls.ends()? {
        metrics::gauge(Metric::CertificateEnds, &[("of", of)]).set(end_s as f64);
    }
    // One thread is plenty for signals and the admin port.
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(1)
        .thread_name("admin")
        .enable_all()
        .build()
        .map_err(|source| ServiceError::System {
            what: "starting the admin thread",
            source,
        })?;
    let shutdown = core.supervisor.shutdown();
    signals::watch(&runtime, shutdown)?;
    let serving = core.health.check("service");
    let connected = core.health.check("zenoh");
    if let AdminListen::At(address) = configuration.admin.listen {
        let address = admin::serve(runtime.handle(), address, Arc::clone(core))?;
        tracing::info!(%address, "admin port open");
    }
    let zenoh = &configuration.zenoh;
    metrics::gauge(Metric::SessionsLimit, &[]).set(zenoh.max_sessions as f64);
    let Some(session) = session::open(zenoh, &connected, shutdown)? else {
        tracing::info!("asked to end before there was a connection");
        return Ok(());
    };
    let process = Process::new(session.clone(), zenoh.max_message_bytes, Arc::clone(core))?;
    session::watch(&process, zenoh, connected)?;
    let grace = configuration.shutdown_grace();
    let running = start(&process, configuration.service)?;
    serving.pass();
    core.has_started.store(true, Ordering::Release);
    tracing::info!(service = %core.service, instance = %core.instance, "started");
    shutdown.wait();
    serving.fail("shutting down");
    core.health.end_quietly();
    finish(running, grace)?;
    drop(process);
    match within(CLOSING_TIMEOUT, move || session.close().wait())? {
        Some(Ok(())) => {}
        Some(Err(error)) => tracing::warn!(%error, "closing the Zenoh session"),
        None => tracing::warn!("the Zenoh session did not close in time"),
    }
    match core.supervisor.fault() {
        Some(fault) => Err(anyhow::Error::msg(fault)),
        None => Ok(()),
    }
}

/// Finishes all that is in flight, and says whether that was in time.
fn finish(running: Box<dyn Running>, grace: Duration) -> anyhow::Result<()> {
    tracing::info!(grace_s = grace.as_secs_f64(), "shutting down");
    let deadline = Instant::now() + grace;
    match within(grace + GRACE_MARGIN, move || running.finish(deadline))? {
        Some(Ok(())) => tracing::info!("finished everything that was in flight"),
        Some(Err(left)) => tracing::warn!(left, "ended before everything was finished"),
        None => tracing::warn!("the service did not finish within its grace and is left behind"),
    }
    Ok(())
}

/// Gives the result of work that is done in time.
fn within<T: Send + 'static>(
    duration: Duration,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<Option<T>, ServiceError> {
    let (sender, receiver) = sync_channel(1);
    drop(thread("ending", move || sender.send(work()).ok())?);
    Ok(receiver.recv_timeout(duration).ok())
}
