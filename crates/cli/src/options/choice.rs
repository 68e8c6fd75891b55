//! Options that take one of some named values.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// A value: its name on the command line, itself, and what it is.
pub type Choice<T> = (&'static str, T, &'static str);

/// Parses the name of one of these values.
pub fn one_of<T: Copy + Send + Sync>(
    choices: &'static [Choice<T>],
) -> impl TypedValueParser<Value = T> {
    let named = choices
        .iter()
        .map(|(name, _, what)| PossibleValue::new(*name).help(*what));
    PossibleValuesParser::new(named).try_map(|given| {
        let mut choices = choices.iter();
        let found = choices.find(|(name, ..)| *name == given);
        found
            .map(|(_, value, _)| *value)
            .ok_or("there is no such value")
    })
}
