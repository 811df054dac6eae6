//! Picture of a file for viewing. In goes a file, out come red, green and blue in linear Rec. 709. Invariant:
//! files of this program are unchanged; any other file shows something.

use super::FrameFile;
use crate::color::{ColorSpace, Rgb};
use crate::description::exr::{Picture, from_chroma, stand_in};
use crate::film::{Channel, Frame, Precision};
use crate::scene::Window;

/// Maximum size of a display window to show: this many times the data window's pixels, or the pixels of an 8K
/// picture.
const MOST_EMPTY: usize = 64;
const LARGEST_EMPTY: usize = 1 << 25;
/// Prefix of this program's attributes.
const OWN: &str = "sunfleck:";

impl FrameFile {
    /// Picture in its display window. Crops of this program's frames are shown in their data window, and so
    /// are files with an oversized display window.
    pub fn shown(self) -> Frame {
        let is_own = self.attributes.0.keys().any(|name| name.starts_with(OWN));
        let Frame { full, window, .. } = self.frame;
        let channels = self.picture().map_or_else(|| self.stand_in(), |picture| self.colors_in_ours(picture));
        let mut frame = Frame { full, window, channels };
        let most = (MOST_EMPTY * window.width * window.height).max(LARGEST_EMPTY);
        if !is_own && full.width.saturating_mul(full.height) <= most {
            frame = frame.within(Window::whole(full));
        }
        frame
    }

    /// Converts red, green and blue to linear Rec. 709, so that files of different colour spaces can be
    /// compared.
    pub fn convert_colors(&mut self) {
        let Some(Picture::Colors(places)) = self.picture() else { return };
        for (channel, place) in self.colors_in_ours(Picture::Colors(places)).into_iter().zip(places) {
            self.frame.channels[place].pixels = channel.pixels;
        }
        self.colors.space = ColorSpace::OURS;
    }

    /// Sentence about the channels shown for a file without a picture.
    pub fn shown_instead(&self) -> Option<String> {
        if self.picture().is_some() {
            return None;
        }
        let channels = &self.frame.channels;
        Some(match stand_in(&self.names()) {
            [Some(grey), Some(same), _] if grey == same => {
                let grey = &channels[grey];
                let values = grey.pixels.iter().copied().filter(|value| value.is_finite());
                let (least, most) = (values.clone().reduce(f32::min), values.reduce(f32::max));
                let range =
                    least.zip(most).map_or(String::new(), |(least, most)| format!(", {least:?} to {most:?}"));
                format!("the file has no R, G and B: `{}` is shown as grey{range}", grey.name)
            }
            places => {
                let name = |place: Option<usize>| place.map_or("black", |place| &channels[place].name);
                let names = places.map(name).join(", ");
                format!("the file has no picture: red, green and blue show {names}")
            }
        })
    }

    fn names(&self) -> Vec<&str> {
        self.frame.channels.iter().map(|channel| channel.name.as_str()).collect()
    }

    fn picture(&self) -> Option<Picture> {
        Picture::among(&self.names())
    }

    fn stand_in(&self) -> Vec<Channel> {
        let black = || vec![0.0; self.frame.window.width * self.frame.window.height];
        let named = |(name, place): (&str, Option<usize>)| match place {
            Some(place) => Channel { name: name.to_owned(), ..self.frame.channels[place].clone() },
            None => Channel::new(name, Precision::Float, black()),
        };
        ["R", "G", "B"].into_iter().zip(stand_in(&self.names())).map(named).collect()
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
