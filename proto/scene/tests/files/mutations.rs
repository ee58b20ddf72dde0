//! Whatever happens to the bytes of a file, reading it ends in a value or an error of that file: never in a panic, not even
//! in one that the reader catches, and never in an allocation out of proportion to a file of a few hundred bytes.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use ::image::ExtendedColorType;
use exr::prelude::Compression;
use gonio_scene::{image, mesh};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

use crate::files;
use crate::fixture_images::{bytes8, hdr, jpeg, plain_exr, png, tiff, values};
use crate::fixture_meshes::{Encoding, Gltf, PLAIN, PlyStyle, obj, ply, stl_ascii, stl_binary};

/// The largest allocation since it was last set to zero, in bytes, by any thread: OpenEXR is decoded by several.
static LARGEST: AtomicUsize = AtomicUsize::new(0);

/// Held by the test that measures; the tests of other modules run beside it, and need little.
static TURN: Mutex<()> = Mutex::new(());

struct Watched;

// SAFETY: every call is passed on to the system's allocator as it is.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Watched {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        LARGEST.fetch_max(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller keeps the contract of `GlobalAlloc::alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract of `GlobalAlloc::dealloc`.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        LARGEST.fetch_max(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller keeps the contract of `GlobalAlloc::alloc_zeroed`.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        LARGEST.fetch_max(size, Ordering::Relaxed);
        // SAFETY: the caller keeps the contract of `GlobalAlloc::realloc`.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Watched = Watched;

const MAX_ALLOCATION: usize = 32 << 20;

/// The TIFF decoder reserves what a tag's count asks for, up to this, before it finds the file to be shorter. Nothing
/// touches that memory, and it is given back with the error.
const MAX_ALLOCATION_TIFF: usize = 256 << 20;

const CASES: u32 = 5000;

/// One change of a file: a byte replaced, removed or doubled, a run of bytes set, or the rest cut off.
#[derive(Debug, Clone)]
enum Change {
    Set(u8),
    Flip(u8),
    Remove,
    Double,
    Fill(u8),
    Cut,
}

fn change() -> impl Strategy<Value = (prop::sample::Index, Change)> {
    let kind = prop_oneof![
        4 => any::<u8>().prop_map(Change::Set),
        4 => (0u8..8).prop_map(Change::Flip),
        1 => Just(Change::Remove),
        1 => Just(Change::Double),
        2 => prop_oneof![Just(0), Just(0x7f), Just(0xff)].prop_map(Change::Fill),
        1 => Just(Change::Cut),
    ];
    (any::<prop::sample::Index>(), kind)
}

fn apply(bytes: &mut Vec<u8>, changes: &[(prop::sample::Index, Change)]) {
    for (index, change) in changes {
        if bytes.is_empty() {
            return;
        }
        let at = index.index(bytes.len());
        match change {
            Change::Set(value) => bytes[at] = *value,
            Change::Flip(bit) => bytes[at] ^= 1 << bit,
            Change::Remove => drop(bytes.remove(at)),
            Change::Double => bytes.insert(at, bytes[at]),
            Change::Fill(value) => bytes[at..].iter_mut().take(4).for_each(|byte| *byte = *value),
            Change::Cut => bytes.truncate(at),
        }
    }
}

/// Reads `name` with many changes of `bytes`, the same ones in every run.
fn survives(name: &str, bytes: &[u8], read: impl Fn(&str, &[u8]) -> Result<(), gonio_scene::SceneError>) {
    read(name, bytes).unwrap_or_else(|error| panic!("the unchanged file: {error}"));
    let limit = if name.ends_with("tif") { MAX_ALLOCATION_TIFF } else { MAX_ALLOCATION };
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let config = Config { cases: CASES, failure_persistence: None, ..Config::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    let result = runner.run(&prop::collection::vec(change(), 1..5), |changes| {
        let mut changed = bytes.to_vec();
        apply(&mut changed, &changes);
        LARGEST.store(0, Ordering::Relaxed);
        if let Err(error) = read(name, &changed) {
            prop_assert!(error.file == name && !error.mend.is_empty(), "{}", error);
            prop_assert!(!error.to_string().contains('\n'), "{}", error);
            prop_assert!(!error.problem.contains("its decoder cannot name"), "a decoder has panicked");
        }
        let largest = LARGEST.load(Ordering::Relaxed);
        prop_assert!(largest <= limit, "an allocation of {} bytes", largest);
        Ok(())
    });
    if let Err(error) = result {
        panic!("{name}: {error}");
    }
}

fn read_mesh(name: &str, bytes: &[u8]) -> Result<(), gonio_scene::SceneError> {
    let mesh = mesh::read(&files(&[(name, bytes)]), name)?;
    // What is read is sound, however it came about.
    assert!(!mesh.triangles.is_empty());
    assert!(mesh.triangles.iter().flatten().all(|&index| (index as usize) < mesh.positions.len()));
    assert!(mesh.positions.iter().chain(mesh.normals.iter().flatten()).flatten().all(|value| value.is_finite()));
    assert!(mesh.normals.is_none_or(|normals| normals.len() == mesh.positions.len()));
    Ok(())
}

fn read_image(name: &str, bytes: &[u8]) -> Result<(), gonio_scene::SceneError> {
    let image = image::read(&files(&[(name, bytes)]), name)?;
    assert_eq!(image.pixels.len(), image.width as usize * image.height as usize);
    assert!(image.pixels.iter().flatten().all(|value| value.is_finite()));
    Ok(())
}

#[test]
fn ply_files() {
    for encoding in [Encoding::Ascii, Encoding::Little, Encoding::Big] {
        survives("a.ply", &ply(PlyStyle { encoding, ..PLAIN }), read_mesh);
    }
    survives("a.ply", &ply(PlyStyle { length: "uint", coordinate: "double", ..PLAIN }), read_mesh);
}

#[test]
fn obj_files() {
    survives("a.obj", &obj(true), read_mesh);
    survives("a.obj", &obj(false), read_mesh);
}

#[test]
fn stl_files() {
    survives("a.stl", &stl_binary("pyramid"), read_mesh);
    survives("a.stl", &stl_ascii(), read_mesh);
}

#[test]
fn gltf_files() {
    survives("a.glb", &Gltf::default().glb(), read_mesh);
    survives("a.gltf", &Gltf::default().embedded(), |name, bytes| {
        // A change of the URI's scheme makes it name another file, which is not there.
        read_mesh(name, bytes)
            .map_err(|error| if error.problem.contains("packed") { error_of(name, error) } else { error })
    });
}

fn error_of(name: &str, error: gonio_scene::SceneError) -> gonio_scene::SceneError {
    gonio_scene::SceneError { file: name.to_owned(), ..error }
}

#[test]
fn exr_files() {
    for compression in [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::PXR24,
        Compression::DWAA(None),
    ] {
        survives("a.exr", &plain_exr(compression), read_image);
    }
}

#[test]
fn integer_images() {
    survives("a.png", &png(&bytes8(3), ExtendedColorType::Rgb8), read_image);
    survives("a.tif", &tiff(&bytes8(3), ExtendedColorType::Rgb8), read_image);
    survives("a.jpg", &jpeg(&bytes8(3), ExtendedColorType::Rgb8), read_image);
}

#[test]
fn float_images() {
    survives("a.hdr", &hdr(&values()), read_image);
    let samples: Vec<u8> = values().iter().flatten().flat_map(|value| value.to_ne_bytes()).collect();
    survives("a.tif", &tiff(&samples, ExtendedColorType::Rgb32F), read_image);
}
