//! Rays against the boxes of a tree. In go a ray and a visitor, out come the leaves that the ray may meet,
//! near ones first. Invariant: no box that the ray meets in exact arithmetic is left out.

use super::{
    simd::{Lanes, Mask, Simd, WIDTH, each_lane, three},
    wide_tree::{LEAF, Node, Stack, WideTree, plane},
};

/// A ray in single precision, prepared for boxes that are padded against rounding. The origin is moved
/// against the planes by which the ray enters and along with those by which it leaves (Woop, Benthin and Wald
/// 2013, section 5). Padding for the boxes' own rounding is part of the boxes.
pub(super) struct BoxRay<L> {
    origin_entering: [L; 3],
    origin_leaving: [L; 3],
    inverse_direction: [L; 3],
    entering: [usize; 3],
    t_min: L,
}

impl<L: Lanes> BoxRay<L> {
    #[inline(always)]
    pub(super) fn new<S: Simd<Lanes = L>>(
        simd: S,
        origin: [f32; 3],
        direction: [f32; 3],
        padding: f32,
        t_min: f32,
    ) -> Self {
        let shift = direction.map(|d| if d < 0.0 { -padding } else { padding });
        Self {
            origin_entering: three(
                #[inline(always)]
                |axis| simd.splat(origin[axis] + shift[axis]),
            ),
            origin_leaving: three(
                #[inline(always)]
                |axis| simd.splat(origin[axis] - shift[axis]),
            ),
            // Adding 0 turns -0 into 0, whose inverse then has the sign that `entering` assumes.
            inverse_direction: three(
                #[inline(always)]
                |axis| simd.splat(1.0 / (direction[axis] + 0.0)),
            ),
            entering: three(|axis| plane(axis, direction[axis] < 0.0)),
            t_min: simd.splat(t_min),
        }
    }

    /// Children whose boxes the ray meets before `t_far`, as bits, with the distances at which it enters.
    #[inline(always)]
    fn meet<S: Simd<Lanes = L>>(&self, simd: S, node: &Node, t_far: f32) -> (u32, L) {
        let mut near = self.t_min;
        let mut far = simd.splat(t_far);
        for axis in 0..3 {
            let entering = self.entering[axis];
            let enter = (simd.load(&node.planes[entering]) - self.origin_entering[axis])
                * self.inverse_direction[axis];
            let leave = (simd.load(&node.planes[entering ^ 1]) - self.origin_leaving[axis])
                * self.inverse_direction[axis];
            // A NaN, from a ray within a plane, must not cull, so it comes first.
            near = enter.max(near);
            far = leave.min(far);
        }
        (near.le(far).bits(), near)
    }

    /// Whether the ray may meet anything of a tree before `t_far`, tested by the uppermost boxes.
    #[inline(always)]
    pub(super) fn may_meet<S: Simd<Lanes = L>>(&self, simd: S, tree: &WideTree, t_far: f32) -> bool {
        match tree.root {
            Some(root) if root & LEAF == 0 => self.meet(simd, &tree.nodes[root as usize], t_far).0 != 0,
            root => root.is_some(),
        }
    }

    /// Visits the leaves whose boxes the ray meets before `t_far`, near ones first. Returns whether a visit
    /// ended the query.
    #[inline(always)]
    pub(super) fn visit_leaves<S: Simd<Lanes = L>>(
        &self,
        simd: S,
        tree: &WideTree,
        mut t_far: f32,
        stack: &mut Stack<Entry>,
        visitor: &mut impl LeafVisitor<S>,
    ) -> bool {
        let Some(root) = tree.root else { return false };
        let base = stack.len();
        let mut child = root;
        loop {
            if child & LEAF != 0 {
                if visitor.visit(simd, child & !LEAF, stack, &mut t_far) {
                    stack.truncate(base);
                    return true;
                }
            } else {
                let node = &tree.nodes[child as usize];
                let (hits, near) = self.meet(simd, node, t_far);
                if hits != 0 {
                    // Most children are visited after some others, and no cache holds all of a large scene.
                    if hits & (hits - 1) != 0 {
                        each_lane(hits, |lane| visitor.expect(simd, node.children[lane]));
                    }
                    child = nearest(simd, node, hits, near, stack);
                    continue;
                }
            }
            child = loop {
                if stack.len() == base {
                    return false;
                }
                match stack.pop() {
                    Some(entry) if entry.t_near <= t_far => break entry.child,
                    _ => {}
                }
            };
        }
    }
}

/// A child to visit, on a stack with the nearest on top.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Entry {
    child: u32,
    /// Distance at which the ray enters it.
    t_near: f32,
}

pub(super) trait LeafVisitor<S: Simd> {
    /// Called for a child that may be visited after some others.
    #[inline(always)]
    fn expect(&self, _simd: S, _child: u32) {}

    /// Visits a leaf and may shorten `t_far`; returns whether the query is over.
    fn visit(&mut self, simd: S, leaf: u32, stack: &mut Stack<Entry>, t_far: &mut f32) -> bool;
}

/// Returns the nearest of the children that are hit; pushes the others onto the stack, the farthest first.
#[inline(always)]
fn nearest<S: Simd>(simd: S, node: &Node, mut hits: u32, near: S::Lanes, stack: &mut Stack<Entry>) -> u32 {
    let first = hits.trailing_zeros() as usize;
    hits &= hits - 1;
    if hits == 0 {
        return node.children[first];
    }
    let near = simd.store(near);
    let mut sorted = [Entry::default(); WIDTH];
    sorted[0] = Entry { child: node.children[first], t_near: near[first] };
    let mut count = 1;
    while hits != 0 {
        let lane = hits.trailing_zeros() as usize;
        hits &= hits - 1;
        let entry = Entry { child: node.children[lane], t_near: near[lane] };
        let mut slot = count;
        while slot > 0 && sorted[slot - 1].t_near < entry.t_near {
            sorted[slot] = sorted[slot - 1];
            slot -= 1;
        }
        sorted[slot] = entry;
        count += 1;
    }
    for entry in &sorted[..count - 1] {
        stack.push(*entry);
    }
    sorted[count - 1].child
}
