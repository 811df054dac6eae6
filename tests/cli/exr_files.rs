//! EXR files of other programs: their colours, codecs, parts and windows. In go files made here; see each
//! test for what is right.

use crate::program::Studio;
use exr::image::write::WritableImage;
use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, Layers};
use exr::math::Vec2;
use exr::meta::attribute::{AttributeValue, Chromaticities, IntegerBounds, Text};
use exr::meta::header::{ImageAttributes, LayerAttributes};
use std::path::Path;

const INPUT_OUTPUT: i32 = 4;
const SCENE: i32 = 3;

/// Of (0.2, 0.5, 0.1) by OpenColorIO 2.6 with its built-in `studio-config-latest`.
const IN_REC_709: [(&str, [f32; 3]); 7] = [
    ("lin_rec709_scene", [0.2, 0.5, 0.1]),
    ("lin_ap1_scene", [0.02179, 0.54330, 0.04601]),
    ("lin_ap0_scene", [-0.10148, 0.62144, 0.03727]),
    ("lin_rec2020_scene", [0.03099, 0.54070, 0.05795]),
    ("lin_p3d65_scene", [0.13252, 0.51262, 0.06658]),
    ("srgb_rec709_scene", [0.03310, 0.21404, 0.01002]),
    ("g22_rec709_scene", [0.02899, 0.21764, 0.00631]),
];

const AP0: Chromaticities = Chromaticities {
    red: Vec2(0.7347, 0.2653),
    green: Vec2(0.0, 1.0),
    blue: Vec2(0.0001, -0.077),
    white: Vec2(0.32168, 0.33767),
};

/// A file to be written.
struct Made {
    display: (usize, usize),
    corner: Vec2<i32>,
    size: (usize, usize),
    /// Name of a part, and its channels with one value each.
    parts: Vec<(&'static str, Vec<(&'static str, f32)>)>,
    id: Option<&'static str>,
    chromaticities: Option<Chromaticities>,
    pixel_aspect: f32,
}

const COLOR: [(&str, f32); 3] = [("R", 0.2), ("G", 0.5), ("B", 0.1)];

impl Made {
    fn new() -> Self {
        let parts = vec![("", COLOR.to_vec())];
        let (display, size, corner) = ((32, 16), (32, 16), Vec2(0, 0));
        Self { display, corner, size, parts, id: None, chromaticities: None, pixel_aspect: 1.0 }
    }

    fn of_space(id: &'static str) -> Self {
        Self { id: Some(id), ..Self::new() }
    }

    fn of(parts: Vec<(&'static str, Vec<(&'static str, f32)>)>) -> Self {
        Self { parts, ..Self::new() }
    }

    fn write(&self, path: &Path) {
        let text = |text: &str| Text::new_or_none(text).unwrap();
        let pixels = self.size.0 * self.size.1;
        let layers: Layers<_> = self
            .parts
            .iter()
            .map(|(name, channels)| {
                let channel = |(name, value): &(&str, f32)| {
                    AnyChannel::new(text(name), FlatSamples::F32(vec![*value; pixels]))
                };
                let mut attributes =
                    LayerAttributes { layer_position: self.corner, ..LayerAttributes::default() };
                attributes.layer_name = (!name.is_empty()).then(|| text(name));
                if let Some(id) = self.id {
                    attributes.other.insert(text("colorInteropID"), AttributeValue::Text(text(id)));
                }
                let channels = AnyChannels::sort(channels.iter().map(channel).collect());
                Layer::new(self.size, attributes, Encoding::FAST_LOSSLESS, channels)
            })
            .collect();
        let mut attributes = ImageAttributes::new(IntegerBounds::from_dimensions(self.display));
        attributes.chromaticities = self.chromaticities;
        attributes.pixel_aspect = self.pixel_aspect;
        let image = Image { attributes, layer_data: layers };
        image.write().non_parallel().to_file(path).unwrap();
    }
}

/// A scene that is nothing but a sky with this picture; its flags for one small frame.
fn sky(studio: &Studio, made: &Made) -> &'static str {
    made.write(&studio.path("sky.exr"));
    std::fs::write(
        studio.path("sky.ron"),
        r#"Scene(version: 1, meshes: {}, objects: {}, sky: Image(image: "sky.exr"),
            cameras: {"main": (position_m: (0.0, 0.0, 4.0), look_at_m: (0.0, 0.0, 0.0), fov_deg: 34.0)})"#,
    )
    .unwrap();
    "render sky.ron --size 8x4 --samples 1 --out out.exr"
}

/// Red, green and blue in the middle of a frame.
fn color(studio: &Studio, name: &str) -> [f32; 3] {
    let frame = studio.frame(name).frame;
    ["R", "G", "B"].map(|name| {
        let pixels = &frame.channel(name).unwrap().pixels;
        pixels[pixels.len() / 2]
    })
}

fn assert_near(found: [f32; 3], expected: [f32; 3], what: &str) {
    let is_near =
        found.iter().zip(&expected).all(|(found, expected)| (found - expected.max(0.0)).abs() < 6e-4);
    assert!(is_near, "{what}: {found:?} for {expected:?}");
}

/// Changes the number of a file's compression, its pixels as they are.
fn recompress(path: &Path, number: u8) {
    let mut bytes = std::fs::read(path).unwrap();
    let name = b"compression\0compression\0\x01\0\0\0";
    let at = bytes.windows(name.len()).position(|window| window == name).unwrap() + name.len();
    bytes[at] = number;
    std::fs::write(path, bytes).unwrap();
}

/// Frames of an anamorphic lens: what is twice as wide as high is stored as a square.
#[test]
fn pixels_that_are_not_square_are_shown_square() {
    let studio = Studio::new();
    for (pixel_aspect, flags, expected) in
        [(2.0, "", (64, 16)), (0.5, "", (32, 32)), (2.0, " --size 50%", (32, 8)), (1e5, "", (32, 16))]
    {
        Made { pixel_aspect, ..Made::new() }.write(&studio.path("squeezed.exr"));
        studio.succeed(&format!("preview squeezed.exr{flags} --out squeezed.png"));
        let shown = image::open(studio.path("squeezed.png")).unwrap();
        assert_eq!((shown.width(), shown.height()), expected, "pixels of {pixel_aspect}");
        assert!(shown.to_rgb8().pixels().all(|pixel| pixel[1] > 99), "pixels of {pixel_aspect}");
    }
}

#[test]
fn skies_are_in_the_colors_that_they_name() {
    let studio = Studio::new();
    for (id, expected) in IN_REC_709 {
        let told = studio.succeed(sky(&studio, &Made::of_space(id))).err;
        assert_near(color(&studio, "out.exr"), expected, id);
        assert!(!told.contains("color-space"), "{told}");
    }
    // By chromaticities alone, as the program itself wrote until 2026.
    let by_chromaticities = Made { chromaticities: Some(AP0), ..Made::new() };
    studio.succeed(sky(&studio, &by_chromaticities));
    assert_near(color(&studio, "out.exr"), IN_REC_709[2].1, "AP0");
}

#[test]
fn doubts_about_colors_are_told_once_by_their_ids() {
    let studio = Studio::new();
    for (id, chromaticities, loss, expected) in [
        ("lin_ap1_scene", Some(AP0), "color-space-conflict", IN_REC_709[1].1),
        ("data", None, "color-space-data", IN_REC_709[0].1),
        ("ocio:acescct_ap1_scene", None, "color-space-unknown", IN_REC_709[0].1),
        ("ocio:acescct_ap1_scene", Some(AP0), "color-space-unknown", IN_REC_709[2].1),
        ("unknown", None, "color-space-unknown", IN_REC_709[0].1),
    ] {
        let line = sky(&studio, &Made { chromaticities, ..Made::of_space(id) });
        let told = studio.succeed(line).err;
        assert_eq!(told.matches(&format!("warning[{loss}]: ")).count(), 1, "{id}: {told}");
        assert_near(color(&studio, "out.exr"), expected, id);
        let refused = studio.fail(&format!("{line} --strict"), SCENE);
        assert!(refused.contains(&format!("error[{loss}]: ")), "{refused}");
    }
}

#[test]
fn frames_say_their_colors_in_both_ways() {
    let studio = Studio::new();
    studio.succeed("render tiny.ron --frames 1 --out a.exr");
    let attributes = studio.frame("a.exr").attributes;
    assert_eq!(attributes.get("colorInteropID"), Some("lin_rec709_scene"));
    assert_eq!(attributes.get("chromaticities"), Some("0.64 0.33 0.3 0.6 0.15 0.06 0.3127 0.329"));
}

#[test]
fn pictures_of_other_spaces_are_compared_and_shown_as_colors() {
    let studio = Studio::new();
    std::fs::create_dir(studio.path("frames")).unwrap();
    Made::of_space("lin_ap1_scene").write(&studio.path("frames/f.0001.exr"));
    let same: Vec<(&str, f32)> = ["R", "G", "B"].into_iter().zip(IN_REC_709[1].1).collect();
    Made { id: Some("lin_rec709_scene"), ..Made::of(vec![("", same)]) }.write(&studio.path("same.exr"));
    let outcome = studio.succeed("diff frames/f.0001.exr same.exr --max-error 2e-4");
    assert!(outcome.err.contains("in different colour spaces, lin_ap1_scene of"), "{}", outcome.err);
    assert!(!studio.succeed("diff frames/f.0001.exr frames/f.0001.exr --max-error 0").err.contains("space"));
    studio.succeed("preview frames --display raw --exposure 0 --out shown.png");
    let shown = image::open(studio.path("shown.png")).unwrap().to_rgb8();
    let expected = IN_REC_709[1].1.map(|light| (255.0 * light) as i32);
    let found = shown.get_pixel(9, 9).0.map(i32::from);
    assert!(found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() <= 1), "{found:?}");
}

#[test]
fn codecs_that_are_not_read_are_called_by_their_names() {
    let studio = Studio::new();
    for (number, name) in [(10, "htj2k256"), (11, "htj2k32"), (12, "lj2k"), (13, "zstd"), (99, "number 99")] {
        let line = sky(&studio, &Made::new());
        std::fs::create_dir_all(studio.path("frames")).unwrap();
        for path in ["sky.exr", "frames/f.0001.exr"] {
            Made::new().write(&studio.path(path));
            recompress(&studio.path(path), number);
        }
        for (line, code) in [
            (line, SCENE),
            ("diff sky.exr sky.exr", INPUT_OUTPUT),
            ("preview frames --out p.png", INPUT_OUTPUT),
        ] {
            let said = studio.fail(line, code);
            assert!(
                said.contains(name) && said.contains("oiiotool IN.exr -a --compression zip"),
                "{line}: {said}"
            );
            assert!(!said.contains("no whole EXR") && !said.contains("copy"), "{line}: {said}");
        }
    }
}

#[test]
fn deep_files_and_cubes_are_refused_in_true_words() {
    let studio = Studio::new();
    let line = sky(&studio, &Made::new());
    let mut bytes = studio.bytes("sky.exr");
    bytes[5] |= 0x08;
    std::fs::write(studio.path("sky.exr"), &bytes).unwrap();
    let said = studio.fail(line, SCENE);
    assert!(said.contains("deep data") && said.contains("--flatten"), "{said}");
    // `diff` would flatten it, if there were any.
    let said = studio.fail("diff sky.exr sky.exr", INPUT_OUTPUT);
    assert!(said.contains("is no whole EXR file"), "{said}");
    Made::new().write(&studio.path("sky.exr"));
    let mut bytes = studio.bytes("sky.exr");
    bytes.splice(8..8, *b"envmap\0envmap\0\x01\0\0\0\x01");
    std::fs::write(studio.path("sky.exr"), &bytes).unwrap();
    let said = studio.fail(line, SCENE);
    assert!(said.contains("six sides of a cube") && said.contains("exrenvmap -latlong"), "{said}");
}

#[test]
fn the_picture_is_the_beauty_in_any_order_of_parts_and_layers() {
    let studio = Studio::new();
    let normal = vec![("R", -0.5), ("G", 0.5), ("B", 1.0)];
    let layered = vec![
        ("N.R", -0.5),
        ("N.G", 0.5),
        ("N.B", 1.0),
        ("v.Combined.R", 0.2),
        ("v.Combined.G", 0.5),
        ("v.Combined.B", 0.1),
    ];
    let white = vec![("R", 0.9), ("G", 0.9), ("B", 0.9)];
    for made in [
        Made::of(vec![("N", normal.clone()), ("albedo", white.clone()), ("C", COLOR.to_vec())]),
        Made::of(vec![("rgba", COLOR.to_vec()), ("N", normal)]),
        Made::of(vec![("depth", vec![("Z", 3.0)]), ("beauty", COLOR.to_vec()), ("albedo", white)]),
        Made::of(vec![("", layered)]),
    ] {
        studio.succeed(sky(&studio, &made));
        assert_near(color(&studio, "out.exr"), IN_REC_709[0].1, made.parts[0].0);
    }
    studio.succeed(sky(&studio, &Made::of(vec![("", vec![("Y", 0.3)])])));
    assert_near(color(&studio, "out.exr"), [0.3; 3], "Y");
    let refused = studio.fail(sky(&studio, &Made::of(vec![("", vec![("Z", 0.3)])])), SCENE);
    assert!(refused.contains("only Z") && refused.contains("as R, G and B"), "{refused}");
}

/// Channels of equal names in several parts are told apart.
#[test]
fn parts_lend_channels_their_names() {
    let studio = Studio::new();
    let part = |value| vec![("R", value), ("G", value), ("B", value)];
    Made::of(vec![("N", part(1.0)), ("C", part(2.0))]).write(&studio.path("a.exr"));
    let table = studio.succeed("diff a.exr a.exr").out;
    let names: Vec<&str> = table.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert_eq!(names, ["RGB", "N.B", "N.G", "N.R", "B", "G", "R"]);
}

#[test]
fn previews_show_the_display_window() {
    let studio = Studio::new();
    std::fs::create_dir(studio.path("frames")).unwrap();
    for (frame, corner) in [Vec2(3, 2), Vec2(-2, 10), Vec2(60, 60)].into_iter().enumerate() {
        let made = Made { corner, size: (8, 8), ..Made::new() };
        made.write(&studio.path(&format!("frames/f.{:04}.exr", frame + 1)));
    }
    studio.succeed("preview frames --display raw --exposure 0 --out p.####.png");
    let lit = |frame: usize| {
        let shown = image::open(studio.path(&format!("p.{frame:04}.png"))).unwrap().to_rgb8();
        assert_eq!(shown.dimensions(), (32, 16));
        shown
            .enumerate_pixels()
            .filter(|(.., pixel)| pixel.0[1] > 100)
            .map(|(x, y, _)| (x, y))
            .collect::<Vec<_>>()
    };
    assert_eq!((lit(1).len(), lit(1)[0]), (64, (3, 2)));
    assert_eq!((lit(2).len(), lit(2)[0]), (36, (0, 10)));
    assert_eq!(lit(3), []);
    // What lies outside of it is compared all the same.
    let same = studio.succeed("diff frames/f.0003.exr frames/f.0003.exr --max-error 0").out;
    assert!(same.contains("RMSE 0.000000"), "{same}");
}

#[test]
fn equality_can_be_asked_for_and_black_has_no_ratio() {
    let studio = Studio::new();
    for (name, value) in [("black.exr", 0.0), ("grey.exr", 1e-4)] {
        Made::of(vec![("", vec![("R", value), ("G", value), ("B", value)])]).write(&studio.path(name));
    }
    let same = studio.succeed("diff black.exr black.exr --max-error 0 --max-rmse 0 --max-relmse 0").out;
    assert!(!same.contains("NaN") && !same.contains("ratio"), "{same}");
    assert!(studio.fail("diff grey.exr black.exr --max-error 0", 5).contains("too far from"));
    assert!(!studio.run("diff grey.exr black.exr").out.contains("inf"));
    studio.fail("diff black.exr black.exr --max-error -1", 2);
}

/// Luminance with chroma of half its size each way, as it is stored without compression.
#[test]
fn luminance_and_chroma_are_read_as_colors() {
    let studio = Studio::new();
    let attribute = |name: &str, kind: &str, value: &[u8]| {
        let size = u32::try_from(value.len()).unwrap().to_le_bytes();
        [name.as_bytes(), b"\0", kind.as_bytes(), b"\0", &size, value].concat()
    };
    let numbers =
        |numbers: &[i32]| numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>();
    let channel = |name: &str, step: i32| [name.as_bytes(), b"\0", &numbers(&[2, 0, step, step])].concat();
    let list = [channel("BY", 2), channel("RY", 2), channel("Y", 1), vec![0]].concat();
    let (width, height) = (32, 16);
    let window = numbers(&[0, 0, width - 1, height - 1]);
    let mut file = [
        b"\x76\x2f\x31\x01\x02\0\0\0".to_vec(),
        attribute("channels", "chlist", &list),
        attribute("compression", "compression", &[0]),
        attribute("dataWindow", "box2i", &window),
        attribute("displayWindow", "box2i", &window),
        attribute("lineOrder", "lineOrder", &[0]),
        attribute("pixelAspectRatio", "float", &1.0_f32.to_le_bytes()),
        attribute("screenWindowCenter", "v2f", &[0; 8]),
        attribute("screenWindowWidth", "float", &1.0_f32.to_le_bytes()),
        vec![0],
    ]
    .concat();
    let [red, green, blue] = IN_REC_709[0].1;
    let luminance = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
    let row = |value: f32, count: i32| value.to_le_bytes().repeat(count as usize);
    let rows: Vec<Vec<u8>> = (0..height)
        .map(|y| {
            let chroma =
                [row(blue / luminance - 1.0, width / 2), row(red / luminance - 1.0, width / 2)].concat();
            let samples = [if y % 2 == 0 { chroma } else { Vec::new() }, row(luminance, width)].concat();
            [numbers(&[y, samples.len() as i32]), samples].concat()
        })
        .collect();
    let mut at = file.len() as u64 + 8 * height as u64;
    for row in &rows {
        file.extend(at.to_le_bytes());
        at += row.len() as u64;
    }
    file.extend(rows.concat());
    let line = sky(&studio, &Made::new());
    std::fs::create_dir(studio.path("frames")).unwrap();
    for path in ["sky.exr", "frames/f.0001.exr"] {
        std::fs::write(studio.path(path), &file).unwrap();
    }
    studio.succeed(line);
    assert_near(color(&studio, "out.exr"), IN_REC_709[0].1, "luminance and chroma");
    studio.succeed("diff sky.exr sky.exr --max-error 0");
    studio.succeed("preview frames --display raw --exposure 0 --out shown.png");
    let shown = image::open(studio.path("shown.png")).unwrap().to_rgb8().get_pixel(20, 10).0;
    assert!(
        shown[0].abs_diff(51) <= 1 && shown[1].abs_diff(127) <= 1 && shown[2].abs_diff(25) <= 1,
        "{shown:?}"
    );
    // Cut off anywhere it is refused, and nothing panics.
    for length in (0..file.len()).step_by(61) {
        std::fs::write(studio.path("sky.exr"), &file[..length]).unwrap();
        studio.fail(line, SCENE);
    }
}

/// Depth, coverage or two colours alone are shown, and which they are is said once a run.
#[test]
fn frames_without_a_picture_are_shown_by_what_they_have() {
    let studio = Studio::new();
    for (channels, seen, said) in [
        (vec![("A", 0.9), ("Z", 0.2)], [51, 51, 51], "`Z` is shown as grey, 0.2 to 0.2"),
        (vec![("A", 0.2)], [51, 51, 51], "`A` is shown as grey"),
        (vec![("R", 0.2), ("G", 0.6)], [51, 153, 0], "red, green and blue show R, G, black"),
        (vec![("N.R", 0.2), ("N.G", 0.6), ("N.B", 0.4)], [51, 153, 102], "show N.R, N.G, N.B"),
    ] {
        Made::of(vec![("", channels)]).write(&studio.path("a.0001.exr"));
        std::fs::copy(studio.path("a.0001.exr"), studio.path("a.0002.exr")).unwrap();
        let told = studio.succeed("preview . --display raw --exposure 0 --out p.####.png").err;
        assert!(told.matches("[no-picture]").count() == 1 && told.contains(said), "{told}");
        let shown = image::open(studio.path("p.0002.png")).unwrap().to_rgb8().get_pixel(3, 3).0;
        assert!(shown.iter().zip(seen).all(|(one, other)| one.abs_diff(other) <= 1), "{shown:?}");
        let told = studio.succeed("diff a.0001.exr a.0002.exr --max-error 0 --picture d.png").err;
        assert!(told.contains(said), "{told}");
        // Depth without end is no light that an exposure is for.
        studio.succeed("preview a.0001.exr --out auto.png");
    }
    assert!(!studio.succeed("diff a.0001.exr a.0002.exr --max-error 0").err.contains("no-picture"));
}

/// What no picture can show is said, once a kind.
#[test]
fn previews_say_which_pixels_they_cannot_show() {
    let studio = Studio::new();
    std::fs::create_dir(studio.path("frames")).unwrap();
    let damaged = Made::of(vec![("", vec![("R", f32::NAN), ("G", 0.5), ("B", 0.1)])]);
    let outside = Made { corner: Vec2(100, 100), ..Made::new() };
    for (number, made) in [&damaged, &damaged, &outside, &Made::new()].into_iter().enumerate() {
        made.write(&studio.path(&format!("frames/f.000{number}.exr")));
    }
    let told = studio.succeed("preview frames --out p.####.png").err;
    for word in
        ["f.0000.exr: warning: pixels are not finite", "(and 1 more)", "f.0002.exr: warning: all pixels"]
    {
        assert!(told.contains(word), "{told}");
    }
    let told = studio.succeed("preview frames/f.0003.exr --out p.png").err;
    assert!(!told.contains("warning") && told.contains("written to p.png"), "{told}");
}
