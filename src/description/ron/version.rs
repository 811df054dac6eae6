//! Version of the format. In goes a number, out comes version 1. Invariant: a file of another version is
//! refused.

use serde::de::{Deserialize, Deserializer, Error, Unexpected};

/// Version 1, the only one.
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
