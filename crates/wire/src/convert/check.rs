//! The checks that placements have to pass.

use ppnpack_packing::checks::check::{BoxedCheck, Fits};
use ppnpack_packing::checks::stability::{PhysicalStability, PublishedStability};
use ppnpack_packing::ranking::refusal::{Cause, Refusal};

use super::pairs;
use crate::error::WireError;
use crate::header;
use crate::v1::{self, Check};

/// The cause of a refusal by each check.
const CAUSES: [(Check, Cause); 10] = [
    (Check::PhysicalStability, Cause::Unstable),
    (Check::PublishedStability, Cause::UnstableByPublishedTest),
    (Check::Fits, Cause::AboveRim),
    (Check::Arm, Cause::Arm),
    (Check::OnFloor, Cause::NotOnFloor),
    (Check::Upright, Cause::CouldFallOver),
    (Check::Trial, Cause::Unsteady),
    (Check::Load, Cause::Load),
    (Check::Balance, Cause::Balance),
    (Check::Sequence, Cause::Sequence),
];

/// Makes the checks of a request, in its order.
///
/// # Errors
/// [`WireError`] where one is unspecified or not known, comes twice, or is the planner's own.
pub fn read_all(checks: &[i32]) -> Result<Vec<BoxedCheck>, WireError> {
    let field = "checks";
    let mut found = Vec::new();
    for (index, number) in checks.iter().enumerate() {
        let check = read(field, *number)?;
        let name = check.as_str_name();
        if checks.iter().take(index).any(|before| before == number) {
            let twice = format_args!("{name} comes twice");
            return Err(WireError::invalid(field, twice));
        }
        let of_planner = || WireError::invalid(field, format_args!("{name} is the planner's own"));
        found.push(boxed(check).ok_or_else(of_planner)?);
    }
    Ok(found)
}

pub(super) fn read(field: &'static str, number: i32) -> Result<Check, WireError> {
    let check = Check::try_from(number).ok();
    check
        .filter(|check| *check != Check::Unspecified)
        .ok_or_else(|| {
            WireError::invalid(field, format_args!("{number} is no check that is known"))
        })
}

fn boxed(check: Check) -> Option<BoxedCheck> {
    match check {
        Check::PhysicalStability => Some(Box::new(PhysicalStability::new(Default::default()))),
        Check::PublishedStability => Some(Box::new(PublishedStability::default())),
        Check::Fits => Some(Box::new(Fits)),
        _ => None,
    }
}

/// Gives the cause of a refusal by a check; `None` for the unspecified one.
pub fn cause(check: Check) -> Option<Cause> {
    pairs::read(&CAUSES, &check)
}

/// Gives the check that refuses for a cause; unspecified where the wire knows none.
pub fn of_cause(cause: Cause) -> Check {
    pairs::write(&CAUSES, &cause)
}

/// Reads the refusals of a check, with their number.
pub(super) fn read_refusals(message: &v1::Refusals) -> Result<(Refusal, u64), WireError> {
    let field = "placement_counts.refusals.check";
    let check = read(field, message.check)?;
    let unknown = || WireError::invalid(field, "no check that refuses");
    let refusal = Refusal {
        cause: cause(check).ok_or_else(unknown)?,
        detail: (!message.detail.is_empty()).then(|| header::text(&message.detail).into()),
    };
    Ok((refusal, message.count))
}

/// Writes the refusals of a check, with their number.
pub(super) fn write_refusals((refusal, count): (&Refusal, u64)) -> v1::Refusals {
    v1::Refusals {
        check: of_cause(refusal.cause).into(),
        count,
        detail: refusal.detail.as_deref().unwrap_or_default().to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_check_has_a_cause_and_every_cause_a_check() {
        for number in 1..=10 {
            let check = Check::try_from(number).unwrap();
            assert_eq!(of_cause(cause(check).unwrap()), check);
            let of_planner = !matches!(
                check,
                Check::PhysicalStability | Check::PublishedStability | Check::Fits
            );
            assert_eq!(read_all(&[number]).is_err(), of_planner, "{check:?}");
        }
        assert!(Check::try_from(11).is_err(), "a check without a cause");
        assert_eq!(cause(Check::Unspecified), None);
        let refused = read_all(&[Check::Arm.into()]).map(|_| ()).unwrap_err();
        assert!(refused.to_string().contains("planner"), "{refused}");
    }

    #[test]
    fn refusals_are_read_as_they_were_written() {
        for (refusal, count) in [
            (Refusal::from(Cause::NotOnFloor), 3),
            (Refusal::because(Cause::Arm, "a wall"), 7),
        ] {
            let message = write_refusals((&refusal, count));
            assert_eq!(read_refusals(&message).unwrap(), (refusal, count));
        }
    }
}
