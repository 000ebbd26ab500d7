//! What was written is read again, and nothing else is.

use std::sync::LazyLock;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::file::{CHECKSUM, HEADER, MAGIC};
use super::*;
use crate::control::Control;
use crate::geometry::MeshView;
use crate::mass::mass_properties;
use crate::mesh::TriangleMesh;
use crate::mesh::shapes::{cuboid, join};
use crate::method::Method;
use crate::surface::SurfaceParameters;

fn bars() -> TriangleMesh {
    join(&[cuboid([0.0; 3], [3.0, 1.0, 1.0]), cuboid([5.0, 0.0, 0.0], [6.0, 2.0, 0.5])])
}

fn file(method: &Method) -> HullsFile {
    let TriangleMesh { positions, triangles, .. } = bars();
    let mesh = MeshView::new(&positions, &triangles);
    let decomposition = method.decompose(mesh, &Control::new()).unwrap();
    let properties = mass_properties(mesh, &decomposition.hulls, 2.0).unwrap();
    HullsFile::new("bars", &decomposition).with_mass_properties(properties)
}

fn full() -> HullsFile {
    static FULL: LazyLock<HullsFile> = LazyLock::new(|| file(&Method::default()));
    let mut file = FULL.clone();
    file.bound = Some(0.25);
    file.verified = Some(VerifiedErrors { protrusion_max: 0.125, uncovered_max: 0.0 });
    file
}

/// The bytes with a checksum that matches, so that the reader goes on to what they say.
fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let end = bytes.len() - CHECKSUM;
    let checksum = crc32fast::hash(&bytes[..end]);
    bytes[end..].copy_from_slice(&checksum.to_le_bytes());
    bytes
}

fn changed(at: usize, by: &[u8]) -> Result<HullsFile, HullsFileError> {
    let mut bytes = full().to_bytes().unwrap();
    bytes[at..at + by.len()].copy_from_slice(by);
    HullsFile::from_bytes(&sealed(bytes))
}

#[test]
fn what_is_written_is_read_again_exactly() {
    for file in [full(), file(&Method::default()), file(&SurfaceParameters::paper().into())] {
        assert_eq!(file.hulls.len(), 2);
        assert!(file.is_current());
        let bytes = file.to_bytes().unwrap();
        assert_eq!(HullsFile::from_bytes(&bytes), Ok(file));
    }
    let mut bare = full();
    (bare.bound, bare.verified, bare.mass_properties) = (None, None, None);
    bare.hulls.clear();
    assert_eq!(HullsFile::from_bytes(&bare.to_bytes().unwrap()), Ok(bare));
}

#[test]
fn the_bounded_methods_promise_is_kept_with_the_hulls() {
    let file = file(&Method::default());
    assert!(file.bound.is_some_and(|bound| bound > 0.0));
    let paper = self::file(&SurfaceParameters::paper().into());
    assert_eq!((paper.bound, paper.verified), (None, None));
    assert_eq!(paper.method, "surface");
}

#[test]
fn the_format_does_not_change_unnoticed() {
    let bytes = full().to_bytes().unwrap();
    let header = b"\x89HULLS\r\n\x01\0\0\0";
    assert!(bytes.starts_with(header));
    assert_eq!(&bytes[HEADER..HEADER + 8], b"\x04\0\0\0bars");
    // Names, counts, diagonal, bound, errors, mass properties, number of hulls; two boxes.
    let body = (4 + 4) + (4 + 7) + 16 + 8 + 9 + 17 + (2 + 10 * 8) + 4 + 2 * (45 + 8 * 24 + 12 * 12);
    assert_eq!(bytes.len(), HEADER + body + CHECKSUM);
}

#[test]
fn every_cut_is_noticed() {
    let bytes = full().to_bytes().unwrap();
    for length in 0..bytes.len() {
        let error = HullsFile::from_bytes(&bytes[..length]).unwrap_err();
        let expected = if length < MAGIC.len() {
            matches!(error, HullsFileError::NotHulls)
        } else {
            matches!(error, HullsFileError::WrongLength { .. })
        };
        assert!(expected, "{length}: {error}");
        if length >= HEADER + CHECKSUM {
            // A liar would also correct the length and the checksum.
            let mut short = bytes[..length].to_vec();
            let body = (length - HEADER - CHECKSUM) as u64;
            short[HEADER - 8..HEADER].copy_from_slice(&body.to_le_bytes());
            assert!(HullsFile::from_bytes(&sealed(short)).is_err(), "{length}");
        }
    }
    let mut longer = bytes;
    longer.push(0);
    assert!(matches!(HullsFile::from_bytes(&longer), Err(HullsFileError::WrongLength { .. })));
}

#[test]
fn every_flipped_bit_is_noticed() {
    let bytes = full().to_bytes().unwrap();
    for bit in 0..8 * bytes.len() {
        let mut damaged = bytes.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        assert!(HullsFile::from_bytes(&damaged).is_err(), "bit {bit}");
    }
}

#[test]
fn a_newer_file_says_so_whatever_else_it_holds() {
    let mut bytes = full().to_bytes().unwrap();
    bytes[8..12].copy_from_slice(&(FORMAT_VERSION + 1).to_le_bytes());
    bytes.truncate(60);
    let error = HullsFile::from_bytes(&bytes).unwrap_err();
    assert_eq!(error, HullsFileError::NewerVersion { found: FORMAT_VERSION + 1 });
    assert!(changed(8, &[0; 4]).is_err());
}

#[test]
fn a_text_file_is_no_hulls_format() {
    for bytes in [&b""[..], b"o hull_0\nv 0 0 0\n", &[0x89]] {
        assert_eq!(HullsFile::from_bytes(bytes), Err(HullsFileError::NotHulls));
    }
}

#[test]
fn counts_that_lie_allocate_nothing() {
    let file = full();
    let hulls = HEADER + (4 + 4) + (4 + 7) + 16 + 8 + 9 + 17 + (2 + 10 * 8);
    assert_eq!(file.to_bytes().unwrap()[hulls..hulls + 4], 2_u32.to_le_bytes());
    let first_hull = hulls + 4;
    for count in [HEADER, hulls, first_hull + 37, first_hull + 41] {
        let result = changed(count, &u32::MAX.to_le_bytes());
        assert!(matches!(result, Err(HullsFileError::Invalid(_))), "{count}");
    }
}

#[test]
fn numbers_and_indices_that_mean_nothing_are_refused() {
    let bytes = full().to_bytes().unwrap();
    let end = bytes.len() - CHECKSUM;
    let beyond = changed(end - 4, &8_u32.to_le_bytes());
    assert!(matches!(beyond, Err(HullsFileError::Invalid(why)) if why.contains("triangle")));
    let last_point = end - 12 * 12 - 8;
    for value in [f64::NAN, f64::INFINITY] {
        let result = changed(last_point, &value.to_le_bytes());
        assert!(matches!(result, Err(HullsFileError::Invalid(why)) if why.contains("finite")));
    }
    let volume = end - 12 * 12 - 8 * 24 - 8 - 9 - 24;
    assert!(changed(volume, &(-1.0_f64).to_le_bytes()).is_err());
    assert!(changed(volume, &0.0_f64.to_le_bytes()).is_err());
    assert!(changed(volume, &7.0_f64.to_le_bytes()).is_ok());
    assert!(changed(HEADER + 4, &[0xFF]).is_err(), "UTF-8");
}

#[test]
fn files_are_written_whole_and_errors_name_them() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("bars.hulls");
    full().write(&path).unwrap();
    assert_eq!(HullsFile::read(&path), Ok(full()));
    assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 1);

    std::fs::write(&path, b"not this").unwrap();
    let error = HullsFile::read(&path).unwrap_err().to_string();
    assert!(error.contains("bars.hulls") && error.contains("no .hulls file"), "{error}");
    let missing = directory.path().join("missing").join("x.hulls");
    assert!(matches!(HullsFile::read(&missing), Err(HullsFileError::File { .. })));
    assert!(matches!(full().write(&missing), Err(HullsFileError::File { .. })));
}

proptest! {
    #![proptest_config(ProptestConfig { rng_seed: RngSeed::Fixed(1), ..Default::default() })]

    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let _ = HullsFile::from_bytes(&bytes);
        let start = full().to_bytes().unwrap()[..HEADER].to_vec();
        let mut sealed_bytes = [start, bytes.clone(), vec![0; CHECKSUM]].concat();
        sealed_bytes[HEADER - 8..HEADER].copy_from_slice(&(bytes.len() as u64).to_le_bytes());
        prop_assert!(HullsFile::from_bytes(&sealed(sealed_bytes)).is_err());
    }

    #[test]
    fn a_liar_with_a_good_checksum_gets_a_sound_file_or_an_error(
        changes in prop::collection::vec((HEADER..1000_usize, any::<u8>()), 1..8),
    ) {
        let mut bytes = full().to_bytes().unwrap();
        for (at, value) in changes {
            let at = at.min(bytes.len() - CHECKSUM - 1);
            bytes[at] = value;
        }
        if let Ok(file) = HullsFile::from_bytes(&sealed(bytes)) {
            for hull in &file.hulls {
                prop_assert!(hull.shape.points.iter().flatten().all(|x| x.is_finite()));
                let count = hull.shape.points.len() as u32;
                prop_assert!(hull.shape.triangles.iter().flatten().all(|index| *index < count));
            }
            let again = HullsFile::from_bytes(&file.to_bytes().unwrap());
            prop_assert_eq!(again, Ok(file));
        }
    }
}
