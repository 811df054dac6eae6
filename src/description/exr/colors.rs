//! Colour space of an EXR file, by `colorInteropID` and `chromaticities`. In go attributes, out comes a
//! space, with a loss if it is uncertain. Invariant: the id takes precedence, as in OpenImageIO.

use super::raw::RawPart;
use crate::color::{ColorSpace, NamedSpace, Primaries};
use crate::diagnostic::Loss;
use glam::DVec2;

/// Colour space of a file's colours.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageColors {
    /// Space of the file's colours.
    pub space: ColorSpace,
    /// Name in the file.
    pub name: String,
    /// Loss for the attribute that is not honoured, and the reason.
    pub doubt: Option<(Loss, String)>,
}

impl ImageColors {
    /// Default colours of files without such attributes (OpenEXR, "Standard attributes").
    pub(super) fn unsaid() -> Self {
        Self { space: ColorSpace::OURS, name: String::from("linear Rec. 709"), doubt: None }
    }

    /// Colour space of a part.
    ///
    /// # Errors
    /// If its chromaticities span no colours, and no other attribute has a colour space.
    pub(super) fn of(part: &RawPart) -> Result<Self, String> {
        let by_primaries = match part.chromaticities() {
            None => None,
            Some(numbers) => match linear(numbers) {
                Some(space) => Some(Self { space, name: words(numbers), doubt: None }),
                None => return Err(String::from("the image's chromaticities span no colours")),
            },
        };
        let Some(id) = part.text("colorInteropID") else {
            return Ok(by_primaries.unwrap_or_else(Self::unsaid));
        };
        let instead = || by_primaries.clone().unwrap_or_else(Self::unsaid);
        let doubted = |loss, what: String| Self { doubt: Some((loss, what)), ..instead() };
        Ok(match NamedSpace::of(&id) {
            NamedSpace::Colors(space) => Self { space, doubt: conflict(&id, space, by_primaries), name: id },
            NamedSpace::Unsaid if by_primaries.is_some() => instead(),
            NamedSpace::Unsaid | NamedSpace::NotKnown => doubted(
                Loss::ColorSpaceUnknown,
                format!("the colour space `{id}` is not known, colours are taken as {}", instead().name),
            ),
            NamedSpace::Data => doubted(
                Loss::ColorSpaceData,
                format!("the image says that it holds data, colours are taken as {}", instead().name),
            ),
        })
    }
}

fn conflict(id: &str, space: ColorSpace, by_primaries: Option<ImageColors>) -> Option<(Loss, String)> {
    let other = by_primaries.filter(|other| !other.space.has_same_primaries(&space))?;
    let found = format!("colorInteropID `{id}` and {} disagree, the id counts", other.name);
    Some((Loss::ColorSpaceConflict, found))
}

fn linear(numbers: [f32; 8]) -> Option<ColorSpace> {
    let place = |at: usize| DVec2::new(numbers[at].into(), numbers[at + 1].into());
    ColorSpace::linear(Primaries { red: place(0), green: place(2), blue: place(4), white: place(6) })
}

fn words(numbers: [f32; 8]) -> String {
    format!("chromaticities {}", numbers.map(|number| format!("{number:.4}")).join(" "))
}
