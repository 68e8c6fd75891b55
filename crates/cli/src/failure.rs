//! Failures of commands, and the exit codes that say so.

use std::process::ExitCode;

use ppnpack_files::WriteError;
use ppnpack_packing::planning::method::MethodError;

/// A failed command: one line for the user, and an exit code.
#[derive(Debug)]
pub enum Failure {
    /// The command line or an input is wrong: exit code 2.
    Input(anyhow::Error),
    /// Something else went wrong: exit code 1.
    Run(anyhow::Error),
}

/// Result of a command.
pub type Outcome<T = ()> = Result<T, Failure>;

impl Failure {
    /// Makes a failure of a wrong option or input.
    pub fn input(message: impl std::fmt::Display) -> Self {
        Self::Input(anyhow::anyhow!("{message}"))
    }

    /// Gives the exit code that says so.
    pub fn exit_code(&self) -> ExitCode {
        match self {
            Self::Input(_) => ExitCode::from(2),
            Self::Run(_) => ExitCode::from(1),
        }
    }
}

impl std::fmt::Display for Failure {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (Self::Input(error) | Self::Run(error)) = self;
        let mut line = String::new();
        for cause in error.chain().map(ToString::to_string) {
            // Some errors name their cause themselves.
            if !line.contains(&cause) {
                let colon = if line.is_empty() { "" } else { ": " };
                line = format!("{line}{colon}{cause}");
            }
        }
        formatter.write_str(&line)
    }
}

impl From<anyhow::Error> for Failure {
    fn from(error: anyhow::Error) -> Self {
        Self::Run(error)
    }
}

impl From<WriteError> for Failure {
    fn from(error: WriteError) -> Self {
        Self::Run(error.into())
    }
}

impl From<MethodError> for Failure {
    /// Takes a network that does not run here for no fault of the command line.
    fn from(error: MethodError) -> Self {
        match error {
            MethodError::Network(_) => Self::Run(error.into()),
            _ => Self::Input(error.into()),
        }
    }
}

/// Marks an error as the fault of the command line or an input.
pub trait OrInput<T> {
    /// Gives the value, or a failure with exit code 2.
    fn or_input(self) -> Outcome<T>;
}

impl<T, E: Into<anyhow::Error>> OrInput<T> for Result<T, E> {
    fn or_input(self) -> Outcome<T> {
        self.map_err(|error| Failure::Input(error.into()))
    }
}

/// Marks an error as a failure of the run.
pub trait OrRun<T> {
    /// Gives the value, or a failure with exit code 1.
    fn or_run(self) -> Outcome<T>;
}

impl<T, E: Into<anyhow::Error>> OrRun<T> for Result<T, E> {
    fn or_run(self) -> Outcome<T> {
        self.map_err(|error| Failure::Run(error.into()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cause_is_named_once() {
        let read = ppnpack_clouds::read(std::path::Path::new("missing.pcd"));
        let error = anyhow::Error::new(read.unwrap_err()).context("no picture");
        let message = Failure::Run(error).to_string();
        assert!(message.starts_with("no picture: missing.pcd cannot be read: "));
        assert_eq!(message.matches("No such file").count(), 1, "{message}");
    }
}
