//! `ppnpack view`: the cells as they work, in Foxglove.

use std::net::SocketAddr;
use std::time::Duration;

use clap::Args;
use ppnpack_service::Shutdown;
use ppnpack_view::View;

use crate::failure::{OrRun, Outcome};
use crate::output::print_line;
use crate::stack::connect::ConnectOptions;

/// Default address for viewers: Foxglove's own port, on this machine alone.
pub(crate) const DEFAULT_ADDRESS: &str = "127.0.0.1:8765";

/// Interval at which it is looked whether it is still served.
const LOOK: Duration = Duration::from_millis(200);

/// Serves the cells to Foxglove as they work, until Ctrl-C: open a connection there to the address
/// that is printed, and the layout `deploy/foxglove.json`.
#[derive(Debug, Args)]
pub(crate) struct ViewArguments {
    /// The address for viewers. There is no access control: other machines see the cells where this
    /// is not a loopback address
    #[arg(long, value_name = "ADDRESS", default_value = DEFAULT_ADDRESS)]
    address: SocketAddr,

    #[command(flatten)]
    connection: ConnectOptions,
}

pub(crate) fn run(arguments: &ViewArguments) -> Outcome {
    let shutdown = Shutdown::default();
    let asked = shutdown.clone();
    ctrlc::set_handler(move || asked.request()).or_run()?;
    let session = arguments.connection.open()?;
    let view = View::start(&session, arguments.address).or_run()?;
    print_line(&address(&view))?;
    print_line("Ready. Ctrl-C ends it.")?;
    while !view.has_ended() && !shutdown.wait_timeout(LOOK) {}
    view.finish().or_run()
}

/// Gives the address for viewers, for people.
pub(crate) fn address(view: &View) -> String {
    format!("Foxglove: ws://{}", view.address())
}
