//! Textures and their images. In go indices of the file's textures, out come texels. Invariant: an image is
//! decoded once for each use of its numbers; a missing one is reported once and dropped everywhere.

use super::buffers::{Buffers, fetch, unreadable};
use super::json::{self, Document};
use super::report::Report;
use super::{Files, Texture, Wrap, invalid, named};
use crate::description::image::{self, DecodedImage, Encoding};
use crate::diagnostic::{Diagnostic, Loss};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

/// Maximum number of texels in the textures of one file; 1 GiB of 8-bit codes.
pub(super) const MAX_TEXELS: usize = 1 << 28;

/// Use of an image's numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Look {
    /// Numbers of the image.
    Plain(Encoding),
    /// Roughness in green, from a glossiness in alpha times this factor.
    Roughness {
        /// `0..=1`.
        glossiness: f64,
    },
}

/// Textures that were requested so far.
pub(super) struct Textures<'a> {
    document: &'a Document,
    buffers: &'a Buffers<'a>,
    file: &'a Path,
    files: &'a mut Files,
    /// Index by the file's texture and its use; `None` if it could not be read.
    numbers: BTreeMap<(usize, Key), Option<usize>>,
    pub(super) read: Vec<Texture>,
}

/// [`Look`] with an order.
type Key = (Encoding, Option<u64>);

impl<'a> Textures<'a> {
    pub(super) fn new(
        document: &'a Document,
        buffers: &'a Buffers<'a>,
        file: &'a Path,
        files: &'a mut Files,
    ) -> Self {
        Self { document, buffers, file, files, numbers: BTreeMap::new(), read: Vec::new() }
    }

    /// Index of a texture for `user`.
    pub(super) fn number(
        &mut self,
        index: usize,
        look: Look,
        user: &str,
        report: &mut Report,
    ) -> Option<usize> {
        let key = match look {
            Look::Plain(encoding) => (encoding, None),
            Look::Roughness { glossiness } => (Encoding::Linear, Some(glossiness.to_bits())),
        };
        if let Some(known) = self.numbers.get(&(index, key)) {
            return *known;
        }
        let texture = self.texture(index, key.0, user, report);
        let texture = report.spare(Loss::TextureUnreadable, texture).map(|texture| match look {
            Look::Plain(_) => texture,
            Look::Roughness { glossiness } => {
                Texture { image: roughness(texture.image, glossiness), ..texture }
            }
        });
        let number = texture.map(|texture| {
            self.read.push(texture);
            self.read.len() - 1
        });
        self.numbers.insert((index, key), number);
        number
    }

    fn texture(
        &mut self,
        index: usize,
        encoding: Encoding,
        user: &str,
        report: &mut Report,
    ) -> Result<Texture, Diagnostic> {
        let texels = self.read.iter().map(|texture| texture.image.texels.len()).sum::<usize>();
        if texels > MAX_TEXELS {
            return Err(invalid(self.file, user, "the textures are too large together")
                .expected("2^28 texels in all")
                .remedy("scale the images down"));
        }
        let Some(texture) = self.document.textures.get(index) else {
            return Err(invalid(self.file, user, format!("texture {index} does not exist")));
        };
        let source = self.source(index, texture)?;
        let image = &self.document.images[source];
        let bytes = self.bytes(image, &format!("images[{source}]"))?;
        let name = named(&image.name, "image", source);
        let sampler = texture.sampler.filter(|&sampler| {
            let path = format!("textures[{index}].sampler");
            report.index_exists(&path, sampler, self.document.samplers.len(), "sampler")
        });
        let sampler = sampler.map(|sampler| &self.document.samplers[sampler]);
        let wrap = sampler.map_or([Wrap::Repeat; 2], |sampler| [sampler.wrap_s, sampler.wrap_t].map(wrap));
        if sampler.is_some_and(|sampler| sampler.mag_filter == Some(9728)) {
            report.not_honoured(Loss::TextureFilter, &name);
        }
        let image = image::decode(&bytes, encoding, report.at(format!("images[{source}]")))?;
        Ok(Texture { name, image, wrap })
    }

    fn source(&self, index: usize, texture: &json::Texture) -> Result<usize, Diagnostic> {
        let path = format!("textures[{index}].source");
        // The plain image has the same contents, and other readers prefer it.
        let others = [&texture.extensions.webp, &texture.extensions.basisu];
        let others = others.into_iter().flatten().filter_map(|image| image.source);
        let Some(source) = texture.source.into_iter().chain(others).next() else {
            let found = match texture.extensions.others.keys().next() {
                Some(format) => format!("the texture has its image as `{format}` alone, which is not read"),
                None => String::from("the texture has no image that can be read"),
            };
            return Err(invalid(self.file, path, found)
                .expected("an image in PNG, JPEG, WebP or KTX2")
                .remedy("export images as PNG or JPEG (Blender: Material > Images)"));
        };
        if source >= self.document.images.len() {
            return Err(invalid(self.file, path, format!("image {source} does not exist")));
        }
        Ok(source)
    }

    fn bytes(&mut self, image: &json::Image, place: &str) -> Result<Cow<'a, [u8]>, Diagnostic> {
        match (&image.buffer_view, &image.uri) {
            (Some(view), _) => {
                let (bytes, _) = self.buffers.view(*view, &format!("{place}.bufferView"))?;
                Ok(Cow::Borrowed(bytes))
            }
            (None, Some(uri)) => {
                let path = format!("{place}.uri");
                let referrer = format!("{}: {path}", self.file.display());
                match fetch(uri, self.file, self.files, &referrer) {
                    Ok(bytes) => bytes.map_err(|found| invalid(self.file, path, found)),
                    Err(error) => Err(unreadable(&error, self.file, &path)),
                }
            }
            (None, None) => Err(invalid(self.file, place, "the image has neither data nor a file")),
        }
    }
}

/// Roughness as 1 minus glossiness (KHR_materials_pbrSpecularGlossiness, "Conversion"), without metal.
fn roughness(image: DecodedImage, glossiness: f64) -> DecodedImage {
    let rough = |texel: [f32; 4]| [0.0, 1.0 - glossiness as f32 * texel[3], 0.0, 1.0];
    DecodedImage { texels: image.texels.into_iter().map(rough).collect(), ..image }
}

fn wrap(code: Option<u32>) -> Wrap {
    match code {
        Some(33071) => Wrap::Clamp,
        Some(33648) => Wrap::Mirror,
        _ => Wrap::Repeat,
    }
}
