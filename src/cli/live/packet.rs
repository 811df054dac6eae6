//! The packets of the viewer tev. In go frames, out come bytes. Invariant: a packet begins
//! with its own length.
//!
//! A packet is what `IpcPacket` of github.com/Tom94/tev has (`include/tev/Ipc.h`, `src/Ipc.cpp`). It begins
//! with a length in bytes (`u32`, itself included) and a kind (`i8`). Then come fields in order: numbers
//! little-endian, truths as a byte, texts ended by a zero byte.

use sunfleck::film::{Channel, Frame};

/// Makes an image, all black.
const CREATE_IMAGE: u8 = 4;
/// Third form of the packet that changes some of an image's pixels: with an offset and a
/// stride for each channel.
const UPDATE_IMAGE: u8 = 6;

/// Values a packet, at most about: the viewer takes a packet as a whole.
const VALUES: usize = 1 << 20;

/// The image that a frame is to be shown as.
pub(super) fn create_image(name: &str, frame: &Frame) -> Vec<u8> {
    let mut packet = Packet::new(CREATE_IMAGE);
    packet.truth(true);
    packet.text(name);
    packet.number(frame.full.width);
    packet.number(frame.full.height);
    packet.names(&shown(frame));
    packet.finish()
}

/// All pixels of a frame, some rows a packet.
pub(super) fn updates(name: &str, frame: &Frame) -> Vec<Vec<u8>> {
    let channels = shown(frame);
    let window = frame.window;
    let rows = (VALUES / (window.width * channels.len()).max(1)).max(1);
    let parts = (0..window.height).step_by(rows).map(|first| {
        let rows = rows.min(window.height - first);
        let mut packet = Packet::new(UPDATE_IMAGE);
        packet.truth(false);
        packet.text(name);
        packet.names(&channels);
        for number in [window.x, window.y + first, window.width, rows] {
            packet.number(number);
        }
        // Channel by channel: where each begins, and how far its values are apart.
        let pixels = window.width * rows;
        for channel in 0..channels.len() {
            packet.0.extend(((channel * pixels) as i64).to_le_bytes());
        }
        for _ in &channels {
            packet.0.extend(1_i64.to_le_bytes());
        }
        for channel in &channels {
            let values = &channel.pixels[first * window.width..][..pixels];
            packet.0.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        }
        packet.finish()
    });
    parts.collect()
}

/// The channels that the viewer gets.
fn shown(frame: &Frame) -> Vec<&Channel> {
    ["R", "G", "B", "A"].iter().filter_map(|name| frame.channel(name)).collect()
}

struct Packet(Vec<u8>);

impl Packet {
    fn new(kind: u8) -> Self {
        Self(vec![0, 0, 0, 0, kind])
    }

    fn truth(&mut self, truth: bool) {
        self.0.push(u8::from(truth));
    }

    fn text(&mut self, text: &str) {
        self.0.extend(text.bytes().filter(|byte| *byte != 0));
        self.0.push(0);
    }

    fn number(&mut self, number: usize) {
        self.0.extend((number as i32).to_le_bytes());
    }

    fn names(&mut self, channels: &[&Channel]) {
        self.number(channels.len());
        for channel in channels {
            self.text(&channel.name);
        }
    }

    fn finish(mut self) -> Vec<u8> {
        let length = self.0.len() as u32;
        self.0[..4].copy_from_slice(&length.to_le_bytes());
        self.0
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use std::io::Read;
    use std::net::{TcpListener, TcpStream};
    use sunfleck::film::Precision;
    use sunfleck::scene::{Size, Window};
    use tev_client::{PacketCreateImage, PacketUpdateImage, TevClient};

    /// Bytes that somebody else's client sends.
    fn sent(send: impl FnOnce(&mut TevClient)) -> Vec<u8> {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let mut client = TevClient::wrap(TcpStream::connect(listener.local_addr().unwrap()).unwrap());
        send(&mut client);
        drop(client);
        let mut bytes = Vec::new();
        listener.accept().unwrap().0.read_to_end(&mut bytes).unwrap();
        bytes
    }

    /// A part of a picture, whose passes are not shown.
    fn frame() -> Frame {
        let names = ["R", "G", "B", "A", "Z"].into_iter().zip(0_u8..);
        let channels = names.map(|(name, number)| {
            let values = (0..12).map(|place| f32::from(number) + 0.25 * place as f32).collect();
            Channel::new(name, Precision::Float, values)
        });
        let window = Window { x: 3, y: 2, width: 4, height: 3 };
        Frame { full: Size { width: 9, height: 7 }, window, channels: channels.collect() }
    }

    #[test]
    fn packets_are_the_bytes_of_another_client() {
        let (frame, names) = (frame(), ["R", "G", "B", "A"]);
        let created = sent(|client| {
            let packet = PacketCreateImage {
                image_name: "leaves.0001",
                grab_focus: true,
                width: 9,
                height: 7,
                channel_names: &names,
            };
            client.send(packet).unwrap();
        });
        assert_eq!(create_image("leaves.0001", &frame), created);
        let data: Vec<f32> = frame.channels[..4].iter().flat_map(|channel| channel.pixels.clone()).collect();
        let updated = sent(|client| {
            let packet = PacketUpdateImage {
                image_name: "leaves.0001",
                grab_focus: false,
                channel_names: &names,
                channel_offsets: &[0, 12, 24, 36],
                channel_strides: &[1; 4],
                x: 3,
                y: 2,
                width: 4,
                height: 3,
                data: &data,
            };
            client.send(packet).unwrap();
        });
        assert_eq!(updates("leaves.0001", &frame), [updated]);
    }
}
