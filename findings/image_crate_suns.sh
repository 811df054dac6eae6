#!/usr/bin/env bash
# Rust's image crate cuts skies off at 1 as it resizes or blurs them: a sun of 100,000 is as bright as a white wall.
#
# Expected: `image` reads OpenEXR and Radiance as floats of any size, and resizing, a weighted mean, keeps the mean light
# of a picture. A sky of 64 x 32 pixels at 0.5 with a sun of 4 pixels at 1e5 has a mean of 195.8, whatever its size. What
# happens: `image` 0.25.10 takes 1 for the greatest number that a float may be in a picture. `resize` to a half has a mean
# of 0.51 by *Triangle* and by *Lanczos3*, with 1 where the sun was, 385 times too dark in all; even *Nearest* clips.
# `fast_blur`, `filter3x3`, `unsharpen` and `adjust_contrast` clip as well. `thumbnail` keeps the sun and adds 0.5 to each
# pixel, as it rounds: the sky is twice as bright. `brighten(0)`, which changes nothing, makes whole numbers of it, 0 for
# the sky and 1 for the sun, and `huerotate(0)` up to 255. `blur`, `rotate90` and `grayscale` are right. Nothing is said;
# the pages of the functions do not name it, that of the trait `Primitive` does.
# Remedy: divide by the greatest number before `resize`, and multiply after.
# Versions: image 0.25.10 with its feature `exr`, exr 1.74.2 (crates.io). Source: measured here;
# https://docs.rs/image/0.25.10/image/trait.Primitive.html (DEFAULT_MAX_VALUE: 1.0 for floats);
# https://docs.rs/image/0.25.10/image/enum.DynamicImage.html (resize, brighten)
# Needs cargo. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
unset CARGO_TARGET_DIR
cargo init --quiet --vcs none --name skies --edition 2021
cargo add --quiet image@=0.25.10 --no-default-features --features exr
cargo add --quiet exr@=1.74.2 # what image reads and writes OpenEXR with
cat >src/main.rs <<'END'
use image::imageops::FilterType::{Lanczos3, Nearest, Triangle};
use image::{DynamicImage, Rgb, Rgb32FImage};

/// The mean of a picture, and its greatest number.
fn light(picture: &DynamicImage) -> (f64, f64) {
    let picture = picture.to_rgb32f();
    let reds = || picture.pixels().map(|pixel| f64::from(pixel.0[0]));
    (reds().sum::<f64>() / reds().count() as f64, reds().fold(0.0, f64::max))
}

/// A picture of `factor` times the light.
fn scaled(picture: &DynamicImage, factor: f32) -> DynamicImage {
    let mut picture = picture.to_rgb32f();
    picture.pixels_mut().for_each(|pixel| pixel.0.iter_mut().for_each(|part| *part *= factor));
    DynamicImage::ImageRgb32F(picture)
}

fn main() {
    let mut sky = Rgb32FImage::from_pixel(64, 32, Rgb([0.5; 3]));
    for (x, y) in [(20, 6), (21, 6), (20, 7), (21, 7)] {
        sky.put_pixel(x, y, Rgb([1e5; 3]));
    }
    sky.save("sky.exr").unwrap();
    let sky = image::open("sky.exr").unwrap();
    let divided = scaled(&scaled(&sky, 1e-5).resize_exact(32, 16, Triangle), 1e5);
    let mut is_same = true;
    for (name, made, mean, greatest) in [
        ("as it is read", sky.clone(), 195.8, 1e5),
        ("rotate90", sky.rotate90(), 195.8, 1e5),
        ("grayscale", sky.grayscale(), 195.8, 1e5),
        ("resize_exact of what was divided before, times that", divided, 195.8, 56251.0),
        ("thumbnail_exact to a half", sky.thumbnail_exact(32, 16), 196.3, 1e5),
        ("blur of 1", sky.blur(1.0), 195.8, 41838.0),
        ("resize_exact to a half, Nearest", sky.resize_exact(32, 16, Nearest), 0.501, 1.0),
        ("resize_exact to a half, Triangle", sky.resize_exact(32, 16, Triangle), 0.509, 1.0),
        ("resize_exact to a half, Lanczos3", sky.resize_exact(32, 16, Lanczos3), 0.509, 1.0),
        ("fast_blur of 1", sky.fast_blur(1.0), 0.502, 0.714),
        ("filter3x3, mean of nine", sky.filter3x3(&[1.0 / 9.0; 9]), 0.458, 1.0),
        ("unsharpen of 1", sky.unsharpen(1.0, 0), 0.493, 1.0),
        ("adjust_contrast by 0", sky.adjust_contrast(0.0), 0.501, 1.0),
        ("brighten by 0", sky.brighten(0), 0.002, 1.0),
        ("huerotate by 0", sky.huerotate(0), 0.997, 255.0),
    ] {
        let found = light(&made);
        println!("image 0.25.10, {name}: mean {:.3}, greatest {:.3}", found.0, found.1);
        let is_near = |found: f64, wanted: f64| (found - wanted).abs() < 0.01 * wanted + 0.002;
        is_same &= is_near(found.0, mean) && is_near(found.1, greatest);
    }
    if !is_same {
        println!("this has changed");
        std::process::exit(1);
    }
}
END
cargo run --quiet
