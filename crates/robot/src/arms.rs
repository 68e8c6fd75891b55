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

/// The names of the built-in arms.
pub fn names() -> impl Iterator<Item = &'static str> {
    ARMS.iter().map(|(name, _)| *name)
}

/// The parameter file of a built-in arm, as a start for one's own.
pub fn text(name: &str) -> Option<&'static str> {
    let arm = ARMS.iter().find(|(known, _)| *known == name);
    arm.map(|(_, text)| *text)
}

/// A built-in arm.
///
/// # Errors
/// [`ParameterError::UnknownArm`] where there is none of this name.
pub fn arm(name: &str) -> Result<Arm, ParameterError> {
    let text = text(name).ok_or_else(|| unknown(name))?;
    Arm::new(&ArmParameters::from_toml(text)?)
}

/// The refusal of a name that no built-in arm has.
pub(crate) fn unknown(name: &str) -> ParameterError {
    ParameterError::UnknownArm {
        name: name.to_owned(),
        known: names().collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_built_in_arm_can_be_made() {
        assert_eq!(names().count(), 2);
        for name in names() {
            let arm = arm(name).unwrap();
            assert!(!arm.name().is_empty(), "{name}");
        }
    }

    #[test]
    fn an_unknown_arm_is_refused_with_the_names_there_are() {
        let message = arm("r2d2").unwrap_err().to_string();
        assert!(message.contains("r2d2") && message.contains("nachi-mz07l"));
    }
}
