//! Files that earlier versions of the library wrote, of the tetrahedron of the unit cube.

use hullwright::hulls_format::{HullScene, HullsFile};

const HULLS: &[u8] = include_bytes!("../data/version_1.hulls");
const SCENE: &[u8] = include_bytes!("../data/version_2.hullscene");

#[test]
fn a_file_of_before_parts_is_read_and_written_as_it_was() {
    let file = HullsFile::from_bytes(HULLS).unwrap();
    assert_eq!((file.name.as_str(), file.algorithm_version), ("tetrahedron", 29));
    assert!((file.hulls[0].shape.volume() - 1.0 / 6.0).abs() < 1e-9);
    assert_eq!((file.parts.len(), file.part_shares.len(), file.part(0)), (0, 0, None));
    assert_eq!(file.to_bytes().unwrap(), HULLS);
}

#[test]
fn a_scene_of_before_parts_is_read_and_written_as_it_was() {
    let scene = HullScene::from_bytes(SCENE).unwrap();
    assert_eq!(scene.meshes[0].names, ["tetrahedron"]);
    assert_eq!(scene.meshes[0].hulls, HullsFile::from_bytes(HULLS).unwrap());
    // But for the version of the algorithm, and the checksum over it.
    let written = scene.to_bytes().unwrap();
    let is_same = |range: std::ops::Range<usize>| written[range.clone()] == SCENE[range];
    assert!(written.len() == SCENE.len() && is_same(0..12) && is_same(16..SCENE.len() - 4));
}
