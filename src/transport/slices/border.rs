//! Border: a straight edge that a slice cuts, of a triangle or of its shadow on another. In goes its cut by
//! the slice, out comes its cut by a slice beside. Invariant: exact within the length of the border.

use super::edges::EdgeOrigin;
use super::fan::Fan;
use super::light_rays::LightRays;
use super::slice::Slice;
use crate::accel::PrimitiveId;
use crate::snapshot::Snapshot;
use glam::{DMat3, DVec3};

/// Maximum difference between a border in double precision and its single-precision cut, as a fraction of its
/// coordinates.
const SAME_PLACE: f64 = 1e-4;

/// Extension of a border beyond its corner, as a fraction of its length: outlines mostly bend there and do
/// not end. Found by trial on leaves500; 0 and 1 do worse.
const BEYOND: f64 = 0.5;

/// Borders in a slice's coordinates: the reach, the height along the axis and the distance from the half
/// plane, metres.
pub(super) struct Borders<'a> {
    snapshot: &'a Snapshot<'a>,
    fan: &'a Fan,
    slice_from_relative: DMat3,
    light_rays: LightRays,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Border {
    /// Point in the half plane of the slice that cuts it.
    point: DVec3,
    along: DVec3,
    /// Range of the border, as multiples of `along` from `point`.
    reaches: (f64, f64),
    /// Point and normal of the plane that the shadow lies on; `None` for a border of the triangle itself.
    shaded: Option<(DVec3, DVec3)>,
    light_rays: LightRays,
}

impl<'a> Borders<'a> {
    pub(super) fn new(
        snapshot: &'a Snapshot<'a>,
        fan: &'a Fan,
        slice: &Slice,
        light_rays: LightRays,
    ) -> Self {
        let outward = slice.outward;
        // Half planes rotate from `outward` towards the third axis.
        let relative_from_slice = DMat3::from_cols(outward, fan.axis, fan.axis.cross(outward));
        Self { snapshot, fan, slice_from_relative: relative_from_slice.transpose(), light_rays }
    }

    fn corners(&self, primitive: PrimitiveId) -> [DVec3; 3] {
        self.snapshot.corners(primitive).map(|corner| self.slice_from_relative * (corner - self.fan.eye))
    }

    /// Border of an edge; `None` if no triangle has that edge, as where a segment is cut off at the axis.
    pub(super) fn of(&self, origin: &EdgeOrigin) -> Option<Border> {
        let cut = origin.border;
        let corners = self.corners(cut.primitive);
        let crossed = [[0, 1], [1, 2], [2, 0]].into_iter().filter_map(|side| {
            let [from, to] = side.map(|corner| corners[corner]);
            let along = to - from;
            let part = -from.z / along.z;
            let point = from + part * along;
            let off = point.truncate().distance(cut.point);
            ((from.z < 0.0) != (to.z < 0.0)).then_some((off, point, along, part))
        });
        let (off, point, along, part) = crossed.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let shaded = origin.shaded.map(|primitive| {
            let [a, b, c] = self.corners(primitive);
            (a, (b - a).cross(c - a))
        });
        let reaches = (-part - BEYOND, 1.0 - part + BEYOND);
        let light_rays = self.light_rays;
        (off <= SAME_PLACE * cut.point.length()).then_some(Border {
            point,
            along,
            reaches,
            shaded,
            light_rays,
        })
    }
}

impl Border {
    /// Distance from the eye at which a ray meets it, metres. It is infinite for a shadow's border, which the
    /// surface below may hide.
    pub(super) fn distance(&self) -> f64 {
        if self.shaded.is_some() { f64::INFINITY } else { self.point.length() }
    }

    /// Slopes of the rays that meet it in two half planes, rotated by an angle of this sine and cosine to
    /// either side; not finite where none does.
    pub(super) fn slopes_beside(&self, (sin, cos): (f64, f64)) -> [f64; 2] {
        let (low, high) = self.reaches;
        [sin, -sin].map(|sin| {
            let part = sin * self.point.x / (cos * self.along.z - sin * self.along.x);
            // The nearer end, where the half plane misses the border.
            let mut point = self.point + part.max(low).min(high) * self.along;
            if let Some((on, normal)) = self.shaded {
                let way = match self.light_rays {
                    LightRays::Parallel => DVec3::Y,
                    LightRays::From(height) => point - height * DVec3::Y,
                };
                point += normal.dot(on - point) / normal.dot(way) * way;
            }
            point.y / (point.x * point.x + point.z * point.z).sqrt()
        })
    }
}

#[cfg(test)]
#[allow(clippy::expect_used)]
mod tests {
    use super::*;
    use crate::accel::{Cut, HalfPlane};
    use crate::light::LightPlace;
    use crate::scene::{
        Camera, Clip, Instance, Lens, Material, Mesh, Motion, Node, Scene, Size, Track, Triangle,
    };
    use crate::snapshot::{MeshTrees, Shutter};
    use crate::transport::slices::edges::EdgeOrigin;
    use crate::transport::slices::segment::CutEnd;
    use crate::transport::slices::{Ring, Slice};
    use glam::{DAffine3, DVec2};
    use proptest::prelude::*;

    impl Border {
        /// Border of infinite length.
        pub(in crate::inside::transport::slices) fn through(point: DVec3, along: DVec3) -> Self {
            let reaches = (f64::NEG_INFINITY, f64::INFINITY);
            Self { point, along, reaches, shaded: None, light_rays: LightRays::Parallel }
        }
    }

    /// A triangle in front of a camera that looks along -Z.
    fn scene(corners: [[f64; 3]; 3]) -> Scene {
        let motion = Motion::Still(DAffine3::IDENTITY);
        let node = Node { name: String::new(), parent: None, motion, visible: Track::from(true) };
        let lens = Lens::Perspective { fov_y: Track::from(1.0) };
        let camera = Camera {
            name: String::new(),
            node: 0,
            lens,
            shift: DVec2::ZERO,
            aperture: None,
            clip: Clip::NONE,
        };
        let mesh = Mesh {
            positions: corners.map(|corner| (DVec3::from(corner) + 4.0 * DVec3::NEG_Z).as_vec3()).to_vec(),
            triangles: vec![Triangle { vertices: [0, 1, 2], material: 0 }],
            ..Mesh::default()
        };
        Scene {
            nodes: vec![node],
            cameras: vec![camera],
            materials: vec![Material::default()],
            meshes: vec![mesh],
            instances: vec![Instance { node: 0, mesh: 0, material: None, leaf_id: 0, deformation: None }],
            ..Scene::default()
        }
    }

    proptest! {
        /// Compared with the accelerator's cut of the triangle in the slice beside.
        #[test]
        fn a_border_leads_to_the_next_cut(
            corners in prop::array::uniform3(prop::array::uniform3(-2.0..2.0_f64)),
            to_light in prop::array::uniform3(-1.0..1.0_f64).prop_filter_map("a direction", |v| DVec3::from(v).try_normalize()),
            part in 0.0..1.0_f64,
            rotated_rad in -0.01..0.01_f64,
        ) {
            let scene = scene(corners);
            let trees = MeshTrees::new(&scene);
            let snapshot = Snapshot::new(&scene, &trees, 0, 1.0, Shutter { open_s: 0.0, close_s: 0.0 });
            let size = Size { width: 100, height: 100 };
            let fan = Fan::new(&snapshot.view, size, DVec2::ZERO, LightPlace::Towards(to_light)).expect("not at the eye");
            let slice_at = |angle: f64| fan.slice(angle, Ring::WHOLE);
            let cuts = |slice: &Slice| {
                let lowest_slope = f64::NEG_INFINITY;
                let half_plane = HalfPlane { eye: fan.eye, axis: fan.axis, outward: slice.outward, lowest_slope };
                let mut cuts: Vec<Cut> = Vec::new();
                snapshot.tree.add_cuts(&half_plane, &mut cuts);
                cuts
            };
            let angle = fan.angles.0 + part * fan.angles.1;
            let (Some(slice), Some(beside)) = (slice_at(angle), slice_at(angle + rotated_rad)) else { return Ok(()) };
            let borders = Borders::new(&snapshot, &fan, &slice, LightRays::Parallel);
            let (from, to) = (cuts(&slice), cuts(&beside));
            let (Some(from), Some(to)) = (from.first(), to.first()) else { return Ok(()) };
            prop_assume!(from.ends.iter().chain(&to.ends).all(|end| end.x > 0.1));
            let cut_slopes = to.ends.map(|end| end.y / end.x);
            let (sin, cos) = rotated_rad.sin_cos();
            for point in from.ends {
                let cut = CutEnd { primitive: from.primitive, point };
                let border = borders.of(&EdgeOrigin { border: cut, shaded: None }).expect("a border of the triangle");
                let [own, _] = border.slopes_beside((0.0, 1.0));
                prop_assert!((own - point.y / point.x).abs() <= 1e-4 * (1.0 + own.abs()), "{own} {point}");
                let [slope, _] = border.slopes_beside((sin, cos));
                prop_assert_eq!(border.slopes_beside((-sin, cos))[1].to_bits(), slope.to_bits());
                let off = cut_slopes.iter().map(|cut| (cut - slope).abs()).fold(f64::INFINITY, f64::min);
                let part = sin * border.point.x / (cos * border.along.z - sin * border.along.x);
                let is_cut_too = border.reaches.0 + BEYOND < part && part < border.reaches.1 - BEYOND;
                prop_assert!(!is_cut_too || off <= 1e-4 * (1.0 + slope.abs()), "{slope} {cut_slopes:?} from {own}");
            }
        }
    }
}
