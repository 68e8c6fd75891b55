//! Settings with their defaults and ranges.

/// A value that a range is asked about.
pub trait Number {
    /// Gives the value as a number; none where it is left open.
    fn number(&self) -> Option<f64>;
}

impl Number for f64 {
    fn number(&self) -> Option<f64> {
        Some(*self)
    }
}

impl Number for u8 {
    fn number(&self) -> Option<f64> {
        Some(f64::from(*self))
    }
}

impl Number for usize {
    fn number(&self) -> Option<f64> {
        Some(*self as f64)
    }
}

impl<Inner: Number> Number for Option<Inner> {
    fn number(&self) -> Option<f64> {
        self.as_ref().and_then(Inner::number)
    }
}

/// Declares a structure of settings with the default of each: what is left out where they are read
/// takes it, and unknown names are refused. The method that is named after `with` checks those that
/// have a range, and names them after what `as` says.
///
/// ```
/// use ppnpack_numbers::within;
///
/// ppnpack_numbers::settings! {
///     /// How a door opens.
///     #[derive(Copy)]
///     pub struct DoorSettings with validate as "door." {
///         /// How wide, in metres.
///         pub width_m: f64 = 0.8 => within("0 to 2 m", 0.0..=2.0),
///         /// How long it stays open, in seconds.
///         pub open_s: f64 = 5.0,
///     }
/// }
///
/// let mut door: DoorSettings = serde_json::from_str(r#"{"open_s": 2.0}"#)?;
/// assert_eq!(door, DoorSettings { open_s: 2.0, ..DoorSettings::default() });
/// assert_eq!(door.width_m, 0.8);
/// assert_eq!(serde_json::to_string(&door)?, r#"{"width_m":0.8,"open_s":2.0}"#);
/// assert!(serde_json::from_str::<DoorSettings>(r#"{"opens": 2.0}"#).is_err());
/// assert!(door.validate().is_ok());
/// door.width_m = 3.0;
/// let refused = door.validate().unwrap_err();
/// assert_eq!(refused.to_string(), "door.width_m must be 0 to 2 m, but is 3");
/// # Ok::<(), serde_json::Error>(())
/// ```
#[macro_export]
macro_rules! settings {
    (
        $(#[$attribute:meta])*
        pub struct $name:ident with $validate:ident $(as $owner:literal)? {
            $(
                $(#[$of_field:meta])*
                pub $field:ident: $kind:ty = $default:expr $(=> $range:expr)?
            ),* $(,)?
        }
    ) => {
        $crate::settings! {
            $(#[$attribute])*
            pub struct $name {
                $($(#[$of_field])* pub $field: $kind = $default),*
            }
        }

        impl $name {
            /// Checks the range of each number that has one.
            ///
            /// # Errors
            /// The first that is outside, by its name.
            pub fn $validate(&self) -> Result<(), $crate::SettingError> {
                let owner = concat!($($owner)?);
                $($(if let Some(number) = $crate::Number::number(&self.$field) {
                    ($range)(&format!("{owner}{}", stringify!($field)), number)?;
                })?)*
                Ok(())
            }
        }
    };
    (
        $(#[$attribute:meta])*
        pub struct $name:ident {
            $($(#[$of_field:meta])* pub $field:ident: $kind:ty = $default:expr),* $(,)?
        }
    ) => {
        $(#[$attribute])*
        #[derive(Debug, Clone, PartialEq, ::serde::Serialize, ::serde::Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $name {
            $($(#[$of_field])* pub $field: $kind),*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default),* }
            }
        }
    };
}
