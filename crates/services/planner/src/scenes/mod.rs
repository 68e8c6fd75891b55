//! The newest heightmap of a cell, and whether it may be planned on.

use std::time::{Duration, Instant};

use ppnpack_packing::kernel::grid::Grid;
use ppnpack_packing::scene::Scene;
use ppnpack_service::ServiceError;
use ppnpack_service::clock::Boottime;
use ppnpack_service::process::Process;
use ppnpack_service::rpc::Client;
use ppnpack_service::stream::{Arrived, Latest};
use ppnpack_wire::keys::{Cell, Stream};
use ppnpack_wire::{MAX_MESSAGE_BYTES, WireError, convert, v1};

/// Maximum wait for the stream before perception is asked: streams drop what they cannot deliver.
const STREAM_PATIENCE: Duration = Duration::from_millis(30);

/// Maximum wait for perception, which answers when it has the heightmap, before the stream is
/// looked at again.
const ANSWER_PATIENCE: Duration = Duration::from_millis(300);

/// Maximum number of doubts about a heightmap that are told.
const MAX_DOUBTS: usize = 16;

/// Limits to the heightmaps that may be planned on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SceneLimits {
    /// Maximum age of a heightmap's cloud.
    pub(crate) age: Duration,
    /// Maximum time of a cloud on its way.
    pub(crate) sensor_latency: Duration,
}

/// The heightmaps of a cell, from the stream, or on request where that is silent.
pub(crate) struct Scenes {
    cell: Cell,
    grid: Grid,
    stream: Latest<v1::Heightmap>,
    client: Client,
    limits: SceneLimits,
    newest: Option<Seen>,
    /// Time when the last clouds came of a heightmap by other settings than the newest.
    other_settings_at: Option<Boottime>,
    /// Heightmaps without a state number show what was done last when their clouds came after this.
    shown_after: Option<Boottime>,
    complaint: String,
}

/// A heightmap that came.
#[derive(Debug, Clone)]
pub(crate) struct Seen {
    pub(crate) id: v1::HeightmapId,
    pub(crate) state_number: u64,
    pub(crate) scene: Scene,
    /// A hash of perception's settings.
    settings: u64,
    /// When the first of its clouds came to perception.
    received: Boottime,
    /// Why nothing is to be planned on it.
    doubts: Option<String>,
    /// Contradiction to what is believed to lie there.
    denied: Option<String>,
}

impl Scenes {
    pub(crate) fn subscribe(
        process: &Process,
        cell: &Cell,
        grid: &Grid,
        limits: SceneLimits,
    ) -> Result<Self, ServiceError> {
        Ok(Self {
            cell: cell.clone(),
            grid: grid.clone(),
            stream: Latest::subscribe(process, cell, Stream::Heightmap, MAX_MESSAGE_BYTES)?,
            client: Client::new(process.session()),
            limits,
            newest: None,
            other_settings_at: None,
            shown_after: None,
            complaint: "none has come yet".to_owned(),
        })
    }

    /// Tells that the container's content changed at this time.
    pub(crate) fn changed(&mut self, at: Boottime) {
        self.shown_after = Some(at + self.limits.sensor_latency);
    }

    /// Has a heightmap count as doubtful, for this reason, until it is
    /// [reconsidered](Self::reconsider).
    pub(crate) fn deny(&mut self, seen: &Seen, reason: String) {
        if let Some(newest) = self.newest.as_mut().filter(|newest| newest.id == seen.id) {
            newest.denied = Some(reason);
        }
    }

    /// Has a heightmap that was denied count again: what is believed may change.
    pub(crate) fn reconsider(&mut self) {
        if let Some(newest) = &mut self.newest {
            newest.denied = None;
        }
    }

    /// Waits until the deadline for a heightmap that shows the state of this number or a later one.
    ///
    /// # Errors
    /// Why there is none.
    pub(crate) fn current(
        &mut self,
        least_state_number: u64,
        deadline: Instant,
    ) -> Result<Seen, String> {
        loop {
            if let Some(arrived) = self.stream.take() {
                self.take_over_new(arrived, deadline);
            }
            if let Some(seen) = &self.newest
                && self.is_usable(seen, least_state_number)
            {
                return Ok(seen.clone());
            }
            if Instant::now() >= deadline {
                return Err(self.why(least_state_number));
            }
            let until = deadline.min(Instant::now() + STREAM_PATIENCE);
            match self.stream.wait(until) {
                Some(arrived) => self.take_over_new(arrived, deadline),
                None => self.ask(least_state_number, deadline),
            }
        }
    }

    /// Asks perception, which keeps the newest heightmap. An answer was on its way no longer than
    /// since it was asked for.
    fn ask(&mut self, least_state_number: u64, deadline: Instant) {
        let asked = Boottime::now();
        let until = deadline.min(Instant::now() + ANSWER_PATIENCE);
        let request = v1::HeightmapRequest {
            least_state_number,
            ..v1::HeightmapRequest::default()
        };
        match self.client.call(&self.cell, request, until) {
            Ok(reply) => {
                let heightmap = reply
                    .heightmap
                    .ok_or_else(|| "perception sent none".to_owned());
                let age = Duration::from_nanos(reply.age_ns).saturating_add(asked.elapsed());
                self.take_over(heightmap, age);
            }
            Err(error) => self.complaint = format!("perception: {error}"),
        }
    }

    /// Takes a heightmap that was published; nobody may have looked for it since it came. One
    /// without a state number is asked for instead: nobody knows how long this one was on its way,
    /// and only its age says what it shows.
    fn take_over_new(
        &mut self,
        arrived: Arrived<Result<v1::Heightmap, WireError>>,
        deadline: Instant,
    ) {
        let heightmap = arrived.message.map_err(|error| error.to_string());
        if heightmap.as_ref().is_ok_and(|new| new.state_number == 0) {
            return self.ask(0, deadline);
        }
        self.take_over(heightmap, arrived.at.elapsed());
    }

    fn take_over(&mut self, heightmap: Result<v1::Heightmap, String>, age: Duration) {
        match heightmap.and_then(|heightmap| self.read(&heightmap, age)) {
            Ok(seen) if self.is_newer(&seen) => {
                self.compare_settings(&seen);
                self.newest = Some(seen);
            }
            Ok(_) => {}
            Err(error) => {
                tracing::warn!(cell = %self.cell, error, "a heightmap is not used");
                self.complaint = error;
            }
        }
    }

    /// Notices that another perception has begun, or begun anew, with other settings.
    fn compare_settings(&mut self, seen: &Seen) {
        let newest = self.newest.as_ref();
        if let Some(other) = newest.filter(|newest| newest.settings != seen.settings) {
            let at = other.received;
            if !self.has_other_settings() {
                tracing::warn!(cell = %self.cell, "heightmaps of different settings come");
            }
            self.other_settings_at = Some(at);
        }
    }

    /// Says whether heightmaps of different settings came of late.
    fn has_other_settings(&self) -> bool {
        let at = self.other_settings_at;
        at.is_some_and(|at| at.elapsed() <= self.limits.age)
    }

    /// Says whether a heightmap is newer: those of one epoch come in order; a repeated one is not.
    fn is_newer(&self, seen: &Seen) -> bool {
        self.newest.as_ref().is_none_or(|newest| {
            newest.id.epoch != seen.id.epoch || newest.id.sequence < seen.id.sequence
        })
    }

    fn read(&self, heightmap: &v1::Heightmap, age: Duration) -> Result<Seen, String> {
        let own = self.cell.as_str();
        if !heightmap.cell.is_empty() && heightmap.cell != own {
            let other = &heightmap.cell;
            return Err(format!(
                "it is of cell {other}, and came as one of cell {own}"
            ));
        }
        let (grid, scene) = convert::scene::read_required("scene", heightmap.scene.as_ref())
            .map_err(|error| error.to_string())?;
        if grid != self.grid {
            return Err(
                "it is of another grid: container, cell and yaws of perception and planner must be the same"
                    .to_owned(),
            );
        }
        let quality = heightmap.quality.clone().unwrap_or_default();
        let age = age.saturating_add(Duration::from_nanos(quality.processing_ns));
        let received = Boottime::now()
            .checked_sub(age)
            .ok_or("it is from before this machine started")?;
        Ok(Seen {
            id: heightmap.id.unwrap_or_default(),
            state_number: heightmap.state_number,
            scene,
            settings: heightmap.settings,
            received,
            doubts: doubts(&quality),
            denied: None,
        })
    }

    fn is_usable(&self, seen: &Seen, least_state_number: u64) -> bool {
        let is_recent = seen.received.elapsed() <= self.limits.age;
        let shows_all = if seen.state_number == 0 {
            self.shown_after.is_none_or(|after| seen.received > after)
        } else {
            seen.state_number >= least_state_number
        };
        let is_sure = seen.doubts.is_none() && seen.denied.is_none();
        is_recent && shows_all && is_sure && !self.has_other_settings()
    }

    fn why(&self, least_state_number: u64) -> String {
        match &self.newest {
            None => format!("there is no heightmap: {}", self.complaint),
            Some(seen) if seen.received.elapsed() > self.limits.age => format!(
                "the newest heightmap came {:.1} s ago: {}",
                seen.received.elapsed().as_secs_f64(),
                self.complaint
            ),
            Some(_) if self.has_other_settings() => {
                "two perceptions with different settings serve the cell: end one of them. Plans go on when the last picture of the other is too old"
                    .to_owned()
            }
            Some(Seen {
                doubts: Some(doubts),
                ..
            })
            | Some(Seen {
                denied: Some(doubts),
                ..
            }) => format!("the newest heightmap is doubtful: {doubts}"),
            Some(seen) if seen.state_number == 0 => {
                "no cloud came since the last report that surely shows what it changed".to_owned()
            }
            Some(seen) => format!(
                "the newest heightmap shows state {} of the cell where {least_state_number} is needed",
                seen.state_number
            ),
        }
    }
}

/// Says why nothing is to be planned on a heightmap of this quality, where that is so.
fn doubts(quality: &v1::HeightmapQuality) -> Option<String> {
    let texts = quality.doubts.iter().take(MAX_DOUBTS);
    let texts: Vec<&str> = texts.map(|doubt| doubt.message.as_str()).collect();
    (!texts.is_empty()).then(|| texts.join("; "))
}

#[cfg(test)]
mod tests;
