//! Passes: pictures that a frame can hold beside its beauty. In goes a name, out come channels and the rule
//! for pixels. Invariant: all properties of a pass are in one row of one table, except its value
//! (`film/pass_value.rs`).
//!
//! Channels have the names and types that Blender 5 shows as Depth, Normal, Position and Vector. A layer's
//! name has no dots.

use serde::Deserialize;

/// Precision of a stored channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// 16-bit floating point, up to 65504.
    Half,
    /// 32-bit floating point.
    Float,
}

/// Rule that makes a pixel's value from its samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelRule {
    /// The weighted mean; a sample that shows no surface counts as the background.
    Mean,
    /// The sample nearest to the pixel's centre. A mean of depths or of ids lies on neither surface;
    /// Cycles does the same.
    Nearest,
    /// Ids ranked by coverage.
    Ranked,
    /// Computed from the finished picture; samples have no value of it.
    Estimate,
}

/// Data that a pass needs beyond light along a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// Nothing.
    Light,
    /// The visible surface.
    Surface,
    /// The surface, and its position a frame before and after.
    Motion,
    /// The surface, and its name.
    Names,
}

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub struct PassRow {
    /// Name on the command line and in glTF.
    pub name: &'static str,
    /// Description, for `--help`.
    pub shows: &'static str,
    /// Full names, at most four, or three if they are averaged. Empty if the pass is written separately.
    pub channels: &'static [&'static str],
    /// Precision of the channels.
    pub precision: Precision,
    /// Rule that makes a pixel's value from its samples.
    pub rule: PixelRule,
    /// Needs of the pass.
    pub needs: Needs,
    /// Unit of the values, `1` if they have none.
    pub unit: &'static str,
    /// Value without a surface.
    pub background: f32,
}

/// Name of Cryptomatte's layers, without their numbers.
pub const MATTE_LAYER: &str = "CryptoObject";

/// Depth of a pixel without a surface. Many readers cannot handle infinity; Cycles writes this number.
const BACKGROUND_DEPTH_M: f32 = 1e10;

macro_rules! passes {
    ($($variant:ident $name:literal $shows:literal [$($channel:literal),*] $precision:ident $rule:ident $needs:ident $unit:literal $background:expr;)*) => {
        /// Pass of a frame beside its beauty. RON files use the variants' names.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize)]
        #[non_exhaustive]
        pub enum Pass {
            $(#[doc = $shows] $variant,)*
        }

        impl Pass {
            /// All passes.
            pub const ALL: &[Self] = &[$(Self::$variant),*];

            /// Row of the table.
            pub const fn row(self) -> PassRow {
                match self {
                    $(Self::$variant => PassRow {
                        name: $name,
                        shows: $shows,
                        channels: &[$($channel),*],
                        precision: Precision::$precision,
                        rule: PixelRule::$rule,
                        needs: Needs::$needs,
                        unit: $unit,
                        background: $background,
                    },)*
                }
            }
        }
    };
}

// In the order of channels in a frame. Single precision holds ids exactly up to 2^24.
passes! {
    Shafts "shafts" "Light scattered in the fog" ["shafts.R", "shafts.G", "shafts.B"] Half Mean Light "W m^-2 sr^-1" 0.0;
    Transmittance "transmittance" "What the fog lets through from the surface" ["transmittance.R", "transmittance.G", "transmittance.B"] Half Mean Light "1" 0.0;
    Indirect "indirect" "Of the beauty, what surfaces show of indirect light" ["indirect.R", "indirect.G", "indirect.B"] Half Mean Light "W m^-2 sr^-1" 0.0;
    IndirectShafts "indirect-shafts" "Of the shafts, what fog scatters of indirect light" ["indirect_shafts.R", "indirect_shafts.G", "indirect_shafts.B"] Half Mean Light "W m^-2 sr^-1" 0.0;
    Depth "depth" "Distance along the view axis, metres" ["Z"] Float Nearest Surface "m" BACKGROUND_DEPTH_M;
    Normal "normal" "Shading normal in world space" ["Normal.X", "Normal.Y", "Normal.Z"] Float Mean Surface "1" 0.0;
    Position "position" "World position, metres" ["Position.X", "Position.Y", "Position.Z"] Float Nearest Surface "m" 0.0;
    Albedo "albedo" "Lambert reflectance" ["albedo.R", "albedo.G", "albedo.B"] Half Mean Surface "1" 0.0;
    LeafId "leaf-id" "Which instance" ["leaf_id.X"] Float Nearest Surface "id" 0.0;
    Error "error" "The estimated relative error of the block of pixels around" ["error.Y"] Half Estimate Light "1" 0.0;
    Motion "motion" "Where things move, in pixels" ["Vector.X", "Vector.Y", "Vector.Z", "Vector.W"] Float Nearest Motion "px" 0.0;
    Cryptomatte "cryptomatte" "Which objects cover how much of a pixel" [] Float Ranked Names "id" 0.0;
}

impl Pass {
    /// Name on the command line and in glTF.
    pub const fn name(self) -> &'static str {
        self.row().name
    }

    /// Pass of the given name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|pass| pass.name() == name)
    }

    /// All names, for an error about an unknown one.
    pub fn names() -> String {
        Self::ALL.iter().map(|pass| pass.name()).collect::<Vec<_>>().join(", ")
    }
}

/// Whether some pass has a need that satisfies `what`.
pub fn any_needs(passes: &[Pass], what: impl Fn(Needs) -> bool) -> bool {
    passes.iter().any(|pass| what(pass.row().needs))
}
