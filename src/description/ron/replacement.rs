//! Replacements of an OBJ file's materials: `"bark"`, or `(transmission: (0.1, 0.3, 0.05))`. In goes RON, out
//! come names or materials. Invariant: both forms are read without buffering, so errors keep their line and
//! column.

use super::material::Material;
use serde::Serialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserialize, Deserializer, Error, MapAccess, Visitor};
use std::fmt;

/// A material of the scene, or one for this mesh alone.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
#[non_exhaustive]
pub enum Replacement {
    /// Name of a material of the scene.
    Named(String),
    /// Material for this mesh; the OBJ file's values are its defaults.
    Inline(Box<Material>),
}

impl Replacement {
    /// Name of a material of the scene, if it is one.
    pub fn name(&self) -> Option<&str> {
        match self {
            Self::Named(name) => Some(name),
            Self::Inline(_) => None,
        }
    }

    /// Material for this mesh, if it is one.
    pub fn inline(&self) -> Option<&Material> {
        match self {
            Self::Named(_) => None,
            Self::Inline(material) => Some(material),
        }
    }
}

impl<'de> Deserialize<'de> for Replacement {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ReplacementVisitor)
    }
}

/// A string is a name; a struct with named fields is a material, and empty parentheses are one without
/// fields.
struct ReplacementVisitor;

impl<'de> Visitor<'de> for ReplacementVisitor {
    type Value = Replacement;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the name of a material, or a material (base_color: .., ..)")
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<Self::Value, E> {
        Ok(Replacement::Named(name.to_owned()))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
        let material = Material::deserialize(MapAccessDeserializer::new(map))?;
        Ok(Replacement::Inline(Box::new(material)))
    }

    fn visit_unit<E: Error>(self) -> Result<Self::Value, E> {
        Ok(Replacement::Inline(Box::default()))
    }
}
