//! Objects with names: `{ "oak": .., "birch": .. }`. In goes a RON map, out comes a list. Invariant: every
//! name occurs once, and the author's order is kept.

use serde::de::{Deserialize, Deserializer, Error, MapAccess, Unexpected, Visitor};
use serde::{Serialize, Serializer};
use std::collections::{BTreeMap, HashSet};
use std::fmt;
use std::marker::PhantomData;

/// Objects of one kind, by name, in the author's order.
#[derive(Clone, Debug, PartialEq)]
pub struct Named<T>(Vec<(String, T)>);

impl<T> Default for Named<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> Named<T> {
    /// A single object.
    pub(super) fn one(name: &str, thing: T) -> Self {
        Self(vec![(name.to_owned(), thing)])
    }

    /// Adds an object; [`super::load_built`] refuses duplicate names.
    pub(crate) fn push(&mut self, name: &str, thing: T) {
        self.0.push((name.to_owned(), thing));
    }

    /// Names and objects, in the author's order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (&str, &T)> {
        self.0.iter().map(|(name, thing)| (name.as_str(), thing))
    }

    /// The names.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|(name, _)| name.as_str())
    }

    /// Object of that name.
    pub fn get(&self, name: &str) -> Option<&T> {
        self.0.iter().find(|(other, _)| other == name).map(|(_, thing)| thing)
    }
}

impl<T> From<BTreeMap<String, T>> for Named<T> {
    fn from(things: BTreeMap<String, T>) -> Self {
        Self(things.into_iter().collect())
    }
}

impl<T: Serialize> Serialize for Named<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.iter())
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Named<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(NamedVisitor(PhantomData))
    }
}

struct NamedVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for NamedVisitor<T> {
    type Value = Named<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a map { \"name\": .., }")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let mut seen = HashSet::new();
        let mut things = Vec::new();
        while let Some(name) = map.next_key::<String>()? {
            if name.is_empty() {
                return Err(A::Error::invalid_value(Unexpected::Str(""), &"a name that is not empty"));
            }
            if !seen.insert(name.clone()) {
                let found = format!("the name \"{name}\" a second time");
                return Err(A::Error::invalid_value(Unexpected::Other(&found), &"every name once"));
            }
            things.push((name, map.next_value()?));
        }
        Ok(Named(things))
    }
}
