//! Messages of ROS 2, as structs: those of its own packages that are needed here, and those of `ppnpack_msgs`.
//!
//! Names of modules, structs and fields are those of ROS, but that a struct does not begin with two capitals.

pub mod action_msgs;
pub mod builtin_interfaces;
pub mod geometry_msgs;
pub mod ppnpack_actions;
pub mod ppnpack_msgs;
pub mod ppnpack_srvs;
pub mod sensor_msgs;
pub mod service_msgs;
pub mod std_msgs;
pub mod std_srvs;
pub mod tf2_msgs;
pub mod unique_identifier_msgs;
pub mod visualization_msgs;

/// Structs that are messages: each with its fields in the order that ROS has them in.
macro_rules! messages {
    ($($(#[$doc:meta])* $name:ident = $type_name:literal {
        $($(#[$field_doc:meta])* $field:ident: $field_type:ty,)*
    })*) => {
        $(
            $(#[$doc])*
            #[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
            pub struct $name {
                $($(#[$field_doc])* pub $field: $field_type,)*
            }

            impl $crate::description::Message for $name {
                fn type_name() -> String {
                    $type_name.to_owned()
                }

                fn fields(
                    types: &mut $crate::description::Types,
                ) -> Vec<$crate::description::FieldDescription> {
                    vec![$($crate::description::FieldDescription::of::<$field_type>(
                        stringify!($field),
                        types,
                    ),)*]
                }
            }

            impl $crate::description::Field for $name {
                fn field_type(
                    types: &mut $crate::description::Types,
                ) -> $crate::description::FieldType {
                    types.nested::<Self>()
                }
            }
        )*
    };
}

/// Types that stand for services: each with its request and its response.
macro_rules! services {
    ($($(#[$doc:meta])* $name:ident = $type_name:literal ($request:ty => $response:ty))*) => {
        $(
            $(#[$doc])*
            #[derive(Debug, Clone, Copy)]
            pub struct $name;

            impl $crate::service::Service for $name {
                type Request = $request;
                type Response = $response;

                fn type_name() -> String {
                    $type_name.to_owned()
                }
            }
        )*
    };
}

pub(crate) use {messages, services};
