//! stub
#![allow(missing_docs)]
use crate::math::{IntervalSet, Ray};
use glam::{DAffine3, DVec3, Vec3};
use std::sync::Arc;
pub struct MeshTree;
impl MeshTree {
    pub fn new(_: &[Vec3], _: &[[u32; 3]]) -> Self {
        Self
    }
}
pub struct PlacedMesh {
    pub mesh: Arc<MeshTree>,
    pub relative_from_mesh: DAffine3,
}
pub struct InstanceTree;
impl InstanceTree {
    pub fn new(_: Vec<PlacedMesh>) -> Self {
        Self
    }
    pub fn nearest_hit(&self, _ray: &Ray, _t_max: f64, _skip: Option<PrimitiveId>) -> Option<Hit> {
        None
    }
    pub fn any_hit(&self, _ray: &Ray, _t_max: f64, _skip: Option<PrimitiveId>) -> bool {
        false
    }
    pub fn add_shadows(&self, _plane: &LightPlane, _shadows: &mut IntervalSet) {}
}
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrimitiveId {
    pub instance: u32,
    pub triangle: u32,
}
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    pub t: f64,
    pub primitive: PrimitiveId,
    pub barycentrics: [f64; 2],
}
pub struct LightPlane;
impl LightPlane {
    pub fn towards_direction(_ray: &Ray, _to_light: DVec3, _t_range: (f64, f64)) -> Option<Self> {
        Some(Self)
    }
    pub fn towards_point(_ray: &Ray, _light: DVec3, _t_range: (f64, f64)) -> Option<Self> {
        Some(Self)
    }
}
