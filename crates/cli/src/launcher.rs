//! Handing over to the programs that have more: the experiments, the network.
//!
//! `ppnpack` is built without what makes and measures networks; for those commands it turns into
//! `ppnpack-experiments`, which lies beside it. Neither links libtorch, so that they run where
//! there is none. Where a command may use a network they turn into `ppnpack-torch`, which has the
//! commands of both and is linked with libtorch; where that cannot run, the reason is kept and
//! given to whoever asks for a network.

use std::convert::Infallible;
use std::ffi::OsString;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use anyhow::{Context, Result, anyhow, bail};
use clap::{Args, Subcommand};
use ppnpack_model::card::ModelCard;
use ppnpack_model::report::TrainingEvent;
use ppnpack_model::settings::{Device, TrainingRequest};
use ppnpack_model::weights::Model;
use ppnpack_packing::ranking::proposals::Proposer;

use crate::Commands;
use crate::failure::{Failure, Outcome};
use crate::network::{Backend, Proposing};

const WITH_NETWORK: &str = "ppnpack-torch";
const WITH_EXPERIMENTS: &str = "ppnpack-experiments";
/// Environment variable that names a full installation of torch, for CUDA: the folder with
/// `lib/libtorch_cuda.so`.
pub(crate) const TORCH_FOLDER: &str = "PPNPACK_TORCH";

/// The commands of `ppnpack-experiments`, for which this process turns into it.
#[derive(Debug, Subcommand)]
pub enum Elsewhere {
    /// Reproduce the paper's tables and test the engine's models
    #[command(disable_help_flag = true)]
    Experiment(Rest),
    /// Make training data for placement proposal networks
    #[command(disable_help_flag = true)]
    Dataset(Rest),
    /// Train a placement proposal network
    #[command(disable_help_flag = true)]
    Train(Rest),
}

/// The arguments after the name of a command.
#[derive(Debug, Args)]
pub struct Rest {
    #[allow(
        dead_code,
        reason = "the other program is given the arguments of this process"
    )]
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<OsString>,
}

impl Commands for Elsewhere {
    fn run(&self, _backend: &dyn Backend) -> Outcome {
        let Err(error) = beside_this_one(WITH_EXPERIMENTS)
            .and_then(|program| become_program(&mut Command::new(program)));
        Err(Failure::Run(error))
    }
}

/// A backend that has no network itself.
#[derive(Debug, Default)]
pub struct Launcher {
    reason: OnceLock<String>,
}

impl Launcher {
    fn unavailable<T>(&self) -> Result<T> {
        let reason = self.reason.get().map(String::as_str);
        let reason = reason.unwrap_or("it was not looked for");
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

/// Turns this process into `ppnpack-torch`; comes back only where it fails.
fn hand_over() -> Result<Infallible> {
    let program = beside_this_one(WITH_NETWORK)?;
    let mut probe = with_torch(&program);
    let answer = probe
        .arg("--version")
        .output()
        .with_context(|| format!("{} cannot be started", program.display()))?;
    if !answer.status.success() {
        let message = String::from_utf8_lossy(&answer.stderr).trim().to_owned();
        bail!("{message}; `scripts/setup network` fetches libtorch");
    }
    become_program(&mut with_torch(&program))
}

fn beside_this_one(name: &str) -> Result<PathBuf> {
    let own = std::env::current_exe().context("this program's own path is not known")?;
    let program = own.with_file_name(name);
    if !program.exists() {
        bail!(
            "there is no {}; `cargo build --bin {name}` makes it, with the profile that made this program",
            program.display()
        );
    }
    Ok(program)
}

/// Prepares the program, with the full installation of torch where one is named: its libraries come
/// first, and CUDA's part, to which nothing is linked, is loaded with it.
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

/// Turns this process into another program, with the same arguments.
fn become_program(command: &mut Command) -> Result<Infallible> {
    let error = command.args(std::env::args_os().skip(1)).exec();
    Err(error).with_context(|| format!("{} cannot be started", command.get_program().display()))
}
