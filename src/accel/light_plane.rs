//! The plane through a ray and a light, which holds all points that can shadow the ray. In go a ray and a
//! light, out come affine functions of position. Invariant: all are computed in double precision.

use crate::math::Ray;
use glam::{DAffine3, DVec3};

/// Angle below which ray and light count as collinear, in radians: directions in double precision resolve no
/// less.
const COLLINEAR: f64 = 1e-14;

/// Angle below which triangles are cut in double precision, in radians, as errors grow as its inverse. Single
/// precision keeps five digits above it.
const NEARLY_COLLINEAR: f64 = 0.02;

/// Finite value for an infinite end of a range of distances, in metres, so that its product with 0 is 0.
const FAR: f64 = 1e30;

/// An affine function of position: `gradient . p + offset`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Functional {
    pub(super) gradient: DVec3,
    pub(super) offset: f64,
}

impl Functional {
    /// The function with this gradient that vanishes at `root`.
    pub(super) fn vanishing_at(root: DVec3, gradient: DVec3) -> Self {
        Self { gradient, offset: -gradient.dot(root) }
    }

    /// The function for positions relative to `by`.
    fn moved(&self, by: DVec3) -> Self {
        Self { gradient: self.gradient, offset: self.offset - self.gradient.dot(by) }
    }

    pub(super) fn at(&self, point: DVec3) -> f64 {
        self.gradient.dot(point) + self.offset
    }

    pub(super) fn negated(&self) -> Self {
        Self { gradient: -self.gradient, offset: -self.offset }
    }

    /// `self + factor * other`.
    pub(super) fn plus(&self, factor: f64, other: &Self) -> Self {
        Self {
            gradient: self.gradient + factor * other.gradient,
            offset: self.offset + factor * other.offset,
        }
    }

    /// The function for positions in the space that `to_here` maps from; it needs no inverse.
    pub(super) fn pulled_back(&self, to_here: &DAffine3) -> Self {
        Self {
            gradient: to_here.matrix3.transpose() * self.gradient,
            offset: self.gradient.dot(to_here.translation) + self.offset,
        }
    }
}

/// Functions of position that give the distance of a point's shadow along the ray.
///
/// A point `p` of the plane (`out_of_plane(p) = 0`) that lies on the light's side of the ray
/// (`towards_light(p) > 0`) shadows the ray at `t = along(p) / depth(p)`; points with `depth(p) <= 0` lie
/// beyond a point light and shadow nothing.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlaneFunctions {
    /// Distance out of the plane, in metres.
    pub(super) out_of_plane: Functional,
    /// Numerator of the shadow's distance along the ray.
    pub(super) along: Functional,
    /// Denominator of that distance; 1 everywhere for a directional light.
    pub(super) depth: Functional,
    /// Height above the ray, towards the light, in metres.
    pub(super) towards_light: Functional,
}

impl PlaneFunctions {
    /// Functions for positions in the space that `to_here` maps from.
    #[inline(always)]
    pub(super) fn pulled_back(&self, to_here: &DAffine3) -> Self {
        self.pulled_back_with(self.out_of_plane.pulled_back(to_here), to_here)
    }

    /// As [`Self::pulled_back`], where `out_of_plane` has been computed already.
    #[inline(always)]
    pub(super) fn pulled_back_with(&self, out_of_plane: Functional, to_here: &DAffine3) -> Self {
        Self {
            out_of_plane,
            along: self.along.pulled_back(to_here),
            depth: self.depth.pulled_back(to_here),
            towards_light: self.towards_light.pulled_back(to_here),
        }
    }

    /// Function that is not negative where the shadow is at or after distance `t`.
    #[inline(always)]
    pub(super) fn at_or_after(&self, t: f64) -> Functional {
        self.along.plus(-t, &self.depth)
    }
}

/// The plane through a ray and a light, with a range of the ray.
#[derive(Clone, Copy, Debug)]
pub struct LightPlane {
    pub(super) functions: PlaneFunctions,
    /// Range of the ray, in metres.
    pub(super) t_range: (f64, f64),
    /// Whether `depth` varies, as for a point light.
    pub(super) is_fan: bool,
    /// Whether the ray is so nearly parallel to the light that it needs double precision.
    pub(super) needs_doubles: bool,
}

impl LightPlane {
    /// Plane for light from the unit direction `to_light`; `None` if the ray is parallel to it, and so
    /// shadows itself.
    pub fn towards_direction(ray: &Ray, to_light: DVec3, t_range: (f64, f64)) -> Option<Self> {
        let normal = exact_cross(ray.direction, to_light);
        let sine = normal.length();
        if sine.is_nan() || sine <= COLLINEAR {
            return None;
        }
        let normal = normal / sine;
        // Vector identities save 1 - cos^2 and d - cos L from cancelling:
        // L x (d x L) = d - cos L and (d x L) x d = L - cos d.
        let along = to_light.cross(normal) / sine;
        let towards_light = normal.cross(ray.direction) / sine;
        Some(Self {
            functions: PlaneFunctions {
                out_of_plane: Functional::vanishing_at(ray.origin, normal),
                along: Functional::vanishing_at(ray.origin, along),
                depth: Functional { gradient: DVec3::ZERO, offset: 1.0 },
                towards_light: Functional::vanishing_at(ray.origin, towards_light),
            },
            t_range: finite(t_range),
            is_fan: false,
            needs_doubles: sine < NEARLY_COLLINEAR,
        })
    }

    /// Plane for light from the point `light`. `None` if it lies on the ray's line.
    pub fn towards_point(ray: &Ray, light: DVec3, t_range: (f64, f64)) -> Option<Self> {
        let to_light = light - ray.origin;
        let normal = exact_cross(ray.direction, to_light);
        let height = normal.length();
        if height.is_nan() || height <= COLLINEAR * to_light.length() {
            return None;
        }
        let normal = normal / height;
        let up = normal.cross(ray.direction);
        let foot = to_light.dot(ray.direction);
        // In the plane, with x along the ray and y up to the light at (foot, height), the light's ray
        // through (x, y) meets y = 0 at (x height - foot y) / (height - y); both are divided by the
        // height, so that a light far away becomes a directional one.
        let x = Functional::vanishing_at(ray.origin, ray.direction);
        let y = Functional::vanishing_at(ray.origin, up);
        let one = Functional { gradient: DVec3::ZERO, offset: 1.0 };
        Some(Self {
            functions: PlaneFunctions {
                out_of_plane: Functional::vanishing_at(ray.origin, normal),
                along: x.plus(-foot / height, &y),
                depth: one.plus(-1.0 / height, &y),
                towards_light: y,
            },
            t_range: finite(t_range),
            is_fan: true,
            needs_doubles: height < NEARLY_COLLINEAR * to_light.length(),
        })
    }

    /// The plane for positions relative to `by`.
    pub(super) fn moved(&self, by: DVec3) -> Self {
        let PlaneFunctions { out_of_plane, along, depth, towards_light } = &self.functions;
        let [out_of_plane, along, depth, towards_light] =
            [out_of_plane, along, depth, towards_light].map(|function| function.moved(by));
        Self { functions: PlaneFunctions { out_of_plane, along, depth, towards_light }, ..*self }
    }
}

fn finite((start, end): (f64, f64)) -> (f64, f64) {
    (start.clamp(-FAR, FAR), end.clamp(-FAR, FAR))
}

/// Cross product to within two roundings even where it cancels (Kahan's difference of products).
fn exact_cross(a: DVec3, b: DVec3) -> DVec3 {
    let difference = |a: f64, b: f64, c: f64, d: f64| {
        let product = c * d;
        let error = (-c).mul_add(d, product);
        a.mul_add(b, -product) + error
    };
    DVec3::new(difference(a.y, b.z, a.z, b.y), difference(a.z, b.x, a.x, b.z), difference(a.x, b.y, a.y, b.x))
}
