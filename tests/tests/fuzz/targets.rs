//! The readers.

use super::Target;
use bytes::Bytes;
use gonio_prepare::raw::{Balance, Colour, Demosaic, Options, develop};
use gonio_proto::convert::digest::digests_from_wire;
use gonio_proto::convert::event::{Event, FilmCollector};
use gonio_proto::convert::job::Job;
use gonio_proto::convert::manifest::{Manifest, pack};
use gonio_proto::convert::reduced::Reduced;
use gonio_proto::convert::request::{request_from_wire, request_to_wire};
use gonio_proto::convert::task::{Hello, Setup, tasks_from_wire};
use gonio_proto::{Digest, limits, wire};
use gonio_scene::capture::Reflectance;
use gonio_scene::files::{DirectoryFiles, MemoryFiles};
use gonio_scene::{Capture, EvaluationRequest, Output, image, mesh, reflectance as measured};
use gonio_sweep::Sweep;
use gonio_tests::captures;
use prost::Message;
use std::sync::Arc;

const MIB: usize = 1 << 20;

/// A capture with most of what the format knows.
const RICH: &str = include_str!("rich.toml");

/// A sweep with every design.
const SWEEP: &str = include_str!("sweep.toml");

fn alone(name: &str, bytes: &[u8]) -> MemoryFiles {
    MemoryFiles([(name.to_owned(), Arc::from(bytes))].into())
}

pub fn capture() -> Target {
    let file = |name: &str| std::fs::read(captures().join(name).join("capture.toml")).unwrap();
    let read = |_: usize, bytes: &[u8]| {
        let Ok(capture) = Capture::read(&alone("capture.toml", bytes)) else { return false };
        // What is taken is written in the same form.
        Capture::parse(&capture.to_toml().unwrap()).unwrap();
        let _ = capture.free_parameters();
        true
    };
    Target {
        name: "captures",
        good: vec![RICH.into(), file("none-201"), file("vignetting-204")],
        read,
        memory: 16 * MIB,
    }
}

pub fn mesh() -> Target {
    let ply = std::fs::read(captures().join("none-201/board.ply")).unwrap();
    let text = b"ply\nformat ascii 1.0\nelement vertex 6\nproperty double x\nproperty double y\nproperty double z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n2 0 0\n2 1 0\n1 1 0\n1 2 0\n0 2. 0\n6 4 5 0 1 2 3\n".to_vec();
    let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0.5\nvn 0 0 1\nf 1//1 2//1 3//1\nf 2//1 4//1 \\\n 3//1\nf 1//1 2//1 4//1 3//1\n".to_vec();
    let stl = b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n".to_vec();
    let gltf = br#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],"bufferViews":[{"buffer":0,"byteLength":36}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}]}"#.to_vec();
    let read = |which: usize, bytes: &[u8]| {
        let name = ["m.ply", "m.obj", "m.stl", "m.gltf", "m.ply"][which];
        mesh::read(&alone(name, bytes), name).is_ok()
    };
    Target { name: "meshes", good: vec![ply, obj, stl, gltf, text], read, memory: 64 * MIB }
}

pub fn image() -> Target {
    let folder = captures().join("none-201/photos");
    let mask = std::fs::read(folder.join("00.mask.png")).unwrap();
    let photo = image::read(&DirectoryFiles::new(captures().join("none-201")), "photos/00.exr").unwrap();
    let pixels = photo.pixels.iter().take(16 * 12).copied().collect();
    let exr = image::encode_exr("a.exr", &image::Image { width: 16, height: 12, pixels }).unwrap();
    let png = image::encode_png8("a.png", 4, 3, &[[1, 200, 3]; 12]).unwrap();
    let hdr =
        b"#?RADIANCE\nEXPOSURE=2\nPRIMARIES=.7 .3 .2 .8 .1 .05 .3 .3\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 3\n\x80\x40\x20\x81\x10\x20\x30\x80\x01\x02\x03\x7f".to_vec();
    let read = |which: usize, bytes: &[u8]| match which {
        0 => image::read_mask(&alone("m.png", bytes), "m.png").is_ok(),
        1 => image::read(&alone("a.exr", bytes), "a.exr").is_ok(),
        2 => {
            image::claims(&alone("a.png", bytes), "a.png").is_ok()
                & image::read(&alone("a.png", bytes), "a.png").is_ok()
        }
        4 => image::read(&alone("a.tif", bytes), "a.tif").is_ok(),
        _ => image::read(&alone("a.hdr", bytes), "a.hdr").is_ok(),
    };
    Target { name: "images", good: vec![mask, exr, png, hdr, tiff()], read, memory: 1280 * MIB }
}

/// RAW files and headers of JPEG. A long run takes the real files of the shared folder, too, where it is.
pub fn raw(long: bool) -> Target {
    let mut good = vec![jpeg(), dng()];
    if long {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/real/raw");
        for name in ["canon_eos_6d.dng", "P003908.KDC", "CRW_0304.CRW"] {
            good.extend(std::fs::read(folder.join(name)));
        }
    }
    let read = |which: usize, bytes: &[u8]| match which {
        0 => gonio_prepare::noise::blocks(bytes).is_some(),
        _ => {
            let camera = Options { colour: Colour::Camera, ..Options::default() };
            let _ =
                develop("a.dng", bytes, Options { demosaic: Demosaic::Superpixel, balance: Balance::AsShot, ..camera });
            develop("a.dng", bytes, camera).is_ok()
        }
    };
    Target { name: "raw", good, read, memory: 512 * MIB }
}

/// The header of a JPEG: two tables, and a frame with chroma of half the size.
fn jpeg() -> Vec<u8> {
    let table = |kind: u8| [&[0xff, 0xdb, 0, 67, kind][..], &[3; 64]].concat();
    let frame = [0xff, 0xc0, 0, 17, 8, 0, 16, 0, 16, 3, 1, 0x22, 0, 2, 0x11, 1, 3, 0x11, 1];
    [&[0xff, 0xd8][..], &table(0), &table(1), &frame].concat()
}

/// A mosaic of 8 x 4 values of 16 bits.
fn dng() -> Vec<u8> {
    let entries: [(u16, u16, u32, u32); 15] = [
        (254, 4, 1, 0),
        (256, 4, 1, 8),
        (257, 4, 1, 4),
        (258, 3, 1, 16),
        (259, 3, 1, 1),
        (262, 3, 1, 32803),
        (273, 4, 1, 194),
        (277, 3, 1, 1),
        (278, 4, 1, 4),
        (279, 4, 1, 64),
        (33421, 3, 2, 2 | 2 << 16),
        (33422, 1, 4, 1 << 8 | 1 << 16 | 2 << 24),
        (50706, 1, 4, 1 | 4 << 8),
        (50714, 3, 1, 100),
        (50717, 3, 1, 4100),
    ];
    let mut bytes = b"II*\0\x08\0\0\0".to_vec();
    bytes.extend((entries.len() as u16).to_le_bytes());
    for (tag, kind, count, value) in entries {
        bytes
            .extend([&tag.to_le_bytes()[..], &kind.to_le_bytes(), &count.to_le_bytes(), &value.to_le_bytes()].concat());
    }
    bytes.extend([0; 4]);
    bytes.extend((0..32_u16).flat_map(|k| (200 + 90 * k).to_le_bytes()));
    bytes
}

/// Three gray floats.
fn tiff() -> Vec<u8> {
    let entries: [(u16, u16, u32); 10] = [
        (256, 3, 3),
        (257, 3, 1),
        (258, 3, 32),
        (259, 3, 1),
        (262, 3, 1),
        (273, 4, 134),
        (277, 3, 1),
        (278, 3, 1),
        (279, 4, 12),
        (339, 3, 3),
    ];
    let mut bytes = b"II*\0\x08\0\0\0".to_vec();
    bytes.extend((entries.len() as u16).to_le_bytes());
    for (tag, kind, value) in entries {
        bytes
            .extend([&tag.to_le_bytes()[..], &kind.to_le_bytes(), &1_u32.to_le_bytes(), &value.to_le_bytes()].concat());
    }
    bytes.extend([0; 4]);
    bytes.extend([0.25_f32, 0.5, 2.0].iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

pub fn sweep() -> Target {
    let read = |_: usize, bytes: &[u8]| match std::str::from_utf8(bytes) {
        Ok(text) => Sweep::parse("sweep.toml", text, limits::SAMPLES).is_ok(),
        Err(_) => false,
    };
    Target { name: "sweeps", good: vec![SWEEP.into()], read, memory: 256 * MIB }
}

pub fn message() -> Target {
    let request = EvaluationRequest {
        numbers: vec![("material.shell.roughness".into(), 0.3)],
        photos: vec![3, 0, 7],
        samples: 16,
        difference_samples: 4,
        forward_samples: 4,
        output: Output::StatisticsAndFilms,
        ..EvaluationRequest::default()
    };
    let digest = Digest::of(b"capture");
    let manifest = pack(&DirectoryFiles::new(captures().join("none-201"))).unwrap().manifest.to_blob();
    let hello = wire::Hello { name: "w".into(), slots: 2, version: gonio_proto::VERSION.into(), reserved_credits: 0 };
    let digests = gonio_proto::convert::digest::digests_to_wire(&[digest, Digest::of(b"b")]);
    let good = vec![
        request_to_wire(digest, &request).encode_to_vec(),
        manifest.to_vec(),
        hello.encode_to_vec(),
        digests.encode_to_vec(),
    ];
    let read = |_: usize, bytes: &[u8]| {
        // Bytes may reach any reader, whichever they were meant for.
        let bytes = Bytes::copy_from_slice(bytes);
        let mut taken = Manifest::from_blob(bytes.clone()).is_ok();
        taken |= wire::EvaluationRequest::decode(bytes.clone()).is_ok_and(|m| request_from_wire(m).is_ok());
        taken |= wire::Hello::decode(bytes.clone()).is_ok_and(|m| Hello::try_from(m).is_ok());
        taken |= wire::BlobDigests::decode(bytes.clone()).is_ok_and(|m| digests_from_wire(&m).is_ok());
        taken |= wire::Tasks::decode(bytes.clone()).is_ok_and(|m| tasks_from_wire(m).is_ok());
        taken |= wire::Setup::decode(bytes.clone()).is_ok_and(|m| Setup::try_from(m).is_ok());
        taken |= wire::EvaluationEvent::decode(bytes.clone()).is_ok_and(|m| Event::try_from(m).is_ok());
        taken |= wire::Job::decode(bytes.clone()).is_ok_and(|m| Job::from_wire(&m).is_ok());
        taken |= wire::ReducedTile::decode(bytes.clone()).is_ok_and(|m| Reduced::from_wire(m).is_ok());
        taken |= wire::FilmChunk::decode(bytes).is_ok_and(|m| FilmCollector::default().add(m).is_ok());
        taken
    };
    Target { name: "messages", good, read, memory: 64 * MIB }
}

pub fn reflectance() -> Target {
    let good = b"phi_i,theta_i,theta_o,phi_o,g,r,b\n0,0.5,0.25,3.5,0.2,0.1,-0.3\n0,0,0,0,2,1,3\n".to_vec();
    let read = |_: usize, bytes: &[u8]| {
        let file = Reflectance { file: "s.csv".into(), ..Reflectance::default() };
        measured::read(&alone("s.csv", bytes), &file).is_ok()
    };
    Target { name: "reflectance", good: vec![good], read, memory: 16 * MIB }
}
