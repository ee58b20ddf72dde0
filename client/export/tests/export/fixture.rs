//! Captures in memory: a plain one, and one with everything.

use gonio_export::{Export, Format, export};
use gonio_scene::Capture;
use gonio_scene::files::MemoryFiles;
use gonio_scene::image::{Image, encode_exr};
use gonio_scene::mesh::{Mesh, write_ply};
use std::sync::Arc;

/// A camera of 40 x 30 pixels.
pub const HEAD: &str = "format = 1\nname = \"part\"\n\
    [camera]\nwidth = 40\nheight = 30\nfx = 60.0\nfy = 60.0\ncx = 20.0\ncy = 15.0\n";
const OBJECT: &str = "[[object]]\nname = \"part\"\nmesh = \"part.ply\"\nmaterial = \"shell\"\n\
    object_to_world = [[0, -1, 0, 0.1], [1, 0, 0, 0.2], [0, 0, 1, 0.3], [0, 0, 0, 1]]\n";
const PHOTOS: &str = "[[photo]]\nfile = \"00.exr\"\nexposure = 2.0\nlights = [\"led\"]\n\
    camera_to_world = [[1, 0, 0, 0.5], [0, -1, 0, 0], [0, 0, -1, 1], [0, 0, 0, 1]]\n\
    [[photo]]\nfile = \"01.exr\"\n\
    camera_to_world = [[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 2], [0, 0, 0, 1]]\n";
const LED: &str = "[[light]]\nname = \"led\"\nkind = \"point\"\nframe = \"camera\"\nposition = [0.1, 0.0, 0.0]\n\
    intensity = [0.4, 0.2, 0.1]\n";

/// A plastic part in front of a camera with a lamp, and a second photo with another lamp on.
pub fn plain() -> String {
    format!(
        "{HEAD}[[material]]\nname = \"shell\"\nmodel = \"plastic\"\nbase_color = [0.5, 0.2, 0.8]\nroughness = 0.4\nior = 1.5\n\
         {OBJECT}{LED}[[light]]\nname = \"ball\"\nkind = \"sphere\"\nposition = [0.5, 0, 2]\nradius = 0.1\n\
         intensity = [1, 1, 1]\n{PHOTOS}"
    )
}

/// Whatever a capture may hold.
pub fn full() -> String {
    let head = HEAD.replace("fy = 60.0", "fy = 61.0").replace("cx = 20.0", "cx = 21.0");
    format!(
        "{head}distortion = [0.1, 0, 0, 0, 0]\naperture_radius = 0.002\nfocus_distance = 0.9\nglare_fraction = 0.05\n\
         glare_width = 2.0\n\
         [sensor]\nread_noise = 0.01\nshot_noise = 0.001\nsaturation = 1.0\nresponse = \"srgb\"\nvignetting = [-0.2, 0.1]\n\
         crosstalk = [0.1, 0, 0, 0.05, 0, 0]\nblack_level = 0.02\ngamma = 1.1\nclip_level = 0.9\n\
         [[material]]\nname = \"shell\"\nmodel = \"plastic\"\nbase_color = [0.5, 0.2, 0.8]\nroughness = 0.4\nior = 1.5\n\
         energy_compensation = true\ndiffuse_roughness = 0.3\nscatter_distance = 0.002\nsecond_lobe_weight = 0.2\n\
         clearcoat_factor = 0.5\nclearcoat_ior = 1.6\nmetallic = 0.1\nanisotropy_strength = 0.4\nanisotropy_rotation = 0.5\n\
         sheen_color = [0.1, 0.2, 0.3]\nalbedo_variation = [0.1]\nroughness_variation = [0.1]\nbump = [0.001]\n\
         [[material]]\nname = \"steel\"\nmodel = \"conductor\"\nroughness = 0.2\neta = [2, 2.1, 2.2]\nk = [3, 3.1, 3.2]\n\
         [[material]]\nname = \"paper\"\nmodel = \"lambert\"\nbase_color = [0.8, 0.8, 0.8]\n\
         {OBJECT}presence = 0.7\n\
         [[object]]\nname = \"mirrored\"\nmesh = \"part.ply\"\nmaterial = \"steel\"\n\
         object_to_world = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -2, 1], [0, 0, 0, 1]]\n\
         [[object]]\nname = \"gone\"\nmesh = \"part.ply\"\nmaterial = \"paper\"\npresence = 0.0\n\
         object_to_world = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n\
         {LED}lobe_exponent = 2.0\n\
         [[light]]\nname = \"sun\"\nkind = \"directional\"\ndirection = [0, 3, -4]\nirradiance = [1, 2, 3]\n\
         [[light]]\nname = \"dark\"\nkind = \"point\"\nposition = [0, 0, 1]\nintensity = [0, 0, 0]\n\
         [[light]]\nname = \"ball\"\nkind = \"sphere\"\nposition = [0.5, 0, 2]\nradius = 0.1\nintensity = [1, 1, 1]\n\
         [[light]]\nname = \"room\"\nkind = \"environment\"\nmap = \"room.exr\"\nscale = 2.0\nazimuth = 0.3\n\
         [[light]]\nname = \"sky\"\nkind = \"environment\"\nradiance = [0.1, 0.2, 0.3]\n\
         {PHOTOS}"
    )
}

/// The files that both name.
pub fn files() -> MemoryFiles {
    let mut files = MemoryFiles::default();
    files.0.insert("part.ply".into(), Arc::from(write_ply(&mesh())));
    let image = Image { width: 8, height: 4, pixels: (0..32).map(|k| [k as f32, 1.0, 0.5]).collect() };
    files.0.insert("room.exr".into(), Arc::from(encode_exr("room.exr", &image).unwrap()));
    files
}

/// A tetrahedron with normals.
pub fn mesh() -> Mesh {
    let s = 1.0 / 3.0_f32.sqrt();
    let directions = [[s, s, s], [s, -s, -s], [-s, s, -s], [-s, -s, s]];
    Mesh {
        positions: directions.map(|p| p.map(|x| 0.1 * x)).to_vec(),
        normals: Some(directions.to_vec()),
        triangles: vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]],
        degenerate: 0,
    }
}

/// The export of a capture's text.
pub fn exported(text: &str, format: Format) -> Export {
    export(&Capture::parse(text).unwrap(), &files(), format).unwrap()
}

/// A file of an export, as text.
pub fn text(export: &Export, name: &str) -> String {
    String::from_utf8(export.files[name].clone()).unwrap()
}

/// A file of an export, as JSON.
pub fn json(export: &Export, name: &str) -> serde_json::Value {
    serde_json::from_slice(&export.files[name]).unwrap()
}

/// Writes an export to a new folder.
pub fn written(export: &Export) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in &export.files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    folder
}
