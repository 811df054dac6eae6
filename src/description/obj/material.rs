//! Materials of MTL files. In goes text, out come materials. Invariant: every number is in its range;
//! statements that are not honoured are reported.
//!
//! `illum`, `Ka`, `Ks` and `Ns` become a coat as in Blender's importer (io/wavefront_obj, obj_import_mtl.cc).

use super::tally::Tally;
use super::text::{number, statements};
use super::texture::{ObjTexture, Placement};
use crate::color::Rgb;
use crate::description::LARGEST_NUMBER;
use crate::diagnostic::Loss;
use std::collections::BTreeMap;
use std::path::Path;

/// Refractive index of plastics, leaves and most non-metals; Blender's default.
const DIELECTRIC_IOR: f64 = 1.5;

/// A material of an MTL file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjMaterial {
    /// Name.
    pub name: String,
    /// `Kd`, linear, `0..=1`; 0.8 by default, and white if it would make a texture black.
    pub diffuse: Rgb,
    /// `map_Kd`.
    pub diffuse_texture: Option<ObjTexture>,
    /// `Ke`, finite and not negative.
    pub emission: Rgb,
    /// `map_Ke`, unscaled if `Ke` is black.
    pub emission_texture: Option<ObjTexture>,
    /// `d`, or 1 less `Tr`, `0..=1`.
    pub opacity: f64,
    /// `map_d`.
    pub opacity_texture: Option<ObjTexture>,
    /// Glossy coat.
    pub coat: Option<ObjCoat>,
    /// `Pc` and `Pcr`: coverage and roughness of a clear coat, `0..=1`.
    pub clearcoat: Option<(f64, f64)>,
    /// `norm`, or `map_Bump`.
    pub normal_map: Option<ObjTexture>,
    /// Whether it is certainly a normal map (`norm`), or may be a height map.
    pub normal_map_is_sure: bool,
}

/// Coat by `illum`, `Ks` and `Ns`, or `Pr` and `Pm`.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjCoat {
    /// Share of metal, `0..=1`.
    pub metallic: f64,
    /// Roughness, `0..=1`, as in glTF and Blender.
    pub roughness: f64,
    /// Reflectance along the normal of the non-metallic part, `0..=1`.
    pub f0: f64,
    /// `map_Pm`, in place of `metallic`.
    pub metallic_texture: Option<ObjTexture>,
    /// `map_Pr`, in place of `roughness`.
    pub roughness_texture: Option<ObjTexture>,
}

impl ObjMaterial {
    fn textures(&self) -> impl Iterator<Item = &ObjTexture> {
        let coat = self.coat.as_ref();
        let coat = coat.map(|coat| [&coat.roughness_texture, &coat.metallic_texture]);
        [&self.diffuse_texture, &self.opacity_texture, &self.emission_texture, &self.normal_map]
            .into_iter()
            .chain(coat.into_iter().flatten())
            .flatten()
    }

    /// Placement of its images: the first one's for all.
    pub(super) fn placement(&self) -> Placement {
        self.textures().next().map(|texture| texture.placement).unwrap_or_default()
    }

    /// Whether it has an image.
    pub(super) fn has_textures(&self) -> bool {
        self.textures().next().is_some()
    }
}

pub(super) fn read(text: &str, path: &Path, tally: &mut Tally) -> Vec<ObjMaterial> {
    let mut readers: Vec<(String, BTreeMap<String, Value>)> = Vec::new();
    for statement in statements(text) {
        let keyword = statement.keyword();
        if keyword.eq_ignore_ascii_case("newmtl") {
            if statement.rest().is_empty() {
                tally.add_at(Loss::MtlUnnamed, "", (path, statement.line));
            }
            readers.push((statement.rest().to_owned(), BTreeMap::new()));
        } else if let Some((_, values)) = readers.last_mut() {
            let value = Value {
                line: statement.line,
                keyword: keyword.to_owned(),
                rest: statement.rest().to_owned(),
                words: statement.words().map(str::to_owned).collect(),
            };
            values.insert(keyword.to_ascii_lowercase(), value);
        } else {
            tally.add_at(Loss::MtlStatement, keyword, (path, statement.line));
        }
    }
    let read = |(name, values)| Reader { path, values, tally }.material(name);
    readers.into_iter().map(read).collect()
}

/// Words after a keyword.
struct Value {
    line: usize,
    keyword: String,
    rest: String,
    words: Vec<String>,
}

/// Statements of one material. Each is removed as it is read; those that remain are unknown.
struct Reader<'a> {
    path: &'a Path,
    values: BTreeMap<String, Value>,
    tally: &'a mut Tally,
}

impl Reader<'_> {
    fn material(mut self, name: String) -> ObjMaterial {
        let diffuse_texture = self.texture(&["map_kd"]);
        let kd = self.color("kd", 1.0);
        let diffuse = match (kd, &diffuse_texture) {
            (None | Some(Rgb::ZERO), Some(_)) => Rgb::ONE,
            (kd, _) => kd.unwrap_or(Rgb::splat(0.8)),
        };
        let normal_map_is_sure = self.values.contains_key("norm");
        let material = ObjMaterial {
            diffuse,
            diffuse_texture,
            emission: self.color("ke", LARGEST_NUMBER).unwrap_or_default(),
            emission_texture: self.texture(&["map_ke"]),
            opacity: self.opacity(),
            opacity_texture: self.texture(&["map_d"]),
            clearcoat: self.clearcoat(),
            normal_map: self.texture(&["norm", "map_bump", "bump"]),
            normal_map_is_sure,
            coat: self.coat(),
            name,
        };
        self.say_other_placements(&material);
        self.say_the_rest(&material);
        material
    }

    fn said(&mut self, loss: Loss, value: &Value) {
        self.tally.add_at(loss, &value.keyword, (self.path, value.line));
    }

    /// Colour with channels from 0 to `most`; one number is a grey.
    fn color(&mut self, key: &str, most: f64) -> Option<Rgb> {
        let value = self.values.remove(key)?;
        let numbers: Option<Vec<f64>> =
            value.words.iter().take(3).map(|word| number(word).map(f64::from)).collect();
        let color = match numbers.as_deref() {
            Some([grey]) => Rgb::splat(*grey),
            Some([red, green, blue]) => Rgb::new(*red, *green, *blue),
            _ => {
                self.said(Loss::MtlValue, &value);
                return None;
            }
        };
        let clamped = color.clamp(Rgb::ZERO, Rgb::splat(most));
        if clamped != color {
            self.said(Loss::MtlValue, &value);
        }
        Some(clamped)
    }

    /// Number from 0 to `most`.
    fn number(&mut self, key: &str, most: f64) -> Option<f64> {
        let value = self.values.remove(key)?;
        let Some(found) = value.words.first().and_then(|word| number(word)).map(f64::from) else {
            self.said(Loss::MtlValue, &value);
            return None;
        };
        let clamped = found.clamp(0.0, most);
        if clamped != found {
            self.said(Loss::MtlValue, &value);
        }
        Some(clamped)
    }

    /// Image of the first keyword that has one; the same image under other keywords is ignored.
    fn texture(&mut self, keys: &[&str]) -> Option<ObjTexture> {
        let mut first = None;
        for key in keys {
            let Some(value) = self.values.remove(*key) else { continue };
            let folder = self.path.parent().unwrap_or(Path::new(""));
            let Some(texture) = ObjTexture::read(&value.rest, folder) else {
                self.said(Loss::MtlValue, &value);
                continue;
            };
            for option in &texture.other_options {
                self.tally.add_at(Loss::MtlTextureOption, option, (self.path, value.line));
            }
            first.get_or_insert(texture);
        }
        first
    }

    fn opacity(&mut self) -> f64 {
        let halo =
            self.values.get_mut("d").filter(|value| value.words.first().is_some_and(|word| word == "-halo"));
        if let Some(value) = halo {
            value.words.remove(0);
            let line = value.line;
            self.tally.add_at(Loss::MtlStatement, "-halo", (self.path, line));
        }
        let (d, tr) = (self.number("d", 1.0), self.number("tr", 1.0));
        d.or(tr.map(|tr| 1.0 - tr)).unwrap_or(1.0)
    }

    fn clearcoat(&mut self) -> Option<(f64, f64)> {
        let (share, roughness) = (self.number("pc", 1.0), self.number("pcr", 1.0));
        share.filter(|share| *share > 0.0).map(|share| (share, roughness.unwrap_or(0.0)))
    }

    fn coat(&mut self) -> Option<ObjCoat> {
        let (illum, ior) = (self.number("illum", f64::MAX), self.number("ni", f64::MAX));
        let (ka, ks) = (self.color("ka", f64::MAX), self.color("ks", 1.0));
        let (ns, pr, pm) = (self.number("ns", f64::MAX), self.number("pr", 1.0), self.number("pm", 1.0));
        let metallic_texture = self.texture(&["map_pm"]);
        let roughness_texture = self.texture(&["map_pr"]);
        self.say_refraction(illum, ior);
        let is_physical =
            pr.is_some() || pm.is_some() || metallic_texture.is_some() || roughness_texture.is_some();
        let is_matte = matches!(illum, Some(0.0 | 1.0)) || ks.is_none() && ns.is_none();
        if is_matte && !is_physical {
            return None;
        }
        let average = |color: Rgb| color.element_sum() / 3.0;
        let has_highlights = illum.is_some_and(|illum| illum >= 2.0);
        let specular = match (ks, is_physical) {
            (Some(ks), _) => average(ks),
            (None, true) => 0.5,
            (None, false) => f64::from(u8::from(has_highlights)),
        };
        let reflects = illum.is_some_and(|illum| (3.0..9.0).contains(&illum));
        let from_illum = if reflects { ka.map_or(1.0, average).min(1.0) } else { 0.0 };
        let metallic = pm.unwrap_or(if is_physical { 0.0 } else { from_illum });
        let from_ns = match ns {
            Some(ns) => 1.0 - (ns.min(1000.0) / 1000.0).sqrt(),
            None if is_physical => 0.5,
            None => f64::from(u8::from(!has_highlights)),
        };
        // Files without refraction often have an index of 1.
        let ior = ior.filter(|ior| *ior > 1.0).unwrap_or(DIELECTRIC_IOR);
        let f0 = (2.0 * specular * ((ior - 1.0) / (ior + 1.0)).powi(2)).min(1.0);
        let is_metal = metallic > 0.0 || metallic_texture.is_some();
        if !is_metal && f0 == 0.0 {
            return None;
        }
        let roughness = pr.unwrap_or(from_ns);
        Some(ObjCoat { metallic, roughness, f0, metallic_texture, roughness_texture })
    }

    /// Reports refraction by glass, as of `illum`, which is not supported.
    fn say_refraction(&mut self, illum: Option<f64>, ior: Option<f64>) {
        if !matches!(illum, Some(4.0 | 6.0 | 7.0 | 9.0)) {
            self.values.remove("tf");
        } else if ior.is_some_and(|ior| ior > 1.0) {
            self.tally.add_at(Loss::MtlStatement, "Ni", (self.path, 1));
        }
    }

    fn say_other_placements(&mut self, material: &ObjMaterial) {
        let placement = material.placement();
        let others = material.textures().filter(|texture| texture.placement != placement).count();
        for _ in 0..others {
            self.tally.add_at(
                Loss::MtlTextureOption,
                "-s, -o of another than the first texture",
                (self.path, 1),
            );
        }
    }

    /// Reports unknown statements, unless they have no effect: ambient light, and shares of 0.
    fn say_the_rest(&mut self, material: &ObjMaterial) {
        for (key, value) in std::mem::take(&mut self.values) {
            let numbers: Vec<Option<f32>> = value.words.iter().map(|word| number(word)).collect();
            let is_all = |wanted: f32| numbers.iter().all(|number| *number == Some(wanted));
            let changes_nothing = match key.as_str() {
                "ps" | "aniso" | "anisor" => is_all(0.0),
                "tf" => is_all(1.0),
                "sharpness" => true,
                // Many exporters write one image three times.
                "map_ka" => (material.diffuse_texture.as_ref()).is_some_and(|texture| {
                    let folder = self.path.parent().unwrap_or(Path::new(""));
                    ObjTexture::read(&value.rest, folder).is_some_and(|ambient| ambient.path == texture.path)
                }),
                _ => false,
            };
            if !changes_nothing {
                self.said(Loss::MtlStatement, &value);
            }
        }
    }
}
