//! What comes with the program can be rendered: sequences in, small frames out.

use crate::checkout;
use crate::program::Studio;
use std::collections::BTreeSet;
use std::sync::Mutex;

/// Names of the sequences in the repository, without `.ron`.
fn sequences() -> BTreeSet<String> {
    let entries = std::fs::read_dir(checkout::file("sequences")).unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    paths.map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned()).collect()
}

#[test]
fn every_sequence_renders_to_light_without_a_warning() {
    // One by one each leaves processors idle.
    let names = Mutex::new(sequences().into_iter());
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some(name) = { names.lock().unwrap().next() } {
                    renders_to_light_without_a_warning(&name);
                }
            });
        }
    });
}

fn renders_to_light_without_a_warning(name: &str) {
    let studio = Studio::new();
    let sequence = format!("checkout:sequences/{name}.ron");
    let line = format!("render {sequence} --size 64x36 --samples 1 --frames 24 --threads 1 --out {name}.exr");
    let outcome = studio.succeed(&line);
    assert!(!outcome.err.contains("warning"), "{name}: {}", outcome.err);
    let file = studio.frame(&format!("{name}.exr"));
    // The median: a sun that can be seen is thousands of times as bright as the rest.
    let mut red = file.frame.channel("R").unwrap().pixels.clone();
    assert!(red.iter().all(|value| value.is_finite()), "{name}");
    red.sort_by(f32::total_cmp);
    let median = red[red.len() / 2];
    assert!((0.01..10.0).contains(&median), "{name}: the median of red is {median}");
}

#[test]
fn the_gallery_shows_every_sequence() {
    let page = std::fs::read_to_string(checkout::file("docs/gallery/README.md")).unwrap();
    for name in sequences() {
        assert!(page.contains(&format!("sequences/{name}.ron")), "{name} is not in the gallery");
        let picture = checkout::file(format!("docs/gallery/{name}.jpg"));
        assert!(picture.exists(), "{} is not there", picture.display());
    }
}

#[test]
fn the_page_on_the_seed_names_tests_that_there_are() {
    let page = std::fs::read_to_string(checkout::file("docs/seed.md")).unwrap();
    let mut count = 0;
    for name in page.split('`').filter_map(|word| word.split_once("::")) {
        let (file, test) = name;
        let source =
            std::fs::read_to_string(checkout::file(file)).unwrap_or_else(|_| panic!("{file} is not there"));
        assert!(
            ["fn ", "def "].iter().any(|kind| source.contains(&format!("{kind}{test}("))),
            "{file} has no test `{test}`"
        );
        count += 1;
    }
    assert!(count >= 10, "only {count} tests are named");
}
