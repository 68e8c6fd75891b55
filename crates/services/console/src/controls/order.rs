//! The operator's orders.

use serde::Deserialize;

use super::ControlError;

/// A control, by its name in the address.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Action {
    /// Nothing is begun any more.
    Hold,
    /// Nothing is begun any more, and what is under way is broken off.
    Abort,
    Resume,
    /// The cell goes on for one placement of each of its robots.
    Step,
    /// Somebody had a hand in a container.
    Touched,
    /// Items were taken out of a container.
    Removed,
    /// An item does not come.
    Withdraw,
    NewContainer,
    Automatic,
}

impl Action {
    pub(crate) fn parse(name: &str) -> Option<Self> {
        serde_json::from_value(name.into()).ok()
    }

    /// Whether it stops a robot: then it waits for no other control.
    pub(crate) fn is_stop(self) -> bool {
        matches!(self, Self::Hold | Self::Abort)
    }

    /// Gives the question before it is carried out, where it moves the robot.
    pub(crate) fn question(self, order: &Order) -> Option<&'static str> {
        match self {
            Self::Resume => {
                Some("The robot will move. Is nobody in the cell, and is every change in it told?")
            }
            Self::Step => Some("The robot will make one placement. Is nobody in the cell?"),
            Self::NewContainer => Some(
                "The container will be taken away and an empty one brought. Is nobody in the cell?",
            ),
            Self::Automatic if order.is_on == Some(true) => Some(
                "The robot will go on by itself. Has somebody looked into the cell, and is nobody in it?",
            ),
            _ => None,
        }
    }
}

/// An order as it comes from a page.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Order {
    pub(crate) cell: String,
    pub(crate) container: Option<String>,
    pub(crate) item_ids: Vec<String>,
    pub(crate) reason: String,
    pub(crate) is_on: Option<bool>,
    /// The holds that the operator saw, and ends.
    pub(crate) hold_ids: Vec<String>,
    /// The failure that the operator saw, and acknowledges.
    pub(crate) failure_id: String,
    pub(crate) confirmed: bool,
}

impl Order {
    /// Gives the items that it names: at least one.
    pub(super) fn items(&self) -> Result<Vec<String>, ControlError> {
        match self.item_ids.is_empty() {
            true => Err(ControlError::invalid("item_ids: an item is needed")),
            false => Ok(self.item_ids.clone()),
        }
    }

    /// Gives the holds that it ends: at least one.
    pub(super) fn hold_ids(&self) -> Result<&[String], ControlError> {
        match self.hold_ids.as_slice() {
            [] => Err(ControlError::invalid(
                "hold_ids: the holds that are to end are needed, as the page showed them",
            )),
            ids => Ok(ids),
        }
    }

    pub(super) fn is_on(&self) -> Result<bool, ControlError> {
        let missing = || ControlError::invalid("is_on: true or false is needed");
        self.is_on.ok_or_else(missing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_moves_the_robot_is_asked_again_and_what_stops_it_is_not() {
        for (name, is_asked, is_stop) in [
            ("hold", false, true),
            ("abort", false, true),
            ("resume", true, false),
            ("step", true, false),
            ("touched", false, false),
            ("removed", false, false),
            ("withdraw", false, false),
            ("new_container", true, false),
            ("automatic", true, false),
        ] {
            let action = Action::parse(name).unwrap();
            let on = Order {
                is_on: Some(true),
                ..Order::default()
            };
            assert_eq!(action.question(&on).is_some(), is_asked, "{name}");
            assert_eq!(action.is_stop(), is_stop, "{name}");
        }
        assert_eq!(Action::Automatic.question(&Order::default()), None);
        assert_eq!(Action::parse("check"), None);
    }

    #[test]
    fn an_order_with_something_unknown_is_no_order() {
        let read = |text: &str| serde_json::from_str::<Order>(text);
        assert_eq!(read(r#"{"cell": "c1"}"#).unwrap().cell, "c1");
        assert!(read(r#"{"cell": "c1", "conatiner": "c1"}"#).is_err());
        assert!(read(r#"{"confirmed": "yes"}"#).is_err());
    }
}
