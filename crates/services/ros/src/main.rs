//! `ppnpack-ros`: the cells in ROS 2, as a process.

use std::process::ExitCode;

use ppnpack_ros_service::Settings;
use ppnpack_service as run;
use ppnpack_wire::keys::Service;

fn main() -> ExitCode {
    run::main(Service::Ros, |process, settings: Settings| {
        Ok(Box::new(ppnpack_ros_service::start(process, &settings)?))
    })
}
