//! EXR files of frames, with their provenance. In go a [`Frame`] and its [`Provenance`], out comes a file
//! that is whole or absent, and back. Invariants: the same frame and provenance give the same bytes. A file
//! has its final name only once all its bytes are on the disk.
//!
//! # What a file looks like
//! One part, scan lines, ZIP, channels sorted by name, header attributes sorted by name. The display window
//! is the full picture, the data window the part that was rendered. Colours are linear Rec. 709:
//! `chromaticities` say so to programs of before 2025, `colorInteropID` to those since. Besides the standard
//! attributes:
//!
//! | attribute | what |
//! |---|---|
//! | `sunfleck:version` | version of this program |
//! | `sunfleck:sceneHash`, `sunfleck:settingsHash` | what was rendered, and how |
//! | `sunfleck:pixelHash` | SHA-256 of the pixels, see below |
//! | `sunfleck:fileHash` | SHA-256 of the whole file, with zeros for its own digits |
//! | `sunfleck:seed`, `sunfleck:samples` | decimal texts |
//! | `sunfleck:sequenceFrames` | the input's first and last frame, `1-48`, whatever a run was asked for |
//!
//! # The pixel hash
//! SHA-256 over the channels in order of their names. Of each come its name, a zero byte, its type (`half`,
//! `float` or `uint`) and a zero byte. Then come its values as stored: little-endian, row by row from the top
//! of the data window. From the file alone, in Python:
//!
//! ```python
//! import hashlib, OpenEXR
//! part = OpenEXR.File("name.0001.exr", separate_channels=True)
//! digest = hashlib.sha256()
//! kinds = {"e": ("half", "<f2"), "f": ("float", "<f4"), "I": ("uint", "<u4")}
//! for name, channel in sorted(part.channels().items(), key=lambda item: item[0].encode()):
//!     kind, stored = kinds[channel.pixels.dtype.char]
//!     digest.update(name.encode() + b"\0" + kind.encode() + b"\0" + channel.pixels.astype(stored).tobytes())
//! assert digest.hexdigest() == part.header()["sunfleck:pixelHash"]
//! ```
//!
//! [`Frame`]: crate::film::Frame

mod animated_png;
mod animated_webp;
mod animation;
mod atomic;
mod bloom;
mod compare;
mod cryptomatte;
mod difference_picture;
mod encode;
mod error;
mod file_hash;
mod folder;
mod leftovers;
mod limits;
mod pixel_hash;
mod preview;
mod provenance;
mod read;
mod region;
mod shown;

pub use animation::Animation;
pub use atomic::{abandon_writes, check_folder, check_name, folder_of, write_whole};
pub use compare::{ChannelErrors, CompareError, Comparison, Errors, IdErrors, compare, net_rmse};
pub use difference_picture::difference_picture;
pub use encode::write;
pub use error::{FrameFileError, RAISE_LIMIT, WITHIN_LIMIT};
pub use folder::{folder_below, frames_in, is_of_frames, is_of_many};
pub use leftovers::{final_name, remove_abandoned};
pub use limits::{Limit, Measure, exceeded};
pub use preview::{Picture, write_preview};
pub use provenance::{Attributes, Provenance};
pub use read::{FrameFile, is_valid, read, read_both};
