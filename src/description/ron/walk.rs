//! A walk through a part of a scene: in go its fields, out comes the first that no file could hold.
//! Invariant: nothing is written; what refuses to be is told by its path, as `Sun.fractal.real`.

use serde::ser::{Error, Impossible, Serialize, SerializeMap, SerializeSeq, SerializeStruct};
use serde::ser::{SerializeStructVariant, SerializeTuple, Serializer};
use std::fmt::{self, Arguments, Display, Write};

/// The path of the first field that refuses to be written, and what it says.
pub(super) fn fault(part: &impl Serialize) -> Option<(String, String)> {
    let mut path = String::new();
    let Refusal(said) = part.serialize(Walk { path: &mut path }).err()?;
    Some((path.trim_start_matches('.').to_owned(), said))
}

/// Refusal in a field's words.
#[derive(Debug)]
struct Refusal(String);

impl Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Refusal {}

impl Error for Refusal {
    fn custom<T: Display>(said: T) -> Self {
        Self(said.to_string())
    }
}

struct Walk<'a> {
    path: &'a mut String,
}

/// Container of fields, some of which have been walked through.
struct Within<'a> {
    path: &'a mut String,
    /// Length of the path outside.
    outside: usize,
    next: usize,
}

impl<'a> Walk<'a> {
    fn within(self, variant: Arguments<'_>) -> Result<Within<'a>, Refusal> {
        let outside = self.path.len();
        // Writing to a string cannot fail.
        let _ = self.path.write_fmt(variant);
        Ok(Within { path: self.path, outside, next: 0 })
    }
}

impl Within<'_> {
    /// Goes into one of them; where it is refused the path stays.
    fn step<T: Serialize + ?Sized>(&mut self, name: Arguments<'_>, value: &T) -> Result<(), Refusal> {
        let here = self.path.len();
        let _ = self.path.write_fmt(name);
        value.serialize(Walk { path: self.path })?;
        self.path.truncate(here);
        Ok(())
    }

    fn leave(self) -> Result<(), Refusal> {
        self.path.truncate(self.outside);
        Ok(())
    }
}

/// Values without fields are as good as written.
macro_rules! plain {
    ($($name:ident: $type:ty),*) => {$(
        fn $name(self, _: $type) -> Result<(), Refusal> {
            Ok(())
        }
    )*};
}

impl<'a> Serializer for Walk<'a> {
    type Ok = ();
    type Error = Refusal;
    type SerializeSeq = Within<'a>;
    type SerializeTuple = Within<'a>;
    type SerializeTupleStruct = Impossible<(), Refusal>;
    type SerializeTupleVariant = Impossible<(), Refusal>;
    type SerializeMap = Within<'a>;
    type SerializeStruct = Within<'a>;
    type SerializeStructVariant = Within<'a>;

    plain! {
        serialize_bool: bool, serialize_i8: i8, serialize_i16: i16, serialize_i32: i32, serialize_i64: i64,
        serialize_u8: u8, serialize_u16: u16, serialize_u32: u32, serialize_u64: u64, serialize_f32: f32,
        serialize_f64: f64, serialize_char: char, serialize_str: &str, serialize_bytes: &[u8],
        serialize_unit_struct: &'static str
    }

    fn serialize_none(self) -> Result<(), Refusal> {
        Ok(())
    }
    fn serialize_unit(self) -> Result<(), Refusal> {
        Ok(())
    }
    fn serialize_unit_variant(self, _: &'static str, _: u32, _: &'static str) -> Result<(), Refusal> {
        Ok(())
    }
    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<(), Refusal> {
        value.serialize(self)
    }
    fn serialize_newtype_struct<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        value: &T,
    ) -> Result<(), Refusal> {
        value.serialize(self)
    }
    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        value: &T,
    ) -> Result<(), Refusal> {
        self.within(format_args!(""))?.step(format_args!(".{variant}"), value)
    }
    fn serialize_seq(self, _: Option<usize>) -> Result<Within<'a>, Refusal> {
        self.within(format_args!(""))
    }
    fn serialize_tuple(self, _: usize) -> Result<Within<'a>, Refusal> {
        self.within(format_args!(""))
    }
    fn serialize_map(self, _: Option<usize>) -> Result<Within<'a>, Refusal> {
        self.within(format_args!(""))
    }
    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Within<'a>, Refusal> {
        self.within(format_args!(""))
    }
    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        _: usize,
    ) -> Result<Within<'a>, Refusal> {
        self.within(format_args!(".{variant}"))
    }
    fn serialize_tuple_struct(
        self,
        name: &'static str,
        _: usize,
    ) -> Result<Self::SerializeTupleStruct, Refusal> {
        Err(Refusal::custom(name))
    }
    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        _: usize,
    ) -> Result<Self::SerializeTupleVariant, Refusal> {
        Err(Refusal::custom(variant))
    }
}

/// Elements have numbers.
macro_rules! numbered {
    ($($kind:ident: $each:ident),*) => {$(
        impl $kind for Within<'_> {
            type Ok = ();
            type Error = Refusal;

            fn $each<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Refusal> {
                self.next += 1;
                self.step(format_args!("[{}]", self.next - 1), value)
            }
            fn end(self) -> Result<(), Refusal> {
                self.leave()
            }
        }
    )*};
}

/// Fields have names.
macro_rules! named {
    ($($kind:ident),*) => {$(
        impl $kind for Within<'_> {
            type Ok = ();
            type Error = Refusal;

            fn serialize_field<T: Serialize + ?Sized>(
                &mut self,
                name: &'static str,
                value: &T,
            ) -> Result<(), Refusal> {
                self.step(format_args!(".{name}"), value)
            }
            fn end(self) -> Result<(), Refusal> {
                self.leave()
            }
        }
    )*};
}

numbered! { SerializeSeq: serialize_element, SerializeTuple: serialize_element }
named! { SerializeStruct, SerializeStructVariant }

impl SerializeMap for Within<'_> {
    type Ok = ();
    type Error = Refusal;

    fn serialize_key<T: Serialize + ?Sized>(&mut self, _: &T) -> Result<(), Refusal> {
        Ok(())
    }
    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Refusal> {
        SerializeSeq::serialize_element(self, value)
    }
    fn end(self) -> Result<(), Refusal> {
        self.leave()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Animated, Camera, Julia, Light, Sun};
    use super::*;

    #[test]
    fn the_path_leads_to_the_first_fault() {
        let julia = Julia { real: 0.0.into(), imaginary: 3.0.into(), iterations: 10.into() };
        let light = Light::Sun(Sun { fractal: Some(julia), ..Sun::default() });
        assert_eq!(fault(&light).map(|(path, _)| path).as_deref(), Some("Sun.fractal.imaginary"));
        let keyed = Some(Animated::keys([(0.0, 40.0), (f64::NAN, 50.0)]));
        let camera = Camera { fov_deg: keyed, ..Camera::default() };
        assert_eq!(fault(&camera).map(|(path, _)| path).as_deref(), Some("fov_deg.keys[1].at_s"));
        assert_eq!(fault(&Camera::default()), None);
    }
}
