//! `inspect` as text. In goes an input, out come lines. Invariant: every light has the file's photometric
//! numbers and this program's radiometric ones.

use super::super::pass_names;
use super::Inspected;
use glam::{DAffine3, DVec3};
use std::collections::HashSet;
use std::f64::consts::PI;
use std::fmt::Write;
use std::sync::Arc;
use sunfleck::color::LUMENS_PER_WATT;
use sunfleck::math::Voxels;
use sunfleck::scene::{
    Animation, AreaShape, Clip, Fog, FogShape, FogVoxels, HeightFalloff, Lens, Light, LightKind, Placement,
    Scene, Sky, SkyLight, SkyPicture, SkySun, SunPicture, SunShows,
};

pub(super) fn describe(inspected: &Inspected, frames: &[f64]) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write(&mut out, inspected, frames);
    out.truncate(out.trim_end().len());
    out
}

fn write(out: &mut String, inspected: &Inspected, frames: &[f64]) -> std::fmt::Result {
    let Inspected { input, scene, settings, plan } = inspected;
    let rate = settings.frame_rate;
    writeln!(out, "{input}: `{}`, content {}", settings.name, &plan.scene.content_hash()[..12])?;
    let (first, last) = (*settings.frames.start(), *settings.frames.end());
    let seconds = |frame: i64| rate.seconds(frame as f64);
    let a_second = match rate.denominator {
        1 => rate.numerator.to_string(),
        denominator => format!("{}/{denominator}", rate.numerator),
    };
    write!(
        out,
        "  frames     {first} to {last} at {a_second} a second; frame {first} is {:.6} s",
        seconds(first)
    )?;
    if last > first {
        write!(out, ", frame {last} is {:.6} s", seconds(last))?;
    }
    writeln!(out)?;
    let size = settings.size;
    writeln!(
        out,
        "  picture    {} x {}, {}, filter {}, seed {}, {}",
        size.width,
        size.height,
        settings.sampling,
        settings.filter.name(),
        settings.seed,
        pass_names(&settings.passes)
    )?;
    write_geometry(out, scene)?;
    write_animations(out, inspected)?;
    for &frame in frames {
        write_frame(out, inspected, frame)?;
    }
    writeln!(out, "  method     exact: every light's visibility along every ray is found from the geometry")?;
    for &frame in frames {
        writeln!(out, "             frame {frame} by {}", plan.choice(frame))?;
    }
    write_skips(out, inspected)?;
    super::properties::write(out, &scene.properties)?;
    if plan.remarks.0.is_empty() {
        writeln!(out, "  remarks    none: everything that the input asks for is honoured")?;
    }
    for remark in &plan.remarks.0 {
        writeln!(out, "{remark}")?;
    }
    Ok(())
}

fn write_geometry(out: &mut String, scene: &Scene) -> std::fmt::Result {
    let used: HashSet<_> = scene.instances.iter().map(|instance| instance.mesh).collect();
    let stored: usize = scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    let placed: usize =
        scene.instances.iter().map(|instance| scene.meshes[instance.mesh].triangles.len()).sum();
    writeln!(
        out,
        "  geometry   {placed} triangles: {} placed {} ({stored} triangles stored); {}, {}",
        count(used.len(), "mesh", "meshes"),
        count(scene.instances.len(), "time", "times"),
        count(scene.nodes.len(), "node", "nodes"),
        count(scene.textures.len(), "texture", "textures")
    )
}

/// Writes the animations, by the names that options take.
fn write_animations(out: &mut String, inspected: &Inspected) -> std::fmt::Result {
    const NAMED: usize = 4;
    for animation in &inspected.scene.animations {
        let Animation { name, moves, is_played, .. } = animation;
        let rounded = |frame: f64| (frame * 1e3).round() / 1e3;
        let frames = match animation.frames(inspected.settings.frame_rate) {
            Some((first, last)) => format!("frames {} to {}", rounded(first), rounded(last)),
            None => String::from("no keys"),
        };
        let more = match moves.len().saturating_sub(NAMED) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let moves: Vec<String> = moves.iter().take(NAMED).map(|name| format!("`{name}`")).collect();
        let moves = if moves.is_empty() { String::from("nothing") } else { moves.join(", ") };
        let played = if *is_played { "played" } else { "not played" };
        writeln!(out, "  animation  `{name}`: {frames}, moves {moves}{more}; {played}")?;
    }
    Ok(())
}

fn write_frame(out: &mut String, inspected: &Inspected, frame: f64) -> std::fmt::Result {
    let Inspected { scene, settings, .. } = inspected;
    let time_s = settings.frame_rate.seconds(frame);
    let placements = scene.placements(time_s);
    writeln!(out, "  at frame {frame} ({time_s:.6} s)")?;
    write_cameras(out, scene, &placements, time_s)?;
    write_lights(out, scene, &placements, time_s)?;
    super::units::write(out, &scene.lights, time_s)?;
    for fog in &scene.fogs {
        write_fog(out, fog, placements[fog.node].world_from_node, time_s)?;
    }
    if let Some(sky) = &scene.sky {
        write_sky(out, sky, time_s)?;
    }
    let hidden = placements.iter().filter(|placement| !placement.visible).count();
    if hidden > 0 {
        writeln!(out, "    hidden   {}", count(hidden, "node", "nodes"))?;
    }
    Ok(())
}

fn write_cameras(out: &mut String, scene: &Scene, placements: &[Placement], time_s: f64) -> std::fmt::Result {
    for camera in &scene.cameras {
        let place = placements[camera.node].world_from_node.translation;
        write!(out, "    camera   `{}` at {place:.3}, ", camera.name)?;
        match &camera.lens {
            Lens::Perspective { fov_y } => {
                write!(out, "vertical field of view {:.3} deg", fov_y.at(time_s).to_degrees())?;
            }
            Lens::Orthographic { height_m } => {
                write!(out, "orthographic, {:.3} m high", height_m.at(time_s))?;
            }
        }
        writeln!(out, "{}", clip(camera.clip))?;
    }
    Ok(())
}

fn write_lights(out: &mut String, scene: &Scene, placements: &[Placement], time_s: f64) -> std::fmt::Result {
    for light in &scene.lights {
        let world = placements[light.node].world_from_node;
        let (beam, place) = ((-world.matrix3.z_axis).normalize_or_zero(), world.translation);
        write!(out, "    {:<8} `{}` ", kind(&light.kind), light.name)?;
        match &light.kind {
            LightKind::Sun | LightKind::SunDisc(_) => write!(out, "along {beam:.3}")?,
            LightKind::Point | LightKind::Sphere { .. } | LightKind::Spot { .. } => {
                write!(out, "at {place:.3}")?;
            }
            LightKind::Area { .. } => write!(out, "at {place:.3} along {beam:.3}")?,
        }
        writeln!(out, ": {}", brightness(light, time_s))?;
    }
    Ok(())
}

fn write_fog(out: &mut String, fog: &Fog, world: DAffine3, time_s: f64) -> std::fmt::Result {
    let half_extents = world.matrix3.x_axis.abs() + world.matrix3.y_axis.abs() + world.matrix3.z_axis.abs();
    let (low, high) = (world.translation - half_extents, world.translation + half_extents);
    let bounds = match &fog.shape {
        FogShape::EvenBox | FogShape::ThinningBox(_) => format!("within {low:.3} to {high:.3}"),
        FogShape::Layer(_) => String::from("without bounds"),
        FogShape::Mist(mist) => {
            let [low, high] = mist.bounds;
            let of_voxels = mist.voxels(time_s).map_or(0, |voxels| voxels.voxels.memory());
            let memory_mb = of_voxels as f64 / 1e6;
            format!(
                "billows of {} m and smaller within {low:.3} to {high:.3}, a voxel every {:.3} m, {memory_mb:.1} MB",
                mist.size_m, mist.voxel_m
            )
        }
        FogShape::Voxels(grids) => {
            let told = |grid: Arc<FogVoxels>| {
                let voxels = grid.parts.iter().map(|part| &part.voxels.voxels);
                let voxels = voxels.max_by(|a, b| a.most().total_cmp(&b.most()))?;
                let [low, high] = voxel_bounds(world * grid.shape_from_voxel, voxels);
                let memory: usize = grid.parts.iter().map(|part| part.voxels.voxels.memory()).sum();
                let (most, memory_mb) = (voxels.most(), memory as f64 / 1e6);
                Some(format!("by voxels, up to {most:.3}, within {low:.3} to {high:.3}, {memory_mb:.2} MB"))
            };
            let mut text = grids.at(time_s).and_then(told).unwrap_or_else(|| String::from("by voxels"));
            if let Some(name) = &grids.names.albedo {
                text += &format!(", albedo by `{name}`");
            }
            if let Some(name) = &grids.names.emission {
                let kelvin = grids.names.kelvin.map_or(String::new(), |kelvin| format!(" of {kelvin} K"));
                text += &format!(", shines by `{name}`{kelvin}");
            }
            text
        }
    };
    let density = fog.density_per_m.at(time_s);
    let mut falloff = String::new();
    if let Some(HeightFalloff { base, scale_height_m }) = fog.shape.falloff() {
        let base = world.transform_point3(DVec3::new(0.0, *base, 0.0));
        let scale_height_m = scale_height_m.at(time_s);
        falloff = format!(
            " at and below {base:.3}, 1/e of it every {scale_height_m:.3} m up (optical depth of the column {})",
            color(density * scale_height_m)
        );
    }
    writeln!(
        out,
        "    fog      `{}` {bounds}: {} /m{falloff}, albedo {}, g {:.3}",
        fog.name,
        color(density),
        color(fog.albedo.at(time_s)),
        fog.anisotropy.at(time_s)
    )
}

fn voxel_bounds(world: DAffine3, voxels: &Voxels) -> [DVec3; 2] {
    let (low, high) = voxels.bounds();
    let middle = world.transform_point3(0.5 * (low + high));
    let half = 0.5 * (high - low);
    let axes = [world.matrix3.x_axis, world.matrix3.y_axis, world.matrix3.z_axis];
    let reach: DVec3 = axes.into_iter().zip(half.to_array()).map(|(axis, half)| half * axis.abs()).sum();
    [middle - reach, middle + reach]
}

fn write_sky(out: &mut String, sky: &Sky, time_s: f64) -> std::fmt::Result {
    let strength = sky.strength.at(time_s);
    let look = match sky.picture() {
        SkyPicture::Even(radiance) => format!("{} W/(m2 sr)", color(*radiance * strength)),
        SkyPicture::Gradient { zenith, horizon, ground } => format!(
            "zenith {}, horizon {}, ground {} W/(m2 sr)",
            color(*zenith * strength),
            color(*horizon * strength),
            color(*ground * strength)
        ),
        SkyPicture::Image(image) => format!(
            "`{}`, {} x {}, times {} W/(m2 sr), turned by {:.3} deg",
            image.name,
            image.width,
            image.height,
            color(strength),
            sky.rotation.at(time_s).to_degrees()
        ),
    };
    let lights = match sky.lights {
        SkyLight::Nothing => "lights nothing",
        SkyLight::Surfaces => "lights surfaces",
        _ => "lights surfaces and fog",
    };
    writeln!(out, "    sky      {look}; {lights}")?;
    for SkySun { to_sun, irradiance, angular_diameter } in sky.suns_at(time_s) {
        writeln!(
            out,
            "    sun      in the sky, along {:.3}: {} W/m2, a disc of {:.4} deg",
            -to_sun,
            color(irradiance),
            angular_diameter.to_degrees()
        )?;
    }
    if sky.suns_apart() == 0 && sky.lights != SkyLight::Nothing && sky.has_sun() {
        writeln!(
            out,
            "             part of it is as bright as a sun: its light is sampled by rays, with noise"
        )?;
    }
    Ok(())
}

/// `1 mesh`, `2 meshes`.
fn count(number: usize, one: &str, many: &str) -> String {
    format!("{number} {}", if number == 1 { one } else { many })
}

/// One number for grey, three for a colour.
fn color(color: DVec3) -> String {
    match color.to_array() {
        [red, green, blue] if red == green && green == blue => format!("{red:.4}"),
        _ => format!("{color:.4}"),
    }
}

/// Writes which work rendering skips for this scene.
fn write_skips(out: &mut String, inspected: &Inspected) -> std::fmt::Result {
    let Inspected { scene, settings, .. } = inspected;
    let used: HashSet<_> = scene.instances.iter().map(|instance| instance.mesh).collect();
    let mut skips = Vec::new();
    if scene.fogs.is_empty() {
        skips.push("no fog: no shafts are computed".to_owned());
    }
    if scene.lights.is_empty() && scene.sky.is_none() {
        skips.push("no lights: no shadow is looked for".to_owned());
    }
    if used.len() < scene.meshes.len() {
        skips.push(format!(
            "{} that nothing places: no tree is built",
            count(scene.meshes.len() - used.len(), "mesh", "meshes")
        ));
    }
    if settings.passes.is_empty() {
        skips.push("no passes: beauty alone".to_owned());
    }
    if scene.is_still() && settings.frames.start() != settings.frames.end() {
        skips.push("nothing moves: one frame is rendered, the others are copies of its pixels".to_owned());
    }
    match skips.is_empty() {
        true => writeln!(out, "  skipped    nothing"),
        false => writeln!(out, "  skipped    {}", skips.join("; ")),
    }
}

fn kind(kind: &LightKind) -> &'static str {
    match kind {
        LightKind::Sun | LightKind::SunDisc(_) => "sun",
        LightKind::Point => "point",
        LightKind::Sphere { .. } => "sphere",
        LightKind::Spot { .. } => "spot",
        LightKind::Area { shape: AreaShape::Rectangle, .. } => "rect",
        LightKind::Area { shape: AreaShape::Ellipse, .. } => "ellipse",
    }
}

fn brightness(light: &Light, time_s: f64) -> String {
    let power = light.power.at(time_s);
    let brightest = power.max_element();
    let photometric = brightest * LUMENS_PER_WATT;
    let radius = |radius: f64| if radius > 0.0 { format!(", radius {radius:.4} m") } else { String::new() };
    let of_point = |size: f64| {
        format!(
            "{} W/sr (brightest channel {photometric:.1} cd, {:.3} W to all sides){}",
            color(power),
            4.0 * PI * brightest,
            radius(size)
        )
    };
    let of_sun = format!("{} W/m2 (brightest channel {photometric:.1} lux)", color(power));
    match &light.kind {
        LightKind::Sun => of_sun,
        LightKind::SunDisc(disc) => {
            let picture = match disc.picture.as_ref().map(SunPicture::shows) {
                None => "",
                Some(SunShows::Even) => " with a darker limb",
                Some(SunShows::Image(_)) => " with an image",
                Some(SunShows::Julia(_)) => " with a fractal",
            };
            let seen = if disc.visible_to_camera { ", seen by the camera" } else { "" };
            let diameter = disc.angular_diameter.at(time_s).to_degrees();
            format!("{of_sun}, a disc of {diameter:.4} deg{picture}{seen}")
        }
        LightKind::Point => of_point(0.0),
        LightKind::Sphere { radius } | LightKind::Spot { radius, .. } => of_point(radius.at(time_s)),
        LightKind::Area { width, height, .. } => format!(
            "{} W (brightest channel {photometric:.1} lm) from {:.4} x {:.4} m",
            color(power),
            width.at(time_s),
            height.at(time_s)
        ),
    }
}

/// Clipping distances, in the single precision of files.
fn clip(clip: Clip) -> String {
    let [start_m, end_m] = [clip.start_m, clip.end_m].map(|plane_m| plane_m as f32);
    match (start_m, end_m) {
        (0.0, f32::INFINITY) => String::new(),
        (_, f32::INFINITY) => format!(", shows surfaces from {start_m} m on"),
        _ => format!(", shows surfaces from {start_m} to {end_m} m"),
    }
}
