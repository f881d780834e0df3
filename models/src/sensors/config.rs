//! What is wrong with a sensor's parameters, with key, value and limits.

use crate::keys::{Holds, Key, find};

/// A parameter that is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ConfigError {
    /// A number outside its limits, or not a number.
    #[error("{key} = {value} is outside {min} ..= {max}")]
    Number {
        /// Name of the parameter, unit last.
        key: &'static str,
        /// What was found.
        value: f64,
        /// Least value allowed.
        min: f64,
        /// Largest value allowed.
        max: f64,
    },
    /// A parameter that has to be given.
    #[error("missing; needed is {needed}")]
    Missing {
        /// Name of the parameter.
        key: &'static str,
        /// What has to be given.
        needed: &'static str,
    },
    /// A list with too few or too many entries.
    #[error("{key} has {found} entries, {min} ..= {max} are allowed")]
    Count {
        /// Name of the parameter.
        key: &'static str,
        /// How many were found.
        found: usize,
        /// Fewest allowed.
        min: usize,
        /// Most allowed.
        max: usize,
    },
    /// A list whose entries do not make what is needed.
    #[error("{key}: {found} ({value:.3} m), needed is {needed}")]
    Shape {
        /// Name of the parameter.
        key: &'static str,
        /// What was found.
        found: &'static str,
        /// Its measure, m.
        value: f64,
        /// What would be right.
        needed: &'static str,
    },
    /// Two parameters that contradict each other.
    #[error("{key} = {value} does not go with {other} = {other_value}")]
    Conflict {
        /// Name of the parameter.
        key: &'static str,
        /// What was found.
        value: f64,
        /// Name of the other parameter.
        other: &'static str,
        /// What was found there.
        other_value: f64,
    },
}

impl ConfigError {
    /// The parameter that it is about.
    #[must_use]
    pub fn key(&self) -> &'static str {
        match self {
            Self::Number { key, .. }
            | Self::Missing { key, .. }
            | Self::Count { key, .. }
            | Self::Shape { key, .. }
            | Self::Conflict { key, .. } => key,
        }
    }
}

/// Refuses `value` unless it lies in `min ..= max`; NaN lies nowhere.
///
/// # Errors
/// [`ConfigError::Number`] with everything a message needs.
pub fn number(key: &'static str, value: f64, min: f64, max: f64) -> Result<(), ConfigError> {
    if value >= min && value <= max {
        Ok(())
    } else {
        Err(ConfigError::Number { key, value, min, max })
    }
}

/// Refuses a list whose length is outside `min ..= max`.
///
/// # Errors
/// [`ConfigError::Count`].
pub fn count(key: &'static str, found: usize, min: usize, max: usize) -> Result<(), ConfigError> {
    if (min..=max).contains(&found) {
        Ok(())
    } else {
        Err(ConfigError::Count { key, found, min, max })
    }
}

/// Refuses `value` outside the limits of the key `word` of `keys`; a word that is not there lets nothing pass.
///
/// # Errors
/// [`ConfigError::Number`] with everything a message needs.
pub fn check(keys: &'static [Key], word: &'static str, value: f64) -> Result<(), ConfigError> {
    match find(&[keys], word).map(|key| key.holds) {
        Some(Holds::Number { least, most } | Holds::Numbers { least, most }) => {
            number(word, value, least, most)
        }
        Some(Holds::Whole { least, most }) => number(word, value, least as f64, most as f64),
        _ => Err(ConfigError::Number { key: word, value, min: f64::NAN, max: f64::NAN }),
    }
}
