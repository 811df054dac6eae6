//! Accessors. In go indices, out come numbers. Invariants: memory is allocated only after the file is known
//! to hold the data. In all it is at most a fixed multiple of the file's size.

use super::buffers::Buffers;
use super::draco::Unpacked;
use super::json::{Accessor, Document};
use crate::diagnostic::Diagnostic;
pub(super) use gltf::accessor::DataType as Component;
use std::cell::Cell;
use std::collections::BTreeMap;

/// Maximum number of times that the same bytes may be read, as meshes share accessors.
const READS_OF_EACH_BYTE: usize = 64;
/// Bytes that any file may take, however small.
const SMALL_BYTES: usize = 64 << 20;

pub(super) struct Accessors<'a> {
    document: &'a Document,
    buffers: &'a Buffers<'a>,
    /// Decompressed replacements of accessors.
    unpacked: BTreeMap<usize, Unpacked>,
    bytes_left: Cell<usize>,
}

/// Requirements on an accessor for one purpose.
#[derive(Clone, Copy)]
pub(super) struct Wanted {
    /// Purpose, as in a message.
    pub(super) purpose: &'static str,
    /// Numbers an element.
    pub(super) width: usize,
    /// Component types that are allowed.
    pub(super) components: &'static [Component],
}

fn component_of_code(code: u32) -> Option<Component> {
    use Component::{F32, I8, I16, U8, U16, U32};
    [I8, U8, I16, U16, U32, F32].into_iter().find(|component| component.as_gl_enum() == code)
}

/// Decodes the number at the start of `bytes`.
fn decoded(component: Component, bytes: &[u8]) -> f64 {
    match component {
        Component::I8 => f64::from(bytes[0] as i8),
        Component::U8 => f64::from(bytes[0]),
        Component::I16 => f64::from(i16::from_le_bytes([bytes[0], bytes[1]])),
        Component::U16 => f64::from(u16::from_le_bytes([bytes[0], bytes[1]])),
        Component::U32 => f64::from(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
        Component::F32 => f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
    }
}

/// Divisor of normalized integers: the largest value (specification, 3.11).
fn one(component: Component) -> f64 {
    match component {
        Component::I8 => 127.0,
        Component::U8 => 255.0,
        Component::I16 => 32767.0,
        Component::U16 => 65535.0,
        Component::U32 | Component::F32 => 1.0,
    }
}

impl<'a> Accessors<'a> {
    pub(super) fn new(
        document: &'a Document,
        buffers: &'a Buffers<'a>,
        unpacked: BTreeMap<usize, Unpacked>,
    ) -> Self {
        let bytes =
            buffers.total_bytes() + unpacked.values().map(|unpacked| unpacked.bytes.len()).sum::<usize>();
        let limit = bytes.saturating_mul(READS_OF_EACH_BYTE).saturating_add(SMALL_BYTES);
        Self { document, buffers, unpacked, bytes_left: Cell::new(limit) }
    }

    /// Error at a place in this file.
    pub(super) fn invalid(&self, path: impl Into<String>, found: impl Into<String>) -> Diagnostic {
        self.buffers.invalid(path, found)
    }

    /// Declared number of elements of accessor `index`; 0 if it does not exist.
    pub(super) fn count(&self, index: usize) -> usize {
        match self.unpacked.get(&index) {
            Some(unpacked) => unpacked.count,
            None => self.document.accessors.get(index).map_or(0, |accessor| accessor.count),
        }
    }

    /// Reads all numbers of accessor `index`, `wanted.width` an element, all finite. `user` is the path that
    /// refers to it.
    pub(super) fn read(&self, index: usize, wanted: Wanted, user: &str) -> Result<Vec<f64>, Diagnostic> {
        let Some(accessor) = self.document.accessors.get(index) else {
            return Err(self.invalid(user, format!("accessor {index} does not exist")));
        };
        let path = format!("accessors[{index}]");
        let unpacked = self.unpacked.get(&index);
        let component = self.check_type(accessor, unpacked, wanted, &path)?;
        let count = self.count(index);
        if count == 0 {
            return Err(self
                .invalid(format!("{path}.count"), "the accessor is empty")
                .expected("at least 1 element"));
        }
        self.take_from_budget(count, wanted, &path)?;
        let mut values = match (unpacked, accessor.buffer_view) {
            (Some(Unpacked { bytes, .. }), _) => {
                let source = Source { bytes, offset: 0, stride: None, component };
                self.elements(source, count, wanted.width, &path)?
            }
            (None, Some(view)) => {
                let (bytes, stride) = self.buffers.view(view, &format!("{path}.bufferView"))?;
                let source = Source { bytes, offset: accessor.byte_offset, stride, component };
                self.elements(source, count, wanted.width, &path)?
            }
            (None, None) => vec![0.0; count * wanted.width],
        };
        self.replace_sparse(&mut values, accessor, component, wanted.width, &path)?;
        if accessor.normalized {
            for value in &mut values {
                *value = (*value / one(component)).max(-1.0);
            }
        }
        match values.iter().position(|value| !value.is_finite()) {
            None => Ok(values),
            Some(at) => Err(self
                .invalid(
                    path,
                    format!("element {} of these {} is not finite", at / wanted.width, wanted.purpose),
                )
                .expected("finite numbers")),
        }
    }

    /// Reads one element for each of so many positions.
    pub(super) fn read_for(
        &self,
        vertices: usize,
        index: usize,
        wanted: Wanted,
        user: &str,
    ) -> Result<Vec<f64>, Diagnostic> {
        let numbers = self.read(index, wanted, user)?;
        let count = numbers.len() / wanted.width;
        if count == vertices {
            return Ok(numbers);
        }
        let found = format!("there are {vertices} positions and {count} of these");
        Err(self.invalid(user, found).expected("as many as there are positions"))
    }

    fn check_type(
        &self,
        accessor: &Accessor,
        unpacked: Option<&Unpacked>,
        wanted: Wanted,
        path: &str,
    ) -> Result<Component, Diagnostic> {
        let shapes = [("SCALAR", 1), ("VEC2", 2), ("VEC3", 3), ("VEC4", 4), ("MAT4", 16)];
        let expected =
            shapes.iter().find(|(_, width)| *width == wanted.width).map_or("MAT4", |shape| shape.0);
        if accessor.shape != expected {
            let found = format!("{} cannot be of type `{}`", wanted.purpose, accessor.shape);
            return Err(self.invalid(format!("{path}.type"), found).expected(expected));
        }
        if let Some(unpacked) = unpacked.filter(|unpacked| unpacked.width != wanted.width) {
            let found = format!("the compressed {} have {} numbers each", wanted.purpose, unpacked.width);
            return Err(self.invalid(path, found).expected(format!("{} numbers", wanted.width)));
        }
        let component_type = unpacked.map_or(accessor.component_type, |unpacked| unpacked.component_type);
        component_of_code(component_type)
            .filter(|component| wanted.components.contains(component))
            .ok_or_else(|| {
                let found = format!("{} cannot be of component type {component_type}", wanted.purpose);
                self.invalid(format!("{path}.componentType"), found)
                    .expected(format!("one of {:?}", wanted.components))
            })
    }

    fn take_from_budget(&self, count: usize, wanted: Wanted, path: &str) -> Result<(), Diagnostic> {
        let bytes = count.saturating_mul(wanted.width * size_of::<f64>());
        match self.bytes_left.get().checked_sub(bytes) {
            Some(left) => {
                self.bytes_left.set(left);
                Ok(())
            }
            None => Err(self.invalid(
                format!("{path}.count"),
                format!("{count} elements are far more than a file of this size holds"),
            )),
        }
    }

    fn elements(
        &self,
        source: Source<'_>,
        count: usize,
        width: usize,
        path: &str,
    ) -> Result<Vec<f64>, Diagnostic> {
        let step = source.component.size();
        let element = width * step;
        let stride = source.stride.unwrap_or(element);
        if stride < element {
            return Err(self.invalid(
                path,
                format!("a byteStride of {stride} is less than the element's {element} bytes"),
            ));
        }
        let end = (count.saturating_sub(1))
            .checked_mul(stride)
            .and_then(|last| last.checked_add(element))
            .and_then(|length| length.checked_add(source.offset));
        if end.is_none_or(|end| end > source.bytes.len()) {
            return Err(self.invalid(
                format!("{path}.count"),
                format!(
                    "{count} elements, {stride} bytes apart, from byte {} on reach beyond the {} bytes of the buffer view",
                    source.offset,
                    source.bytes.len()
                ),
            ));
        }
        Ok((0..count)
            .flat_map(|i| (0..width).map(move |j| i * stride + j * step))
            .map(|at| decoded(source.component, &source.bytes[source.offset + at..]))
            .collect())
    }

    fn replace_sparse(
        &self,
        values: &mut [f64],
        accessor: &Accessor,
        component: Component,
        width: usize,
        path: &str,
    ) -> Result<(), Diagnostic> {
        let Some(sparse) = &accessor.sparse else { return Ok(()) };
        let path = format!("{path}.sparse");
        if sparse.count > accessor.count {
            return Err(self.invalid(format!("{path}.count"), "more elements are replaced than there are"));
        }
        let index_component = component_of_code(sparse.indices.component_type)
            .filter(|component| matches!(component, Component::U8 | Component::U16 | Component::U32))
            .ok_or_else(|| {
                self.invalid(format!("{path}.indices.componentType"), "indices cannot be of this type")
            })?;
        let (bytes, _) = self.buffers.view(sparse.indices.buffer_view, &path)?;
        let source =
            Source { bytes, offset: sparse.indices.byte_offset, stride: None, component: index_component };
        let indices = self.elements(source, sparse.count, 1, &path)?;
        let (bytes, _) = self.buffers.view(sparse.values.buffer_view, &path)?;
        let source = Source { bytes, offset: sparse.values.byte_offset, stride: None, component };
        let replacements = self.elements(source, sparse.count, width, &path)?;
        for (index, replacement) in indices.iter().zip(replacements.chunks_exact(width)) {
            let start = *index as usize * width;
            let Some(target) = values.get_mut(start..start + width) else {
                return Err(self.invalid(path, format!("element {index} does not exist")));
            };
            target.copy_from_slice(replacement);
        }
        Ok(())
    }
}

struct Source<'b> {
    bytes: &'b [u8],
    offset: usize,
    stride: Option<usize>,
    component: Component,
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::report::Report;
    use super::super::{Files, buffers};
    use super::*;
    use std::path::Path;

    const ANY: &[Component] =
        &[Component::I8, Component::U8, Component::I16, Component::U16, Component::U32, Component::F32];

    /// The numbers of accessor 0 of a document with one buffer.
    fn read(bytes: &[u8], views: &str, accessor: &str, width: usize) -> Result<Vec<f64>, Diagnostic> {
        let json = format!(
            r#"{{"buffers": [{{"byteLength": {}}}], "bufferViews": {views}, "accessors": [{accessor}]}}"#,
            bytes.len()
        );
        let document: Document = serde_json::from_str(&json).unwrap();
        let file = Path::new("test.glb");
        let mut report = Report::new(file);
        let buffers = buffers::load(&document, Some(bytes), file, &mut Files::default(), &mut report);
        Accessors::new(&document, &buffers, BTreeMap::new()).read(
            0,
            Wanted { purpose: "numbers", width, components: ANY },
            "test",
        )
    }

    #[test]
    fn interleaved_elements_are_read_at_their_stride() {
        let bytes = [1, 2, 99, 3, 4, 99, 5, 6];
        let views = r#"[{"buffer": 0, "byteLength": 8, "byteStride": 3}]"#;
        let accessor = r#"{"bufferView": 0, "componentType": 5121, "count": 3, "type": "VEC2"}"#;
        assert_eq!(read(&bytes, views, accessor, 2).unwrap(), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    }

    #[test]
    fn normalised_integers_reach_from_minus_one_to_one() {
        let views = r#"[{"buffer": 0, "byteLength": 4}]"#;
        let numbers = |kind: u32, count: u32, bytes: [u8; 4]| {
            let accessor = format!(
                r#"{{"bufferView": 0, "componentType": {kind}, "normalized": true, "count": {count}, "type": "SCALAR"}}"#
            );
            read(&bytes, views, &accessor, 1).unwrap()
        };
        assert_eq!(numbers(5120, 4, [0x80, 0x81, 0, 0x7f]), [-1.0, -1.0, 0.0, 1.0]);
        assert_eq!(numbers(5121, 2, [0, 255, 0, 0]), [0.0, 1.0]);
        assert_eq!(numbers(5122, 2, [0x00, 0x80, 0xff, 0x7f]), [-1.0, 1.0]);
        assert_eq!(numbers(5123, 2, [0, 0, 0xff, 0xff]), [0.0, 1.0]);
    }

    #[test]
    fn sparse_elements_replace_those_of_the_base() {
        let bytes = [1, 2, 0, 0, 0, 0, 96, 64];
        let views = r#"[{"buffer": 0, "byteLength": 4}, {"buffer": 0, "byteOffset": 4, "byteLength": 4}]"#;
        let accessor = r#"{"componentType": 5126, "count": 3, "type": "SCALAR",
            "sparse": {"count": 1, "indices": {"bufferView": 0, "byteOffset": 1, "componentType": 5121},
                       "values": {"bufferView": 1}}}"#;
        assert_eq!(read(&bytes, views, accessor, 1).unwrap(), [0.0, 0.0, 3.5]);
    }

    #[test]
    fn the_last_element_may_end_with_the_view_and_no_later() {
        let views = r#"[{"buffer": 0, "byteLength": 4}]"#;
        let accessor = |offset: u32| {
            format!(
                r#"{{"bufferView": 0, "byteOffset": {offset}, "componentType": 5123, "count": 1, "type": "SCALAR"}}"#
            )
        };
        assert!(read(&[0; 4], views, &accessor(2), 1).is_ok());
        assert!(read(&[0; 4], views, &accessor(3), 1).is_err());
    }
}
