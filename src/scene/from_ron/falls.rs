//! Blocks of falling leaves. In go those of a file, out come nodes with keys and instances. Invariant: until
//! it lands, leaf `i` depends on its block's fields other than `count`, and on `i`. An object with the leaf's
//! name takes precedence.

use super::Resolver;
use crate::color::Rgb;
use crate::description::ron;
use crate::diagnostic::{Diagnostic, Loss};
use crate::math::Chance;
use crate::scene::fall::{
    Eddies, Emitter, Fall, Fallen, Ground, Gusts, LONGEST_FLIGHT_S, Obstacles, Outline, Species, Surface,
    Wind, at_rest, sum_of_shares,
};
use crate::scene::{
    Baking, Extend, Key, MaterialIndex, MeshIndex, Motion, RayVisibility, Rotation, Segment, Track,
};
use glam::{DAffine3, DVec3};
use std::collections::BTreeMap;

/// Maximum ratio of a mesh's width to its length, as leaves have samples all over their scaled blades.
const MOST_WIDTH_TO_LENGTH: f64 = 100.0;
/// Maximum height of the start, as higher leaves would fall for minutes.
const HIGHEST_START_M: f64 = 200.0;

/// Triangles of all ground objects, by name; `None` for one that cannot be a ground, which is reported
/// already.
type Grounds<'a> = BTreeMap<&'a str, Option<Vec<[DVec3; 3]>>>;

/// Meshes, materials and tints of a species.
struct Dress {
    meshes: Vec<MeshIndex>,
    materials: Vec<MaterialIndex>,
    tint: Vec<Rgb>,
}

/// Draw of a leaf's tint, beyond those of a flight.
const TINT: u64 = 1 << 32;

/// Block with the meshes and materials of its leaves.
struct Flock<'a> {
    name: &'a str,
    block: &'a ron::Fall,
    fall: Fall,
    dresses: Vec<Dress>,
}

impl Resolver<'_> {
    /// Simulates the leaves of all blocks, which come to rest on each other where they share a ground.
    pub(super) fn falls(&mut self, baking: &Baking) {
        let file = self.file;
        let mut grounds = Grounds::new();
        for (name, block) in file.fall.iter() {
            if let Some(object) = &block.ground.object {
                let field = format!("fall.{name}.ground.object");
                // Reported for each block that names it.
                if grounds.get(object.as_str()).is_none_or(Option::is_none) {
                    grounds.insert(object, self.still_triangles(&field, object));
                }
            }
        }
        let blocks = file.fall.iter();
        let mut flocks: Vec<Flock<'_>> =
            blocks.filter_map(|(name, block)| self.flock(name, block, &grounds)).collect();
        while !flocks.is_empty() {
            let ground = flocks[0].block.ground.clone();
            let (together, others) = flocks.into_iter().partition(|flock| flock.block.ground == ground);
            flocks = others;
            self.come_to_rest(&together, baking);
        }
    }

    fn come_to_rest(&mut self, flocks: &[Flock<'_>], baking: &Baking) {
        let falls: Vec<&Fall> = flocks.iter().map(|flock| &flock.fall).collect();
        for (leaves, Flock { name, block, dresses, .. }) in at_rest(&falls, baking).into_iter().zip(flocks) {
            let in_the_air = leaves.iter().filter(|leaf| !leaf.landed).count();
            if in_the_air > 0 {
                let found = format!(
                    "{in_the_air} of {} leaves are in the air for longer than {LONGEST_FLIGHT_S} s, and stay there",
                    leaves.len()
                );
                let place = self.problems.place(&format!("fall.{name}"));
                self.scene.remarks.push(Diagnostic::warning(Loss::LeavesInTheAir, place, found));
            }
            for (number, leaf) in leaves.into_iter().enumerate() {
                let tint = Chance::of(block.seed, number as u32).at(TINT);
                self.fallen((format!("{name}.{number}"), tint), leaf, dresses, block);
            }
        }
    }

    fn flock<'b>(&mut self, name: &'b str, block: &'b ron::Fall, grounds: &Grounds<'_>) -> Option<Flock<'b>> {
        let owner = format!("fall.{name}");
        if !self.has_room_for(&owner, block.count.0) || !self.has_room_to_fall(&owner, block.count.0) {
            return None;
        }
        let species = self.species(&owner, block);
        let emitter = self.emitter(&owner, &block.emitter);
        let wind = self.wind(&owner, &block.wind);
        let motion = block.motion.as_ref().map_or(Some(()), |motion| self.check_motion(&owner, motion));
        let ground = ground(&block.ground, grounds);
        let obstacles = self.obstacles(&owner, &block.obstacles);
        let ((species, dresses), emitter) = (species?, emitter?);
        let speed_gain = self.keyed(&owner, "speed", &block.speed);
        let (wind, (), ground, obstacles) = (wind?, motion?, ground?, obstacles?);
        let height_m = emitter.highest_m() - block.ground.height_m.si();
        if height_m > HIGHEST_START_M {
            let found = format!("leaves would start {height_m} m above the ground");
            let expected = format!("at most {HIGHEST_START_M} m from `ground.height_m` to the highest leaf");
            let remedy = "lower the emitter, or raise `ground.height_m`";
            self.problems.error(&format!("{owner}.emitter"), found, &expected, remedy);
            return None;
        }
        let fall = Fall {
            count: block.count.0,
            seed: block.seed,
            species,
            motion: block.motion.clone(),
            emitter,
            wind,
            ground,
            obstacles,
            release_s: (block.release_s.at(0.0), block.release_s.at(1.0)),
            speed_gain: speed_gain?,
        };
        Some(Flock { name, block, fall, dresses })
    }

    /// Adds to the number of falling leaves; returns false, after a report, if there are too many.
    fn has_room_to_fall(&mut self, owner: &str, leaves: u32) -> bool {
        self.fall_count = self.fall_count.saturating_add(leaves);
        if self.fall_count > ron::MOST_FALLING {
            let found = format!("with this block {} leaves fall", self.fall_count);
            let expected = format!("at most {} leaves in all `fall` blocks together", ron::MOST_FALLING);
            let remedy = "use fewer, or meshes that hold several leaves";
            self.problems.error(&format!("{owner}.count"), found, &expected, remedy);
        }
        let all = self.file.fall.iter().map(|(_, block)| u64::from(block.count.0)).sum::<u64>();
        all <= u64::from(ron::MOST_FALLING)
    }

    fn fallen(&mut self, (name, chance): (String, f64), leaf: Fallen, dresses: &[Dress], block: &ron::Fall) {
        let Dress { meshes, materials, tint } = &dresses[leaf.species];
        let mesh = meshes[leaf.outline];
        let material = materials.get((leaf.material * materials.len() as f64) as usize).copied();
        let dress = (material, self.tinted(material, tint, chance));
        let &ron::Fall { visible_to_camera, casts_shadow, holdout, attached, .. } = block;
        let rays = RayVisibility { visible_to_camera, casts_shadow, holdout };
        if let Some(&node) = self.nodes.get(name.as_str()) {
            // The author has animated this leaf; an object with a mesh of its own is placed already.
            if self.file.objects.get(&name).is_some_and(|object| object.mesh.is_none()) {
                let scale = Motion::Still(DAffine3::from_scale(DVec3::splat(leaf.scale)));
                let node = self.scene.add_node(name, Some(node), scale);
                self.scene.set_ray_visibility(node, rays);
                self.tinted_instance(node, mesh, dress);
            }
            return;
        }
        let motion = Motion::Keyed {
            translation: leaf.translation,
            rotation: Rotation::Quaternion(leaf.rotation),
            scale: DVec3::splat(leaf.scale).into(),
        };
        let node = self.scene.add_node(name, None, motion);
        if !attached {
            let key = |time_s, value| Key { time_s, value, to_next: Segment::Step };
            let keys = vec![key(leaf.release_s - 1.0, false), key(leaf.release_s, true)];
            if let Some(visible) = Track::new(keys, Extend::Hold) {
                self.scene.nodes[node].visible = visible;
            }
        }
        self.scene.set_ray_visibility(node, rays);
        self.tinted_instance(node, mesh, dress);
    }

    fn species(&mut self, owner: &str, block: &ron::Fall) -> Option<(Vec<Species>, Vec<Dress>)> {
        if block.species.is_empty() {
            let remedy = "add `species: [(meshes: [\"leaf\"], length_m: 0.08)]`";
            let field = format!("{owner}.species");
            self.problems.error(&field, "the list is empty", "at least one species", remedy);
            return None;
        }
        let all = block.species.iter().enumerate();
        let found: Vec<_> =
            all.map(|(at, species)| self.one_species(&format!("{owner}.species[{at}]"), species)).collect();
        found.into_iter().collect::<Option<Vec<_>>>().map(|found| found.into_iter().unzip())
    }

    fn one_species(&mut self, owner: &str, species: &ron::Species) -> Option<(Species, Dress)> {
        let meshes = self.leaf_meshes(owner, &species.meshes);
        let materials = self.leaf_materials(owner, &species.materials);
        self.check_tint(owner, !species.tint.is_empty(), &species.materials);
        let tint = species.tint.iter().map(|color| color.si()).collect();
        let (meshes, materials) = (meshes?, materials?);
        let outlines: Vec<_> = (meshes.iter())
            .map(|&mesh| {
                let mesh = &self.scene.meshes[mesh];
                let vertices: Vec<DVec3> = mesh.positions.iter().map(|point| point.as_dvec3()).collect();
                let triangles: Vec<_> = mesh.triangles.iter().map(|triangle| triangle.vertices).collect();
                Outline::new(&vertices, &triangles)
            })
            .collect();
        if let Some(at) = outlines.iter().position(Option::is_none) {
            let found =
                format!("the mesh `{}` has no length along z or no width along x", species.meshes[at]);
            let remedy = "turn the mesh so that the leaf lies flat, its tip towards -z";
            self.problems.error(&format!("{owner}.meshes[{at}]"), found, "a leaf in the x-z plane", remedy);
        }
        let widest = outlines.iter().map(|outline| outline.as_ref().map_or(0.0, Outline::width_to_length));
        if let Some((at, ratio)) = widest.enumerate().find(|(_, ratio)| *ratio > MOST_WIDTH_TO_LENGTH) {
            let found = format!("the mesh `{}` is {ratio:.0} times as wide as long", species.meshes[at]);
            let expected = format!("a leaf, at most {MOST_WIDTH_TO_LENGTH} times as wide as long");
            let remedy = "turn the mesh so that the leaf's tip points towards -z, or correct its length";
            self.problems.error(&format!("{owner}.meshes[{at}]"), found, &expected, remedy);
            return None;
        }
        let range = |span: ron::Span<ron::LeafLength>| (span.at(0.0), span.at(1.0));
        let mass = species.areal_mass_kg_per_m2;
        let resolved = Species {
            share: species.share.si(),
            outlines: outlines.into_iter().collect::<Option<_>>()?,
            length_m: range(species.length_m),
            width_m: species.width_m.map(range),
            areal_mass_kg_per_m2: (mass.at(0.0), mass.at(1.0)),
            curl: (species.curl_deg.at(0.0), species.curl_deg.at(1.0)),
        };
        Some((resolved, Dress { meshes, materials, tint }))
    }

    fn emitter(&mut self, owner: &str, emitter: &ron::Emitter) -> Option<Emitter> {
        let owner = format!("{owner}.emitter");
        match emitter {
            ron::Emitter::Box { min_m, max_m } => {
                let (low, high) = (min_m.si(), max_m.si());
                if !low.cmple(high).all() {
                    let found = "`min_m` has a larger coordinate than `max_m`";
                    self.problems.error(&owner, found, "min_m <= max_m in x, y and z", "exchange the two");
                    return None;
                }
                Some(Emitter::Box(low, high))
            }
            ron::Emitter::Ellipsoid { center_m, radii_m } => {
                Some(Emitter::Ellipsoid(center_m.si(), radii_m.si()))
            }
            ron::Emitter::Surface { object } => {
                let field = format!("{owner}.object");
                let surface = Surface::new(self.still_triangles(&field, object)?);
                if surface.is_none() {
                    let found = format!("the mesh of `{object}` has no area");
                    let remedy = "name an object with a mesh that can be seen";
                    self.problems.error(&field, found, "a surface", remedy);
                }
                surface.map(Emitter::Surface)
            }
        }
    }

    fn wind(&mut self, owner: &str, wind: &ron::Wind) -> Option<Wind> {
        let owner = format!("{owner}.wind");
        let mean = self.keyed(&owner, "mean_m_per_s", &wind.mean_m_per_s)?;
        let gust = self.keyed(&owner, "gust_m_per_s", &wind.gust_m_per_s)?;
        let eddy = self.keyed(&owner, "eddy_m_per_s", &wind.eddy_m_per_s)?;
        if mean.hull().iter().any(|mean| mean.y != 0.0) {
            let found = "the mean wind blows up or down, for ever";
            let remedy = "make its y 0; gusts and eddies go up and down";
            let field = format!("{owner}.mean_m_per_s");
            self.problems.error(&field, found, "a wind along the ground", remedy);
            return None;
        }
        Some(Wind::new(
            mean,
            Gusts { speed_m_per_s: gust, every_s: wind.gust_s.si() },
            Eddies { speed_m_per_s: eddy, size_m: wind.eddy_m.si() },
            wind.seed,
        ))
    }

    /// Refuses weights of modes that are all 0.
    fn check_motion(&mut self, owner: &str, motion: &ron::FallMotion) -> Option<()> {
        if sum_of_shares(motion) == 0.0 {
            let expected = "a share of `steady`, `flutter`, `tumble`, `chaotic`, `helical` or `spiral`";
            let remedy = "give one of them a share, or take `motion` out";
            self.problems.error(&format!("{owner}.motion"), "all shares are 0", expected, remedy);
            return None;
        }
        Some(())
    }

    fn obstacles(&mut self, owner: &str, names: &[String]) -> Option<Obstacles> {
        let named = names.iter().enumerate();
        let found: Vec<_> =
            named.map(|(at, name)| self.still_triangles(&format!("{owner}.obstacles[{at}]"), name)).collect();
        let triangles: Vec<_> = found.into_iter().collect::<Option<_>>()?;
        Some(Obstacles::new(&triangles.concat()))
    }

    /// Triangles of an object's mesh in the world, if it never moves.
    pub(super) fn still_triangles(&mut self, field: &str, name: &str) -> Option<Vec<[DVec3; 3]>> {
        let node = self.problems.find(field, "object", name, &self.nodes)?;
        if self.changes_shape(field, name) {
            return None;
        }
        let mut world_from_node = DAffine3::IDENTITY;
        let mut next = Some(node);
        while let Some(node) = next {
            let Motion::Still(parent_from_node) = self.scene.nodes[node].motion else {
                let found = format!("the object `{name}` moves, or follows one that does");
                let remedy = "name an object without keys";
                self.problems.error(field, found, "an object that stays where it is", remedy);
                return None;
            };
            world_from_node = parent_from_node * world_from_node;
            next = self.scene.nodes[node].parent;
        }
        let instance = self.scene.instances.iter().find(|instance| instance.node == node);
        let Some(instance) = instance else {
            let remedy = "name an object with a `mesh`";
            self.problems.error(field, format!("the object `{name}` has no mesh to see"), "a mesh", remedy);
            return None;
        };
        let mesh = &self.scene.meshes[instance.mesh];
        let point =
            |vertex: u32| world_from_node.transform_point3(mesh.positions[vertex as usize].as_dvec3());
        Some(mesh.triangles.iter().map(|triangle| triangle.vertices.map(point)).collect())
    }
}

/// Ground of a block: outside its own object, leaves land on those of other blocks.
fn ground(ground: &ron::FallGround, grounds: &Grounds<'_>) -> Option<Ground> {
    let own = ground.object.as_deref();
    let triangles = own.map_or(Some(Vec::new()), |object| grounds.get(object)?.clone())?;
    let others = grounds.iter().filter(|(object, _)| Some(**object) != own);
    let others = others.filter_map(|(_, triangles)| triangles.as_deref()).flatten();
    Some(Ground::new(ground.height_m.si(), triangles, others.copied().collect()))
}
