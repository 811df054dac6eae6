//! Values that may change over time, for programs that make scenes. In go keys, out come keyed values as
//! files have them. Invariant: what is on or off jumps.

use serde::{Serialize, Serializer};

/// A value that stays, or one that goes straight from key to key.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Animated<T> {
    /// The same at all times.
    Still(T),
    /// Interpolated between keys.
    Keyed {
        /// At least one, their times strictly increasing.
        keys: Vec<Key<T>>,
        /// What happens outside the keys.
        extend: Extend,
    },
}

/// A value at a time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Key<T> {
    /// Seconds.
    pub at_s: f64,
    /// The value there.
    pub value: T,
}

/// What a keyed value does outside its keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub enum Extend {
    /// Keeps the first or last value.
    #[default]
    Hold,
    /// Starts over.
    Cycle,
}

impl<T> Animated<T> {
    /// From pairs of seconds and values; holds the first and the last.
    pub fn keys(keys: impl IntoIterator<Item = (f64, T)>) -> Self {
        Self::Keyed { keys: pairs(keys), extend: Extend::Hold }
    }

    /// The same over and over.
    pub fn cycle(keys: impl IntoIterator<Item = (f64, T)>) -> Self {
        Self::Keyed { keys: pairs(keys), extend: Extend::Cycle }
    }
}

fn pairs<T>(keys: impl IntoIterator<Item = (f64, T)>) -> Vec<Key<T>> {
    keys.into_iter().map(|(at_s, value)| Key { at_s, value }).collect()
}

impl<T> From<T> for Animated<T> {
    fn from(value: T) -> Self {
        Self::Still(value)
    }
}

/// What is on or off goes to no value between.
pub(super) fn in_steps<S: Serializer>(visible: &Animated<bool>, serializer: S) -> Result<S::Ok, S::Error> {
    let Animated::Keyed { keys, extend } = visible else { return visible.serialize(serializer) };
    let key =
        |key: &Key<bool>| serde_json::json!({ "at_s": key.at_s, "value": key.value, "to_next": "Step" });
    let keys: Vec<serde_json::Value> = keys.iter().map(key).collect();
    serde_json::json!({ "keys": keys, "extend": extend }).serialize(serializer)
}
