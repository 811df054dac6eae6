//! Colour space of an EXR file, by `colorInteropID` and `chromaticities`. In go attributes, out comes a
//! space, with a loss if it is uncertain. Invariant: the id takes precedence, as in OpenImageIO.

use crate::color::{ColorSpace, NamedSpace, Primaries};
use crate::diagnostic::Loss;
use ::exr::math::Vec2;
use ::exr::meta::attribute::{AttributeValue, Chromaticities, Text};
use ::exr::meta::header::Header;
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
    pub(crate) fn unsaid() -> Self {
        Self { space: ColorSpace::OURS, name: String::from("linear Rec. 709"), doubt: None }
    }

    /// Colour space of a part, by its attributes or else the first part's.
    ///
    /// # Errors
    /// If its chromaticities span no colours, and no other attribute has a colour space.
    pub(crate) fn of(headers: &[Header], part: usize) -> Result<Self, String> {
        let said = |header: &Header| (header.shared_attributes.chromaticities, id(header));
        let (chromaticities, id) = match said(&headers[part]) {
            (None, None) => said(&headers[0]),
            found => found,
        };
        let by_primaries = match chromaticities {
            None => None,
            Some(numbers) => match linear(numbers) {
                Some(space) => Some(Self { space, name: words(numbers), doubt: None }),
                None => return Err(String::from("the image's chromaticities span no colours")),
            },
        };
        let Some(id) = id else {
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

fn id(header: &Header) -> Option<String> {
    match header.own_attributes.other.get(&Text::from("colorInteropID"))? {
        AttributeValue::Text(id) => Some(String::from_utf8_lossy(id.bytes()).into_owned()),
        _ => None,
    }
}

fn linear(Chromaticities { red, green, blue, white }: Chromaticities) -> Option<ColorSpace> {
    let [red, green, blue, white] =
        [red, green, blue, white].map(|Vec2(x, y)| DVec2::new(x.into(), y.into()));
    ColorSpace::linear(Primaries { red, green, blue, white })
}

fn words(Chromaticities { red, green, blue, white }: Chromaticities) -> String {
    let numbers = [red, green, blue, white].map(|Vec2(x, y)| format!("{x:.4} {y:.4}"));
    format!("chromaticities {}", numbers.join(" "))
}
