//! Logs: one line an event, on standard error.

use std::io::IsTerminal;

use tracing::level_filters::LevelFilter;
use tracing::{Event, Subscriber};
use tracing_subscriber::layer::Context;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::registry::{LookupSpan, Registry};
use tracing_subscriber::util::SubscriberInitExt;
use tracing_subscriber::{Layer, fmt};

use crate::configuration::{LogFormat, LogSettings};
use crate::error::ServiceError;
use crate::metrics::{self, Metric};

/// A layer that can stand under that of the logs.
pub(crate) type BoxedLayer = Box<dyn Layer<Registry> + Send + Sync>;

/// Sets logs up for the whole process, and with them the layer of the traces. Panics are logged
/// too.
pub(crate) fn init(settings: &LogSettings, traces: Option<BoxedLayer>) -> Result<(), ServiceError> {
    let filter = settings.to_filter()?;
    tracing_subscriber::registry()
        .with(traces)
        .with(lines(settings.format).with_filter(filter))
        .with(Counting.with_filter(LevelFilter::WARN))
        .try_init()
        .map_err(|error| ServiceError::start(format_args!("logs cannot be set up: {error}")))?;
    std::panic::set_hook(Box::new(|panic| {
        let thread = std::thread::current();
        let thread = thread.name().unwrap_or("unnamed");
        tracing::error!(thread, "{panic}");
    }));
    Ok(())
}

/// Counts warnings and errors, by the crate that they come from.
struct Counting;

impl<S: Subscriber> Layer<S> for Counting {
    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        let target = event.metadata().target();
        let of = target.split("::").next().unwrap_or_default();
        metrics::counter(Metric::WarningsTotal, &[("of", of)]).increment(1);
    }
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
