//! `inspect --json`: every node, camera and light at chosen frames. In goes an input, out comes JSON.
//! Invariant: matrices are row by row, for column vectors, in glTF's space; numbers are in SI units.

use super::Inspected;
use glam::{DAffine3, DMat4};
use serde_json::{Map, Value, json};
use sunfleck::diagnostic::Diagnostics;
use sunfleck::scene::{
    Animation, AreaShape, Camera, Lens, Light, LightKind, Placement, RenderSettings, Sampling,
};

pub(super) fn describe(inspected: &Inspected, frames: &[f64]) -> String {
    let Inspected { input, scene, settings, plan } = inspected;
    let rate = settings.frame_rate;
    let (samples, tolerance) = match settings.sampling {
        Sampling::Exactly(samples) => (samples, None),
        Sampling::Until { tolerance, most } => (most, Some(tolerance)),
    };
    let described = json!({
        "input": input,
        "scene_hash": plan.scene.content_hash(),
        "name": settings.name,
        "frame_rate": [rate.numerator, rate.denominator],
        "frame_start": settings.frames.start(),
        "frame_end": settings.frames.end(),
        "size": [settings.size.width, settings.size.height],
        "samples": samples,
        "tolerance": tolerance,
        "filter": settings.filter.name(),
        "animations": scene.animations.iter().map(|animation| describe_animation(animation, settings)).collect::<Vec<_>>(),
        "instances": scene.instances.len(),
        "triangles": scene.instances.iter().map(|i| scene.meshes[i.mesh].triangles.len()).sum::<usize>(),
        "losses": losses(&plan.remarks),
        "remarks": plan.remarks.0.iter().map(ToString::to_string).collect::<Vec<_>>(),
        "frames": frames.iter().map(|&frame| describe_frame(inspected, frame)).collect::<Vec<_>>(),
    });
    format!("{described:#}")
}

fn describe_animation(animation: &Animation, settings: &RenderSettings) -> Value {
    let frames = animation.frames(settings.frame_rate);
    json!({
        "name": animation.name,
        "played": animation.is_played,
        "frame_start": frames.map(|(first, _)| first),
        "frame_end": frames.map(|(_, last)| last),
        "moves": animation.moves,
    })
}

/// Losses of the input: one object a kind and place.
pub(in crate::cli) fn losses(remarks: &Diagnostics) -> Value {
    let losses = remarks.losses().map(|(loss, diagnostic)| {
        json!({
            "id": loss.id(),
            "count": diagnostic.count,
            "place": diagnostic.place.to_string().trim_end_matches(": "),
            "found": diagnostic.found,
            "remedy": diagnostic.remedy,
        })
    });
    losses.collect()
}

fn describe_frame(inspected: &Inspected, frame: f64) -> Value {
    let Inspected { scene, settings, plan, .. } = inspected;
    let seconds = settings.frame_rate.seconds(frame);
    let placements = scene.placements(seconds);
    let world = |node: usize| row_major(placements[node].world_from_node);
    let nodes = scene.nodes.iter().zip(&placements).map(|(node, placement)| {
        let Placement { world_from_node, visible } = *placement;
        (node.name.as_str(), json!({ "world": row_major(world_from_node), "visible": visible }))
    });
    let lights = scene
        .lights
        .iter()
        .map(|light| (light.name.as_str(), describe_light(light, world(light.node), seconds)));
    let sky_suns = scene.sky.iter().flat_map(|sky| sky.suns_at(seconds)).map(|sun| {
        json!({
            "to_sun": sun.to_sun.to_array(),
            "irradiance_w_per_m2": sun.irradiance.to_array(),
            "angular_diameter_rad": sun.angular_diameter,
        })
    });
    let camera = scene.cameras.get(plan.camera);
    let aspect = settings.size.width as f64 / settings.size.height as f64;
    let describe = |camera: &Camera| {
        let mut described = json!({
            "name": camera.name,
            "world": world(camera.node),
            "projection": camera.projection(aspect, seconds).transpose().to_cols_array(),
            "clip_start_m": camera.clip.start_m,
        });
        if camera.clip.end_m.is_finite() {
            described["clip_end_m"] = camera.clip.end_m.into();
        }
        match &camera.lens {
            Lens::Perspective { fov_y } => described["fov_y_rad"] = fov_y.at(seconds).into(),
            Lens::Orthographic { height_m } => described["height_m"] = height_m.at(seconds).into(),
        }
        described
    };
    json!({
        "frame": frame,
        "seconds": seconds,
        "method": plan.choice(frame).to_string(),
        "nodes": by_name(nodes),
        "camera": camera.map(describe),
        "cameras": by_name(scene.cameras.iter().map(|camera| (camera.name.as_str(), describe(camera)))),
        "lights": by_name(lights),
        "sky_suns": sky_suns.collect::<Vec<_>>(),
    })
}

fn describe_light(light: &Light, world: [f64; 16], seconds: f64) -> Value {
    let power = light.power.at(seconds).to_array();
    match &light.kind {
        LightKind::Sun => json!({ "kind": "sun", "world": world, "irradiance_w_per_m2": power }),
        LightKind::SunDisc(disc) => json!({
            "kind": "sun",
            "world": world,
            "irradiance_w_per_m2": power,
            "angular_diameter_rad": disc.angular_diameter.at(seconds),
            "visible_to_camera": disc.visible_to_camera,
        }),
        LightKind::Point => json!({ "kind": "point", "world": world, "intensity_w_per_sr": power }),
        LightKind::Sphere { radius } => json!({
            "kind": "sphere",
            "world": world,
            "intensity_w_per_sr": power,
            "radius_m": radius.at(seconds),
        }),
        LightKind::Area { shape, width, height, spread } => json!({
            "kind": if *shape == AreaShape::Rectangle { "rectangle" } else { "ellipse" },
            "world": world,
            "power_w": power,
            "width_m": width.at(seconds),
            "height_m": height.at(seconds),
            "spread_rad": spread.at(seconds),
        }),
        LightKind::Spot { outer_angle, blend, radius } => json!({
            "kind": "spot",
            "world": world,
            "intensity_w_per_sr": power,
            "outer_rad": outer_angle.at(seconds),
            "blend": blend.at(seconds),
            "radius_m": radius.at(seconds),
        }),
    }
}

/// Names need not be unique: later duplicates get `#2`, `#3` and so on.
fn by_name<'a>(entries: impl Iterator<Item = (&'a str, Value)>) -> Map<String, Value> {
    let mut map = Map::new();
    let mut namesakes = std::collections::HashMap::new();
    for (name, value) in entries {
        let count = namesakes.entry(name).and_modify(|count| *count += 1).or_insert(1);
        let key = if *count == 1 { name.to_owned() } else { format!("{name}#{count}") };
        map.insert(key, value);
    }
    map
}

fn row_major(affine: DAffine3) -> [f64; 16] {
    DMat4::from(affine).transpose().to_cols_array()
}
