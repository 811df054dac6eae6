//! Custom properties of a glTF file for this program. In goes a file, out comes text: those present, the
//! defaults of others, and their meanings. Invariant: names, defaults and meanings are those of
//! docs/extras.schema.json.

use serde_json::Value;
use std::fmt::Write;
use std::sync::LazyLock;
use sunfleck::scene::Property;

static SCHEMA: LazyLock<Value> = LazyLock::new(|| {
    serde_json::from_str(include_str!("../../../docs/extras.schema.json")).unwrap_or_default()
});
/// Maximum number of owners shown for a property.
const SHOWN: usize = 4;

pub(super) fn write(out: &mut String, properties: &[Property]) -> std::fmt::Result {
    let mut names: Vec<&str> = Vec::new();
    for property in properties {
        if !names.contains(&property.name.as_str()) {
            names.push(&property.name);
        }
    }
    for name in names {
        let described = &SCHEMA["properties"][name];
        writeln!(out, "  property   `{name}` {}", text(&described["description"]))?;
        let having: Vec<_> = properties.iter().filter(|property| property.name == name).collect();
        for property in having.iter().take(SHOWN) {
            writeln!(out, "    of {}", property.owner)?;
            write_fields(out, &described["properties"], &property.value)?;
        }
        if having.len() > SHOWN {
            writeln!(out, "    and of {} more", having.len() - SHOWN)?;
        }
    }
    Ok(())
}

fn write_fields(out: &mut String, described: &Value, value: &Value) -> std::fmt::Result {
    let (Some(described), Some(value)) = (described.as_object(), value.as_object()) else { return Ok(()) };
    for (field, found) in value {
        let Some(known) = described.get(field) else {
            writeln!(out, "      {field} {found}: not known, passed over")?;
            continue;
        };
        let default = known.get("default").map_or(String::new(), |default| format!(" (default {default})"));
        writeln!(out, "      {field} {found}{default}: {}", text(&known["description"]))?;
    }
    let left_out = described.iter().filter(|(field, _)| !value.contains_key(*field));
    let left_out: Vec<String> = left_out
        .map(|(field, known)| match known.get("default") {
            Some(default) => format!("{field} {default}"),
            None => format!("{field} none"),
        })
        .collect();
    if !left_out.is_empty() {
        writeln!(out, "      left out: {}", left_out.join(", "))?;
    }
    Ok(())
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}
