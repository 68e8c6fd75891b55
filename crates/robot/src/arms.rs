//! Arms that are built in, by name.

use crate::arm::Arm;
use crate::error::ParameterError;
use crate::parameters::ArmParameters;

/// Name and parameter file.
const ARMS: [(&str, &str); 2] = [
    ("nachi-mz07l", include_str!("arms/nachi-mz07l.toml")),
    (
        "abb-irb1200-5-90",
        include_str!("arms/abb-irb1200-5-90.toml"),
    ),
];

/// Gives the names of the built-in arms.
pub fn names() -> impl Iterator<Item = &'static str> {
    ARMS.iter().map(|(name, _)| *name)
}

/// Gives the parameter file of a built-in arm, as a start for one's own.
pub fn text(name: &str) -> Option<&'static str> {
    let arm = ARMS.iter().find(|(known, _)| *known == name);
    arm.map(|(_, text)| *text)
}

/// Makes a built-in arm.
///
/// # Errors
/// [`ParameterError::UnknownArm`] where there is none of this name.
pub fn arm(name: &str) -> Result<Arm, ParameterError> {
    let text = text(name).ok_or_else(|| unknown(name))?;
    Arm::new(&ArmParameters::from_toml(text)?)
}

/// Refuses a name that no built-in arm has.
pub(crate) fn unknown(name: &str) -> ParameterError {
    ParameterError::UnknownArm {
        name: name.to_owned(),
        known: names().collect(),
    }
}
