//! What breaks renderers, one file a hazard, each against a slow truth in double precision or a closed
//! form. What was found, with the measured errors, is in docs/builders/numerics.md.

mod compare;
mod fog_truth;
mod scenes;
mod truth;

mod alignment;
mod edges;
mod fence;
mod fog;
mod height;
mod hostile;
mod light_places;
mod pictures;
mod places;
mod sun_disc;
mod triangles;
