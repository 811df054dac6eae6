//! Fog, background, sky and render settings, which glTF lacks. In goes a scene, out come its extras.
//! Invariant: their names are those that `scene/from_gltf/extras.rs` reads.

use super::{Writer, beside};
use crate::color::{Look, Rgb};
use crate::diagnostic::{Diagnostic, Loss, Place};
use crate::scene::{Bounces, Fog, FogShape, RenderSettings, Sampling, Sky, SkyLight, SkyPicture, Texture};
use base64::prelude::{BASE64_STANDARD as STANDARD, Engine};
use exr::image::write::WritableImage;
use exr::image::{Image, SpecificChannels};
use exr::math::Vec2;
use serde_json::{Map, Value, json};
use std::io::Cursor;

impl Writer<'_> {
    /// Adds all fog volumes at their nodes.
    pub(super) fn add_fogs(&mut self) {
        for fog in &self.scene.fogs {
            if let FogShape::Mist(_) = fog.shape {
                let found = format!("fog.{}: mist is not carried by glTF, the bank is left out", fog.name);
                self.lost(Loss::ExportMist, found);
                continue;
            }
            let written = self.fog(fog);
            let is_taken = |node: &Map<String, Value>| {
                node.get("extras").is_some_and(|extras| extras.get("sunfleck_fog_volume").is_some())
            };
            let node = self.free_node(self.node_numbers[fog.node], is_taken);
            self.set_extra(node, "sunfleck_fog_volume", written);
        }
    }

    fn fog(&mut self, fog: &Fog) -> Value {
        let time_s = self.moments.start_s;
        let falloff = fog.shape.falloff();
        let owner = format!("{}.sunfleck_fog_volume", self.scene.nodes[fog.node].name);
        self.carry_color(format!("{owner}.density"), &fog.density_per_m);
        self.carry_color(format!("{owner}.albedo"), &fog.albedo);
        self.carry_number(format!("{owner}.anisotropy"), &fog.anisotropy);
        if let Some(falloff) = falloff {
            self.carry_number(format!("{owner}.scale_height"), &falloff.scale_height_m);
        }
        let mut written = json!({
            "density": channels(fog.density_per_m.at(time_s)),
            "albedo": channels(fog.albedo.at(time_s)),
            "anisotropy": fog.anisotropy.at(time_s),
        });
        match &fog.shape {
            FogShape::EvenBox | FogShape::ThinningBox(_) => written["shape"] = json!("box"),
            FogShape::Layer(_) => written["shape"] = json!("layer"),
            // Left out, and reported as a loss.
            FogShape::Mist(_) => {}
            FogShape::Voxels(grids) => {
                let uri = beside::uri(&grids.path, self.folder);
                self.files.insert(uri.clone());
                written["vdb"] = json!(uri);
                written["grid"] = json!(grids.names.density);
                if let Some(name) = &grids.names.albedo {
                    written["albedo_grid"] = json!(name);
                }
                if let Some(name) = &grids.names.emission {
                    written["emission_grid"] = json!(name);
                    written["emission"] = json!(channels(grids.emission.at(time_s)));
                    self.carry_color(format!("{owner}.emission"), &grids.emission);
                }
                if let Some(kelvin) = grids.names.kelvin {
                    written["emission_kelvin"] = json!(kelvin);
                    if grids.names.is_principled {
                        written["emission_principled"] = json!(true);
                    }
                }
            }
        }
        if let Some(falloff) = falloff {
            written["scale_height"] = json!(falloff.scale_height_m.at(time_s));
            written["base_height"] = json!(falloff.base);
        }
        written
    }

    /// Sky at the first frame, if the file can hold it.
    fn sky(&mut self, sky: Option<&Sky>) -> Result<Option<Value>, Diagnostic> {
        let Some(sky) = sky else { return Ok(None) };
        let (strength, rotation) =
            (sky.strength.at(self.moments.start_s), sky.rotation.at(self.moments.start_s));
        let scaled = |color: Rgb| json!((color * strength).to_array());
        let mut written = match sky.picture() {
            SkyPicture::Even(color) => json!({ "color": scaled(*color) }),
            SkyPicture::Gradient { zenith, horizon, ground } => {
                json!({ "zenith": scaled(*zenith), "horizon": scaled(*horizon), "ground": scaled(*ground) })
            }
            SkyPicture::Image(image) => json!({
                "image": exr_uri(image)?, "strength": strength.to_array(), "rotation": rotation,
            }),
        };
        if !sky.is_constant() {
            self.lost(Loss::ExportSky, "the sky does not change in glTF: it stays as it is at the start");
        }
        written["lights"] = json!(match sky.lights {
            SkyLight::Nothing => "nothing",
            SkyLight::Surfaces => "surfaces",
            SkyLight::SurfacesAndFog => "surfaces_and_fog",
        });
        if !sky.visible_to_camera {
            written["visible_to_camera"] = json!(false);
        }
        Ok(Some(written))
    }

    pub(super) fn scene_extras(&mut self, settings: &RenderSettings) -> Result<Value, Diagnostic> {
        let rate = settings.frame_rate;
        let mut sunfleck = json!({
            "version": 1,
            "fps": rate.numerator,
            "fps_base": rate.denominator,
            "frame_start": settings.frames.start(),
            "frame_end": settings.frames.end(),
            "resolution": [settings.size.width, settings.size.height],
            "light_units": "spec",
            "shutter": settings.shutter,
            "shutter_offset": settings.shutter_around(0.0)[0],
            "filter": settings.filter.name(),
            "seed": settings.seed,
            "mirror_depth": settings.mirror_depth,
            "passes": settings.passes.iter().map(|pass| pass.name()).collect::<Vec<_>>(),
        });
        let camera =
            settings.camera.as_ref().or_else(|| self.scene.cameras.first().map(|camera| &camera.name));
        if let Some(camera) = camera {
            sunfleck["camera"] = json!(camera);
        }
        match settings.bounces {
            Bounces::All => {}
            Bounces::UpTo(count) => sunfleck["bounces"] = json!(count),
        }
        if let Some(stops) = settings.exposure_stops {
            sunfleck["exposure"] = json!(stops);
        }
        if settings.look != Look::None {
            sunfleck["look"] = json!(settings.look.name());
        }
        match settings.sampling {
            Sampling::Exactly(samples) => sunfleck["samples"] = json!(samples),
            Sampling::Until { tolerance, most } => {
                sunfleck["samples"] = json!(most);
                sunfleck["tolerance"] = json!(tolerance);
            }
        }
        let mut extras = json!({ "sunfleck": sunfleck });
        if self.scene.background != Rgb::ZERO {
            extras["sunfleck_env"] = json!({ "color": self.scene.background.to_array(), "strength": 1.0 });
        }
        if let Some(sky) = self.sky(self.scene.sky.as_ref())? {
            extras["sunfleck_env"] = sky;
        }
        if let Some(backdrop) = self.sky(self.scene.backdrop.as_ref())? {
            if self.scene.sky.is_none() {
                extras["sunfleck_env"] = json!({ "color": [0.0, 0.0, 0.0] });
            }
            extras["sunfleck_env"]["backdrop"] = backdrop;
        }
        Ok(extras)
    }
}

/// Data URI of an image of radiances; OpenEXR keeps single precision.
fn exr_uri(image: &Texture) -> Result<String, Diagnostic> {
    let texels: Vec<[f32; 4]> = image.texels.iter().collect();
    let channels = SpecificChannels::rgb(|Vec2(x, y)| {
        let [red, green, blue, _] = texels[y * image.width + x];
        (red, green, blue)
    });
    let mut bytes = Cursor::new(Vec::new());
    let exr = Image::from_channels((image.width, image.height), channels);
    exr.write().non_parallel().to_buffered(&mut bytes).map_err(|error| {
        let found = format!("the sky's image `{}` cannot be stored as OpenEXR: {error}", image.name);
        Diagnostic::error(Place::Nowhere, found)
            .expected("an image that OpenEXR can hold")
            .remedy("make the image smaller")
    })?;
    Ok(format!("data:image/x-exr;base64,{}", STANDARD.encode(bytes.into_inner())))
}

/// One number if all channels are equal, else three.
fn channels(color: Rgb) -> Value {
    match color.to_array() {
        [red, green, blue] if red == green && green == blue => json!(red),
        each => json!(each),
    }
}
