//! The sensors of a cell.

use std::time::{Duration, Instant};

/// Sensors whose clouds make one heightmap together.
#[derive(Debug, Clone)]
pub(crate) struct Sensors {
    /// One without a name stands for any.
    names: Vec<String>,
}

impl Sensors {
    /// Makes sensors with these names; without any, there is one, whatever its name.
    pub(crate) fn new(names: &[String]) -> Self {
        let names = match names {
            [] => vec![String::new()],
            names => names.to_vec(),
        };
        Self { names }
    }

    pub(crate) fn count(&self) -> usize {
        self.names.len()
    }

    /// Gives the index of the sensor of this name, where it belongs to the cell.
    pub(crate) fn index_of(&self, name: &str) -> Option<usize> {
        let is_own = |own: &String| own.is_empty() || own == name;
        self.names.iter().position(is_own)
    }

    /// Names the sensors that sent nothing for a while, for people; `None` where all sent
    /// something.
    ///
    /// `last` is when the last cloud of each came.
    pub(crate) fn silence(&self, last: &[Option<Instant>], patience: Duration) -> Option<String> {
        let now = Instant::now();
        let silent = |(name, last): (&String, &Option<Instant>)| {
            let sensor = match name.as_str() {
                "" => "its sensor".to_owned(),
                name => format!("its sensor \"{name}\""),
            };
            match last {
                None => Some(format!("{sensor} has sent nothing yet")),
                Some(last) if now.saturating_duration_since(*last) > patience => {
                    let silent_s = now.saturating_duration_since(*last).as_secs_f64();
                    Some(format!("{sensor} has sent nothing for {silent_s:.1} s"))
                }
                Some(_) => None,
            }
        };
        let silent: Vec<String> = self.names.iter().zip(last).filter_map(silent).collect();
        (!silent.is_empty()).then(|| silent.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sensor_without_a_name_is_any() {
        let any = Sensors::new(&[]);
        assert_eq!((any.count(), any.index_of("left")), (1, Some(0)));
        let two = Sensors::new(&["left".to_owned(), "right".to_owned()]);
        assert_eq!(two.index_of("right"), Some(1));
        assert_eq!(two.index_of(""), None);
    }

    #[test]
    fn who_is_silent_is_named() {
        let two = Sensors::new(&["left".to_owned(), "right".to_owned()]);
        let now = Instant::now();
        let patience = Duration::from_secs(1);
        assert_eq!(two.silence(&[Some(now), Some(now)], patience), None);
        let long_ago = now.checked_sub(Duration::from_secs(3));
        let silence = two.silence(&[None, long_ago], patience).unwrap();
        assert!(
            silence.contains("\"left\" has sent nothing yet"),
            "{silence}"
        );
        assert!(
            silence.contains("\"right\" has sent nothing for 3.0 s"),
            "{silence}"
        );
    }
}
