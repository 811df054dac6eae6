//! Finished frame in memory. In goes a rendered film, out come arrays and files. Invariant: a written file
//! equals the command line's for the same settings.

use super::arrays::Array;
use super::error::RenderError;
use super::plan::Plan;
use crate::color::{Display, Look};
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::film::{self, Channel};
use crate::frame_file::{self, Provenance};
use crate::passes::{MATTE_LAYER, Pass};
use crate::render::{Rendered, Statistics};
use crate::scene::{Size, Window};
use std::path::Path;

/// Unit of the beauty's channels.
const RADIANCE: &str = "W m^-2 sr^-1";

/// A rendered frame: the beauty and the passes that were asked for.
#[derive(Clone, Debug)]
pub struct Frame {
    number: i64,
    picture: film::Frame,
    statistics: Statistics,
    provenance: Provenance,
    /// Exposure of the scene, if it has one.
    exposure_stops: Option<f64>,
    look: Look,
    remarks: Diagnostics,
}

impl Frame {
    pub(super) fn new(plan: &Plan, number: i64, rendered: Rendered) -> Self {
        Self {
            number,
            picture: rendered.frame,
            statistics: rendered.statistics,
            provenance: plan.provenance(number),
            exposure_stops: plan.settings.exposure_stops,
            look: plan.settings.look,
            remarks: plan.remarks.clone(),
        }
    }

    /// Number of the frame.
    pub fn number(&self) -> i64 {
        self.number
    }

    /// Size of the whole picture.
    pub fn full_size(&self) -> Size {
        self.picture.full
    }

    /// Part of the picture that was rendered; arrays have its size.
    pub fn window(&self) -> Window {
        self.picture.window
    }

    /// Names of all channels, as in a file.
    pub fn channel_names(&self) -> impl Iterator<Item = &str> {
        self.picture.channels.iter().map(|channel| channel.name.as_str())
    }

    /// Channel with the given name, such as `R`, `A` or `Normal.X`.
    pub fn channel(&self, name: &str) -> Option<Array> {
        let channel = self.picture.channel(name)?;
        let unit = Pass::ALL.iter().find(|&&pass| belongs(channel, pass)).map(|&pass| pass.row().unit);
        let unit = unit.unwrap_or(if name == "A" { "1" } else { RADIANCE });
        Some(self.array(&[channel], unit))
    }

    /// Beauty: R, G and B in linear Rec. 709, and in A the share of the pixel that surfaces cover.
    pub fn beauty(&self) -> Array {
        let channels = ["R", "G", "B", "A"].map(|name| self.picture.channel(name));
        let channels: Vec<&Channel> = channels.into_iter().flatten().collect();
        self.array(&channels, RADIANCE)
    }

    /// All channels of a pass; `None` if it was not requested.
    pub fn pass(&self, pass: Pass) -> Option<Array> {
        let channels = self.picture.channels.iter().filter(|channel| belongs(channel, pass));
        let mut channels: Vec<&Channel> = channels.collect();
        let place = |channel: &&Channel| pass.row().channels.iter().position(|name| *name == channel.name);
        channels.sort_by_key(place);
        if channels.is_empty() { None } else { Some(self.array(&channels, pass.row().unit)) }
    }

    /// Statistics of its rendering.
    pub fn statistics(&self) -> &Statistics {
        &self.statistics
    }

    /// Requests of the scene that this frame does not honour.
    pub fn warnings(&self) -> impl Iterator<Item = &Diagnostic> {
        self.remarks.reported()
    }

    /// Exposure that a camera would choose, in powers of two.
    pub fn auto_exposure_stops(&self) -> f64 {
        self.picture.auto_exposure_stops()
    }

    /// Writes an EXR file with all channels, whole or not at all; folders are created.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), RenderError> {
        Ok(frame_file::write(path.as_ref(), &self.picture, &self.provenance)?)
    }

    /// Writes a PNG for viewing, with the scene's look and exposure. A scene without an exposure gets this
    /// frame's automatic one, so brightness may flicker: see [`Self::write_png_at`]. Folders are created.
    ///
    /// # Errors
    /// If the picture is too large for a PNG or the file cannot be written.
    pub fn write_png(&self, path: impl AsRef<Path>) -> Result<(), RenderError> {
        self.write_png_at(path, self.exposure_stops.unwrap_or_else(|| self.auto_exposure_stops()))
    }

    /// Writes the frame as a PNG with light multiplied by 2 to the power of `exposure_stops`, which has to be
    /// finite. One value for a whole sequence avoids flicker.
    ///
    /// # Errors
    /// If the picture is too large for a PNG or the file cannot be written.
    pub fn write_png_at(&self, path: impl AsRef<Path>, exposure_stops: f64) -> Result<(), RenderError> {
        let display = Display { exposure_stops, look: self.look, ..Display::default() };
        Ok(frame_file::write_preview(path.as_ref(), &self.picture, &display)?)
    }

    fn array(&self, channels: &[&Channel], unit: &'static str) -> Array {
        let Window { width, height, .. } = self.picture.window;
        Array::of(channels, width, height, unit)
    }
}

fn belongs(channel: &Channel, pass: Pass) -> bool {
    match pass {
        Pass::Cryptomatte => channel.name.starts_with(MATTE_LAYER),
        pass => pass.row().channels.contains(&channel.name.as_str()),
    }
}
