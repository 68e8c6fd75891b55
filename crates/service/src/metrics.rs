//! Metrics. Each has its name here and nowhere else.

use std::sync::OnceLock;

use metrics::{Counter, Gauge, Histogram, Key, KeyName, Label, Level, Metadata, SharedString};
use metrics_exporter_prometheus::{BuildError, Matcher, PrometheusBuilder, PrometheusHandle};
use ppnpack_wire::keys::{Method, Service};

/// Upper bounds of the buckets of durations, in seconds.
const DURATION_BUCKETS_S: [f64; 16] = [
    0.0001, 0.0002, 0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0,
    10.0,
];

static METADATA: Metadata<'static> = Metadata::new("ppnpack", Level::INFO, None);
static RECORDER: OnceLock<PrometheusHandle> = OnceLock::new();

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Counter,
    Gauge,
    Duration,
}

macro_rules! metrics {
    ($($(#[$doc:meta])* $variant:ident: $kind:ident = $name:literal, $help:literal;)*) => {
        /// A metric.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum Metric {
            $(#[doc = $help] $(#[$doc])* $variant,)*
        }

        impl Metric {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$variant,)*];

            /// Gives its name.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }

            /// Describes it.
            pub fn help(self) -> &'static str {
                match self {
                    $(Self::$variant => $help,)*
                }
            }

            fn kind(self) -> Kind {
                match self {
                    $(Self::$variant => Kind::$kind,)*
                }
            }
        }
    };
}

metrics! {
    RequestsTotal: Counter = "ppnpack_requests_total",
        "Requests answered. Labels: service, method, status.";
    RequestQueueSeconds: Duration = "ppnpack_request_queue_seconds",
        "How long requests waited for a thread. Labels: service, method.";
    RequestWorkSeconds: Duration = "ppnpack_request_work_seconds",
        "How long a thread worked on requests. Labels: service, method.";
    CallsTotal: Counter = "ppnpack_calls_total",
        "Requests made of others. Labels: service, method, outcome (ok, refused, no_answer, timed_out, malformed, failed).";
    CallSeconds: Duration = "ppnpack_call_seconds",
        "How long others took to answer. Labels: service, method.";
    StrayRepliesTotal: Counter = "ppnpack_stray_replies_total",
        "Replies dropped because they came late or belong to another request. Labels: service, method.";
    MalformedTotal: Counter = "ppnpack_malformed_total",
        "Messages refused because they are no message of their kind. Labels: kind (the stream, or service and method).";
    PublishedTotal: Counter = "ppnpack_published_total",
        "Messages published. Labels: stream.";
    ReceivedTotal: Counter = "ppnpack_received_total",
        "Messages received from streams. Labels: stream; cell where the newest of one cell is read.";
    CloudsTotal: Counter = "ppnpack_clouds_total",
        "Clouds by what became of them. Labels: fate (mapped, replaced, malformed, late, repeated, unserved, failed, no_room).";
    DoubtsTotal: Counter = "ppnpack_doubts_total",
        "Heightmaps that nothing is planned on. Labels: cell, kind (of the doubt).";
    StaleScenesTotal: Counter = "ppnpack_stale_scenes_total",
        "Plans that failed because no heightmap came that may be planned on. Labels: cell.";
    DecisionsTotal: Counter = "ppnpack_decisions_total",
        "Decisions. Labels: cell, is_degraded (true, false).";
    SessionsEndedTotal: Counter = "ppnpack_sessions_ended_total",
        "Sessions that came to their end. Labels: cell, end.";
    OutcomesTotal: Counter = "ppnpack_outcomes_total",
        "Placements that ended. Labels: cell, kind (of the outcome).";
    OverwrittenTotal: Counter = "ppnpack_overwritten_total",
        "Messages that a newer one replaced before they were read. Labels: stream.";
    ControlsTotal: Counter = "ppnpack_controls_total",
        "Controls of the operator's page. Labels: action, outcome (done, refused, unanswered).";
    ConsolePages: Gauge = "ppnpack_console_pages",
        "Operator's pages that are connected.";
    Ready: Gauge = "ppnpack_ready",
        "1 while the process is ready, else 0.";
    RouterSessions: Gauge = "ppnpack_router_sessions",
        "Sessions that a router has with others.";
    SessionsLimit: Gauge = "ppnpack_sessions_limit",
        "The most sessions that others may have with this process.";
    ResidentBytes: Gauge = "ppnpack_resident_bytes",
        "Memory of this process.";
    MemoryLimitBytes: Gauge = "ppnpack_memory_limit_bytes",
        "Memory that this process may have, where its control group limits it.";
    WarningsTotal: Counter = "ppnpack_warnings_total",
        "Warnings and errors in the log, whether or not they are shown. Labels: of (the crate).";
    CertificateEnds: Gauge = "ppnpack_certificate_ends",
        "When a certificate of this process ends, in seconds since 1970. Labels: of (certificate, root_ca).";
}

fn key(metric: Metric, labels: &[(&'static str, &str)]) -> Key {
    let labels: Vec<Label> = labels
        .iter()
        .map(|(name, value)| Label::new(*name, (*value).to_owned()))
        .collect();
    Key::from_parts(KeyName::from_const_str(metric.name()), labels)
}

/// Makes the labels of a service and method.
pub(crate) fn method_labels(service: Service, method: Method) -> [(&'static str, &'static str); 2] {
    [("service", service.as_str()), ("method", method.as_str())]
}

/// Gives the counter of a metric with these labels. Keep it where it is used often.
pub fn counter(metric: Metric, labels: &[(&'static str, &str)]) -> Counter {
    metrics::with_recorder(|recorder| recorder.register_counter(&key(metric, labels), &METADATA))
}

/// Gives the gauge of a metric with these labels. Keep it where it is used often.
pub fn gauge(metric: Metric, labels: &[(&'static str, &str)]) -> Gauge {
    metrics::with_recorder(|recorder| recorder.register_gauge(&key(metric, labels), &METADATA))
}

/// Gives the histogram of a metric with these labels. Keep it where it is used often.
pub fn histogram(metric: Metric, labels: &[(&'static str, &str)]) -> Histogram {
    metrics::with_recorder(|recorder| recorder.register_histogram(&key(metric, labels), &METADATA))
}

/// Writes all metrics for Prometheus; nothing where [`install`] was not called.
pub fn render() -> String {
    let recorder = RECORDER.get();
    recorder.map(PrometheusHandle::render).unwrap_or_default()
}

/// Begins to count; counters that were made before stay still. From then on [`tidy`] has to be
/// called every few seconds.
///
/// # Errors
/// [`BuildError`] where something else counts already.
pub fn install() -> Result<(), BuildError> {
    let mut builder = PrometheusBuilder::new();
    for metric in Metric::ALL {
        if metric.kind() == Kind::Duration {
            let name = Matcher::Full(metric.name().to_owned());
            builder = builder.set_buckets_for_metric(name, &DURATION_BUCKETS_S)?;
        }
    }
    let handle = builder.install_recorder()?;
    metrics::with_recorder(|recorder| {
        for metric in Metric::ALL {
            let name = KeyName::from_const_str(metric.name());
            let help = SharedString::const_str(metric.help());
            match metric.kind() {
                Kind::Counter => recorder.describe_counter(name, None, help),
                Kind::Gauge => recorder.describe_gauge(name, None, help),
                Kind::Duration => recorder.describe_histogram(name, None, help),
            }
        }
    });
    RECORDER.set(handle).ok();
    Ok(())
}

/// Sorts the values of histograms into buckets, as each takes memory until then, and measures the
/// memory.
pub fn tidy() {
    if let Some(handle) = RECORDER.get() {
        handle.run_upkeep();
    }
    for (metric, bytes) in [
        (Metric::ResidentBytes, resident_bytes()),
        (Metric::MemoryLimitBytes, memory_limit_bytes()),
    ] {
        if let Some(bytes) = bytes {
            gauge(metric, &[]).set(bytes);
        }
    }
}

fn resident_bytes() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let mut lines = status.lines();
    let line = lines.find_map(|line| line.strip_prefix("VmRSS:"))?;
    let kib: f64 = line.trim().strip_suffix(" kB")?.parse().ok()?;
    Some(kib * 1024.0)
}

/// Gives the limit of the container, if there is one.
fn memory_limit_bytes() -> Option<f64> {
    let limit = std::fs::read_to_string("/sys/fs/cgroup/memory.max").ok()?;
    limit.trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn what_is_counted_is_shown() {
        install().unwrap();
        counter(Metric::PublishedTotal, &[("stream", "plan")]).increment(2);
        histogram(Metric::CallSeconds, &[("method", "plan")]).record(0.0015);
        gauge(Metric::Ready, &[]).set(1.0);
        tidy();
        let text = render();
        let mut lines = text.lines();
        let resident = lines.find_map(|line| line.strip_prefix("ppnpack_resident_bytes "));
        let resident: f64 = resident.unwrap().parse().unwrap();
        assert!(resident > 1e6, "a process has a megabyte: {resident}");
        for line in [
            "ppnpack_published_total{stream=\"plan\"} 2",
            "ppnpack_call_seconds_bucket{method=\"plan\",le=\"0.002\"} 1",
            "ppnpack_call_seconds_bucket{method=\"plan\",le=\"0.001\"} 0",
            "ppnpack_ready 1",
            "# HELP ppnpack_ready 1 while the process is ready, else 0.",
        ] {
            assert!(text.contains(line), "{line} is not in:\n{text}");
        }
    }

    #[test]
    fn names_are_those_of_prometheus() {
        let names = Metric::ALL.iter().map(|metric| metric.name());
        assert_eq!(BTreeSet::from_iter(names).len(), Metric::ALL.len());
        for metric in Metric::ALL {
            let name = metric.name();
            assert!(name.starts_with("ppnpack_"), "{name}");
            let suffixes = ["_total", "_seconds"].map(|suffix| name.ends_with(suffix));
            let kinds = [Kind::Counter, Kind::Duration].map(|kind| metric.kind() == kind);
            assert_eq!(kinds, suffixes, "{name}");
        }
    }
}
