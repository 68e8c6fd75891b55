//! How long a process takes to see that nobody reads a stream: all that records of steps cost a planner while nobody looks on.
#![allow(clippy::unwrap_used, missing_docs)]

use criterion::{Criterion, criterion_group, criterion_main};
use ppnpack_service::embedded;
use ppnpack_service::stream::Publisher;
use ppnpack_wire::keys::{Cell, Service, Stream};
use ppnpack_wire::v1;

fn nobody_reads(criterion: &mut Criterion) {
    let hub = embedded::hub().unwrap();
    let process = embedded::process(&hub, Service::Planner, "planner-1").unwrap();
    let cell = Cell::new("cell-1").unwrap();
    let records: Publisher<v1::PlanningRecord> =
        Publisher::new(&process, &cell, Stream::Record).unwrap();
    assert!(!records.has_readers());
    criterion.bench_function("nobody reads a stream", |bencher| {
        bencher.iter(|| records.has_readers());
    });
}

criterion_group!(benches, nobody_reads);
criterion_main!(benches);
