//! Objects scaled to a line or a point. In goes a scene, out comes a warning that names those that never
//! show. Invariant: an object whose scale changes over time is not among them.

use super::{Motion, Node, Scene};
use crate::diagnostic::{Diagnostic, Place};
use glam::{DAffine3, DMat3, Vec3};

/// Relative area that counts as 0, the rounding of a zero.
const NOTHING: f64 = 1e-12;

/// Warning about objects scaled to lines or points, with their number and the first one's name.
pub(super) fn remark(scene: &Scene, time_s: f64, place: Place) -> Option<Diagnostic> {
    let placements = scene.placements(time_s);
    let is_flat = |node: usize, mesh: usize| {
        let placement = &placements[node];
        placement.visible
            && is_line(placement.world_from_node, &scene.meshes[mesh].positions)
            && !grows(scene, node)
    };
    let mut flat = scene
        .instances
        .iter()
        .filter(|instance| instance.deformation.is_none() && is_flat(instance.node, instance.mesh));
    let name = &scene.nodes[flat.next()?.node].name;
    let more = match flat.count() {
        0 => String::new(),
        more => format!(" (and {more} more)"),
    };
    let found = format!("`{name}`{more} is scaled by 0 to a line or a point: nothing of it is seen");
    Some(Diagnostic::choice(place, found).remedy("give it a scale other than 0, or take it out"))
}

/// Whether the scale of a node or of an ancestor changes.
fn grows(scene: &Scene, node: usize) -> bool {
    let changes = |node: &Node| matches!(&node.motion, Motion::Keyed { scale, .. } if !scale.is_constant());
    scene.with_ancestors(node).any(changes)
}

/// Whether the bounding box of vertices has no area in the world, but some in its own space.
fn is_line(world_from_mesh: DAffine3, positions: &[Vec3]) -> bool {
    let linear = world_from_mesh.matrix3;
    let axes = [linear.x_axis, linear.y_axis, linear.z_axis].map(|axis| axis.length());
    let longest = axes.into_iter().fold(0.0, f64::max);
    // Rarely true, so that few boxes are computed.
    if linear.determinant().abs() > NOTHING * longest.powi(3) {
        return false;
    }
    let bounds = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (low, high) = positions.iter().fold(bounds, |(low, high), at| (low.min(*at), high.max(*at)));
    let sides = DMat3::from_diagonal((high - low).as_dvec3());
    let own = largest_area(sides);
    own > 0.0 && largest_area(linear * sides) <= NOTHING * own * longest.powi(2)
}

/// Largest face of a box, from its edges.
fn largest_area(edges: DMat3) -> f64 {
    let [x, y, z] = [edges.x_axis, edges.y_axis, edges.z_axis];
    [x.cross(y), y.cross(z), z.cross(x)].map(|normal| normal.length()).into_iter().fold(0.0, f64::max)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use glam::DVec3;

    const TRIANGLE: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];

    fn is_line_by(x: f64, y: f64, z: f64) -> bool {
        let turn = glam::DQuat::from_rotation_x(1.0) * glam::DQuat::from_rotation_z(2.0);
        let scale = DAffine3::from_scale(DVec3::new(x, y, z));
        is_line(DAffine3::from_quat(turn) * scale, &TRIANGLE)
    }

    #[test]
    fn only_what_has_no_area_left_is_a_line() {
        assert!(is_line_by(0.0, 0.0, 0.0) && is_line_by(1.0, 0.0, 1.0) && is_line_by(0.0, 0.0, 1.0));
        let turn = DAffine3::from_quat(glam::DQuat::from_rotation_y(0.7) * glam::DQuat::from_rotation_x(0.3));
        let flat = DAffine3::from_scale(DVec3::new(3.0, 0.0, 0.0));
        assert!(is_line(turn * flat * turn, &TRIANGLE));
        assert!(!is_line_by(1.0, 1.0, 0.0) && !is_line_by(1e-9, 1e-9, 1e-9) && !is_line_by(-1.0, 2.0, 0.0));
    }
}
