//! Voxels of one file. In go its grids and their names, out come overlapping volumes. Invariant: values are
//! linear between voxels. So fog whose albedo varies by voxel becomes two volumes, one that scatters and one
//! that absorbs.

use super::leaves::{leaves, vector_voxels};
use super::velocities::Velocities;
use super::{FogPart, FogVoxels, GridNames, Refused};
use crate::color::{Blackbody, Rgb};
use crate::description::vdb::{Floats, Grid, Vectors};
use crate::math::{BRICK, VectorVoxels, Voxels, VoxelsBuilder, VoxelsError};
use glam::{IVec3, Vec3};
use std::sync::Arc;

/// Maximum albedo, with a tolerance for rounding.
const MOST_ALBEDO: f32 = 1.001;
/// Number of temperatures in the table of blackbody colours, which is linear between them.
const TEMPERATURES: usize = 4096;
/// Minimum temperature of a reference, and maximum brightness relative to it.
const COLDEST: f64 = 100.0;
const BRIGHTEST: f64 = 1e12;
const CHANNELS: [Rgb; 3] = [Rgb::X, Rgb::Y, Rgb::Z];

/// Volumes of a file's grids.
pub(super) fn fog_voxels(grids: &[Grid], names: &GridNames) -> Result<FogVoxels, Refused> {
    let density = floats(grids, &names.density)?;
    let mut fog = match &names.albedo {
        None => {
            let voxels = built(density, |value| value).map_err(|error| unbuilt(&names.density, error))?;
            FogVoxels::plain(density.transform, voxels)
        }
        Some(name) => {
            let parts = by_albedo((&names.density, density), (name, vectors(grids, name)?))?;
            FogVoxels { shape_from_voxel: density.transform, parts, ..FogVoxels::default() }
        }
    };
    if let Some(name) = &names.emission {
        let emission = floats(grids, name)?;
        fog.shape_from_emission = emission.transform;
        let blackbody = names.kelvin.map(|kelvin| (kelvin, blackbody(names, kelvin)));
        fog.emission = emission_parts(name, emission, blackbody)?;
    }
    fog.velocities = Velocities::of(grids).map(Arc::new);
    Ok(fog)
}

fn refused<T>(found: String, expected: &str, remedy: &'static str) -> Result<T, Refused> {
    Err(Refused { found, expected: expected.to_owned(), remedy })
}

fn grid<'a>(grids: &'a [Grid], name: &str) -> Result<&'a Grid, Refused> {
    if let Some(grid) = grids.iter().find(|grid| grid.name == name) {
        return Ok(grid);
    }
    let found = format!("there is no grid `{name}`");
    if grids.is_empty() {
        return refused(found, "a grid", "write the fog's grids into it");
    }
    // Names may contain any character.
    let names: Vec<String> = grids.iter().map(|grid| format!("`{}`", grid.name.escape_debug())).collect();
    refused(found, &format!("one of {}", names.join(", ")), "name one of them")
}

/// Scalar grid for fog or emission.
fn floats<'a>(grids: &'a [Grid], name: &str) -> Result<&'a Floats, Refused> {
    let grid = grid(grids, name)?;
    let Some(floats) = &grid.floats else {
        let found = format!("grid `{name}` is a {}", grid.kind);
        return refused(found, "a grid of floats", "name another, or write it as one of floats");
    };
    if floats.tree.background != 0.0 {
        let found = format!("grid `{name}` is {} everywhere else", floats.tree.background);
        return refused(found, "a background of 0", "write it with that: fog ends somewhere");
    }
    if let Some(least) = floats.least().filter(|least| *least < 0.0) {
        let found = format!("grid `{name}` has a voxel of {least}");
        return refused(found, "none below 0", "clip it where it is made, or name another");
    }
    Ok(floats)
}

fn vectors<'a>(grids: &'a [Grid], name: &str) -> Result<&'a Vectors, Refused> {
    let grid = grid(grids, name)?;
    grid.vectors.as_ref().ok_or_else(|| Refused {
        found: format!("grid `{name}` is a {}", grid.kind),
        expected: String::from("a grid of vectors"),
        remedy: "name another, or write it as one of vectors (vec3s)",
    })
}

fn unbuilt(name: &str, error: VoxelsError) -> Refused {
    let found = format!("grid `{name}`: {error}");
    let (expected, remedy) = match error {
        VoxelsError::Empty => ("fog somewhere", "name another, or leave the fog out"),
        VoxelsError::TooFar => ("voxels about the origin", "count them from there where it is made"),
        VoxelsError::TooWide(_) => ("fewer", "clip it to what is seen, or write it with larger voxels"),
    };
    Refused { found, expected: expected.to_owned(), remedy }
}

/// Voxels of active values; inactive ones are not part of the grid.
fn built(floats: &Floats, of: impl Fn(f32) -> f32) -> Result<Voxels, VoxelsError> {
    let mut builder = VoxelsBuilder::of_up_to(floats.tree.leaves().len());
    for tile in &floats.tree.tiles {
        builder.add_even(IVec3::from(tile.origin), tile.edge, of(tile.value))?;
    }
    for (origin, values) in leaves(floats, 0.0) {
        builder.add(origin, values.into_iter().map(&of));
    }
    builder.built()
}

/// Volumes that scatter and that absorb all light of a channel; one for all channels where they are equal.
fn by_albedo(
    (of_density, density): (&str, &Floats),
    (name, colors): (&str, &Vectors),
) -> Result<Vec<FogPart>, Refused> {
    if !density.transform.abs_diff_eq(colors.transform, 1e-6) {
        let found = format!("grid `{name}` has other voxels than `{of_density}`");
        return refused(found, "the same transform for both", "write both on the same voxels");
    }
    let tiles = colors.tree.tiles.iter().map(|tile| tile.value);
    let voxels = colors.tree.leaves().flat_map(|leaf| leaf.values).copied();
    let mut is_grey = true;
    for value in tiles.chain(voxels).chain([colors.tree.background]) {
        is_grey &= value[0] == value[1] && value[1] == value[2];
        if let Some(number) = value.into_iter().find(|number| !(0.0..=MOST_ALBEDO).contains(number)) {
            let found = format!("grid `{name}` has a voxel of {number}");
            return refused(found, "albedos from 0 to 1", "scale it where it is made, or name another");
        }
    }
    let colors = vector_voxels(colors, Vec3::from);
    let all = [Rgb::ONE];
    let mut parts = Vec::new();
    for (channel, &extinction) in (if is_grey { &all[..] } else { &CHANNELS }).iter().enumerate() {
        for scatters in [true, false] {
            let share = |color: Vec3| {
                let albedo = color[channel].min(1.0);
                if scatters { albedo } else { 1.0 - albedo }
            };
            match built_with(density, &colors, share) {
                Ok(voxels) => {
                    let albedo = if scatters { Rgb::ONE } else { Rgb::ZERO };
                    parts.push(FogPart { extinction, albedo, voxels: Arc::new(voxels.into()) });
                }
                // Nothing scatters, or nothing absorbs.
                Err(VoxelsError::Empty) => {}
                Err(error) => return Err(unbuilt(of_density, error)),
            }
        }
    }
    if parts.is_empty() { Err(unbuilt(of_density, VoxelsError::Empty)) } else { Ok(parts) }
}

/// Voxels of density times a share by colour.
fn built_with(
    density: &Floats,
    colors: &VectorVoxels,
    share: impl Fn(Vec3) -> f32,
) -> Result<Voxels, VoxelsError> {
    let mut builder = VoxelsBuilder::default();
    let mut add = |first: IVec3, values: &dyn Fn(usize) -> f32| {
        let along = |place: usize| IVec3::new(place as i32 >> 6, place as i32 >> 3 & 7, place as i32 & 7);
        builder.add(first, (0..BRICK).map(|place| values(place) * share(colors.voxel(first + along(place)))));
    };
    for (origin, values) in leaves(density, 0.0) {
        add(origin, &|place| values[place]);
    }
    for tile in &density.tree.tiles {
        let along = i64::from(tile.edge >> 3);
        if along > 16 {
            return Err(VoxelsError::TooWide(along.pow(3) as u64));
        }
        let along = along as i32;
        for place in 0..along.pow(3) {
            let brick = IVec3::new(place / (along * along), place / along % along, place % along);
            add(IVec3::from(tile.origin) + 8 * brick, &|_| tile.value);
        }
    }
    builder.built()
}

fn blackbody(names: &GridNames, kelvin: f64) -> Blackbody {
    if names.is_principled {
        Blackbody::by_fourth_power(kelvin)
    } else {
        Blackbody::of_luminance_1_at(kelvin)
    }
}

/// Emission: as the grid has it, or of black bodies with this temperature where it is 1.
fn emission_parts(
    name: &str,
    grid: &Floats,
    blackbody: Option<(f64, Blackbody)>,
) -> Result<Vec<(Rgb, Arc<Voxels>)>, Refused> {
    let part = |color: Rgb, voxels: Result<Voxels, VoxelsError>| match voxels {
        Ok(voxels) => Some(Ok((color, Arc::new(voxels)))),
        // All of it is cold.
        Err(VoxelsError::Empty) => None,
        Err(error) => Some(Err(unbuilt(name, error))),
    };
    let Some((kelvin, blackbody)) = blackbody else {
        return part(Rgb::ONE, built(grid, |value| value)).into_iter().collect();
    };
    let most = grid.extent().map_or(0.0, |extent| extent.most);
    let hottest = kelvin * f64::from(most);
    // Written so that NaN is refused too.
    if !(kelvin >= COLDEST && blackbody.at(hottest).max_element() <= BRIGHTEST) {
        let found =
            format!("grid `{name}` is {hottest} K where it is hottest, and shines as if 1 were {kelvin} K");
        let expected = format!("{COLDEST} K or more, and no more than {BRIGHTEST:e} times as bright");
        return refused(found, &expected, "say the temperature where the grid is 1");
    }
    let step = most / TEMPERATURES as f32;
    let lights: Vec<Vec3> = (0..=TEMPERATURES + 1)
        .map(|number| blackbody.at(kelvin * number as f64 * f64::from(step)).as_vec3())
        .collect();
    let light = |value: f32| {
        let at = if step > 0.0 { value / step } else { 0.0 };
        let before = (at as usize).min(TEMPERATURES);
        lights[before].lerp(lights[before + 1], at - before as f32)
    };
    let channels = CHANNELS.iter().enumerate();
    channels.filter_map(|(channel, &color)| part(color, built(grid, |value| light(value)[channel]))).collect()
}
