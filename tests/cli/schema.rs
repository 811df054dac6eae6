//! Checks JSON against a JSON Schema. Invariant: it knows the words that our schemas use, and no others, so a
//! schema cannot ask for anything that is not checked.

use serde_json::Value;

/// Everything in `value` that the schema at `root` does not allow.
pub(crate) fn violations(root: &Value, value: &Value) -> Vec<String> {
    violations_of(root, root, value)
}

fn violations_of(root: &Value, schema: &Value, value: &Value) -> Vec<String> {
    let mut found = Vec::new();
    check(root, schema, value, "$", &mut found);
    found
}

fn check(root: &Value, schema: &Value, value: &Value, path: &str, found: &mut Vec<String>) {
    for (word, rule) in schema.as_object().unwrap() {
        let holds = match word.as_str() {
            "$schema" | "$defs" | "title" | "description" | "default" => true,
            "minimum" => value.as_f64().is_none_or(|number| number >= rule.as_f64().unwrap()),
            "maximum" => value.as_f64().is_none_or(|number| number <= rule.as_f64().unwrap()),
            "exclusiveMinimum" => value.as_f64().is_none_or(|number| number > rule.as_f64().unwrap()),
            "exclusiveMaximum" => value.as_f64().is_none_or(|number| number < rule.as_f64().unwrap()),
            "$ref" => {
                let target = root.pointer(rule.as_str().unwrap().trim_start_matches('#')).unwrap();
                check(root, target, value, path, found);
                true
            }
            "type" => {
                let types = rule.as_array().map_or(vec![rule], |types| types.iter().collect());
                types.iter().any(|name| is_of_type(value, name.as_str().unwrap()))
            }
            "anyOf" => {
                rule.as_array().unwrap().iter().any(|rule| violations_of(root, rule, value).is_empty())
            }
            "enum" => rule.as_array().unwrap().contains(value),
            "required" => {
                rule.as_array().unwrap().iter().all(|name| value.get(name.as_str().unwrap()).is_some())
            }
            "minItems" => value.as_array().is_none_or(|items| items.len() as u64 >= rule.as_u64().unwrap()),
            "maxItems" => value.as_array().is_none_or(|items| items.len() as u64 <= rule.as_u64().unwrap()),
            "items" => {
                for (index, item) in value.as_array().into_iter().flatten().enumerate() {
                    check(root, rule, item, &format!("{path}[{index}]"), found);
                }
                true
            }
            "properties" => {
                for (name, field) in value.as_object().into_iter().flatten() {
                    if let Some(rule) = rule.get(name) {
                        check(root, rule, field, &format!("{path}.{name}"), found);
                    }
                }
                true
            }
            "additionalProperties" => {
                let is_named =
                    |name: &str| schema.get("properties").is_some_and(|named| named.get(name).is_some());
                let others = value.as_object().into_iter().flatten().filter(|(name, _)| !is_named(name));
                for (name, field) in others {
                    match rule {
                        Value::Bool(false) => found.push(format!("{path}.{name} is not described")),
                        rule => check(root, rule, field, &format!("{path}.{name}"), found),
                    }
                }
                true
            }
            other => panic!("`{other}` is not a word that is checked"),
        };
        if !holds {
            found.push(format!("{path} = {value}: {word} is {rule}"));
        }
    }
}

fn is_of_type(value: &Value, name: &str) -> bool {
    match name {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "number" => value.is_number(),
        "integer" => value.is_i64() || value.is_u64(),
        "boolean" => value.is_boolean(),
        "null" => value.is_null(),
        other => panic!("`{other}` is no type"),
    }
}
