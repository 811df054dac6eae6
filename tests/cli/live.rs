//! `render --live`: packets as the viewer tev reads them (`src/Ipc.cpp` there), and viewers that go away.

use crate::program::{Studio, outcome};
use std::io::Read;
use std::net::{TcpListener, TcpStream};
use std::thread;

/// A packet's fields, read one after another.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        let (field, rest) = self.0.split_at(N);
        self.0 = rest;
        field.try_into().unwrap()
    }
    fn number(&mut self) -> i32 {
        i32::from_le_bytes(self.bytes())
    }
    fn long(&mut self) -> usize {
        i64::from_le_bytes(self.bytes()).try_into().unwrap()
    }
    fn text(&mut self) -> String {
        let end = self.0.iter().position(|&byte| byte == 0).unwrap();
        let text = String::from_utf8(self.0[..end].to_vec()).unwrap();
        self.0 = &self.0[end + 1..];
        text
    }
}

/// What the viewer shows in the end.
#[derive(Default)]
struct Image {
    name: String,
    size: [i32; 2],
    /// R, G, B and A.
    channels: Vec<Vec<f32>>,
    updates: usize,
}

fn show(stream: &[u8]) -> Vec<Image> {
    let mut images: Vec<Image> = Vec::new();
    let mut rest = stream;
    while !rest.is_empty() {
        let length = u32::from_le_bytes(rest[..4].try_into().unwrap()) as usize;
        let (packet, behind) = rest.split_at(length);
        rest = behind;
        let mut fields = Fields(&packet[4..]);
        let [kind, _grab_focus] = fields.bytes();
        let name = fields.text();
        match kind {
            4 => {
                let size = [fields.number(), fields.number()];
                let names: Vec<String> = (0..fields.number()).map(|_| fields.text()).collect();
                assert_eq!(names, ["R", "G", "B", "A"]);
                let channels = vec![vec![f32::NAN; (size[0] * size[1]) as usize]; 4];
                images.push(Image { name, size, channels, updates: 0 });
            }
            6 => {
                let image = images.last_mut().unwrap();
                assert_eq!(name, image.name);
                image.updates += 1;
                let count = fields.number();
                for expected in ["R", "G", "B", "A"] {
                    assert_eq!(fields.text(), expected);
                }
                let [x, y, width, height] = [0; 4].map(|_| fields.number());
                assert!(x >= 0 && y >= 0 && x + width <= image.size[0] && y + height <= image.size[1]);
                let offsets: Vec<usize> = (0..count).map(|_| fields.long()).collect();
                let strides: Vec<usize> = (0..count).map(|_| fields.long()).collect();
                let values: Vec<f32> = fields
                    .0
                    .chunks_exact(4)
                    .map(|value| f32::from_le_bytes(value.try_into().unwrap()))
                    .collect();
                let pixels = (width * height) as usize;
                assert_eq!(
                    values.len(),
                    offsets[3] + (pixels - 1) * strides[3] + 1,
                    "not a value more or less"
                );
                for (channel, into) in image.channels.iter_mut().enumerate() {
                    for pixel in 0..pixels {
                        let (column, row) = (pixel as i32 % width, pixel as i32 / width);
                        into[((y + row) * image.size[0] + x + column) as usize] =
                            values[offsets[channel] + pixel * strides[channel]];
                    }
                }
            }
            other => panic!("a packet of kind {other}"),
        }
    }
    images
}

#[test]
fn a_viewer_sees_frames_as_they_become() {
    let studio = Studio::new();
    let viewer = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = viewer.local_addr().unwrap();
    let seen = thread::spawn(move || {
        let mut stream = Vec::new();
        viewer.accept().unwrap().0.read_to_end(&mut stream).unwrap();
        show(&stream)
    });
    studio.succeed(&format!(
        "render tiny.ron --frames 1-2 --tolerance 0.01 --samples 16 --out a/ --live {address}"
    ));
    studio.succeed("render tiny.ron --frames 1-2 --tolerance 0.01 --samples 16 --out b/");
    let images = seen.join().unwrap();
    let last = images.last().unwrap();
    assert!(last.name.ends_with("tiny.0002.exr") && last.updates > 0, "{}", last.name);
    let frame = studio.frame("a/tiny.0002.exr").frame;
    assert_eq!(last.size, [frame.full.width as i32, frame.full.height as i32]);
    for (name, shown) in ["R", "G", "B", "A"].into_iter().zip(&last.channels) {
        let channel = frame.channel(name).unwrap();
        let stored: Vec<f32> = shown.iter().map(|&value| channel.precision.stored(value)).collect();
        assert_eq!(stored, channel.pixels, "{name}: the last look is the frame");
    }
    for name in ["tiny.0001.exr", "tiny.0002.exr"] {
        assert_eq!(
            studio.bytes(&format!("a/{name}")),
            studio.bytes(&format!("b/{name}")),
            "looking on changes nothing"
        );
    }
}

#[test]
fn frames_do_not_need_the_viewer() {
    let studio = Studio::new();
    // A place where nobody listens, and no other run can: the other end of a connection.
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let other_end = TcpStream::connect(taken.local_addr().unwrap()).unwrap();
    let address = other_end.local_addr().unwrap();
    let outcome = studio
        .succeed(&format!("render tiny.ron --frames 1 --size 8x4 --samples 1 --out a/ --live {address}"));
    assert!(outcome.err.contains("warning: --live") && outcome.err.contains("remedy"), "{}", outcome.err);
    // One that hangs up at once.
    let viewer = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = viewer.local_addr().unwrap();
    let gone = thread::spawn(move || drop(viewer.accept().unwrap()));
    studio.succeed(&format!("render tiny.ron --frames 1-3 --samples 1 --out b/ --live {address}"));
    gone.join().unwrap();
    assert_eq!(studio.names("b").len(), 3);
}

#[test]
fn what_is_no_address_is_refused_before_anything_is_rendered() {
    let studio = Studio::new();
    for address in ["", "no host at all", "127.0.0.1:99999", "[::1"] {
        let mut command = studio.command("render tiny.ron --frames 1 --out refused/ --live");
        let outcome = outcome(command.arg(address).output().unwrap());
        assert_eq!(outcome.code, 2, "{address}: {}", outcome.err);
        assert!(
            outcome.err.contains("--live") && outcome.err.contains("remedy"),
            "{address}: {}",
            outcome.err
        );
        assert!(!studio.path("refused").exists());
    }
}
