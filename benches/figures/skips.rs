//! Work that the renderer leaves out where a scene does not need it, each time with and without. In goes a
//! scene, out comes a row for each such skip. Invariant: the skipped work is brought back through the public
//! interface alone. A scene or a job that needs the work, but shows the same picture, does that. So no inner
//! loop has a switch for it.

use crate::{inputs, skips_on_disk};
use std::fmt::Write;
use std::path::Path;
use sunfleck::accel::MeshTree;
use sunfleck::bench::{RelativeErrors, seconds, timed};
use sunfleck::color::Rgb;
use sunfleck::film::Frame;
use sunfleck::passes::Pass;
use sunfleck::render::{Job, Method, Watch, render};
use sunfleck::scene::{
    self, AlphaMode, Bounces, Clearcoat, Coat, LightKind, Material, PixelFilter, Sampling, Scene, Sheen,
    Size, Sky, SkyLight, SkyPicture, SunDisc, Track, Window,
};
use sunfleck::snapshot::{Exposure, MeshTrees, Shutter};

/// Index of the scene's camera.
const CAMERA: usize = 0;

/// Prints the skips of `leaves500`.
pub fn run(rounds: usize) {
    let scene = inputs::load("leaves500/leaves500.glb");
    let folder = tempfile::tempdir().unwrap();
    let plan = Plan::new(&scene, Size { width: 480, height: 270 }, rounds, folder.path());
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    println!("{}", table(&one.install(|| measure(&plan)).unwrap()));
}

impl<'a> Plan<'a> {
    /// Slices of four samples a pixel at the start of a scene.
    pub(crate) fn new(scene: &'a Scene, size: Size, rounds: usize, folder: &'a Path) -> Self {
        let job = Job {
            size,
            window: Window::whole(size),
            passes: Vec::new(),
            sampling: Sampling::Exactly(4),
            filter: PixelFilter::Box,
            seed: 0,
            mirror_depth: 4,
            bounces: Bounces::NONE,
            method: Method::Slices,
        };
        Self { scene, shutter: Shutter { open_s: 0.0, close_s: 0.0 }, job, rounds, folder }
    }
}

/// A number that changes no picture: far below what single precision can tell from nothing.
const NEXT_TO_NOTHING: f64 = 1e-300;

/// Coat that shines so little that nobody sees it.
const THIN_COAT: Coat = Coat {
    metallic: 0.0,
    roughness: 0.5,
    texture: None,
    f0: Rgb::splat(NEXT_TO_NOTHING),
    f0_texture: None,
    f90: NEXT_TO_NOTHING,
};
const THIN_CLEARCOAT: Clearcoat = Clearcoat {
    share: NEXT_TO_NOTHING,
    texture: None,
    roughness: 0.5,
    roughness_texture: None,
    normal_map: None,
};
const THIN_SHEEN: Sheen = Sheen {
    color: Rgb::splat(NEXT_TO_NOTHING),
    color_texture: None,
    roughness: 0.5,
    roughness_texture: None,
};

/// Work that could be left out, and is not: docs/decisions/measuring.md has the figures.
const NOT_SKIPPED: &str = "not skipped: geometry that can neither be seen nor cast a shadow into view; building all of it takes 1 % of a frame\n";

/// What is measured.
pub(crate) struct Plan<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) shutter: Shutter,
    /// The picture; its passes are left aside.
    pub(crate) job: Job,
    /// Number of measurements of each side, at least one.
    pub(crate) rounds: usize,
    /// A folder for what goes by the disk.
    pub(crate) folder: &'a Path,
}

/// One thing that is skipped.
#[derive(Clone, Debug)]
pub(crate) struct Skip {
    /// Name.
    pub(crate) name: &'static str,
    /// Way in which the work was brought back.
    pub(crate) without: &'static str,
    /// Seconds of processor time with the skip, and without.
    pub(crate) seconds: (f64, f64),
    /// Root mean square difference of the two pictures, relative to the mean; 0 is the same bits.
    pub(crate) difference: f64,
}

/// A way to a picture, and the seconds of the part that counts.
pub(crate) type Side<'a> = &'a dyn Fn() -> Result<(Frame, f64), String>;

/// Measures a row: its name, how the work is brought back, the picture with the skip and without.
pub(crate) type AddRow<'a> = dyn FnMut(&'static str, &'static str, Side, Side) -> Result<(), String> + 'a;

/// Measures every skip on the current rayon pool.
///
/// # Errors
/// If the folder cannot be written to; the reason, for people.
pub(crate) fn measure(plan: &Plan) -> Result<Vec<Skip>, String> {
    let mut skips = Vec::new();
    let mut row = |name, without, with_skip: Side, without_skip: Side| {
        compare(plan.rounds, with_skip, without_skip).map(|(seconds, difference)| {
            skips.push(Skip { name, without, seconds, difference });
        })
    };
    fog(plan, &mut row)?;
    lights(plan, &mut row)?;
    surfaces(plan, &mut row)?;
    sky(plan, &mut row)?;
    passes_and_samples(plan, &mut row)?;
    meshes(plan, &mut row)?;
    skips_on_disk::measure(plan, &mut row)?;
    Ok(skips)
}

fn fog(plan: &Plan, row: &mut AddRow) -> Result<(), String> {
    let clear = changed(plan, &|scene| scene.fogs.clear());
    let thin = changed(plan, &|scene| {
        for fog in &mut scene.fogs {
            fog.density_per_m = Track::from(Rgb::splat(NEXT_TO_NOTHING));
        }
    });
    row("no fog, no work for fog", "fog of density 1e-300", &|| shown(plan, &clear), &|| shown(plan, &thin))?;
    if plan.scene.fogs.is_empty() {
        return Ok(());
    }
    let of_density = |factor: Rgb| changed(plan, &|scene| set_density(scene, plan, factor));
    // The smallest step from 1 that double precision knows.
    let last_bit = Rgb::new(1.0, 1.0 + f64::EPSILON, 1.0 - f64::EPSILON);
    let (grey, coloured) = (of_density(Rgb::ONE), of_density(last_bit));
    row("grey fog: one exponential", "channels that differ in the last bit", &|| shown(plan, &grey), &|| {
        shown(plan, &coloured)
    })
}

fn lights(plan: &Plan, row: &mut AddRow) -> Result<(), String> {
    let with_light = |power: f64| {
        changed(plan, &|scene| {
            if let Some(mut light) = scene.lights.first().cloned() {
                light.power = Track::from(Rgb::splat(power));
                scene.lights.push(light);
            }
        })
    };
    let (dark, dim) = (with_light(0.0), with_light(NEXT_TO_NOTHING));
    row("lights that are out", "a light of power 1e-300", &|| shown(plan, &dark), &|| shown(plan, &dim))?;
    // Both sides go ray by ray: with an extent each slice has a draw of its own, and so another picture.
    let by_rays = Plan { job: Job { method: Method::Segments, ..plan.job.clone() }, ..*plan };
    let extended = changed(plan, &|scene| {
        for light in &mut scene.lights {
            light.kind = with_extent(&light.kind);
        }
    });
    row(
        "lights without extent take no samples",
        "an extent of 1e-12",
        &|| shown(&by_rays, plan.scene),
        &|| shown(&by_rays, &extended),
    )
}

fn surfaces(plan: &Plan, row: &mut AddRow) -> Result<(), String> {
    let of_material =
        |change: &dyn Fn(&mut Material)| changed(plan, &|scene| scene.materials.iter_mut().for_each(change));
    let mut pair =
        |name, without, with_skip: &dyn Fn(&mut Material), without_skip: &dyn Fn(&mut Material)| {
            let (with_skip, without_skip) = (of_material(with_skip), of_material(without_skip));
            row(name, without, &|| shown(plan, &with_skip), &|| shown(plan, &without_skip))
        };
    pair(
        "no mirrors, no reflected rays",
        "mirrors of reflectance 1e-300",
        &|material| material.mirror = Rgb::ZERO,
        &|material| material.mirror = Rgb::splat(NEXT_TO_NOTHING),
    )?;
    pair("no coats", "coats that reflect 1e-300", &|material| material.coat = None, &|material| {
        material.coat = Some(THIN_COAT);
    })?;
    pair(
        "no clear coats, no sheen",
        "both of 1e-300",
        &|material| (material.clearcoat, material.sheen) = (None, None),
        &|material| (material.clearcoat, material.sheen) = (Some(THIN_CLEARCOAT), Some(THIN_SHEEN)),
    )?;
    pair(
        "nothing to see through: no veils",
        "all surfaces blended, opaque but for the last bit",
        &|material| material.alpha_mode = AlphaMode::Opaque,
        &|material| {
            material.alpha_mode = AlphaMode::Blend;
            // The largest number below 1.
            material.opacity = 1.0 - 0.5 * f64::EPSILON;
        },
    )
}

fn sky(plan: &Plan, row: &mut AddRow) -> Result<(), String> {
    let under_sky = |strength: f64| {
        changed(plan, &|scene| {
            let sky = Sky::new(SkyPicture::Even(Rgb::ONE));
            scene.sky = sky.map(|sky| {
                sky.with(Track::from(Rgb::splat(strength)), Track::from(0.0), SkyLight::default())
            });
        })
    };
    let (black, dim) = (under_sky(0.0), under_sky(NEXT_TO_NOTHING));
    row("no sky, no rays to it", "a sky of 1e-300", &|| shown(plan, &black), &|| shown(plan, &dim))
}

fn passes_and_samples(plan: &Plan, row: &mut AddRow) -> Result<(), String> {
    // Not that of the error, which is estimated from more and smaller passes over the picture.
    let passes: Vec<Pass> = Pass::ALL.iter().copied().filter(|pass| *pass != Pass::Error).collect();
    row("passes not asked for", "all of them", &|| shown(plan, plan.scene), &|| {
        Ok(picture(plan, plan.scene, &passes))
    })?;
    let sampled = |sampling: Sampling| Plan { job: Job { sampling, ..plan.job.clone() }, ..*plan };
    let (tolerant, uniform) =
        (sampled(Sampling::Until { tolerance: 0.02, most: 64 }), sampled(Sampling::Exactly(64)));
    row(
        "samples of pixels that are good enough",
        "64 everywhere, against a tolerance of 0.02",
        &|| shown(&tolerant, plan.scene),
        &|| shown(&uniform, plan.scene),
    )
}

fn meshes(plan: &Plan, row: &mut AddRow) -> Result<(), String> {
    let scene = plan.scene;
    let kept = MeshTrees::new(scene);
    let next_frame = |trees: &MeshTrees| {
        let (exposure, seconds) = timed(|| exposure(plan, scene, trees));
        Ok((rendered(plan, &exposure, &[]), seconds))
    };
    next_frame(&kept)?;
    row("mesh trees kept from frame to frame", "built again", &|| next_frame(&kept), &|| {
        next_frame(&MeshTrees::new(scene))
    })?;
    row("meshes that no frame shows", "their trees built", &|| next_frame(&kept), &|| {
        let (frame, seconds) = next_frame(&kept)?;
        Ok((frame, seconds + timed(|| scene.meshes.iter().map(tree).count()).1))
    })
}

fn changed(plan: &Plan, change: &dyn Fn(&mut Scene)) -> Scene {
    let mut scene = plan.scene.clone();
    change(&mut scene);
    scene
}

/// Light with a size that is next to nothing, where it has none.
fn with_extent(kind: &LightKind) -> LightKind {
    const SIZE: f64 = 1e-12;
    match kind {
        LightKind::Sun => LightKind::SunDisc(SunDisc::even(Track::from(SIZE))),
        LightKind::Point => LightKind::Sphere { radius: Track::from(SIZE) },
        other => other.clone(),
    }
}

fn set_density(scene: &mut Scene, plan: &Plan, factor: Rgb) {
    for fog in &mut scene.fogs {
        let mean = fog.density_per_m.at(plan.shutter.middle_s()).element_sum() / 3.0;
        fog.density_per_m = Track::from(mean * factor);
    }
}

fn tree(mesh: &scene::Mesh) -> MeshTree {
    let triangles: Vec<[u32; 3]> = mesh.triangles.iter().map(|triangle| triangle.vertices).collect();
    MeshTree::new(&mesh.positions, &triangles)
}

fn exposure<'a>(plan: &Plan, scene: &'a Scene, trees: &'a MeshTrees) -> Exposure<'a> {
    let aspect = plan.job.size.width as f64 / plan.job.size.height as f64;
    let exposure = Exposure::new(scene, trees, CAMERA, aspect, plan.shutter);
    // Frozen here, where that is timed, or before anything is.
    exposure.moments();
    exposure
}

fn rendered(plan: &Plan, exposure: &Exposure, passes: &[Pass]) -> Frame {
    let job = Job { passes: passes.to_vec(), ..plan.job.clone() };
    render(exposure, &job, &Watch::NOBODY).frame
}

/// The picture of a scene, and the time of rendering alone.
pub(crate) fn picture(plan: &Plan, scene: &Scene, passes: &[Pass]) -> (Frame, f64) {
    let trees = MeshTrees::new(scene);
    let exposure = exposure(plan, scene, &trees);
    timed(|| rendered(plan, &exposure, passes))
}

/// Picture without passes, and its time.
fn shown(plan: &Plan, scene: &Scene) -> Result<(Frame, f64), String> {
    Ok(picture(plan, scene, &[]))
}

/// The least times of both sides, taken in turns, and how far their pictures are apart at most.
fn compare(rounds: usize, with_skip: Side, without_skip: Side) -> Result<((f64, f64), f64), String> {
    let (mut least, mut difference) = ((f64::INFINITY, f64::INFINITY), 0.0_f64);
    for _ in 0..rounds.max(1) {
        let ((a, with_s), (b, without_s)) = (with_skip()?, without_skip()?);
        least = (least.0.min(with_s), least.1.min(without_s));
        difference = difference.max(RelativeErrors::new(&a, &b).rmse);
    }
    Ok((least, difference))
}

/// The rows, and below them what there is no row for.
fn table(skips: &[Skip]) -> String {
    let mut text = format!(
        "{:<42} {:>10} {:>10} {:>7}   {:<16} {}\n",
        "skipped", "CPU s", "without", "times", "picture", "brought back by"
    );
    for skip in skips {
        let (with, without) = skip.seconds;
        let same = if skip.difference == 0.0 {
            String::from("the same bits")
        } else {
            format!("within {:.0e}", skip.difference)
        };
        let _ = writeln!(
            text,
            "{:<42} {:>10} {:>10} {:>7.2}   {same:<16} {}",
            skip.name,
            seconds(with),
            seconds(without),
            without / with,
            skip.without
        );
    }
    text.push_str(NOT_SKIPPED);
    text
}
