//! Light of bright walls. In go their radiance and the irradiance that they give all walls, out come their
//! sweep and the second scattering. Invariant: faces of walls get none of it from that sweep, as ordinates
//! would spread it in beams (ray effects, Lewis & Miller 1984, section 4-6).

use super::angle_set::SweepSource;
use super::boundary::BoundaryCondition;
use super::first_collision_source::BrightWalls;
use super::moments::{Moments, NodeMoments};
use super::quadrature::Quadrature;
use super::source_iteration::{Problem, Solution, Source};
use super::sweep::{Sweeper, Swept};
use super::walls::Walls;
use super::wanted::Wanted;
use crate::color::Rgb;

impl Problem<'_> {
    /// Sweeps the light of bright walls. Returns it with the light that medium and walls scatter of it.
    pub(super) fn sweep_bright(
        &self,
        sweeper: &mut Sweeper,
        bright: &BrightWalls,
        nothing: &Source,
    ) -> (Swept, Source) {
        let of_channel =
            |channel: usize| bright.radiances.iter().map(|color| color[channel] as f32).collect();
        let walls = [0, 1, 2].map(of_channel);
        let sources = SweepSource {
            volume: &nothing.volume,
            beams: &[],
            walls: &walls,
            glossy: None,
            bodies: None,
            incident: BoundaryCondition::Vacuum,
        };
        let wanted = Wanted { moments: true, ..self.last(true) };
        // Few ordinates would be seen in fog, on leaves and in corners.
        let fine = Quadrature::fine();
        let mut swept = sweeper.sweep(&fine, &sources, &wanted, self.cancelled);
        let whole = swept.radiances.filter(|_| !(self.cancelled)());
        swept.radiances = whole.map(|radiances| radiances.along(&fine, self.quadrature));
        let volume = self.scatter(&swept.moments, true).volume;
        let walls = self.domain.walls.scattered(&bright.irradiances);
        (swept, Source { volume, walls, has_first: false })
    }
}

impl Solution {
    /// Adds bright walls' light as swept to that of the first order.
    pub(super) fn add_bright(&mut self, (mut swept, bright): (Swept, BrightWalls)) {
        self.all.add(&swept.moments, [1.0; 3]);
        let of_first_order = self.radiances.first_mut().zip(swept.radiances.take());
        of_first_order.into_iter().for_each(|(sum, radiances)| sum.add(&radiances));
        self.last.add_last(&swept);
        self.on_walls = Some((swept.moments, bright.irradiances));
    }
}

impl Walls {
    /// Irradiance on each face: that of moments of light, with the part `swept` replaced by the known
    /// irradiance of patches.
    pub(crate) fn on_faces(&self, light: &NodeMoments, known: Option<&(Moments, Vec<Rgb>)>) -> Vec<[f32; 3]> {
        let mut on_faces = self.faces.irradiances(light);
        let Some((swept, irradiances)) = known else { return on_faces };
        let swept = self.faces.irradiances(&NodeMoments::of(swept));
        let mut sums = vec![(Rgb::ZERO, 0.0); on_faces.len()];
        for (patch, &irradiance) in self.patches.iter().zip(irradiances) {
            for &(node, weight) in &patch.seen_by {
                if let Some(face) = self.faces.number(node as usize, patch.normal) {
                    sums[face].0 += f64::from(weight) * irradiance;
                    sums[face].1 += f64::from(weight);
                }
            }
        }
        for ((face, swept), (sum, weight)) in on_faces.iter_mut().zip(&swept).zip(sums) {
            if weight > 0.0 {
                let known = (sum / weight).to_array();
                for channel in 0..3 {
                    face[channel] = (face[channel] - swept[channel]).max(0.0) + known[channel] as f32;
                }
            }
        }
        on_faces
    }
}
