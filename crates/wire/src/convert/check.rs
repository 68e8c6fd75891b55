//! The checks that placements have to pass.

use ppnpack_packing::check::{BoxedCheck, Fits};
use ppnpack_packing::stability::{
    PhysicalStability, PhysicalStabilitySettings, PublishedStability,
};

use crate::error::WireError;
use crate::v1::Check;

/// Each check with the name of its domain, [`ValidityCheck::name`](ppnpack_packing::check::ValidityCheck::name).
const NAMES: [(Check, &str); 4] = [
    (Check::PhysicalStability, "unstable"),
    (Check::PublishedStability, "unstable by the published test"),
    (Check::Fits, "above the rim"),
    (Check::Arm, "not possible for the arm"),
];

/// Makes the checks of a request, in its order.
///
/// # Errors
/// [`WireError`] where one is unspecified or not known, comes twice, or is the arm's.
pub fn read_all(checks: &[i32]) -> Result<Vec<BoxedCheck>, WireError> {
    let field = "checks";
    let mut found = Vec::new();
    for (index, number) in checks.iter().enumerate() {
        let check = read(field, *number)?;
        if checks.iter().take(index).any(|before| before == number) {
            let name = check.as_str_name();
            return Err(WireError::invalid(
                field,
                format_args!("{name} comes twice"),
            ));
        }
        if check == Check::Arm {
            return Err(WireError::invalid(
                field,
                "whether an arm can do it is checked by the planner that has the arm",
            ));
        }
        found.extend(boxed(check));
    }
    Ok(found)
}

/// Reads a check.
pub(super) fn read(field: &'static str, number: i32) -> Result<Check, WireError> {
    let check = Check::try_from(number).unwrap_or(Check::Unspecified);
    if check == Check::Unspecified {
        return Err(WireError::invalid(
            field,
            format_args!("{number} is no check that is known"),
        ));
    }
    Ok(check)
}

fn boxed(check: Check) -> Option<BoxedCheck> {
    match check {
        Check::Unspecified | Check::Arm => None,
        Check::PhysicalStability => {
            let settings = PhysicalStabilitySettings::default();
            Some(Box::new(PhysicalStability::new(settings)))
        }
        Check::PublishedStability => Some(Box::new(PublishedStability::default())),
        Check::Fits => Some(Box::new(Fits)),
    }
}

/// The name of a check in the domain; empty for the unspecified one.
pub fn name(check: Check) -> &'static str {
    let mut names = NAMES.iter();
    names
        .find(|(known, _)| *known == check)
        .map_or("", |(_, name)| name)
}

/// The check of a name of the domain; unspecified where there is none.
pub fn from_name(text: &str) -> Check {
    let mut names = NAMES.iter();
    let named = names.find(|(_, name)| *name == text);
    named.map_or(Check::Unspecified, |(check, _)| *check)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checks_have_the_names_of_the_domain() {
        let of_wire = || NAMES.iter().filter(|(check, _)| *check != Check::Arm);
        let numbers: Vec<i32> = of_wire().map(|(check, _)| i32::from(*check)).collect();
        let boxed = read_all(&numbers).unwrap();
        assert_eq!(boxed.len(), numbers.len());
        for ((_, text), boxed) in of_wire().zip(boxed) {
            assert_eq!(boxed.name(), *text);
        }
        for (check, text) in NAMES {
            assert_eq!(name(check), text);
            assert_eq!(from_name(text), check);
        }
        let refused = read_all(&[Check::Arm.into()]).map(|_| ()).unwrap_err();
        assert!(refused.to_string().contains("planner"), "{refused}");
        assert_eq!(name(Check::Unspecified), "");
        assert_eq!(from_name("out of reach"), Check::Unspecified);
    }
}
