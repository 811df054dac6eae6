//! OpenVDB files as Blender writes them (tests/data/vdb/make.py), whole and damaged.

use crate::checkout;
use glam::DVec3;
use std::path::Path;
use sunfleck::description::LoadError;
use sunfleck::description::vdb::{self, Grid, Leaf};

fn bytes(name: &str) -> Vec<u8> {
    std::fs::read(checkout::file("tests/data/vdb").join(name)).expect("a file")
}

fn parsed(bytes: &[u8]) -> Result<Vec<Grid>, LoadError> {
    vdb::parse(bytes, Path::new("made.vdb"))
}

#[test]
fn every_voxel_has_the_value_and_place_that_blender_gave_it() {
    let grids = parsed(&bytes("several.vdb")).expect("a valid file");
    let names: Vec<_> = grids.iter().map(|grid| grid.name.as_str()).collect();
    assert_eq!(names, ["density", "heat", "velocity", "nothing"]);
    assert!(grids[2].floats.is_none(), "vectors are no numbers");
    assert!(grids[3].floats.as_ref().expect("floats").extent().is_none(), "it has no voxels");
    for grid in &grids[..2] {
        let floats = grid.floats.as_ref().expect("floats");
        let voxels: Vec<_> = floats.tree.leaves().flat_map(Leaf::voxels).collect();
        let (block, lines): (Vec<_>, Vec<_>) = voxels.into_iter().partition(|(voxel, _)| voxel[0] > 100);
        assert_eq!(lines.len(), 11 * 3 * 4);
        for ([i, j, k], value) in lines {
            assert_eq!(value, 2.25 + i as f32 * 0.5 + j as f32 * 0.0625 + k as f32 * 0.125, "{i} {j} {k}");
        }
        assert!(block.iter().all(|(_, value)| *value == 0.75));
        let in_tiles: usize = floats.tree.tiles.iter().map(|tile| (tile.edge as usize).pow(3)).sum();
        assert_eq!(block.len() + in_tiles, 16 * 8 * 8);
        // Rows are multiplied by vectors from the left: i goes along y, j along -x.
        let place = floats.transform.transform_point3(DVec3::new(2.0, 4.0, 8.0));
        assert_eq!(place, DVec3::new(0.0, 3.0, 4.0));
    }
}

/// Floats, doubles, doubles as halves, whole numbers of 32 and 64 bits, and vectors of doubles.
#[test]
fn every_kind_of_number_is_read() {
    let grids = parsed(&bytes("numbers.vdb")).expect("a valid file");
    let (vectors, numbers) = grids.split_last().expect("grids");
    assert_eq!(numbers.len(), 5);
    for grid in numbers {
        let floats = grid.floats.as_ref().unwrap_or_else(|| panic!("{} is not read", grid.kind));
        let values: Vec<_> = floats.tree.leaves().flat_map(Leaf::voxels).collect();
        let expected: Vec<_> = (0..10_i16).map(|i| ([i.into(), 0, 0], f32::from(i) + 1.0)).collect();
        assert_eq!(values, expected, "{}", grid.kind);
    }
    let vectors = vectors.vectors.as_ref().expect("vectors");
    let values: Vec<_> = vectors.tree.leaves().flat_map(Leaf::voxels).collect();
    assert_eq!(values[9], ([9, 0, 0], [10.0, 18.0, -1.0]));
}

#[test]
fn a_billion_voxels_take_no_more_than_their_tiles() {
    let grids = parsed(&bytes("billion.vdb")).expect("a valid file");
    let floats = grids[0].floats.as_ref().expect("floats");
    let extent = floats.extent().expect("voxels");
    assert_eq!((extent.voxels, extent.mean), (1 << 30, 0.5));
    assert!(floats.tree.memory() < 20_000, "{} bytes", floats.tree.memory());
}

#[test]
fn a_file_that_ends_early_is_refused_with_the_place() {
    let whole = bytes("several.vdb");
    for length in (0..whole.len() - 100).step_by(397) {
        let error = parsed(&whole[..length]).expect_err("it is cut").diagnostics().to_string();
        assert!(error.contains("made.vdb") && error.contains("(byte "), "{length}: {error}");
        assert!(error.contains("remedy"), "{length}: {error}");
    }
}

#[test]
fn flipped_bits_are_answered() {
    let whole = bytes("several.vdb");
    let mut refused = 0;
    // All of the header and the first nodes, and some of what follows.
    for at in (0..1500).chain((1500..whole.len()).step_by(101)) {
        let mut damaged = whole.clone();
        damaged[at] ^= 1 << (at % 8);
        refused += usize::from(parsed(&damaged).is_err());
    }
    assert!(refused > 100, "only {refused} are refused");
}
