//! The version of the format. Invariant: a file of another version is refused, never half understood.

use serde::de::{Deserialize, Deserializer, Error, Unexpected};

/// Version 1, the only one there is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Version;

impl<'de> Deserialize<'de> for Version {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match u64::deserialize(deserializer)? {
            1 => Ok(Self),
            other => Err(D::Error::invalid_value(
                Unexpected::Unsigned(other),
                &"version 1, the only one that this program reads",
            )),
        }
    }
}
