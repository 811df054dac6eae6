//! Choice of the animations of a file that are played. In go all of its channels and what whoever renders
//! asked for; those of other animations are taken out. Invariant: unless all are asked for, no two that
//! are played move the same thing.
//!
//! Blender exports an action an object, which belong together; a game's model has a walk and a run, which
//! do not. They are told apart by whether they move the same things.

use super::clock::Clock;
use crate::description::gltf::report::Report;
use crate::description::gltf::{GltfScene, Property};
use crate::diagnostic::{Diagnostic, Loss};
use crate::scene::Animation;
use std::collections::BTreeSet;

/// Target of a channel, which two animations cannot both move: a property of something, with its number.
type Target = (Property, usize);

/// Chooses animations and lists all. Channels of those that do not play are taken out of the file.
/// `wanted` is a name, a number or `all`; without it each plays that moves nothing that an earlier one
/// moves.
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

/// Puts the keys of animations to their true times.
pub(super) fn set_right(animations: &mut [Animation], clock: &Clock) {
    for keys_s in animations.iter_mut().filter_map(|animation| animation.keys_s.as_mut()) {
        *keys_s = (clock.seconds(keys_s.0 as f32), clock.seconds(keys_s.1 as f32));
    }
}

/// Animations, in the file's order, that do not move what an earlier one moves.
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

/// The first and the last key of an animation, in the file's seconds.
fn keys_s(source: &GltfScene, animation: usize) -> Option<(f64, f64)> {
    let played = source.channels.iter().filter(|channel| channel.animation == animation);
    let times_s = played.map(|channel| &channel.times_s);
    let ends =
        times_s.filter_map(|times_s| Some((f64::from(*times_s.first()?), f64::from(*times_s.last()?))));
    ends.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}
