//! The clock by which decisions age.

use std::sync::LazyLock;
use std::time::{Duration, SystemTime};

use ppnpack_service::clock::Boottime;

/// When this process looked first, by the time of day and by time passed.
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

/// How long ago something was decided, where that is told; what was decided later than now has no age that could be known.
pub(crate) fn age(decided_at_ns: u64) -> Option<Duration> {
    let nanoseconds = now_ns().checked_sub(decided_at_ns);
    nanoseconds.map(Duration::from_nanos)
}
