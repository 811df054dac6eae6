//! Binary part of a `.glb` file. In go numbers and images, out come bytes and the accessors that describe
//! them. Invariant: every view starts at a multiple of four bytes.

use serde_json::{Value, json};

#[derive(Debug, Default)]
pub(super) struct Binary {
    pub(super) bytes: Vec<u8>,
    pub(super) views: Vec<Value>,
    pub(super) accessors: Vec<Value>,
}

/// Use of a view by the GPU.
#[derive(Clone, Copy)]
pub(super) enum Target {
    Vertices = 34962,
    Indices = 34963,
}

/// glTF's component type of 32-bit floats.
const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;

impl Binary {
    pub(super) fn view(&mut self, bytes: impl IntoIterator<Item = u8>, target: Option<Target>) -> usize {
        let start = self.bytes.len();
        self.bytes.extend(bytes);
        let mut view = json!({ "buffer": 0, "byteOffset": start, "byteLength": self.bytes.len() - start });
        if let Some(target) = target {
            view["target"] = json!(target as u32);
        }
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(view);
        self.views.len() - 1
    }

    /// Adds an accessor of floats, `WIDTH` a value, with bounds if glTF demands them.
    pub(super) fn floats<const WIDTH: usize>(
        &mut self,
        values: &[[f32; WIDTH]],
        target: Option<Target>,
        with_bounds: bool,
    ) -> usize {
        let view = self.view(values.iter().flatten().flat_map(|value| value.to_le_bytes()), target);
        let kind = if WIDTH == 16 { "MAT4" } else { ["SCALAR", "VEC2", "VEC3", "VEC4"][WIDTH - 1] };
        let mut accessor =
            json!({ "bufferView": view, "componentType": FLOAT, "count": values.len(), "type": kind });
        if with_bounds {
            let bound = |least: fn(f32, f32) -> f32, start: f32| -> Vec<f32> {
                (0..WIDTH).map(|axis| values.iter().map(|value| value[axis]).fold(start, least)).collect()
            };
            accessor["min"] = json!(bound(f32::min, f32::INFINITY));
            accessor["max"] = json!(bound(f32::max, f32::NEG_INFINITY));
        }
        self.accessor(accessor)
    }

    /// Adds an accessor of a part of existing floats, one a value.
    pub(super) fn part_of_times(&mut self, view: usize, times_s: &[f32], first: usize) -> usize {
        self.accessor(json!({
            "bufferView": view, "byteOffset": 4 * first, "componentType": FLOAT, "count": times_s.len(),
            "type": "SCALAR", "min": [times_s[0]], "max": [times_s[times_s.len() - 1]],
        }))
    }

    /// Adds an accessor of vertex indices below `vertices`.
    pub(super) fn indices(&mut self, indices: &[u32], vertices: usize) -> usize {
        // glTF reserves the largest value of each type for primitive restart.
        let (kind, view) = if vertices < usize::from(u16::MAX) {
            let bytes = indices.iter().flat_map(|&index| (index as u16).to_le_bytes());
            (UNSIGNED_SHORT, self.view(bytes, Some(Target::Indices)))
        } else {
            let bytes = indices.iter().flat_map(|&index| index.to_le_bytes());
            (UNSIGNED_INT, self.view(bytes, Some(Target::Indices)))
        };
        self.accessor(
            json!({ "bufferView": view, "componentType": kind, "count": indices.len(), "type": "SCALAR" }),
        )
    }

    /// Adds an accessor of four joints a vertex.
    pub(super) fn joints(&mut self, joints: &[[u16; 4]]) -> usize {
        let bytes = joints.as_flattened().iter().flat_map(|joint| joint.to_le_bytes());
        let view = self.view(bytes, Some(Target::Vertices));
        self.accessor(
            json!({ "bufferView": view, "componentType": UNSIGNED_SHORT, "count": joints.len(), "type": "VEC4" }),
        )
    }

    fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}
