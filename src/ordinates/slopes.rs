//! Slopes of sources within dense cells. In go the source and the extinction of all nodes, out come its
//! derivatives along the axes of the world, away from leaves. Invariant: a slope moves a cell's source and
//! adds none, so every order conserves energy, and uniform light stays uniform.
//!
//! With uniform sources light diffuses too fast, by a quarter of the square of a cell's optical depth. So in
//! dense cells they are linear (linear characteristics; Larsen & Miller 1980, "Convergence rates of spatial
//! difference equations for the discrete-ordinates neutron transport equations in slab geometry").

use super::planes::Planes;

/// Optical depth of a cell from which its source has a slope, and that from which it has all of it.
const DENSE: [f32; 2] = [0.25, 0.5];
/// Minimum extinction of the nodes on both sides, relative to the node between them: fog ends elsewhere.
const ALIKE: f32 = 0.25;

/// Share of its slope that the source of a cell has, by the cell's optical depth.
pub(crate) fn share(depth: f32) -> f32 {
    ((depth - DENSE[0]) / (DENSE[1] - DENSE[0])).clamp(0.0, 1.0)
}

/// Whether any cell is so dense.
pub(super) fn are_dense(extinction: &[f32], cell_m: f32) -> bool {
    extinction.iter().any(|extinction| share(cell_m * extinction) > 0.0)
}

/// Fog by node.
pub(super) struct Fog<'a> {
    /// Isotropic source, with that of leaves.
    pub(super) source: &'a [f32],
    /// Extinction, 1/m.
    pub(super) extinction: &'a [f32],
    /// Nodes with leaves.
    pub(super) with_leaves: &'a [usize],
}

/// Slopes by axis of the world and by node, per metre; none at nodes that walls `cut`.
pub(super) fn slopes(
    planes: &Planes,
    Fog { source, extinction, with_leaves }: Fog,
    cell_m: f32,
    cut: impl Iterator<Item = usize>,
) -> [Vec<f32>; 3] {
    let mut slopes = [(); 3].map(|()| vec![0.0; source.len()]);
    // Leaves scatter and emit too, beside the extinction of fog.
    let mut is_of_fog = vec![true; source.len()];
    with_leaves.iter().for_each(|&node| is_of_fog[node] = false);
    let [count, stride] = [planes.count, planes.stride];
    let rows = (1..count[0].saturating_sub(1))
        .flat_map(|plane| (1..count[1].saturating_sub(1)).map(move |row| (plane, row)));
    for (plane, row) in rows {
        let first = plane * stride[0] + row * stride[1];
        for node in first + 1..first + count[2] - 1 {
            let here = extinction[node];
            let share = share(cell_m * here);
            if share == 0.0 || !is_of_fog[node] {
                continue;
            }
            // The source function: what is sent by what is lost.
            let function = |node: usize| source[node] / extinction[node];
            let across = stride.map(|stride| {
                let [before, after] = [node - stride, node + stride];
                let are_alike = extinction[before].min(extinction[after]) >= ALIKE * here;
                if are_alike && is_of_fog[before] && is_of_fog[after] {
                    0.5 * (function(after) - function(before))
                } else {
                    0.0
                }
            });
            // Not limited: the operator stays linear, so that orders add up.
            let factor = share * here / cell_m;
            for (axis, across) in planes.axes.into_iter().zip(across) {
                slopes[axis][node] = factor * across;
            }
        }
    }
    // Nodes beside them may lie behind walls.
    cut.for_each(|node| slopes.iter_mut().for_each(|slopes| slopes[node] = 0.0));
    slopes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ordinates::planes::Layout;

    fn fog<'a>(source: &'a [f32], extinction: &'a [f32], with_leaves: &'a [usize]) -> Fog<'a> {
        Fog { source, extinction, with_leaves }
    }

    #[test]
    fn slopes_are_those_of_linear_sources_in_dense_cells() {
        let size = [4, 5, 6];
        let planes = Planes::new(Layout { size, is_turned: false }, 2);
        let place = |node: usize| [node % 4, node / 4 % 5, node / 20].map(|index| index as f32);
        let of =
            |value: &dyn Fn([f32; 3]) -> f32| (0..120).map(|node| value(place(node))).collect::<Vec<f32>>();
        let (linear, even) = (of(&|[x, y, z]| 9.0 + x - 0.5 * y + 0.25 * z), of(&|_| 2.0));
        let inside = 2 + 4 * 2 + 20 * 3;
        for (extinction, expected) in [(2.0, [2.0, -1.0, 0.5]), (0.2, [0.0; 3])] {
            let extinctions = vec![extinction; 120];
            let source: Vec<f32> = linear.iter().map(|function| extinction * function).collect();
            let found = slopes(&planes, fog(&source, &extinctions, &[]), 1.0, std::iter::empty());
            let found = [0, 1, 2].map(|axis: usize| found[axis][inside]);
            assert!((0..3).all(|axis| (found[axis] - expected[axis]).abs() < 1e-5), "{found:?}");
        }
        let extinctions = of(&|[x, ..]| 2.0 + 0.1 * x);
        let source: Vec<f32> =
            even.iter().zip(&extinctions).map(|(function, loss)| function * loss).collect();
        let found = slopes(&planes, fog(&source, &extinctions, &[]), 1.0, std::iter::empty());
        assert!(found.iter().flatten().all(|slope| slope.abs() < 1e-5), "even light has none");
        // In even light a node with leaves sends more, which is no slope of its neighbours.
        let leaves = inside + 1;
        let source: Vec<f32> =
            (0..120).map(|node| source[node] * if node == leaves { 6.0 } else { 1.0 }).collect();
        let found = slopes(&planes, fog(&source, &extinctions, &[leaves]), 1.0, std::iter::empty());
        assert!(found.iter().flatten().all(|slope| slope.abs() < 1e-5), "leaves are not fog");
    }
}
