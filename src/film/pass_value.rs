//! Values of a sample in each pass. In go a sample and a pass, out come the numbers of the pass's channels
//! (see `passes.rs`). Invariant: without a surface they are the pass's background.

use crate::passes::Pass;
use crate::transport::Sample;
use glam::DVec3;

/// Value of a sample in a pass; passes with fewer channels use the first ones.
pub(super) fn value(pass: Pass, sample: &Sample) -> [f64; 4] {
    let three = |value: DVec3| value.extend(0.0).to_array();
    match (pass, &sample.surface) {
        (Pass::Shafts, _) => three(sample.shafts),
        (Pass::Indirect, _) => three(sample.indirect),
        (Pass::IndirectShafts, _) => three(sample.indirect_shafts),
        (Pass::Transmittance, _) => three(sample.transmittance),
        (Pass::Albedo, Some(surface)) => three(surface.albedo),
        (Pass::Normal, Some(surface)) => three(surface.normal),
        (Pass::Position, Some(surface)) => three(surface.position),
        (Pass::Depth, Some(surface)) => [surface.depth_m; 4],
        (Pass::LeafId, Some(surface)) => [f64::from(surface.leaf_id); 4],
        (Pass::Motion, _) => sample.motion_px,
        // Not a value of single samples, see [`PixelRule`].
        (Pass::Error | Pass::Cryptomatte, _) => [0.0; 4],
        (_, None) => [f64::from(pass.row().background); 4],
    }
}
