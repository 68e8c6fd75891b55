//! Settings with their defaults.

/// Declares a structure of settings with the default of each: what is left out where they are read takes it, and unknown names
/// are refused.
///
/// ```
/// ppnpack_numbers::settings! {
///     /// How a door opens.
///     #[derive(Copy)]
///     pub struct DoorSettings {
///         /// How wide, in metres.
///         pub width_m: f64 = 0.8,
///         /// How long it stays open, in seconds.
///         pub open_s: f64 = 5.0,
///     }
/// }
///
/// let door: DoorSettings = serde_json::from_str(r#"{"open_s": 2.0}"#)?;
/// assert_eq!(door, DoorSettings { open_s: 2.0, ..DoorSettings::default() });
/// assert_eq!(door.width_m, 0.8);
/// assert_eq!(serde_json::to_string(&door)?, r#"{"width_m":0.8,"open_s":2.0}"#);
/// assert!(serde_json::from_str::<DoorSettings>(r#"{"opens": 2.0}"#).is_err());
/// # Ok::<(), serde_json::Error>(())
/// ```
#[macro_export]
macro_rules! settings {
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
