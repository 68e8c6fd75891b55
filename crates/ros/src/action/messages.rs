//! What goes to and fro of every action.

use std::marker::PhantomData;

use serde::{Deserialize, Serialize};

use super::Action;
use crate::description::{Field, FieldDescription, FieldType, Message, Types};
use crate::messages::builtin_interfaces::Time;
use crate::messages::unique_identifier_msgs::Uuid;
use crate::service::Service;

/// The service by which goals are sent.
pub(super) struct SendGoal<A>(PhantomData<fn(A)>);

/// The service by which results are asked for.
pub(super) struct GetResult<A>(PhantomData<fn(A)>);

/// Sends a goal.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
pub struct SendGoalRequest<A: Action> {
    /// Its id.
    pub goal_id: Uuid,
    /// What is wanted.
    pub goal: A::Goal,
}

/// Whether a goal is carried out.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
pub struct SendGoalResponse<A: Action> {
    /// Whether it is.
    pub accepted: bool,
    /// Since when.
    pub stamp: Time,
    #[serde(skip)]
    action: PhantomData<fn(A)>,
}

impl<A: Action> SendGoalResponse<A> {
    pub(super) fn accepted(stamp: Time) -> Self {
        Self {
            accepted: true,
            stamp,
            action: PhantomData,
        }
    }

    pub(super) fn refused() -> Self {
        Self {
            accepted: false,
            ..Self::accepted(Time::default())
        }
    }
}

/// Asks for the result of a goal; it is answered when the goal has ended.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
pub struct GetResultRequest<A: Action> {
    /// Its id.
    pub goal_id: Uuid,
    #[serde(skip)]
    action: PhantomData<fn(A)>,
}

/// How a goal ended.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
pub struct GetResultResponse<A: Action> {
    /// How it ended, as [`super::Status`] numbers it.
    pub status: i8,
    /// What came of it.
    pub result: A::Result,
}

/// How far a goal is.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
pub struct FeedbackMessage<A: Action> {
    /// Its id.
    pub goal_id: Uuid,
    /// How far it is.
    pub feedback: A::Feedback,
}

impl<A: Action> Service for SendGoal<A> {
    type Request = SendGoalRequest<A>;
    type Response = SendGoalResponse<A>;

    fn type_name() -> String {
        format!("{}_SendGoal", A::type_name())
    }
}

impl<A: Action> Service for GetResult<A> {
    type Request = GetResultRequest<A>;
    type Response = GetResultResponse<A>;

    fn type_name() -> String {
        format!("{}_GetResult", A::type_name())
    }
}

/// Messages whose names and fields depend on the action.
macro_rules! messages_of_actions {
    ($($name:ident = $suffix:literal { $($field:ident: $field_type:ty,)* })*) => {
        $(
            impl<A: Action> Message for $name<A> {
                fn type_name() -> String {
                    format!(concat!("{}", $suffix), A::type_name())
                }

                fn fields(types: &mut Types) -> Vec<FieldDescription> {
                    vec![$(FieldDescription::of::<$field_type>(stringify!($field), types),)*]
                }
            }

            impl<A: Action> Field for $name<A> {
                fn field_type(types: &mut Types) -> FieldType {
                    types.nested::<Self>()
                }
            }
        )*
    };
}

messages_of_actions! {
    SendGoalRequest = "_SendGoal_Request" {
        goal_id: Uuid,
        goal: A::Goal,
    }

    SendGoalResponse = "_SendGoal_Response" {
        accepted: bool,
        stamp: Time,
    }

    GetResultRequest = "_GetResult_Request" {
        goal_id: Uuid,
    }

    GetResultResponse = "_GetResult_Response" {
        status: i8,
        result: A::Result,
    }

    FeedbackMessage = "_FeedbackMessage" {
        goal_id: Uuid,
        feedback: A::Feedback,
    }
}
