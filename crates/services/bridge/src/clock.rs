//! The clock by which decisions age.

use std::sync::LazyLock;
use std::time::{Duration, SystemTime};

use ppnpack_service::clock::Boottime;

/// The time at which this process looked first, by the time of day and by time passed.
static BEGAN: LazyLock<(Duration, Boottime)> = LazyLock::new(|| {
    let since_1970 = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    (since_1970.unwrap_or_default(), Boottime::now())
});

/// Nanoseconds since 1970 by the time of day when this process began, and from then on by time
/// passed, asleep or not: a clock that is set changes nothing before the next start.
pub(crate) fn now_ns() -> u64 {
    let (since_1970, began) = *BEGAN;
    let now = since_1970.saturating_add(began.elapsed());
    u64::try_from(now.as_nanos()).unwrap_or(u64::MAX)
}
