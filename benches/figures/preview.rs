//! A scan-line picture from scene to PNG: time of its parts.

use crate::inputs;
use cpu_time::ProcessTime;
use std::time::Instant;
use sunfleck::color::Display;
use sunfleck::frame_file::Picture;
use sunfleck::scanline;
use sunfleck::scene::Size;
use sunfleck::snapshot::{MeshTrees, Shutter, Snapshot};

const SIZE: Size = Size { width: 480, height: 270 };

/// Both reference scenes: the fastest of `rounds` counts, by the processor's time of one thread, and
/// by the clock with all.
pub fn run(rounds: usize) {
    println!(
        "{} x {}, milliseconds a frame; by the clock with all threads: frames a second",
        SIZE.width, SIZE.height
    );
    println!(
        "{:>10} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}",
        "", "snapshot", "drawing", "display", "PNG", "together", "a second"
    );
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("preview.png");
    let instant = Shutter { open_s: 0.0, close_s: 0.0 };
    for named in inputs::reference_scenes() {
        let trees = MeshTrees::new(&named.scene);
        let aspect = SIZE.width as f64 / SIZE.height as f64;
        let frame = |laps: &mut dyn FnMut()| {
            let snapshot = Snapshot::new(&named.scene, &trees, 0, aspect, instant);
            laps();
            let drawn = scanline::draw(&snapshot, SIZE);
            laps();
            let picture = Picture::of(&drawn, &Display::default()).expect("it has colours");
            laps();
            picture.write(&path).expect("room on the disk");
            laps();
        };
        let (mut parts, mut clock) = ([f64::INFINITY; 4], f64::INFINITY);
        for _ in 0..rounds {
            one.install(|| {
                let (mut since, mut part) = (ProcessTime::now(), 0);
                frame(&mut || {
                    parts[part] = parts[part].min(since.elapsed().as_secs_f64());
                    (since, part) = (ProcessTime::now(), part + 1);
                });
            });
            let started = Instant::now();
            frame(&mut || {});
            clock = clock.min(started.elapsed().as_secs_f64());
        }
        let [snapshot, drawing, display, png] = parts.map(|seconds| 1e3 * seconds);
        let together = snapshot + drawing + display + png;
        println!(
            "{:>10} {snapshot:>9.1} {drawing:>9.1} {display:>9.1} {png:>9.1} {together:>9.1} {:>9.1}",
            named.name,
            1.0 / clock
        );
    }
}
