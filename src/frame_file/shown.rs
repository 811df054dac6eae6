//! A file's picture as eyes are to see it. In goes a file, out come red, green and blue in linear Rec. 709.
//! Invariant: of a file of ours nothing changes.

use super::FrameFile;
use crate::color::{ColorSpace, Rgb};
use crate::description::exr::{Picture, from_chroma};
use crate::film::{Channel, Frame, Precision};
use crate::scene::Window;

/// Times the data's pixels, or pixels, that a display window has at most to be shown: as many as a picture
/// of 8K has.
const MOST_EMPTY: usize = 64;
const LARGEST_EMPTY: usize = 1 << 25;
/// Prefix of the names of our own attributes.
const OWN: &str = "sunfleck:";

impl FrameFile {
    /// The picture, in its display window. Of our own frames, whose window is a crop, in that; so too where
    /// the display window is out of all proportion. A file without colours stays as it is.
    pub fn shown(self) -> Frame {
        let names: Vec<&str> = self.frame.channels.iter().map(|channel| channel.name.as_str()).collect();
        let Some(picture) = Picture::among(&names) else { return self.frame };
        let is_own = self.attributes.0.keys().any(|name| name.starts_with(OWN));
        let Frame { full, window, .. } = self.frame;
        let mut frame = Frame { full, window, channels: self.colors_in_ours(picture) };
        let most = (MOST_EMPTY * window.width * window.height).max(LARGEST_EMPTY);
        if !is_own && full.width.saturating_mul(full.height) <= most {
            frame = whole(&frame);
        }
        frame
    }

    /// Red, green and blue in linear Rec. 709, the others as they are: what two files of different colours
    /// can be compared by.
    pub fn convert_colors(&mut self) {
        let names: Vec<&str> = self.frame.channels.iter().map(|channel| channel.name.as_str()).collect();
        let Some(Picture::Colors(places)) = Picture::among(&names) else { return };
        for (channel, place) in self.colors_in_ours(Picture::Colors(places)).into_iter().zip(places) {
            self.frame.channels[place].pixels = channel.pixels;
        }
        self.colors.space = ColorSpace::OURS;
    }

    fn colors_in_ours(&self, picture: Picture) -> Vec<Channel> {
        let channels = &self.frame.channels;
        let (places, weights) = (
            match picture {
                Picture::Colors(places) | Picture::Chroma(places) => places,
                Picture::Luminance(place) => [place; 3],
            },
            self.colors.space.luminances(),
        );
        let precision = channels[places[0]].precision;
        let is_stored = matches!(picture, Picture::Colors(_) | Picture::Luminance(_));
        if is_stored && self.colors.space.is_same(&ColorSpace::OURS) {
            let named =
                |(name, place): (&str, usize)| Channel { name: name.to_owned(), ..channels[place].clone() };
            return ["R", "G", "B"].into_iter().zip(places).map(named).collect();
        }
        let mut planes: [Vec<f32>; 3] = places.map(|place| channels[place].pixels.clone());
        for pixel in 0..planes[0].len() {
            let color: [f32; 3] = std::array::from_fn(|plane| planes[plane][pixel]);
            let color = if is_stored { color } else { from_chroma(color, weights) };
            let color = self.colors.space.to_rec_709(Rgb::from(color.map(f64::from))).as_vec3().to_array();
            (0..3).for_each(|plane| planes[plane][pixel] = color[plane]);
        }
        let precision = if is_stored { precision } else { Precision::Float };
        let named = |(name, pixels): (&str, Vec<f32>)| Channel { name: name.to_owned(), precision, pixels };
        ["R", "G", "B"].into_iter().zip(planes).map(named).collect()
    }
}

/// Black where there are no pixels.
fn whole(frame: &Frame) -> Frame {
    let window = Window::whole(frame.full);
    if frame.window == window {
        return frame.clone();
    }
    let channel = |channel: &Channel| {
        let value = |(x, y)| frame.window.index(x, y).map_or(0.0, |index| channel.pixels[index]);
        Channel { pixels: window.pixels().map(value).collect(), ..channel.clone() }
    };
    Frame { full: frame.full, window, channels: frame.channels.iter().map(channel).collect() }
}
