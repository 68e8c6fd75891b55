//! Asks a service on this machine, at its admin port, whether it is ready: exit code 0 or 1.
//!
//! usage: `ppnpack-healthcheck [ADDRESS]`; without one, at `PPNPACK__ADMIN__LISTEN`.
//!
//! A program of its own: a container that starts its service's program every few seconds takes the
//! processor from the service. The ppn service's brings libtorch along, whose loading stalls the
//! network.

use std::net::SocketAddr;
use std::process::ExitCode;

const VARIABLE: &str = "PPNPACK__ADMIN__LISTEN";

/// Exit code of a wrong command line or environment (`EX_USAGE`).
const EXIT_USAGE: u8 = 64;

fn main() -> ExitCode {
    let given = std::env::args().nth(1).or(std::env::var(VARIABLE).ok());
    let Some(address) = given.and_then(|given| given.parse::<SocketAddr>().ok()) else {
        eprintln!(
            "ppnpack-healthcheck: give the address of an admin port, such as 127.0.0.1:9100, or set {VARIABLE}"
        );
        return ExitCode::from(EXIT_USAGE);
    };
    match ppnpack_service::ask_ready(address) {
        Ok(()) => {
            println!("ready");
            ExitCode::SUCCESS
        }
        Err(reason) => {
            eprintln!("ppnpack-healthcheck: {reason}");
            ExitCode::FAILURE
        }
    }
}
