//! `preview`: pictures, contact sheets and animations, drawn or of frames that are there.

use crate::program::Studio;
use image::codecs::webp::WebPDecoder;
use image::{AnimationDecoder, DynamicImage, RgbImage};
use std::io::Cursor;

fn picture(studio: &Studio, name: &str) -> RgbImage {
    let bytes = studio.bytes(name);
    image::load_from_memory_with_format(&bytes, image::ImageFormat::Png).unwrap().to_rgb8()
}

#[test]
fn pictures_and_a_sheet_where_nobody_said_otherwise() {
    let studio = Studio::new();
    let outcome = studio.succeed("preview tiny.ron --frames 1-3 --size 16x9");
    let names = ["tiny.0001.png", "tiny.0002.png", "tiny.0003.png", "tiny.sheet.png"];
    assert_eq!(studio.names("out/tiny.preview"), names);
    assert!(outcome.err.lines().last().unwrap().starts_with("3 frames of 16x9 in "), "{}", outcome.err);
    let sheet = picture(&studio, "out/tiny.preview/tiny.sheet.png");
    assert_eq!(sheet.dimensions(), (32, 18));
    let second = picture(&studio, "out/tiny.preview/tiny.0002.png");
    assert!(second.pixels().any(|pixel| pixel.0 != [0; 3]), "something is seen");
    assert_eq!(image::imageops::crop_imm(&sheet, 16, 0, 16, 9).to_image(), second);
}

#[test]
fn the_name_says_what_is_made() {
    let studio = Studio::new();
    studio.succeed("preview tiny.ron --frames 1-2 --size 16x9 --out a/x.##.png");
    assert_eq!(studio.names("a"), ["x.01.png", "x.02.png"]);
    studio.succeed("preview tiny.ron --frames 1-2 --size 16x9 --out sheet.png");
    assert_eq!(picture(&studio, "sheet.png").dimensions(), (32, 9));
    studio.succeed("preview tiny.ron --frames 2 --size 16x9 --out one.png");
    assert_eq!(picture(&studio, "one.png"), picture(&studio, "a/x.02.png"));
    studio.succeed("preview tiny.ron --frames 1-2 --size 16x9 --out a.apng --threads 1");
    // The picture that viewers without animation show is the first.
    assert_eq!(picture(&studio, "a.apng"), picture(&studio, "a/x.01.png"));
    studio.succeed("preview tiny.ron --frames 1-2 --size 16x9 --out a.webp --threads 1");
    let file = Cursor::new(studio.bytes("a.webp"));
    let frames = WebPDecoder::new(file).unwrap().into_frames().collect_frames().unwrap();
    assert_eq!(frames.len(), 2);
    for (frame, name) in frames.into_iter().zip(["a/x.01.png", "a/x.02.png"]) {
        assert_eq!(DynamicImage::from(frame.into_buffer()).to_rgb8(), picture(&studio, name));
    }
}

/// 23.976 is near several rates: the one that is meant has to be written as it is.
#[test]
fn rates_of_film_are_fractions() {
    let studio = Studio::new();
    for command in ["preview", "render"] {
        let refused = studio.fail(&format!("{command} tiny.ron --frames 1-2 --size 16x9 --fps 23.976"), 2);
        assert!(refused.contains("--fps") && refused.contains("24000/1001"), "{refused}");
    }
    assert_eq!(studio.names("out"), [""; 0]);
    studio.succeed("preview tiny.ron --frames 1-2 --size 16x9 --fps 24000/1001 --out a.apng");
    let file = png::Decoder::new(Cursor::new(studio.bytes("a.apng"))).read_info().unwrap();
    let control = file.info().frame_control.unwrap();
    assert_eq!((control.delay_num, control.delay_den), (1001, 24000));
}

#[test]
fn frames_that_are_there_are_shown_as_they_are() {
    let studio = Studio::new();
    studio.succeed("render tiny.ron --frames 1-2 --size 16x9 --samples 1 --out a/ --preview png");
    studio.succeed("preview a --frames 2 --out b/x.####.png");
    assert_eq!(studio.names("b"), ["x.0002.png"]);
    assert_eq!(picture(&studio, "b/x.0002.png"), picture(&studio, "a/tiny.0002.png"));
    studio.succeed("preview a/tiny.0002.exr --out alone.png");
    assert_eq!(picture(&studio, "alone.png"), picture(&studio, "a/tiny.0002.png"));
    assert!(studio.fail("preview gone.exr", 4).contains("gone.exr"));
    studio.succeed("render tiny.ron --frames 1 --size 16x9 --samples 1 --out c/other.####.exr");
    std::fs::copy(studio.path("a/tiny.0001.exr"), studio.path("c/tiny.0001.exr")).unwrap();
    let refused = studio.fail("preview c --out c.apng", 4);
    assert!(refused.contains("other.0001.exr") && refused.contains("are both frame 1"), "{refused}");
    studio.succeed("preview c/tiny.####.exr --out one.png");
    assert_eq!(picture(&studio, "one.png"), picture(&studio, "a/tiny.0001.png"));
    let lacking = studio.run("diff c/tiny.%04d.exr a/tiny.####.exr --max-error 0");
    assert!(
        lacking.out.contains("frame 1: RGB") && lacking.out.contains("frame 2: c/tiny"),
        "{}",
        lacking.out
    );
    let refused = studio.fail("diff a a --picture both.png", 2);
    assert!(refused.contains("--picture both.####.png"), "{refused}");
    let refused = studio.fail("diff a a --picture both.####.jpg", 2);
    assert!(refused.contains("--picture") && !refused.contains("--out"), "{refused}");
    std::fs::write(studio.path("taken"), "").unwrap();
    studio.fail("diff a a --picture taken/both.####.png", 4);
    studio.succeed("preview a --out both.apng --fps 12");
    let refused = studio.fail("preview tiny.ron --frames 1 --size 16385x1 --out wide.webp", 4);
    assert!(refused.contains("16384") && refused.contains("remedy"), "{refused}");
    studio.succeed("preview a --size 50% --out small.png");
    assert_eq!(picture(&studio, "small.png").dimensions(), (16, 5));
    assert!(studio.fail("preview a --camera low", 2).contains("--camera"));
    assert!(studio.fail("preview b", 2).contains("remedy"));
}

/// What a lens scatters makes edges half as high, but for what stays close by, and the frame beside it
/// knows nothing of it.
#[test]
fn bloom_is_in_pictures_for_eyes_alone() {
    let studio = Studio::new();
    let render =
        "render tiny.ron --frames 1 --size 512x288 --samples 1 --bounces 0 --preview png --display raw";
    studio.succeed(&format!("{render} --out a/"));
    studio.succeed(&format!("{render} --out b/ --bloom 0.5"));
    assert_eq!(studio.frame("a/tiny.0001.exr").frame, studio.frame("b/tiny.0001.exr").frame);
    // By how much neighbours differ.
    let sharpness = |name: &str| {
        let picture = picture(&studio, name);
        let green = |x, y| f64::from(picture.get_pixel(x, y).0[1]);
        let places = (1..512).flat_map(|x| (0..288).map(move |y| (x, y)));
        places.map(|(x, y)| (green(x, y) - green(x - 1, y)).powi(2)).sum::<f64>()
    };
    let [sharp, soft] = ["a/tiny.0001.png", "b/tiny.0001.png"].map(sharpness);
    assert!((0.25..0.5).contains(&(soft / sharp)), "{soft} {sharp}");
    // By itself it scatters what is beyond white, of which this frame has nothing.
    for (bloom, folder) in [("0", "c/"), ("auto", "d/")] {
        let render = render.replace("raw", "agx");
        studio.succeed(&format!("{render} --out {folder} --bloom {bloom}"));
    }
    let [clean, by_itself] = ["c/tiny.0001.png", "d/tiny.0001.png"].map(|name| picture(&studio, name));
    assert_eq!(clean, by_itself);
    let refused = studio.fail("preview a/ --bloom 1.5", 2);
    assert!(refused.contains("--bloom") && refused.contains("from 0 to 1"), "{refused}");
}
