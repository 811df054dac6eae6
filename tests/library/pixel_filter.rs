//! Pixels by a filter wider than a pixel, by rays and from slices, against its own integral. And what every
//! picture promises, whatever filters it.

use crate::checkout;
use crate::common::{EXACT, INSTANT, add_light, camera_at, place};
use glam::{DAffine3, DVec2, DVec3};
use sunfleck::color::Rgb;
use sunfleck::film::{Frame, filter};
use sunfleck::passes::Pass;
use sunfleck::render::{Job, Method, Watch, render};
use sunfleck::scene::{
    Instance, LightKind, Material, Mesh, PixelFilter, Sampling, Scene, Size, Triangle, Window,
};
use sunfleck::snapshot::{Exposure, MeshTrees};
use sunfleck::{description, scene};

const SIZE: Size = Size { width: 32, height: 16 };
const METHODS: [Method; 2] = [Method::Slices, Method::Segments];

fn leaves500() -> Scene {
    let path = checkout::file("tests/data/leaves500/leaves500.glb");
    scene::resolve(description::load(&path).expect("a good file"), None).expect("a good scene").0
}

/// Where something shines: what lies to the right of a line through a place of the picture,
/// which leans by an angle.
#[derive(Clone, Copy, Debug)]
struct Edge {
    through_px: DVec2,
    leans_rad: f64,
}

impl Edge {
    /// Unit vector into the light, y downwards.
    fn inwards(self) -> DVec2 {
        DVec2::from_angle(self.leans_rad)
    }

    /// Black but for where it shines; a sun makes it a picture that slices serve.
    fn scene(self) -> Scene {
        let mut scene = camera_at(DVec3::ZERO);
        add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::new(0.3, -1.0, -0.4), Rgb::ONE);
        let node = place(&mut scene, DAffine3::IDENTITY);
        scene.materials.push(Material { base_color: Rgb::ZERO, emission: Rgb::ONE, ..Material::default() });
        // At a metre the picture is two metres high.
        let (inwards, size) = (self.inwards(), DVec2::new(SIZE.width as f64, SIZE.height as f64));
        let position = |ahead: f64, aside: f64| {
            let at_px = self.through_px + ahead * inwards + aside * inwards.perp();
            let at = (2.0 * at_px - size) / size.y;
            DVec3::new(at.x, -at.y, -1.0).as_vec3()
        };
        let corners = [(0.0, -99.0), (99.0, -99.0), (99.0, 99.0), (0.0, 99.0)];
        scene.meshes.push(Mesh {
            positions: corners.map(|(ahead, aside)| position(ahead, aside)).to_vec(),
            triangles: [[0, 1, 2], [0, 2, 3]].map(|vertices| Triangle { vertices, material: 0 }).to_vec(),
            ..Mesh::default()
        });
        scene.instances.push(Instance { node, mesh: 0, material: None, leaf_id: 1, deformation: None });
        scene
    }

    /// How much of the filter's weight lies where it shines, by points of the pixel and around.
    fn weight_within(self, x: usize, y: usize) -> f64 {
        let steps = 120;
        let offset = |step: i32| 2.0 * (f64::from(step) + 0.5) / f64::from(steps) - 1.0;
        let centre = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
        let (mut within, mut all) = (0.0, 0.0);
        for offset_px in
            (0..steps * steps).map(|point| DVec2::new(offset(point % steps), offset(point / steps)))
        {
            let weight = filter::weight(offset_px.x) * filter::weight(offset_px.y);
            let is_within = (centre + offset_px - self.through_px).dot(self.inwards()) > 0.0;
            within += if is_within { weight } else { 0.0 };
            all += weight;
        }
        within / all
    }

    /// The largest difference between a picture and what its pixels should be, near the middle.
    fn error_of(self, frame: &Frame) -> f64 {
        let red = red(frame);
        let pixels = (4..SIZE.height - 4).flat_map(|y| (4..SIZE.width - 4).map(move |x| (x, y)));
        let error = |(x, y): (usize, usize)| (red[y * SIZE.width + x] - self.weight_within(x, y)).abs();
        pixels.map(error).fold(0.0, f64::max)
    }
}

const EDGES: [Edge; 4] = [
    Edge { through_px: DVec2::new(16.0, 8.0), leans_rad: 0.0 },
    Edge { through_px: DVec2::new(16.3, 8.2), leans_rad: 0.1 },
    Edge { through_px: DVec2::new(15.8, 8.5), leans_rad: 0.7 },
    Edge { through_px: DVec2::new(16.5, 7.6), leans_rad: 1.55 },
];

fn job(method: Method, filter: PixelFilter, sampling: Sampling) -> Job {
    let (size, window, passes) = (SIZE, Window::whole(SIZE), vec![Pass::Cryptomatte]);
    Job {
        size,
        window,
        passes,
        sampling,
        filter,
        seed: 0,
        mirror_depth: EXACT.mirror_depth,
        bounces: sunfleck::scene::Bounces::NONE,
        method,
    }
}

fn picture(scene: &Scene, job: &Job) -> Frame {
    let trees = MeshTrees::new(scene);
    let aspect = job.size.width as f64 / job.size.height as f64;
    let exposure = Exposure::new(scene, &trees, 0, aspect, INSTANT).with_mattes(scene);
    render(&exposure, job, &Watch::NOBODY).frame
}

fn red(frame: &Frame) -> Vec<f64> {
    frame.channel("R").expect("a colour").pixels.iter().map(|&value| f64::from(value)).collect()
}

/// What 256 samples of a pixel with an edge may be off by: less by lines than by points.
fn most_error(method: Method) -> f64 {
    if method == Method::Slices { 0.006 } else { 0.025 }
}

#[test]
fn an_edge_is_as_soft_as_the_filter() {
    for method in METHODS {
        for edge in EDGES {
            let job = job(method, PixelFilter::BlackmanHarris, Sampling::Exactly(256));
            let error = edge.error_of(&picture(&edge.scene(), &job));
            println!("{method:?}, {edge:?}: off by {error:.4} at most");
            assert!(error < most_error(method), "{method:?}, {edge:?}: {error}");
        }
    }
}

/// Late passes see what lies beside the pixels that still want samples, so that these stay means over the
/// whole filter. (Samples of rays lie within their pixel's own filter from the start.)
#[test]
fn passes_to_a_tolerance_keep_the_filter() {
    for edge in EDGES {
        let sampling = Sampling::Until { tolerance: 1e-3, most: 256 };
        let job = job(Method::Slices, PixelFilter::BlackmanHarris, sampling);
        let error = edge.error_of(&picture(&edge.scene(), &job));
        println!("{edge:?}: off by {error:.4} at most");
        assert!(error < most_error(Method::Slices), "{edge:?}: {error}");
    }
}

/// What covers a pixel is weighed as its colour is.
#[test]
fn coverage_is_filtered_too() {
    let frame =
        picture(&EDGES[1].scene(), &job(Method::Slices, PixelFilter::BlackmanHarris, Sampling::Exactly(64)));
    let covered = frame.channel("CryptoObject00.G").expect("a coverage");
    for (covered, red) in covered.pixels.iter().zip(red(&frame)) {
        assert!((f64::from(*covered) - red).abs() < 1e-3, "{covered} {red}");
    }
}

#[test]
fn a_part_has_the_pixels_of_the_whole() {
    let scene = leaves500();
    let part = Window { x: 9, y: 3, width: 14, height: 9 };
    for method in METHODS {
        for sampling in [Sampling::Exactly(5), Sampling::Until { tolerance: 0.05, most: 64 }] {
            let job = job(method, PixelFilter::BlackmanHarris, sampling);
            let whole = picture(&scene, &job);
            let part = picture(&scene, &Job { window: part, ..job });
            assert_eq!(part, whole.part(part.window), "{method:?}, {sampling}");
        }
    }
}
