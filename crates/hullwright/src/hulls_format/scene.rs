//! `.hullscene`: the hulls of all meshes of a scene in one file, each mesh found by its content.

use std::collections::HashMap;
use std::path::Path;

use super::file::{
    HullsFile, HullsFileError, Reader, SCENE_FORMAT_VERSION, SCENE_MAGIC, begin, count, numbers,
    open, points, read_bytes, read_numbers, seal, text, valid,
};
use super::mesh_hash::MeshHash;
use super::surfaces::{BakedSurface, LEAST_SURFACE};
use crate::decomposition::ALGORITHM_VERSION;
use crate::geometry::MeshView;
use crate::method::Method;

/// Version 3 is as this one, but what it holds of a mesh may say what its hulls are made of: a
/// library that can't read that should say so of the whole file.
const WITHOUT_PARTS: u32 = 2;

/// The newest version without surfaces.
const WITHOUT_SURFACES: u32 = 3;

/// The hulls of all meshes of a scene.
///
/// ```
/// use hullwright::hulls_format::{BakedMesh, HullScene, HullsFile, MeshHash, SceneLookup};
/// use hullwright::{Control, Method, Parameters, decompose, mass_properties};
///
/// # let mesh = hullwright::TriangleMesh::new(
/// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
/// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
/// # );
/// let parameters = Parameters::default();
/// let decomposition = decompose(&mesh, &parameters, &Control::new())?;
/// let mass = mass_properties(&mesh, &decomposition.hulls, 1.0)?;
/// let hulls = HullsFile::new("rock", &decomposition).with_mass_properties(mass);
/// let scene = HullScene::new("level", vec![BakedMesh::new(&mesh, parameters, hulls)]);
/// assert_eq!(HullScene::from_bytes(&scene.to_bytes()?)?, scene);
///
/// let hash = MeshHash::of(&mesh);
/// let default = Method::default();
/// assert!(matches!(scene.look_up(hash, &default, &["rock"]), SceneLookup::Found(_)));
/// let finer = "max_error=1%".parse()?;
/// assert!(matches!(scene.look_up(hash, &finer, &["rock"]), SceneLookup::OtherParameters(_)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct HullScene {
    /// The scene's name; may be empty.
    pub name: String,
    /// Its meshes, each with its parameters at most once.
    pub meshes: Vec<BakedMesh>,
    /// The triangles of meshes, for what never moves; none in a file of version 1.
    pub triangles: Vec<BakedTriangles>,
    /// Surfaces of what never moves; none in a file of version 3.
    pub surfaces: Vec<BakedSurface>,
}

/// The triangles of one mesh of a scene.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct BakedTriangles {
    /// Its index among the meshes of the glTF file, and those of others with the same content.
    pub gltf_meshes: Vec<u32>,
    /// Finite coordinates.
    pub positions: Vec<[f32; 3]>,
    /// Indices of positions.
    pub triangles: Vec<[u32; 3]>,
}

/// One mesh of a scene, and its hulls by one set of parameters.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct BakedMesh {
    /// The names of the mesh and of the nodes that show it.
    pub names: Vec<String>,
    /// Its index among the meshes of the glTF file, and those of others with the same content;
    /// empty if it comes from elsewhere, or a file of version 1.
    pub gltf_meshes: Vec<u32>,
    /// The least and the largest coordinates of the corners of its triangles; `None` in a file of
    /// version 1, and where the mesh was not at hand.
    pub bounds: Option<[[f32; 3]; 2]>,
    /// The mesh's content.
    pub hash: MeshHash,
    /// What the mesh was decomposed with.
    pub parameters: Method,
    /// The hulls.
    pub hulls: HullsFile,
}

/// What a scene has of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SceneLookup<'a> {
    /// Its hulls.
    Found(&'a BakedMesh),
    /// Its hulls as an older or newer version of the algorithm made them.
    OtherAlgorithm(&'a BakedMesh),
    /// Its hulls by other parameters.
    OtherParameters(&'a BakedMesh),
    /// The hulls of another mesh of the same name: the mesh was changed since.
    OtherContent(&'a BakedMesh),
    /// Nothing.
    Missing,
}

impl BakedMesh {
    /// The hulls of `mesh` by `parameters`; its name is theirs. O(triangles).
    pub fn new<'a>(
        mesh: impl Into<MeshView<'a>>,
        parameters: impl Into<Method>,
        hulls: HullsFile,
    ) -> Self {
        let (names, mesh) = (vec![hulls.name.clone()], mesh.into());
        Self {
            names,
            gltf_meshes: Vec::new(),
            bounds: bounds_of(mesh),
            hash: MeshHash::of(mesh),
            parameters: parameters.into(),
            hulls,
        }
    }

    /// The hulls of a mesh that is not at hand, but its hash; its name is theirs, and its bounds
    /// are not known.
    pub fn of_hash(hash: MeshHash, parameters: impl Into<Method>, hulls: HullsFile) -> Self {
        Self {
            names: vec![hulls.name.clone()],
            gltf_meshes: Vec::new(),
            bounds: None,
            hash,
            parameters: parameters.into(),
            hulls,
        }
    }

    /// The same with its indices among the meshes of a glTF file.
    #[must_use]
    pub fn with_gltf_meshes(mut self, indices: Vec<u32>) -> Self {
        self.gltf_meshes = indices;
        self
    }

    /// The same with the names of nodes that show the mesh, each once.
    #[must_use]
    pub fn with_names(mut self, names: impl IntoIterator<Item = String>) -> Self {
        for name in names {
            if !name.is_empty() && !self.names.contains(&name) {
                self.names.push(name);
            }
        }
        self
    }
}

impl BakedTriangles {
    /// The triangles of `mesh` with finite corners, in single precision, each place once. O(size).
    pub fn new<'a>(mesh: impl Into<MeshView<'a>>, gltf_meshes: Vec<u32>) -> Self {
        let mesh = mesh.into();
        let (mut positions, mut indices) = (Vec::new(), HashMap::new());
        let mut index_of = |vertex: u32| {
            // The negative zero is the same place.
            let position = mesh.position(vertex)?.map(|x| x as f32 + 0.0);
            position.iter().all(|x| x.is_finite()).then_some(())?;
            Some(*indices.entry(position.map(f32::to_bits)).or_insert_with(|| {
                positions.push(position);
                positions.len() as u32 - 1
            }))
        };
        let corners = |[a, b, c]: &[u32; 3]| Some([index_of(*a)?, index_of(*b)?, index_of(*c)?]);
        let triangles = mesh.triangles().iter().filter_map(corners).collect();
        Self { gltf_meshes, positions, triangles }
    }

    /// The least and the largest coordinates; `None` without triangles. O(size).
    pub fn bounds(&self) -> Option<[[f32; 3]; 2]> {
        bounds_of(MeshView::new(&self.positions, &self.triangles))
    }
}

impl HullScene {
    /// A scene of meshes.
    pub fn new(name: impl Into<String>, meshes: Vec<BakedMesh>) -> Self {
        Self { name: name.into(), meshes, triangles: Vec::new(), surfaces: Vec::new() }
    }

    /// The same with the triangles of meshes.
    #[must_use]
    pub fn with_triangles(mut self, triangles: Vec<BakedTriangles>) -> Self {
        self.triangles = triangles;
        self
    }

    /// The same with the surfaces of what never moves.
    #[must_use]
    pub fn with_surfaces(mut self, surfaces: Vec<BakedSurface>) -> Self {
        self.surfaces = surfaces;
        self
    }

    /// What there is of a mesh with this content and one of these names, by these parameters.
    /// O(meshes).
    pub fn look_up(&self, hash: MeshHash, parameters: &Method, names: &[&str]) -> SceneLookup<'_> {
        let of_content = || self.meshes.iter().filter(|baked| baked.hash == hash);
        let found = of_content().find(|baked| baked.parameters == *parameters);
        if let Some(baked) = found {
            return match baked.hulls.is_current() {
                true => SceneLookup::Found(baked),
                false => SceneLookup::OtherAlgorithm(baked),
            };
        }
        if let Some(baked) = of_content().next() {
            return SceneLookup::OtherParameters(baked);
        }
        let has_name =
            |baked: &&BakedMesh| baked.names.iter().any(|name| names.contains(&name.as_str()));
        let of_name = self.meshes.iter().find(has_name);
        of_name.map_or(SceneLookup::Missing, SceneLookup::OtherContent)
    }

    /// The bytes of the file. O(size).
    ///
    /// # Errors
    /// [`HullsFileError::Invalid`] if a text or a list has more parts than 32 bits count, and that
    /// of [`HullsFile::to_bytes`].
    pub fn to_bytes(&self) -> Result<Vec<u8>, HullsFileError> {
        let has_parts = self.meshes.iter().any(|baked| !baked.hulls.parts.is_empty());
        let version = match (self.surfaces.is_empty(), has_parts) {
            (false, _) => SCENE_FORMAT_VERSION,
            (true, true) => WITHOUT_SURFACES,
            (true, false) => WITHOUT_PARTS,
        };
        let mut bytes = begin(SCENE_MAGIC, version, ALGORITHM_VERSION);
        text(&mut bytes, &self.name)?;
        count(&mut bytes, self.meshes.len())?;
        for baked in &self.meshes {
            count(&mut bytes, baked.names.len())?;
            for name in &baked.names {
                text(&mut bytes, name)?;
            }
            numbers(&mut bytes, &baked.gltf_meshes)?;
            bytes.push(baked.bounds.is_some().into());
            points(&mut bytes, baked.bounds.as_slice().as_flattened());
            bytes.extend(baked.hash.as_bytes());
            text(&mut bytes, &baked.parameters.to_string())?;
            let hulls = baked.hulls.to_bytes()?;
            count(&mut bytes, hulls.len())?;
            bytes.extend(hulls);
        }
        count(&mut bytes, self.triangles.len())?;
        for baked in &self.triangles {
            numbers(&mut bytes, &baked.gltf_meshes)?;
            count(&mut bytes, baked.positions.len())?;
            points(&mut bytes, &baked.positions);
            numbers(&mut bytes, baked.triangles.as_flattened())?;
        }
        if version > WITHOUT_SURFACES {
            count(&mut bytes, self.surfaces.len())?;
            self.surfaces.iter().try_for_each(|surface| surface.write(&mut bytes))?;
        }
        Ok(seal(bytes))
    }

    /// Reads the bytes of a file. O(size).
    ///
    /// # Errors
    /// [`HullsFileError`] says what is wrong with them.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, HullsFileError> {
        let ([format, _], mut reader) = open(bytes, SCENE_MAGIC, SCENE_FORMAT_VERSION)?;
        let name = reader.text()?;
        let meshes = reader.count(LEAST_MESH)?;
        let meshes =
            (0..meshes).map(|_| baked_mesh(&mut reader, format)).collect::<Result<_, _>>()?;
        let triangles = match format {
            1 => 0,
            _ => reader.count(LEAST_TRIANGLES)?,
        };
        let triangles =
            (0..triangles).map(|_| baked_triangles(&mut reader)).collect::<Result<_, _>>()?;
        let surfaces = match format {
            ..=WITHOUT_SURFACES => 0,
            _ => reader.count(LEAST_SURFACE)?,
        };
        let surfaces =
            (0..surfaces).map(|_| BakedSurface::read(&mut reader)).collect::<Result<_, _>>()?;
        reader.end()?;
        Ok(Self { name, meshes, triangles, surfaces })
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`HullsFileError::File`] if it can't be read, [`HullsFileError::At`] if it does not hold
    /// what it should.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, HullsFileError> {
        read_bytes(path.as_ref(), Self::from_bytes)
    }
}

/// The box around the corners of triangles, as far as they are finite.
fn bounds_of(mesh: MeshView<'_>) -> Option<[[f32; 3]; 2]> {
    let corners = mesh.triangles().iter().flatten().filter_map(|vertex| mesh.position(*vertex));
    let finite = corners.map(|corner| corner.map(|x| x as f32));
    let finite = finite.filter(|corner| corner.iter().all(|x| x.is_finite()));
    finite.fold(None, |bounds, corner| {
        let [low, high] = bounds.unwrap_or([corner; 2]);
        let pick = |of: [f32; 3], pick: fn(f32, f32) -> f32| {
            std::array::from_fn(|axis| pick(of[axis], corner[axis]))
        };
        Some([pick(low, f32::min), pick(high, f32::max)])
    })
}

/// The bytes of a mesh without names and hulls in version 1: a hash and three lengths.
const LEAST_MESH: usize = 32 + 3 * 4;

fn baked_mesh(reader: &mut Reader<'_>, format: u32) -> Result<BakedMesh, HullsFileError> {
    // A name is at least its length.
    let names = reader.count(4)?;
    let names = (0..names).map(|_| reader.text()).collect::<Result<_, _>>()?;
    let (gltf_meshes, bounds) = match format {
        1 => (Vec::new(), None),
        _ => {
            let read =
                |reader: &mut Reader<'_>| Ok([reader.single_point()?, reader.single_point()?]);
            (read_numbers(reader)?, reader.optional(read)?)
        }
    };
    let hash = MeshHash::from_bytes(reader.array()?);
    let parameters = reader.text()?;
    let parameters = parameters.parse().map_err(|_| HullsFileError::Invalid(NO_PARAMETERS))?;
    let length = reader.count(1)?;
    let hulls = HullsFile::from_bytes(reader.take(length)?)?;
    Ok(BakedMesh { names, gltf_meshes, bounds, hash, parameters, hulls })
}

/// The bytes of a mesh without triangles: three lengths.
const LEAST_TRIANGLES: usize = 3 * 4;

fn baked_triangles(reader: &mut Reader<'_>) -> Result<BakedTriangles, HullsFileError> {
    let gltf_meshes = read_numbers(reader)?;
    let positions = reader.count(size_of::<[f32; 3]>())?;
    let positions = (0..positions).map(|_| reader.single_point()).collect::<Result<Vec<_>, _>>()?;
    let corners = read_numbers(reader)?;
    let (triangles, rest) = corners.as_chunks::<3>();
    valid(rest.is_empty(), "a triangle lacks a corner")?;
    let all_exist = corners.iter().all(|corner| (*corner as usize) < positions.len());
    valid(all_exist, "a triangle names a point that is not there")?;
    Ok(BakedTriangles { gltf_meshes, positions, triangles: triangles.to_vec() })
}

const NO_PARAMETERS: &str = "a mesh's parameters are none that this library has";

#[cfg(test)]
mod tests {
    use std::sync::LazyLock;

    use super::*;
    use crate::control::Control;
    use crate::decompose::decompose;
    use crate::hulls_format::file::{CHECKSUM, HEADER};
    use crate::hulls_format::parts::MeshPart;
    use crate::mesh::TriangleMesh;
    use crate::mesh::shapes::cuboid;
    use crate::parameters::{Length, Parameters};

    fn bar(length: f64) -> TriangleMesh {
        cuboid([0.0; 3], [length, 1.0, 1.0])
    }

    fn scene() -> HullScene {
        static SCENE: LazyLock<HullScene> = LazyLock::new(|| {
            let baked = |length: f64, parameters: Parameters| {
                let mesh = bar(length);
                let view = crate::MeshView::new(&mesh.positions, &mesh.triangles);
                let made = decompose(view, &parameters, &Control::new()).unwrap();
                let hulls = HullsFile::new(format!("bar {length}"), &made);
                let baked = BakedMesh::new(view, parameters, hulls).with_gltf_meshes(vec![7, 2]);
                baked.with_names(["node".into(), "".into()])
            };
            let fine = Parameters::default().with_max_error(Length::share(0.01));
            let meshes = vec![baked(2.0, Parameters::default()), baked(3.0, fine)];
            let floor = bar(9.0);
            let view = crate::MeshView::new(&floor.positions, &floor.triangles);
            let floor = BakedTriangles::new(view, vec![3]);
            HullScene::new("level", meshes).with_triangles(vec![floor])
        });
        SCENE.clone()
    }

    fn hash(length: f64) -> MeshHash {
        let mesh = bar(length);
        MeshHash::of(crate::MeshView::new(&mesh.positions, &mesh.triangles))
    }

    #[test]
    fn what_is_written_is_read_again_exactly() {
        let scene = scene();
        assert_eq!(scene.meshes[0].names, ["bar 2", "node"]);
        let bytes = scene.to_bytes().unwrap();
        assert!(bytes.starts_with(b"\x89HULSC\r\n\x02\0\0\0"));
        assert_eq!(HullScene::from_bytes(&bytes), Ok(scene));
        let empty = HullScene::new("", Vec::new());
        assert_eq!(HullScene::from_bytes(&empty.to_bytes().unwrap()), Ok(empty));
    }

    #[test]
    fn a_scene_whose_hulls_know_their_parts_is_of_a_version_that_older_libraries_refuse_as_newer() {
        let mut scene = scene();
        let hulls = scene.meshes[1].hulls.clone();
        let part = MeshPart::new("bar 3", 0, "steel");
        scene.meshes[1].hulls = hulls.with_parts(vec![part.clone()], Vec::new());
        let bytes = scene.to_bytes().unwrap();
        assert!(bytes.starts_with(b"\x89HULSC\r\n\x03\0\0\0"));
        let read = HullScene::from_bytes(&bytes).unwrap();
        assert_eq!(read.meshes[1].hulls.part(0), Some(&part));
        assert_eq!(read, scene);
    }

    #[test]
    fn a_file_of_version_1_is_read_without_what_it_lacks() {
        let mut scene = scene();
        assert_eq!(scene.meshes[0].bounds, Some([[0.0; 3], [2.0, 1.0, 1.0]]));
        let mut bytes = begin(SCENE_MAGIC, 1, ALGORITHM_VERSION);
        text(&mut bytes, &scene.name).unwrap();
        count(&mut bytes, scene.meshes.len()).unwrap();
        for baked in &mut scene.meshes {
            count(&mut bytes, baked.names.len()).unwrap();
            baked.names.iter().for_each(|name| text(&mut bytes, name).unwrap());
            bytes.extend(baked.hash.as_bytes());
            text(&mut bytes, &baked.parameters.to_string()).unwrap();
            let hulls = baked.hulls.to_bytes().unwrap();
            count(&mut bytes, hulls.len()).unwrap();
            bytes.extend(hulls);
            (baked.gltf_meshes, baked.bounds) = (Vec::new(), None);
        }
        scene.triangles.clear();
        assert_eq!(HullScene::from_bytes(&seal(bytes)), Ok(scene));
    }

    #[test]
    fn triangles_are_kept_with_each_place_once_and_without_what_is_not_finite() {
        let mut mesh = bar(2.0);
        let corners: Vec<[f64; 3]> =
            mesh.triangles.iter().flatten().map(|v| mesh.positions[*v as usize]).collect();
        let count = corners.len() as u32;
        mesh.positions =
            corners.into_iter().map(|p| p.map(|x| if x == 0.0 { -x } else { x })).collect();
        mesh.positions.push([f64::NAN; 3]);
        mesh.triangles = (0..count / 3).map(|of| [3 * of, 3 * of + 1, 3 * of + 2]).collect();
        mesh.triangles.push([0, 1, count]);
        let baked =
            BakedTriangles::new(crate::MeshView::new(&mesh.positions, &mesh.triangles), vec![0]);
        assert_eq!((baked.positions.len(), baked.triangles.len()), (8, 12));
        assert_eq!(baked.bounds(), Some([[0.0; 3], [2.0, 1.0, 1.0]]));
    }

    #[test]
    fn triangles_that_mean_nothing_are_refused_and_false_counts_allocate_nothing() {
        let bytes = scene().to_bytes().unwrap();
        let end = bytes.len() - CHECKSUM;
        let corners = end - 12 * 3 * 4 - 4;
        let points = corners - 8 * 3 * 4 - 4;
        let indices = points - 4 - 4;
        let changed = |at: usize, by: [u8; 4]| {
            let mut bytes = bytes[..end].to_vec();
            bytes[at..at + 4].copy_from_slice(&by);
            bytes.truncate(end);
            HullScene::from_bytes(&seal(bytes))
        };
        assert_eq!(changed(indices, 1_u32.to_le_bytes()), Ok(scene()));
        for (at, value, why) in [
            (end - 4, 8_u32.to_le_bytes(), "a triangle names"),
            (corners, 35_u32.to_le_bytes(), "lacks a corner"),
            (corners - 4, f32::NAN.to_le_bytes(), "not finite"),
            (corners, u32::MAX.to_le_bytes(), "more than it holds"),
            (points, u32::MAX.to_le_bytes(), "more than it holds"),
            (indices, u32::MAX.to_le_bytes(), "more than it holds"),
            (indices - 4, u32::MAX.to_le_bytes(), "more than it holds"),
            (indices - 4, 0_u32.to_le_bytes(), "more after"),
        ] {
            let result = changed(at, value);
            assert!(
                matches!(result, Err(HullsFileError::Invalid(what)) if what.contains(why)),
                "{why}: {result:?}"
            );
        }
    }

    #[test]
    fn a_mesh_is_found_by_content_and_parameters_or_the_lookup_has_the_reason() {
        let scene = scene();
        let (default, fine) =
            (Method::default(), Parameters::default().with_max_error(Length::share(0.01)).into());
        assert_eq!(scene.look_up(hash(2.0), &default, &[]), SceneLookup::Found(&scene.meshes[0]));
        assert_eq!(
            scene.look_up(hash(2.0), &fine, &["node"]),
            SceneLookup::OtherParameters(&scene.meshes[0])
        );
        assert_eq!(
            scene.look_up(hash(9.0), &default, &["bar 3"]),
            SceneLookup::OtherContent(&scene.meshes[1])
        );
        assert_eq!(scene.look_up(hash(9.0), &default, &["other"]), SceneLookup::Missing);
        let mut older = scene.clone();
        older.meshes[0].hulls.algorithm_version -= 1;
        assert!(matches!(older.look_up(hash(2.0), &default, &[]), SceneLookup::OtherAlgorithm(_)));
    }

    #[test]
    fn a_hash_is_read_from_its_digits_and_from_nothing_else() {
        let text = hash(2.0).to_string();
        assert_eq!((text.parse(), text.to_uppercase().parse()), (Ok(hash(2.0)), Ok(hash(2.0))));
        for wrong in ["", "0", &text[2..], &format!("{text}00"), &text.replace('a', "g"), "ßß"] {
            let read = wrong.parse::<MeshHash>();
            assert!(read.is_err() || wrong == text, "{wrong}");
        }
    }

    #[test]
    fn a_mesh_that_is_known_by_its_hash_is_found_as_one_that_is_at_hand() {
        let known = scene().meshes.remove(0);
        let alone = BakedMesh::of_hash(known.hash, known.parameters.clone(), known.hulls.clone());
        assert_eq!((alone.bounds, &alone.names[0]), (None, &known.hulls.name));
        let scene = HullScene::new("alone", vec![alone]);
        let read = HullScene::from_bytes(&scene.to_bytes().unwrap()).unwrap();
        let found = read.look_up(known.hash, &known.parameters, &[]);
        assert!(matches!(found, SceneLookup::Found(baked) if baked.hulls == known.hulls));
    }

    #[test]
    fn a_file_of_one_mesh_is_no_scene_and_a_scene_no_file_of_one_mesh() {
        let single = scene().meshes[0].hulls.to_bytes().unwrap();
        assert_eq!(HullScene::from_bytes(&single), Err(HullsFileError::IsSingle));
        let bytes = scene().to_bytes().unwrap();
        assert_eq!(HullsFile::from_bytes(&bytes), Err(HullsFileError::IsScene));
    }

    #[test]
    fn no_damage_goes_unnoticed_and_none_panics() {
        let bytes = scene().to_bytes().unwrap();
        for length in 0..bytes.len() {
            assert!(HullScene::from_bytes(&bytes[..length]).is_err(), "{length} bytes");
        }
        for at in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] ^= 0x55;
            let algorithm = 12..16;
            assert!(HullScene::from_bytes(&damaged).is_err(), "byte {at}");
            // With a checksum that matches the reader goes on to the body.
            let end = damaged.len() - CHECKSUM;
            let checksum = crc32fast::hash(&damaged[..end]);
            damaged[end..].copy_from_slice(&checksum.to_le_bytes());
            let is_read = HullScene::from_bytes(&damaged).is_ok();
            assert!(at >= HEADER || algorithm.contains(&at) || at >= end || !is_read, "byte {at}");
        }
    }
}
