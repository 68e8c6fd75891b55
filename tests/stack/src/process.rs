//! One process of the stack.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};

use anyhow::{Context, Result, bail};
pub(crate) use nix::sys::signal::Signal;
use nix::sys::signal::kill;
use nix::sys::wait::{Id, WaitPidFlag, waitid};
use nix::unistd::Pid;

/// A program with its arguments, which can be run again and again.
#[derive(Debug)]
pub(crate) struct Process {
    program: PathBuf,
    arguments: Vec<String>,
    environment: Vec<(String, String)>,
    log: PathBuf,
    child: Option<Child>,
}

impl Process {
    pub(crate) fn new(
        program: PathBuf,
        arguments: Vec<String>,
        environment: &[(String, String)],
        log: &Path,
    ) -> Self {
        Self {
            program,
            arguments,
            environment: environment.to_owned(),
            log: log.to_owned(),
            child: None,
        }
    }

    /// Starts it; its output is added to its log.
    pub(crate) fn start(&mut self) -> Result<()> {
        let log = File::options().create(true).append(true).open(&self.log)?;
        let child = Command::new(&self.program)
            .args(&self.arguments)
            .envs(self.environment.iter().map(|(name, value)| (name, value)))
            .stdin(Stdio::null())
            .stdout(log.try_clone()?)
            .stderr(log)
            .spawn()
            .with_context(|| format!("{} cannot be started", self.program.display()))?;
        self.child = Some(child);
        Ok(())
    }

    pub(crate) fn id(&self) -> Option<u32> {
        self.child.as_ref().map(Child::id)
    }

    pub(crate) fn send(&mut self, signal: Signal) -> Result<()> {
        let Some(child) = &self.child else {
            bail!("{} does not run", self.program.display());
        };
        let process = Pid::from_raw(i32::try_from(child.id())?);
        kill(process, signal)?;
        if signal == Signal::SIGSTOP {
            // On a busy machine its threads go on for a while.
            waitid(Id::Pid(process), WaitPidFlag::WSTOPPED)?;
        }
        Ok(())
    }

    pub(crate) fn wait(&mut self) -> Result<ExitStatus> {
        let Some(mut child) = self.child.take() else {
            bail!("{} does not run", self.program.display());
        };
        Ok(child.wait()?)
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        if let Some(mut child) = self.child.take() {
            // Nothing is left to do for a process that cannot be ended.
            drop(child.kill());
            drop(child.wait());
        }
    }
}

/// A program of the workspace: beside this one, or beside this one's folder, as of tests.
pub(crate) fn beside(program: &str) -> Result<PathBuf> {
    let own = std::env::current_exe()?;
    let folders = own.ancestors().skip(1).take(2);
    let mut found = folders.map(|folder| folder.join(program));
    found.find(|path| path.is_file()).with_context(|| {
        format!("there is no {program}: `cargo build --bins` makes it, with the same profile")
    })
}
