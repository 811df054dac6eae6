//! Table of lights in common units. In go lights, out comes text. Invariant: a light is given only in units
//! that apply to it.

use std::f64::consts::PI;
use std::fmt::Write;
use sunfleck::color::LUMENS_PER_WATT;
use sunfleck::scene::{Light, LightKind};

/// Writes Blender's power in W with its meaning, for the brightest channel.
pub(super) fn write(out: &mut String, lights: &[Light], time_s: f64) -> std::fmt::Result {
    if lights.is_empty() {
        return Ok(());
    }
    writeln!(
        out,
        "    light units, brightest channel {:>11} {:>11} {:>11} {:>11} {:>11}",
        "W", "W/m2", "lux", "W/sr", "cd"
    )?;
    for light in lights {
        let power = light.power.at(time_s).max_element();
        let [watts, per_m2, lux, per_sr, candela] = match light.kind {
            LightKind::Sun | LightKind::SunDisc(_) => {
                [None, Some(power), Some(power * LUMENS_PER_WATT), None, None]
            }
            LightKind::Point | LightKind::Sphere { .. } | LightKind::Spot { .. } => {
                [Some(power * 4.0 * PI), None, None, Some(power), Some(power * LUMENS_PER_WATT)]
            }
            // A Lambertian emitter's axial intensity is its power over pi.
            LightKind::Area { .. } => {
                [Some(power), None, None, Some(power / PI), Some(power / PI * LUMENS_PER_WATT)]
            }
        };
        write!(out, "      {:<28} ", format!("`{}`", light.name))?;
        for number in [watts, per_m2, lux, per_sr, candela] {
            match number {
                Some(number) => write!(out, " {number:>11.5}")?,
                None => write!(out, " {:>11}", "-")?,
            }
        }
        writeln!(out)?;
    }
    Ok(())
}
