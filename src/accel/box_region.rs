//! Boxes of a tree against regions bounded by affine functions. In go functions of position, out come the
//! leaves that may overlap the region. Invariant: a box is skipped only if nothing in it can belong to the
//! region, even after rounding.

use super::{
    block::Block,
    light_plane::Functional,
    simd::{Lanes, Mask, Simd, each_lane, three},
    triangle_cut::Corners,
    wide_tree::{self, Bounds, LEAF, Node, Stack, WideTree, plane},
};

/// An affine function in single precision.
#[derive(Clone, Copy)]
pub(super) struct LaneFunctional<L> {
    gradient: [L; 3],
    offset: L,
}

impl<L: Lanes> LaneFunctional<L> {
    #[inline(always)]
    pub(super) fn new<S: Simd<Lanes = L>>(simd: S, functional: &Functional) -> Self {
        Self {
            gradient: three(
                #[inline(always)]
                |axis| simd.splat(functional.gradient[axis] as f32),
            ),
            offset: simd.splat(functional.offset as f32),
        }
    }

    #[inline(always)]
    pub(super) fn at(&self, [x, y, z]: [L; 3]) -> L {
        self.gradient[0] * x + self.gradient[1] * y + self.gradient[2] * z + self.offset
    }

    /// Values at the vertices of each triangle.
    #[inline(always)]
    pub(super) fn at_corners<S: Simd<Lanes = L>>(&self, simd: S, block: &Block) -> Corners<L> {
        three(
            #[inline(always)]
            |vertex| {
                let [x, y, z] = &block.vertices[vertex];
                self.at([simd.load(x), simd.load(y), simd.load(z)])
            },
        )
    }
}

/// Error bound of an affine function evaluated in a box in single precision.
#[inline(always)]
fn padding(functional: &Functional, bounds: Bounds) -> f64 {
    wide_tree::padding(functional.gradient.abs().dot(bounds.magnitude().as_dvec3()) + functional.offset.abs())
}

/// Whether an affine function may be 0 in a box.
#[inline(always)]
pub(super) fn may_vanish(functional: &Functional, bounds: Bounds) -> bool {
    let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    let spread = functional.gradient.abs().dot(0.5 * (max - min));
    functional.at(0.5 * (min + max)).abs() <= spread + padding(functional, bounds)
}

/// Upper bound of an affine function over a box.
pub(super) struct BoxLimit<L> {
    functional: LaneFunctional<L>,
    corner: [usize; 3],
}

impl<L: Lanes> BoxLimit<L> {
    /// Bound for the region, with the rounding error of its offset. Boxes of nodes are padded by the error of
    /// positions.
    #[inline(always)]
    pub(super) fn new<S: Simd<Lanes = L>>(simd: S, functional: &Functional) -> Self {
        let offset = functional.offset + wide_tree::padding(functional.offset.abs());
        let padded = Functional { offset, ..*functional };
        let corner = three(|axis| plane(axis, functional.gradient[axis] >= 0.0));
        Self { functional: LaneFunctional::new(simd, &padded), corner }
    }

    #[inline(always)]
    fn at<S: Simd<Lanes = L>>(&self, simd: S, node: &Node) -> L {
        self.functional.at(three(
            #[inline(always)]
            |axis| simd.load(&node.planes[self.corner[axis]]),
        ))
    }
}

/// Test of boxes against a region: they may overlap it where no bound is negative. The first two are a plane
/// from both of its sides.
pub(super) struct BoxRegion<L, const N: usize>(pub(super) [BoxLimit<L>; N]);

impl<L: Lanes, const N: usize> BoxRegion<L, N> {
    /// Children that may overlap the region, as bits.
    #[inline(always)]
    fn meets<S: Simd<Lanes = L>>(&self, simd: S, node: &Node) -> u32 {
        let zero = simd.splat(0.0);
        let mut met = zero.le(self.0[0].at(simd, node)) & zero.le(self.0[1].at(simd, node));
        if met.bits() == 0 {
            return 0;
        }
        for limit in &self.0[2..] {
            met = met & zero.le(limit.at(simd, node));
        }
        met.bits()
    }

    /// Visits the leaves whose boxes may overlap the region.
    #[inline(always)]
    pub(super) fn visit_leaves<S: Simd<Lanes = L>>(
        &self,
        simd: S,
        tree: &WideTree,
        stack: &mut Stack<u32>,
        visit: impl FnMut(u32, &mut Stack<u32>),
    ) {
        self.visit_expected_leaves(simd, tree, stack, |_| {}, visit);
    }

    /// The same, with a call of `expect` for a leaf that is visited after some others.
    #[inline(always)]
    pub(super) fn visit_expected_leaves<S: Simd<Lanes = L>>(
        &self,
        simd: S,
        tree: &WideTree,
        stack: &mut Stack<u32>,
        expect: impl Fn(u32),
        mut visit: impl FnMut(u32, &mut Stack<u32>),
    ) {
        let Some(root) = tree.root else { return };
        let base = stack.len();
        stack.push(root);
        while stack.len() > base
            && let Some(child) = stack.pop()
        {
            if child & LEAF != 0 {
                visit(child & !LEAF, stack);
                continue;
            }
            let node = &tree.nodes[child as usize];
            each_lane(self.meets(simd, node), |lane| {
                let child = node.children[lane];
                // Without it, gathering waited for memory two fifths of its time in large scenes.
                if child & LEAF != 0 {
                    expect(child & !LEAF);
                } else if let Some(node) = tree.nodes.get(child as usize) {
                    simd.prefetch(node);
                }
                stack.push(child);
            });
        }
    }
}
