//! Lights. In go lights, out come glTF's in lux and candela; sizes, pictures on suns and area lights go into
//! `sunfleck_light`. Invariant: read back, a light has the same power, to the rounding of one multiplication.

use super::Writer;
use super::materials::png;
use crate::color::{LUMENS_PER_WATT, Rgb};
use crate::diagnostic::Diagnostic;
use crate::scene::{AreaShape, Julia, LampTraits, Light, LightKind, SunDisc, SunPicture, SunShows};
use base64::prelude::{BASE64_STANDARD as STANDARD, Engine};
use serde_json::{Map, Value, json};
use std::f64::consts::PI;

/// Least difference in radians of a cone's angles: glTF wants the inner one smaller.
const NARROWEST_EDGE: f64 = 1e-9;

impl Writer<'_> {
    pub(super) fn add_lights(&mut self) -> Result<(), Diagnostic> {
        self.scene.lights.iter().try_for_each(|light| self.add_light(light))
    }

    fn add_light(&mut self, light: &Light) -> Result<(), Diagnostic> {
        let time_s = self.moments.start_s;
        let node = self.node_numbers[light.node];
        let node = self.free_node(node, |node| {
            has(node, "extensions", "KHR_lights_punctual") || has(node, "extras", "sunfleck_light")
        });
        let owner = format!("{}.sunfleck_light", self.scene.nodes[light.node].name);
        for (name, number) in light.kind.numbers() {
            self.carry_number(format!("{owner}.{name}"), number);
        }
        let traits = self.scene.lamp_traits.get(&light.node).copied().unwrap_or_default();
        let (name, unit) = light.kind.blenders_power();
        self.carry_color(format!("{owner}.{name}"), &light.power.map_linear(|value| value * unit));
        let (brightest, color) = brightest(light.power.at(time_s));
        let mut ours = Map::new();
        for (name, value) in fields(&light.kind, time_s)?.into_iter().chain(fields_of(traits)) {
            ours.insert(name.to_owned(), value);
        }
        let Some((kind, cone)) = kind_in_gltf(&light.kind, time_s) else {
            ours.insert("power_w".to_owned(), json!(brightest));
            ours.insert("color".to_owned(), json!(color.to_array()));
            self.set_extra(node, "sunfleck_light", Value::Object(ours));
            return Ok(());
        };
        if !ours.is_empty() {
            self.set_extra(node, "sunfleck_light", Value::Object(ours));
        }
        let mut written = json!({
            "name": light.name, "type": kind, "color": color.to_array(), "intensity": brightest * LUMENS_PER_WATT,
        });
        if let Some(cone) = cone {
            written["spot"] = cone;
        }
        self.lights.push(written);
        self.extensions.insert("KHR_lights_punctual");
        let number = self.lights.len() - 1;
        self.extend_node(node, "KHR_lights_punctual", json!({ "light": number }));
        Ok(())
    }
}

/// Type of a light in glTF, and a spot's cone; `None` for an area light.
fn kind_in_gltf(kind: &LightKind, time_s: f64) -> Option<(&'static str, Option<Value>)> {
    match kind {
        LightKind::Sun | LightKind::SunDisc(_) => Some(("directional", None)),
        LightKind::Point | LightKind::Sphere { .. } => Some(("point", None)),
        LightKind::Spot { outer_angle, blend, .. } => {
            let outer = outer_angle.at(time_s);
            let inner = outer * (1.0 - blend.at(time_s).max(NARROWEST_EDGE));
            Some(("spot", Some(json!({ "innerConeAngle": inner, "outerConeAngle": outer }))))
        }
        LightKind::Area { .. } => None,
    }
}

/// Fields of `sunfleck_light` for properties that glTF lacks.
fn fields(kind: &LightKind, time_s: f64) -> Result<Vec<(&'static str, Value)>, Diagnostic> {
    Ok(match kind {
        LightKind::Sun | LightKind::Point => vec![],
        LightKind::SunDisc(disc) => sun_disc(disc, time_s)?,
        LightKind::Sphere { radius } => vec![("radius", json!(radius.at(time_s)))],
        LightKind::Spot { radius, .. } => {
            let radius = radius.at(time_s);
            if radius > 0.0 { vec![("radius", json!(radius))] } else { vec![] }
        }
        LightKind::Area { shape, width, height, spread } => {
            let shape = if *shape == AreaShape::Rectangle { "rectangle" } else { "ellipse" };
            let size_m = [width.at(time_s), height.at(time_s)];
            let mut fields = vec![("type", json!("area")), ("shape", json!(shape)), ("size", json!(size_m))];
            if !spread.is_constant() || spread.at(time_s) < PI {
                fields.push(("spread", json!(spread.at(time_s))));
            }
            fields
        }
    })
}

fn fields_of(traits: LampTraits) -> impl Iterator<Item = (&'static str, Value)> {
    let LampTraits { soft_falloff, shines_inward, visible_to_camera, visible_in_mirrors } = traits;
    let named = [
        ("soft_falloff", soft_falloff),
        ("shines_inward", shines_inward),
        ("visible_to_camera", visible_to_camera),
        ("visible_in_mirrors", visible_in_mirrors),
    ];
    named.into_iter().filter(|(_, has)| *has).map(|(name, _)| (name, json!(true)))
}

fn sun_disc(disc: &SunDisc, time_s: f64) -> Result<Vec<(&'static str, Value)>, Diagnostic> {
    let mut said = vec![("angle", json!(disc.angular_diameter.at(time_s)))];
    if disc.visible_to_camera {
        said.push(("visible_to_camera", json!(true)));
    }
    if let Some(picture) = &disc.picture {
        said.extend(sun_picture(picture, time_s)?);
        said.push(("picture_rotation", json!(disc.picture_rotation.at(time_s))));
    }
    Ok(said)
}

/// Picture of a sun, as fields of `sunfleck_light`.
fn sun_picture(picture: &SunPicture, time_s: f64) -> Result<Vec<(&'static str, Value)>, Diagnostic> {
    let mut fields = Vec::new();
    match picture.shows() {
        SunShows::Even => {}
        SunShows::Image(image) => {
            let uri = format!("data:image/png;base64,{}", STANDARD.encode(png(image, false)?));
            fields.push(("image", json!(uri)));
        }
        SunShows::Julia(Julia { real, imaginary, iterations }) => {
            let fractal = json!({
                "real": real.at(time_s), "imaginary": imaginary.at(time_s), "iterations": iterations,
            });
            fields.push(("fractal", fractal));
        }
    }
    if picture.limb_darkening() > 0.0 {
        fields.push(("limb_darkening", json!(picture.limb_darkening())));
    }
    Ok(fields)
}

fn has(node: &Map<String, Value>, group: &str, key: &str) -> bool {
    node.get(group).is_some_and(|group| group.get(key).is_some())
}

/// Value of the brightest channel, and the colour relative to it.
fn brightest(power: Rgb) -> (f64, Rgb) {
    let brightest = power.max_element();
    if brightest > 0.0 { (brightest, power / brightest) } else { (0.0, Rgb::ONE) }
}
