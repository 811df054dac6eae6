//! Blender's own evaluation of a scene, as the samples' `*.gt.json` hold it, and distances from it.

use crate::blender::samples;
use serde_json::Value;
use std::f64::consts::PI;

/// One `*.gt.json`.
pub(crate) struct Truth {
    json: Value,
}

impl Truth {
    pub(crate) fn read(name: &str) -> Self {
        let bytes = std::fs::read(samples::path(name)).unwrap();
        Self { json: serde_json::from_slice(&bytes).unwrap() }
    }

    pub(crate) fn frames(&self) -> impl Iterator<Item = &Value> {
        self.json["frames"].as_array().unwrap().iter()
    }
}

/// Row by row.
pub(crate) fn matrix(numbers: &Value) -> Vec<f64> {
    let numbers: Vec<f64> =
        numbers.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect();
    assert_eq!(numbers.len(), 16);
    numbers
}

fn at(rows: &Value, row: usize, column: usize) -> f64 {
    rows[row][column].as_f64().unwrap()
}

/// Of the last column, where something is, and of the others.
pub(crate) fn world_differences(ours: &[f64], theirs: &Value) -> (f64, f64) {
    let difference = |index: usize| (ours[index] - at(theirs, index / 4, index % 4)).abs();
    let (places, axes): (Vec<usize>, Vec<usize>) = (0..16).partition(|index| index % 4 == 3);
    let worst = |indices: Vec<usize>| indices.into_iter().map(difference).fold(0.0, f64::max);
    (worst(places), worst(axes))
}

/// All but depth, which Blender maps to its clipping planes: the third row.
pub(crate) fn projection_difference(ours: &[f64], theirs: &Value) -> f64 {
    let difference = |index: usize| (ours[index] - at(theirs, index / 4, index % 4)).abs();
    (0..16).filter(|index| index / 4 != 2).map(difference).fold(0.0, f64::max)
}

/// Largest relative difference of a light's power and angles.
pub(crate) fn light_difference(ours: Option<&Value>, theirs: &Value) -> f64 {
    let Some(ours) = ours else { return f64::INFINITY };
    let number = |name: &str| theirs[name].as_f64().unwrap();
    let relative = |ours: f64, theirs: f64| if ours == theirs { 0.0 } else { (ours / theirs - 1.0).abs() };
    let watts = number("energy") * theirs["exposure"].as_f64().unwrap_or(0.0).exp2();
    // Blender gives a lamp of P watts the intensity P / (4 pi); a sun's watts are W/m2; an area
    // light's watts are light (measured in Cycles 5.0.1: tools/peers/compare_cycles.py).
    let (field, expected) = match theirs["type"].as_str().unwrap() {
        "SUN" => ("irradiance_w_per_m2", watts),
        "AREA" => ("power_w", watts),
        _ => ("intensity_w_per_sr", watts / (4.0 * PI)),
    };
    let power = ours[field].as_array().unwrap_or_else(|| panic!("no {field} in {ours}"));
    let color = theirs["color"].as_array().unwrap();
    let mut worst = (0..3)
        .map(|channel| {
            relative(power[channel].as_f64().unwrap(), expected * color[channel].as_f64().unwrap())
        })
        .fold(0.0, f64::max);
    if let Some(size) = theirs.get("spot_size").and_then(Value::as_f64) {
        worst = worst.max(relative(ours["outer_rad"].as_f64().unwrap(), size / 2.0));
        worst = worst.max((ours["blend"].as_f64().unwrap() - number("spot_blend")).abs());
    }
    worst
}
