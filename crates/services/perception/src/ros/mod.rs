//! Cameras whose drivers publish clouds as ROS 2 does: over `rmw_zenoh`, or through the bridge of
//! ROS 2 over DDS.
//!
//! A cloud is read on Zenoh's thread, as those of the workspace's own stream are: its points are
//! copied once, and nothing is waited for. The attachment of `rmw_zenoh` (a count, a time, who
//! published) is not read.

pub(crate) mod settings;

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use ppnpack_catalogue::unit::LengthUnit;
use ppnpack_service::ServiceError;
use ppnpack_service::metrics::{self, Metric};
use ppnpack_service::process::Process;
use ppnpack_wire::convert::cloud::to_metres;
use ppnpack_wire::keys::Stream;
use ppnpack_wire::ros::{PointCloud2, to_cloud, topic};
use ppnpack_wire::{WireError, v1};
use zenoh::Wait;
use zenoh::pubsub::Subscriber;
use zenoh::sample::Sample;

use crate::counts::{Counts, Fate};
use crate::router::Router;
use crate::tray;
use settings::{Camera, RosCamera};

/// Takes the clouds of a camera, until the subscriber is dropped.
pub(crate) fn subscribe(
    process: &Process,
    camera: &RosCamera,
    router: &Arc<Router>,
    trays: &tray::Clouds,
    counts: &Arc<Counts>,
) -> Result<Subscriber<()>, ServiceError> {
    let camera = camera.read();
    let camera = camera.map_err(|reason| ServiceError::start(format_args!("ros: {reason}")))?;
    let key = camera.key.clone();
    let stream = match camera.is_tray {
        true => Stream::TrayCloud,
        false => Stream::Cloud,
    };
    let received = metrics::counter(Metric::ReceivedTotal, &[("stream", stream.as_str())]);
    let (router, trays, counts) = (Arc::clone(router), trays.clone(), Arc::clone(counts));
    let sequence = AtomicU64::new(1);
    let callback = move |sample: Sample| {
        received.increment(1);
        let Some(room) = router.room(&camera.cell, sample.payload().len()) else {
            return;
        };
        match read(&sample, &sequence, &camera) {
            Ok(mut cloud) => {
                cloud.sensor.clone_from(&camera.sensor);
                let cloud = room.with(cloud);
                match camera.is_tray {
                    true => trays.put(&camera.cell, cloud),
                    false => router.route(&camera.cell, cloud),
                }
            }
            Err(error) => {
                let reason = format!("{}: {error}", sample.key_expr());
                counts.refuse(&camera.cell, Fate::Malformed, &reason);
            }
        }
    };
    let session = process.session();
    let subscriber = session.declare_subscriber(key.clone()).callback(callback);
    let refused = |error: zenoh::Error| ServiceError::Zenoh {
        action: format!("subscribing {key}"),
        reason: error.to_string(),
    };
    subscriber.wait().map_err(refused)
}

/// Reads a cloud, and gives it the next number.
fn read(
    sample: &Sample,
    sequence: &AtomicU64,
    camera: &Camera,
) -> Result<v1::PointCloud, WireError> {
    topic::check_key(sample.key_expr())?;
    // A larger payload is not even put together.
    topic::check_size(sample.payload().len())?;
    let payload = sample.payload().to_bytes();
    let message = PointCloud2::read(&payload)?;
    let number = sequence.fetch_add(1, Ordering::Relaxed);
    let mut cloud = to_cloud(&message, number, &camera.container_from_sensor)?;
    if camera.unit != LengthUnit::Metres {
        to_metres(&mut cloud, camera.unit.metres())?;
    }
    Ok(cloud)
}
