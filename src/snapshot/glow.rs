//! What glows, as a light to be looked for. In go a snapshot's triangles and what they emit, out come points
//! of them, as densely as they glow. Invariant: every point that glows may be picked.

use super::Snapshot;
use crate::accel::PrimitiveId;
use crate::color::{Rgb, luminance};
use glam::DVec3;

/// Triangles that glow, to pick points of by their power.
pub struct Glow {
    triangles: Vec<PrimitiveId>,
    /// Sums of area times luminance, textures aside, up to and with each of them.
    up_to: Vec<f64>,
}

impl Glow {
    /// `None` if nothing glows.
    pub(super) fn of(snapshot: &Snapshot) -> Option<Self> {
        if snapshot.materials.iter().all(|material| material.emission == Rgb::ZERO) {
            return None;
        }
        let (mut triangles, mut up_to, mut all) = (Vec::new(), Vec::new(), 0.0);
        for mesh in (0..snapshot.mesh_count()).map(|number| snapshot.mesh(number)) {
            for (primitive, _) in mesh.triangles() {
                let brightness = luminance(snapshot.emission(primitive));
                if brightness > 0.0 {
                    let [a, b, c] = snapshot.corners(primitive);
                    all += brightness * 0.5 * (b - a).cross(c - a).length();
                    triangles.push(primitive);
                    up_to.push(all);
                }
            }
        }
        (all > 0.0 && all.is_finite()).then_some(Self { triangles, up_to })
    }

    /// A point that three uniform numbers pick, and its triangle.
    pub fn pick(&self, snapshot: &Snapshot, [which, u, v]: [f64; 3]) -> (PrimitiveId, DVec3) {
        let last = self.up_to.len() - 1;
        let number = self.up_to.partition_point(|&up_to| up_to <= which * self.up_to[last]).min(last);
        let [a, b, c] = snapshot.corners(self.triangles[number]);
        // Evenly all over: Pharr, Jakob & Humphreys 2023, "Physically Based Rendering", 6.5.3.
        let root = u.sqrt();
        (self.triangles[number], a + root * ((1.0 - v) * (b - a) + v * (c - a)))
    }

    /// How densely [`Glow::pick`] picks points of a triangle, 1/m^2; 0 if it does not glow.
    pub fn picked_per_m2(&self, snapshot: &Snapshot, primitive: PrimitiveId) -> f64 {
        self.up_to.last().map_or(0.0, |all| luminance(snapshot.emission(primitive)) / all)
    }
}

impl Snapshot<'_> {
    /// What glows; `None` if nothing does. Listed when it is first asked for.
    pub fn glow(&self) -> Option<&Glow> {
        self.glow.get_or_init(|| Glow::of(self)).as_ref()
    }

    /// Radiance that a triangle's material emits, before its texture and its vertices' colours.
    fn emission(&self, primitive: PrimitiveId) -> Rgb {
        let instance = &self.scene.instances[self.placed[primitive.instance as usize].instance];
        let triangle = &self.scene.meshes[instance.mesh].triangles[primitive.triangle as usize];
        self.materials[instance.material.unwrap_or(triangle.material)].emission
    }
}
