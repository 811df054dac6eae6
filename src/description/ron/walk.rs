//! Validation of scene parts from code. In goes a part, out comes its first invalid field. Invariant: fields
//! are serialized without output; one that fails is reported by its path, such as `Sun.fractal.real`.

use serde::Serialize;
use serde_json::ser::{CharEscape, CompactFormatter, Formatter, Serializer};
use std::io::{Result, Write, sink};

/// Path of the first field that fails to serialize, and its error.
pub(super) fn fault(part: &impl Serialize) -> Option<(String, String)> {
    let mut steps = Vec::new();
    let walk = Walk { steps: &mut steps, is_in_name: false };
    let said = part.serialize(&mut Serializer::with_formatter(sink(), walk)).err()?;
    let step = |step| match step {
        Step::Field(name) => format!(".{name}"),
        Step::Place(number) => format!("[{number}]"),
    };
    let path: String = steps.into_iter().map(step).collect();
    Some((path.trim_start_matches('.').to_owned(), said.to_string()))
}

/// Step into a field or variant by name, or into a list.
enum Step {
    Field(String),
    Place(usize),
}

/// Path to the field that is serialized.
struct Walk<'a> {
    steps: &'a mut Vec<Step>,
    is_in_name: bool,
}

impl Formatter for Walk<'_> {
    fn begin_array<W: Write + ?Sized>(&mut self, _: &mut W) -> Result<()> {
        self.steps.push(Step::Place(0));
        Ok(())
    }

    fn begin_array_value<W: Write + ?Sized>(&mut self, _: &mut W, is_first: bool) -> Result<()> {
        if let Some(Step::Place(number)) = self.steps.last_mut() {
            *number += usize::from(!is_first);
        }
        Ok(())
    }

    fn end_array<W: Write + ?Sized>(&mut self, _: &mut W) -> Result<()> {
        self.steps.pop();
        Ok(())
    }

    fn begin_object_key<W: Write + ?Sized>(&mut self, _: &mut W, _: bool) -> Result<()> {
        self.steps.push(Step::Field(String::new()));
        self.is_in_name = true;
        Ok(())
    }

    fn write_string_fragment<W: Write + ?Sized>(&mut self, _: &mut W, part: &str) -> Result<()> {
        if let (true, Some(Step::Field(name))) = (self.is_in_name, self.steps.last_mut()) {
            name.push_str(part);
        }
        Ok(())
    }

    fn write_char_escape<W: Write + ?Sized>(&mut self, out: &mut W, escape: CharEscape) -> Result<()> {
        let mut escaped = Vec::new();
        CompactFormatter.write_char_escape(&mut escaped, escape)?;
        self.write_string_fragment(out, &String::from_utf8_lossy(&escaped))
    }

    fn end_object_key<W: Write + ?Sized>(&mut self, _: &mut W) -> Result<()> {
        self.is_in_name = false;
        Ok(())
    }

    fn end_object_value<W: Write + ?Sized>(&mut self, _: &mut W) -> Result<()> {
        self.steps.pop();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Animated, Camera, Julia, Light, Material, Sun};
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn the_path_leads_to_the_first_fault() {
        let julia = Julia { real: 0.0.into(), imaginary: 3.0.into(), iterations: 10.into() };
        let light = Light::Sun(Sun { fractal: Some(julia), ..Sun::default() });
        assert_eq!(fault(&light).map(|(path, _)| path).as_deref(), Some("Sun.fractal.imaginary"));
        let keyed = Some(Animated::keys([(0.0, 40.0), (f64::NAN, 50.0)]));
        let camera = Camera { fov_deg: keyed, ..Camera::default() };
        assert_eq!(fault(&camera).map(|(path, _)| path).as_deref(), Some("fov_deg.keys[1].at_s"));
        assert_eq!(fault(&Camera::default()), None);
        let dark = Material::default().with(|material| material.opacity = Some(f64::NAN.into()));
        let named = BTreeMap::from([(r#"a "leaf""#, dark)]);
        let path = fault(&named).map(|(path, _)| path);
        assert_eq!(path.as_deref(), Some(r#"a \"leaf\".opacity"#));
    }
}
