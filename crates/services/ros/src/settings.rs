//! The settings.

use std::collections::BTreeMap;

use ppnpack_perception::extrinsics::Extrinsics;
use ppnpack_service::ServiceSettings;
use ppnpack_service::configuration::{Endpoints, in_range, settings};
use ppnpack_wire::keys::Cell;

use crate::rmw::keys::Name;

const MAX_DOMAIN: u32 = 232;

settings! {
    /// Settings of the service.
    pub struct Settings {
        /// The domain of ROS (`ROS_DOMAIN_ID`).
        pub domain: u32 = 0,
        /// The router of ROS (`rmw_zenohd`), such as `tcp/127.0.0.1:7447`; without one, the stack's
        /// own.
        pub connect: Endpoints = Endpoints::default(),
        /// The beginning of the names of topics and services; the cell's name follows.
        pub namespace: String = "/ppnpack".to_owned(),
        /// How long a request of ROS may take, in seconds.
        pub request_limit_s: f64 = 30.0,
        /// The poses of the containers' frames in the frame `world`; the default is its origin.
        pub containers: BTreeMap<String, Extrinsics> = BTreeMap::new(),
    }
}

impl ServiceSettings for Settings {
    fn validate(&self) -> Result<(), String> {
        in_range("domain", self.domain, 0..=MAX_DOMAIN)?;
        in_range("request_limit_s", self.request_limit_s, 0.1..=600.0)?;
        Name::new(&self.namespace).map_err(|error| format!("namespace: {error}"))?;
        for (cell, pose) in &self.containers {
            let refused = |error: &dyn std::fmt::Display| format!("containers.{cell}: {error}");
            Cell::new(cell).map_err(|error| refused(&error))?;
            pose.pose().map_err(|error| refused(&error))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_settings_are_named() {
        type Change = fn(&mut Settings);
        let changes: [(&str, Change); 4] = [
            ("domain", |it| it.domain = 233),
            ("request_limit_s", |it| it.request_limit_s = f64::NAN),
            ("namespace", |it| it.namespace = "ppnpack".to_owned()),
            ("containers.all", |it| {
                let pose = Extrinsics {
                    position_m: [0.1, 0.1, 0.9],
                    orientation_xyzw: [1.0, 0.0, 0.0, 0.0],
                };
                it.containers.insert("all".to_owned(), pose);
            }),
        ];
        assert_eq!(Settings::default().validate(), Ok(()));
        for (expected, change) in changes {
            let mut settings = Settings::default();
            change(&mut settings);
            let reason = settings.validate().unwrap_err();
            assert!(reason.starts_with(expected), "{reason}");
        }
    }
}
