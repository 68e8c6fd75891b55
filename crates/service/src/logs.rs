//! Logs: one line an event, on standard error.

use std::io::IsTerminal;

use tracing::Subscriber;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::registry::{LookupSpan, Registry};
use tracing_subscriber::util::SubscriberInitExt;
use tracing_subscriber::{Layer, fmt};

use crate::configuration::{LogFormat, LogSettings};
use crate::error::ServiceError;

/// A layer that can stand under that of the logs.
pub(crate) type BoxedLayer = Box<dyn Layer<Registry> + Send + Sync>;

/// Sets logs up for the whole process, and with them the layer of the traces. Panics are logged too.
pub(crate) fn init(settings: &LogSettings, traces: Option<BoxedLayer>) -> Result<(), ServiceError> {
    let filter = settings.to_filter()?;
    tracing_subscriber::registry()
        .with(traces)
        .with(lines(settings.format).with_filter(filter))
        .try_init()
        .map_err(|error| ServiceError::observability("logs", &error))?;
    std::panic::set_hook(Box::new(|panic| {
        let thread = std::thread::current();
        let thread = thread.name().unwrap_or("unnamed");
        tracing::error!(thread, "{panic}");
    }));
    Ok(())
}

fn lines<S>(format: LogFormat) -> Box<dyn Layer<S> + Send + Sync>
where
    S: Subscriber + for<'span> LookupSpan<'span>,
{
    let layer = fmt::layer().with_writer(std::io::stderr);
    match format {
        LogFormat::Json => Box::new(layer.json().flatten_event(true).with_ansi(false)),
        LogFormat::Human => Box::new(layer.with_ansi(std::io::stderr().is_terminal())),
    }
}
