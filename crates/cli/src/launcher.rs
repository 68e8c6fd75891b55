//! Handing over to the program that has the network.
//!
//! `ppnpack` does not link libtorch, so that it runs where there is none. Where a command may use a network it turns
//! into `ppnpack-torch`, which lies beside it, has the same commands and is linked with libtorch; where that cannot
//! run, the reason is kept and given to whoever asks for a network.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use anyhow::{Context, Result, anyhow, bail};
use ppnpack_model::card::ModelCard;
use ppnpack_model::report::TrainingEvent;
use ppnpack_model::settings::{Device, TrainingRequest};
use ppnpack_model::weights::Model;
use ppnpack_packing::proposals::Proposer;

use crate::network::{Backend, Proposing};

const PROGRAM: &str = "ppnpack-torch";
/// Names a full installation of torch, for CUDA: the folder that has `lib/libtorch_cuda.so`.
const TORCH_FOLDER: &str = "PPNPACK_TORCH";

/// A backend that has no network itself.
#[derive(Debug, Default)]
pub struct Launcher {
    reason: OnceLock<String>,
}

impl Launcher {
    fn unavailable<T>(&self) -> Result<T> {
        let reason = self
            .reason
            .get()
            .map_or("it was not looked for", String::as_str);
        Err(anyhow!("the network cannot run here: {reason}"))
    }
}

impl Backend for Launcher {
    /// Turns this process into `ppnpack-torch`; comes back where that cannot run.
    fn prepare(&self) {
        let Err(error) = hand_over();
        let reason = format!("{error:#}");
        tracing::info!(reason, "the network cannot run here");
        self.reason.get_or_init(|| reason);
    }

    fn open(&self, _model: &Model, _how: &Proposing<'_>) -> Result<Box<dyn Proposer>> {
        self.unavailable()
    }

    fn network(
        &self,
        _model: &Model,
        _device: Device,
    ) -> Result<Box<dyn ppnpack_ppn_service::Network>> {
        self.unavailable()
    }

    fn train(
        &self,
        _request: &TrainingRequest,
        _watch: &mut dyn FnMut(TrainingEvent),
    ) -> Result<ModelCard> {
        self.unavailable()
    }
}

/// Does not come back where it succeeds.
fn hand_over() -> Result<std::convert::Infallible> {
    let program = beside_this_one()?;
    let mut probe = with_torch(&program);
    let answer = probe
        .arg("--version")
        .output()
        .with_context(|| format!("{} cannot be started", program.display()))?;
    if !answer.status.success() {
        let message = String::from_utf8_lossy(&answer.stderr).trim().to_owned();
        bail!("{message}; `scripts/setup network` fetches libtorch");
    }
    become_program(with_torch(&program).args(std::env::args_os().skip(1)))
}

fn beside_this_one() -> Result<PathBuf> {
    let own = std::env::current_exe().context("this program's own path is not known")?;
    let program = own.with_file_name(PROGRAM);
    if !program.exists() {
        bail!(
            "there is no {}; `cargo build --release --bin {PROGRAM}` makes it",
            program.display()
        );
    }
    Ok(program)
}

/// The program, with the full installation of torch where one is named: its libraries come first, and CUDA's part,
/// to which nothing is linked, is loaded with it.
fn with_torch(program: &Path) -> Command {
    let mut command = Command::new(program);
    if let Some(folder) = std::env::var_os(TORCH_FOLDER) {
        let libraries = Path::new(&folder).join("lib");
        let cuda = libraries.join("libtorch_cuda.so");
        command.env("LD_LIBRARY_PATH", &libraries);
        if cuda.exists() {
            command.env("LD_PRELOAD", cuda);
        }
    }
    command
}

#[cfg(unix)]
fn become_program(command: &mut Command) -> Result<std::convert::Infallible> {
    use std::os::unix::process::CommandExt;
    let error = command.exec();
    Err(error).context("the program with the network cannot be started")
}

#[cfg(not(unix))]
fn become_program(_command: &mut Command) -> Result<std::convert::Infallible> {
    bail!("the network runs on Unix alone")
}
