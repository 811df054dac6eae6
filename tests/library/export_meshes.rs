//! Meshes written as glTF and read back.

use glam::{DAffine3, DVec3, Vec2, Vec3, Vec4};
use std::path::Path;
use sunfleck::scene::{
    self, Instance, Material, Mesh, Motion, Node, RenderSettings, Scene, Texture, TextureMap, Track,
    Triangle, Wrap,
};
use sunfleck::{description, export};

/// A flat mesh has no normals, without which glTF knows no tangents; those here are not what its texture
/// coordinates would give, as where a texture transform turns them.
#[test]
fn flat_meshes_keep_tangents_for_their_normal_maps() {
    let slanted = |x: f32, y: f32| Vec3::new(x, y, 0.3 * x * y);
    let mesh = Mesh {
        name: "roof".into(),
        positions: [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| slanted(x, y)).to_vec(),
        uvs: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
        tangents: vec![Vec3::new(0.6, 0.8, 0.0).extend(-1.0); 4],
        triangles: [[0, 1, 2], [0, 2, 3]].map(|vertices| Triangle { vertices, material: 0 }).to_vec(),
        ..Mesh::default()
    };
    let map = TextureMap { texture: 0, layer: 0 };
    let texels = vec![[0.5, 0.5, 1.0, 1.0]; 4].into();
    let scene = Scene {
        nodes: vec![Node {
            name: "roof".into(),
            parent: None,
            motion: Motion::Still(DAffine3::IDENTITY),
            visible: Track::from(true),
        }],
        materials: vec![Material { normal_map: Some((map, 1.0)), ..Material::default() }],
        textures: vec![Texture {
            name: "bumps".into(),
            width: 2,
            height: 2,
            texels,
            wrap: [Wrap::Repeat; 2],
        }],
        instances: vec![Instance { node: 0, mesh: 0, material: None, leaf_id: 1, deformation: None }],
        meshes: vec![mesh.clone()],
        ..Scene::default()
    };
    let exported = export::glb(&scene, &RenderSettings::default(), Path::new("")).unwrap();
    assert!(exported.remarks.0.is_empty(), "{}", exported.remarks);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.glb");
    std::fs::write(&path, [exported.head, exported.binary].concat()).unwrap();
    let (again, _) = scene::resolve(description::load(&path).unwrap(), None).unwrap();

    let found = &again.meshes[0];
    let corners =
        |mesh: &Mesh| mesh.triangles.iter().flat_map(|triangle| triangle.vertices).collect::<Vec<u32>>();
    assert_eq!(corners(found).len(), corners(&mesh).len());
    for (ours, theirs) in corners(found).into_iter().zip(corners(&mesh)) {
        let (ours, theirs) = (ours as usize, theirs as usize);
        assert_eq!(found.positions[ours], mesh.positions[theirs]);
        assert_eq!(found.uvs[ours], mesh.uvs[theirs]);
        assert!((found.tangents[ours] - mesh.tangents[theirs]).abs().max_element() < 1e-6);
    }
    for Triangle { vertices, .. } in &found.triangles {
        let [a, b, c] = vertices.map(|vertex| found.positions[vertex as usize].as_dvec3());
        let normal: DVec3 = (b - a).cross(c - a).normalize();
        for vertex in vertices {
            assert!((found.normals[*vertex as usize].as_dvec3() - normal).length() < 1e-6);
        }
    }
    assert_eq!(found.tangents[0].w, Vec4::NEG_W.w);
}
