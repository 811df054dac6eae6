//! Choice of a file's animations to play. In go all channels and the requested animation, out come the
//! channels that play. Invariant: unless all are requested, no two that play have a common target.
//!
//! Blender exports one action an object, which belong together; a game's model has a walk and a run, which do
//! not. Common targets tell the two cases apart.

use super::clock::Clock;
use crate::description::gltf::report::Report;
use crate::description::gltf::{GltfScene, Property};
use crate::diagnostic::{Diagnostic, Loss};
use crate::scene::Animation;
use std::collections::BTreeSet;

/// Target of a channel, which two animations cannot both move: a property of an object, with the object's
/// index.
type Target = (Property, usize);

/// Chooses animations, removes the channels of others, and lists all. `wanted` is a name, a number or `all`;
/// without it, each animation plays that has no target of an earlier one.
pub(super) fn choose(source: &mut GltfScene, wanted: Option<&str>, report: &mut Report) -> Vec<Animation> {
    let targets = targets(source);
    let is_played: Vec<bool> = match wanted {
        None => side_by_side(source, &targets, report),
        Some("all") => vec![true; source.animations.len()],
        Some(wanted) => {
            let chosen = source.animations_called(wanted);
            if chosen.is_empty() {
                let found = format!("there is no animation `{wanted}`");
                report.error("animations", found, &source.animation_names());
            }
            (0..source.animations.len()).map(|index| chosen.contains(&index)).collect()
        }
    };
    let animation = |(index, name): (usize, &String)| Animation {
        name: name.clone(),
        keys_s: keys_s(source, index),
        moves: moves(source, &targets[index]),
        is_played: is_played[index],
    };
    let animations = source.animations.iter().enumerate().map(animation).collect();
    source.channels.retain(|channel| is_played[channel.animation]);
    animations
}

/// Corrects the key times of animations.
pub(super) fn set_right(animations: &mut [Animation], clock: &Clock) {
    for keys_s in animations.iter_mut().filter_map(|animation| animation.keys_s.as_mut()) {
        *keys_s = (clock.seconds(keys_s.0 as f32), clock.seconds(keys_s.1 as f32));
    }
}

/// Animations, in the file's order, without a target of an earlier one.
fn side_by_side(source: &GltfScene, targets: &[BTreeSet<Target>], report: &mut Report) -> Vec<bool> {
    let mut moved = BTreeSet::new();
    let mut is_free = |(targets, name): (&BTreeSet<Target>, &String)| {
        let is_free = moved.is_disjoint(targets);
        if is_free {
            moved.extend(targets.iter().copied());
        } else {
            let left_out = Diagnostic::error(report.file(), format!("`{name}`"))
                .remedy("--animation NAME plays another one, --animation all all of them at once");
            report.leave_out(Loss::AnimationsLeftOut, left_out);
        }
        is_free
    };
    targets.iter().zip(&source.animations).map(&mut is_free).collect()
}

fn targets(source: &GltfScene) -> Vec<BTreeSet<Target>> {
    let mut targets = vec![BTreeSet::new(); source.animations.len()];
    for channel in &source.channels {
        targets[channel.animation].insert((channel.property, channel.index));
    }
    targets
}

fn moves(source: &GltfScene, targets: &BTreeSet<Target>) -> Vec<String> {
    let node = |index: usize| source.nodes[index].name.clone();
    let name = |&(property, index): &Target| match property {
        Property::NodeVisible => node(index),
        property if property.is_of_transform() => node(index),
        Property::CameraFovY | Property::CameraHalfHeight => source.cameras[index].name.clone(),
        Property::LightColor
        | Property::LightIntensity
        | Property::SpotInnerAngle
        | Property::SpotOuterAngle => source.lights[index].name.clone(),
        _ => source.materials[index].name.clone(),
    };
    let names: BTreeSet<String> = targets.iter().map(name).collect();
    names.into_iter().collect()
}

/// First and last key of an animation, in the file's seconds.
fn keys_s(source: &GltfScene, animation: usize) -> Option<(f64, f64)> {
    let played = source.channels.iter().filter(|channel| channel.animation == animation);
    let times_s = played.map(|channel| &channel.times_s);
    let ends =
        times_s.filter_map(|times_s| Some((f64::from(*times_s.first()?), f64::from(*times_s.last()?))));
    ends.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}
