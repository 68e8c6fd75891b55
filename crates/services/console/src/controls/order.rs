//! What an operator orders.

use serde::Deserialize;

use super::ControlError;

/// What may be ordered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Action {
    /// Nothing is begun any more.
    Hold,
    /// As a hold, and what is under way is broken off.
    Abort,
    /// The cell goes on.
    Resume,
    /// The cell goes on for one placement.
    Step,
    /// Somebody had a hand in a container.
    Touched,
    /// Items were taken out of a container.
    Removed,
    /// An item does not come.
    Withdraw,
    /// An empty container is brought.
    NewContainer,
    /// The automatic mode is switched.
    Automatic,
}

impl Action {
    const ALL: [Self; 9] = [
        Self::Hold,
        Self::Abort,
        Self::Resume,
        Self::Step,
        Self::Touched,
        Self::Removed,
        Self::Withdraw,
        Self::NewContainer,
        Self::Automatic,
    ];

    pub(crate) fn parse(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|action| action.as_str() == name)
    }

    pub(crate) fn as_str(self) -> &'static str {
        match self {
            Self::Hold => "hold",
            Self::Abort => "abort",
            Self::Resume => "resume",
            Self::Step => "step",
            Self::Touched => "touched",
            Self::Removed => "removed",
            Self::Withdraw => "withdraw",
            Self::NewContainer => "new_container",
            Self::Automatic => "automatic",
        }
    }

    /// Whether it stops a robot: then it waits for no other control.
    pub(crate) fn is_stop(self) -> bool {
        matches!(self, Self::Hold | Self::Abort)
    }

    /// What is asked before it is carried out, where it moves the robot.
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
    pub(crate) confirmed: bool,
}

impl Order {
    /// The items that it names: at least one.
    pub(super) fn items(&self) -> Result<Vec<String>, ControlError> {
        match self.item_ids.is_empty() {
            true => Err(ControlError::Invalid(
                "item_ids: an item is needed".to_owned(),
            )),
            false => Ok(self.item_ids.clone()),
        }
    }

    pub(super) fn is_on(&self) -> Result<bool, ControlError> {
        let missing = || ControlError::Invalid("is_on: true or false is needed".to_owned());
        self.is_on.ok_or_else(missing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_action_has_a_name_of_its_own() {
        for action in Action::ALL {
            assert_eq!(Action::parse(action.as_str()), Some(action));
        }
        assert_eq!(Action::parse("check"), None);
    }

    #[test]
    fn what_moves_the_robot_is_asked_again_and_what_stops_it_is_not() {
        let order = |is_on| Order {
            is_on: Some(is_on),
            ..Order::default()
        };
        let asked = Action::ALL
            .into_iter()
            .filter(|action| action.question(&order(true)).is_some());
        let moving = [
            Action::Resume,
            Action::Step,
            Action::NewContainer,
            Action::Automatic,
        ];
        assert_eq!(asked.collect::<Vec<_>>(), moving);
        assert_eq!(Action::Automatic.question(&order(false)), None);
        assert!(
            Action::ALL
                .into_iter()
                .filter(|action| action.is_stop())
                .count()
                == 2
        );
    }

    #[test]
    fn an_order_with_something_unknown_is_no_order() {
        let read = |text: &str| serde_json::from_str::<Order>(text);
        assert_eq!(read(r#"{"cell": "c1"}"#).unwrap().cell, "c1");
        assert!(read(r#"{"cell": "c1", "conatiner": "c1"}"#).is_err());
        assert!(read(r#"{"confirmed": "yes"}"#).is_err());
    }
}
