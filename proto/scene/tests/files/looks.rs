//! How meshes look by their files, and what maps that cannot be used are told.

use gonio_scene::capture::{CAPTURE_FILE, Capture, MapRole};
use gonio_scene::image::{Curve, Image, encode_exr, encode_png8, linear, read_texture};
use gonio_scene::mesh::{self, Look};
use gonio_scene::{Assets, Result};

use crate::files;

const TRIANGLE: &str = "ply\nformat ascii 1.0\nHEAD\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                        MORE\nelement face 1\nproperty list uchar int vertex_indices\nFACE\nend_header\n";

/// An ascii PLY of one triangle with more properties, each vertex's values and the face's.
fn ply(head: &str, more: &str, vertices: [&str; 3], face: [&str; 2]) -> String {
    let head = TRIANGLE.replace("HEAD", head).replace("MORE", more).replace("FACE", face[0]);
    let [a, b, c] = vertices;
    format!("{head}0 0 0 {a}\n1 0 0 {b}\n0 1 0 {c}\n3 0 1 2 {}\n", face[1]).replace("\n\n", "\n")
}

const UCHAR: &str = "property uchar red\nproperty uchar green\nproperty uchar blue";
const FLOAT: &str = "property float red\nproperty float green\nproperty float blue";
const ST: &str = "property float s\nproperty float t";

fn look(path: &str, text: &str, more: &[(&str, &[u8])]) -> Look {
    let all = [&[(path, text.as_bytes())], more].concat();
    mesh::read_with_look(&files(&all), path).unwrap().1
}

fn close(found: &[f32], expected: &[f32]) {
    assert_eq!(found.len(), expected.len());
    assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{found:?} for {expected:?}");
}

#[test]
fn integers_of_a_ply_are_srgb_and_floats_are_linear() {
    let text = ply("comment c", UCHAR, ["255 0 188", "0 0 0", "10 20 30"], ["", ""]);
    // IEC 61966-2-1: 188 / 255 is 0.5029 of the light, 10 / 255 is 0.003035.
    let found = look("a.ply", &text, &[]);
    assert!(found.groups[0].says(MapRole::BaseColor).colours);
    close(&found.colours.as_ref().unwrap()[0], &[1.0, 0.0, 0.502_886]);
    close(&found.colours.unwrap()[2][..1], &[0.003_035_3]);
    let text = ply("comment c", FLOAT, ["0.25 0.5 1.5", "0 0 0", "0 0 0"], ["", ""]);
    close(&look("a.ply", &text, &[]).colours.unwrap()[0], &[0.25, 0.5, 1.5]);
}

#[test]
fn coordinates_of_a_ply_run_up_at_vertices_and_at_corners() {
    let text = ply("comment TextureFile skin.png", ST, ["0 0", "1 0", "0 0.75"], ["", ""]);
    let found = look("meshes/a.ply", &text, &[]);
    close(&found.coordinates.unwrap()[2], &[0.0, 0.25]);
    let picture = found.groups[0].says(MapRole::BaseColor).picture.clone().unwrap();
    assert_eq!((picture.place.as_str(), picture.curve), ("meshes/skin.png", Curve::Colour));
    let wedges = ["property list uchar float texcoord", "6 0.5 1 0.25 0.5 0 0"];
    let text = ply("comment c", "", ["", "", ""], wedges);
    let found = look("a.ply", &text, &[]);
    close(found.coordinates.unwrap().as_flattened(), &[0.5, 0.0, 0.25, 0.5, 0.0, 1.0]);
}

const OBJ: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 0 0.75\n\
                   usemtl wood\nf 1/1 2/2 3/3\nusemtl steel\nf 2/2 4/3 3/1\n";
const MTL: &[u8] =
    b"newmtl wood\nKd 0.5 1 1\nmap_Kd sub\\wood.png\nmap_Pr rough.png\nPr 0.5\nnewmtl steel\nKd 0.1 0.2 0.3\nPm 1.0\n";

#[test]
fn an_obj_has_the_groups_and_textures_of_its_library() {
    let found = look("m/a.obj", OBJ, &[("m/a.mtl", MTL)]);
    let names: Vec<&str> = found.groups.iter().map(|group| group.name.as_str()).collect();
    assert_eq!(names, ["", "wood", "steel"]);
    assert_eq!((found.group_of(0), found.group_of(1)), (1, 2));
    assert_eq!(found.libraries, ["m/a.mtl"]);
    let wood = &found.groups[1];
    let picture = |role| wood.says(role).picture.clone().unwrap();
    assert_eq!(picture(MapRole::BaseColor).place, "m/sub/wood.png");
    assert_eq!(
        (picture(MapRole::Roughness).place.as_str(), picture(MapRole::Roughness).curve),
        ("m/rough.png", Curve::Linear)
    );
    assert_eq!(wood.says(MapRole::BaseColor).factor, [0.5, 1.0, 1.0]);
    assert_eq!(
        (wood.says(MapRole::Roughness).factor, found.groups[2].says(MapRole::Metallic).factor),
        ([0.5; 3], [1.0; 3])
    );
    // A vertex for every pair of coordinates: 2 has one, 3 has two.
    close(&found.coordinates.unwrap()[2], &[0.0, 0.25]);
    let coloured = look("a.obj", "v 0 0 0 1 0 0\nv 1 0 0 0 0 1\nv 0 1 0 0.5 0.5 0.5\nf 1 2 3\n", &[]);
    close(&coloured.colours.unwrap()[2], &[0.214_041; 3]);
}

/// Three corners: positions, then COLOR_0 of normalised bytes, TEXCOORD_0 of floats, and a PNG.
fn glb() -> Vec<u8> {
    let png = encode_png8("t.png", 1, 1, &[[255, 188, 0]]).unwrap();
    let floats = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let mut bytes = floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    bytes.extend([255, 0, 51, 255, 0, 255, 0, 255, 102, 102, 102, 255]);
    bytes.extend(floats(&[0.0, 0.0, 1.0, 0.0, 0.25, 0.75]));
    let start = bytes.len();
    bytes.extend(&png);
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
        "buffers":[{{"byteLength":{}}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":12}},
          {{"buffer":0,"byteOffset":48,"byteLength":24}},{{"buffer":0,"byteOffset":{start},"byteLength":{}}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
          {{"bufferView":1,"componentType":5121,"normalized":true,"count":3,"type":"VEC4"}},
          {{"bufferView":2,"componentType":5126,"count":3,"type":"VEC2"}}],
        "images":[{{"bufferView":3,"mimeType":"image/png"}}],"samplers":[{{"wrapS":33071,"wrapT":33648}}],
        "textures":[{{"source":0,"sampler":0}}],
        "materials":[{{"name":"shell","pbrMetallicRoughness":{{"baseColorFactor":[0.5,1,1,1],
          "baseColorTexture":{{"index":0}},"metallicRoughnessTexture":{{"index":0}},"roughnessFactor":0.25}}}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"COLOR_0":1,"TEXCOORD_0":2}},"material":0}},
          {{"attributes":{{"POSITION":0}}}}]}}]}}"#,
        bytes.len(),
        png.len()
    );
    let mut json = json.into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut out = b"glTF".to_vec();
    out.extend([2, (28 + json.len() + bytes.len()) as u32].into_iter().flat_map(u32::to_le_bytes));
    for (kind, content) in [(b"JSON", &json), (b"BIN\0", &bytes)] {
        out.extend((content.len() as u32).to_le_bytes());
        out.extend(kind);
        out.extend(content);
    }
    out
}

#[test]
fn a_glb_has_factors_colours_coordinates_and_textures() {
    let bytes = glb();
    let (mesh, found) = mesh::read_with_look(&files(&[("a.glb", &bytes)]), "a.glb").unwrap();
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (6, 2));
    assert_eq!(found.groups.iter().map(|group| group.name.as_str()).collect::<Vec<_>>(), ["shell", ""]);
    assert_eq!(found.group_of, [0, 1]);
    // COLOR_0 is linear, and white where a primitive has none; coordinates run down, and are nowhere there.
    close(&found.colours.as_ref().unwrap()[0], &[1.0, 0.0, 0.2]);
    close(&found.colours.unwrap()[3], &[1.0; 3]);
    let coordinates = found.coordinates.unwrap();
    close(&coordinates[2], &[0.25, 0.75]);
    assert!(coordinates[3][0].is_nan());
    let says = found.groups[0].says(MapRole::BaseColor);
    assert_eq!((says.factor, says.colours), ([0.5, 1.0, 1.0], true));
    let picture = says.picture.as_ref().unwrap();
    assert_eq!((picture.place.as_str(), picture.curve), ("a.glb#images[0]", Curve::Srgb));
    assert_eq!(picture.wrap, [mesh::Wrap::Clamp, mesh::Wrap::Mirror]);
    assert_eq!(found.groups[0].says(MapRole::Roughness).factor, [0.25; 3]);
    assert_eq!(found.groups[0].says(MapRole::Roughness).picture.as_ref().unwrap().curve, Curve::Linear);
}

/// Loads a capture of one object with a material of these keys; behind "PARTS" stand further keys of the object.
fn load(mesh: &str, keys: &str, all: &[(&str, &[u8])]) -> Result<Assets> {
    let (keys, parts) = keys.split_once("PARTS").unwrap_or((keys, ""));
    let toml = format!(
        "format = 1\nname = \"x\"\n[camera]\nwidth = 4\nheight = 4\nfx = 4.0\nfy = 4.0\ncx = 2.0\ncy = 2.0\n\
         [[material]]\nname = \"m\"\nmodel = \"plastic\"\nbase_color = [1, 1, 1]\nroughness = 0.5\nior = 1.5\n{keys}\n\
         [[object]]\nname = \"o\"\nmesh = \"{mesh}\"\nmaterial = \"m\"\n\
         object_to_world = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n{parts}\n\
         [[photo]]\nfile = \"a.png\"\ncamera_to_world = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n"
    );
    let files = files(&[&[(CAPTURE_FILE, toml.as_bytes())], all].concat());
    Assets::load(&Capture::read(&files)?, &files)
}

const MESH: &str = "base_color_map = \"mesh\"";
const IMAGE: &str = "base_color_map = \"t.png\"";

#[test]
fn what_a_map_needs_and_lacks_is_said() {
    let plain = ply("comment c", "", ["", "", ""], ["", ""]);
    let unwrapped = ply("comment c", ST, ["0 0", "1 0", "0 1"], ["", ""]);
    let half = ply("comment c", "", ["", "", ""], ["property list uchar float texcoord", "2 0 0"]);
    let nan = ply("comment c", FLOAT, ["0 0 0", "0.5 nan 0", "0 0 0"], ["", ""]);
    let negative = ply("comment c", FLOAT, ["0 0 0", "0.5 -1 0", "0 0 0"], ["", ""]);
    let two = ply("comment TextureFile a.png\ncomment TextureFile b.png", ST, ["0 0", "1 0", "0 1"], ["", ""]);
    let absent = ply("comment TextureFile gone.png", ST, ["0 0", "1 0", "0 1"], ["", ""]);
    let typed = ply("comment c", &UCHAR.replace("uchar", "int"), ["1 2 3", "1 2 3", "1 2 3"], ["", ""]);
    let png = encode_png8("t.png", 2, 1, &[[0, 128, 255]; 2]).unwrap();
    let huge = huge_png();
    let bright = encode_exr("r.exr", &Image { width: 1, height: 1, pixels: vec![[0.0, 2.0, 0.0]] }).unwrap();
    let dark = encode_exr("r.exr", &Image { width: 1, height: 1, pixels: vec![[0.5, -0.1, 0.0]] }).unwrap();
    let wrong = b"\x89PNG\r\n\x1a\nnothing".to_vec();
    for (mesh, keys, texture, says) in [
        (&plain, MESH, None, "capture.toml: material.m.base_color_map: is \"mesh\", and a.ply has neither colours"),
        (
            &plain,
            IMAGE,
            Some(("t.png", &png)),
            "material.m.base_color_map: needs texture coordinates, which a.ply does not",
        ),
        (&half, IMAGE, Some(("t.png", &png)), "a.ply: vertex 1: has the texture coordinates [NaN, NaN]"),
        (&nan, MESH, None, "a.ply: vertex 1: has the colour [0.5, NaN, 0.0], which is no reflectance"),
        (&negative, MESH, None, "a.ply: vertex 1: has the colour [0.5, -1.0, 0.0]"),
        (&typed, MESH, None, "a.ply: red: has colours of a type that is not known"),
        (&two, MESH, None, "a.ply: a.png: is one of several textures of the mesh"),
        (&absent, MESH, None, "gone.png: is not among the files"),
        (&unwrapped, IMAGE, None, "t.png: is not among the files"),
        (&unwrapped, IMAGE, Some(("t.png", &huge)), "t.png: size: is 20000 x 1 pixels, above the limit of 16384"),
        (&unwrapped, IMAGE, Some(("t.png", &wrong)), "t.png: "),
        (
            &unwrapped,
            "roughness_map = \"r.exr\"",
            Some(("r.exr", &bright)),
            "r.exr: has values above 1, and is a roughness_map",
        ),
        (
            &unwrapped,
            "base_color_map = \"r.exr\"",
            Some(("r.exr", &dark)),
            "r.exr: pixel (column 0, row 0): has a value below 0",
        ),
        (
            &unwrapped,
            "metallic_map = \"mesh\"",
            None,
            "material.m.metallic_map: is \"mesh\", and a.ply has no such map",
        ),
        (&plain, "PARTS[object.materials]\nlid = \"m\"", None, "object.o.materials.lid: is no material of a.ply"),
        (
            &plain,
            "PARTS[object.materials]\nlid = \"q\"",
            None,
            "object.o.materials.lid: names \"q\", which is no material here",
        ),
        (&plain, "PARTS[object.materials]\nlid = 1", None, "object.o.materials.lid: is a TOML integer"),
        (&plain, "base_color_map = 1", None, "material.m.base_color_map: is a TOML integer"),
        (&plain, "normals_map = \"mesh\"", None, "material.m.normals_map: is not a key"),
    ] {
        let mut all = vec![("a.ply", mesh.as_bytes())];
        all.extend(texture.map(|(name, bytes)| (name, bytes.as_slice())));
        let error = load("a.ply", keys, &all).unwrap_err().to_string();
        assert!(error.contains(says), "{keys}: {error}");
        // Without its maps every one of these meshes is sound.
        assert!(load("a.ply", "", &all).is_ok(), "{keys}");
    }
}

#[test]
fn an_obj_that_lacks_something_is_told() {
    let load = |keys: &str, obj: &str, more: &[(&str, &[u8])]| {
        load("a.obj", keys, &[&[("a.obj", obj.as_bytes())], more].concat()).map_err(|error| error.to_string())
    };
    let library = [("a.mtl", MTL)];
    assert!(load(MESH, OBJ, &[]).unwrap_err().contains("a.mtl: is not among the files"));
    assert!(load(MESH, OBJ, &library).unwrap_err().contains("sub/wood.png: is not among the files"));
    assert!(load(MESH, OBJ, &[("a.mtl", b"newmtl wood\nKd 1 x 1\n")]).unwrap_err().starts_with("a.mtl: "));
    let options = b"newmtl wood\nmap_Kd -s 2 2 2 wood.png\n";
    assert!(load(MESH, OBJ, &[("a.mtl", options)]).unwrap_err().contains("has options that are not supported"));
    let some = OBJ.replace("f 2/2 4/3 3/1", "f 2 4 3");
    assert!(load(MESH, &some, &library).unwrap_err().contains("a.obj: vt: has texture coordinates at 3 of"));
    assert!(load("", &some, &[]).is_ok() && load("", OBJ, &[]).is_ok());
    // The parts' names need no library, and are told.
    let unknown = load("PARTS[object.materials]\nlid = \"m\"", OBJ, &[]).unwrap_err();
    assert!(unknown.contains("the names there are: wood, steel"), "{unknown}");
    assert!(load("PARTS[object.materials]\nsteel = \"m\"", OBJ, &[]).is_ok());
}

#[test]
fn a_glb_brings_its_textures_along_and_a_part_without_coordinates_is_told() {
    let bytes = glb();
    let error = load("a.glb", IMAGE, &[("a.glb", &bytes), ("t.png", b"")]).unwrap_err().to_string();
    assert!(error.contains("a.glb: vertex 3: has the texture coordinates [NaN, NaN]"), "{error}");
    let assets = load("a.glb", &format!("{MESH}\nroughness_map = \"mesh\""), &[("a.glb", &bytes)]).unwrap();
    let value = |curve: Curve| assets.textures.iter().find(|(key, _)| key.curve == curve).unwrap().1.pixels[0];
    close(&value(Curve::Srgb), &[1.0, 0.502_886, 0.0]);
    close(&value(Curve::Linear), &[1.0, 188.0 / 255.0, 0.0]);
}

#[test]
fn a_png_that_says_that_it_is_linear_is() {
    let png = encode_png8("t.png", 2, 1, &[[188; 3]; 2]).unwrap();
    let with = |gamma: u32| {
        let mut out = png[..33].to_vec();
        let chunk = [&b"gAMA"[..], &gamma.to_be_bytes()].concat();
        let crc = chunk.iter().fold(!0u32, |crc, byte| {
            (0..8).fold(crc ^ u32::from(*byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 })
        });
        out.extend(4u32.to_be_bytes());
        out.extend(chunk);
        out.extend((!crc).to_be_bytes());
        out.extend(&png[33..]);
        read_texture(&files(&[("t.png", &out)]), "t.png", Curve::Colour).map(|image| image.pixels[0][0])
    };
    close(&[with(100_000).unwrap(), with(45_455).unwrap()], &[188.0 / 255.0, linear(188.0 / 255.0)]);
    assert!(with(60_000).unwrap_err().to_string().contains("gAMA: says by its gAMA"));
}

/// The head of a PNG of 20000 x 1 pixels.
fn huge_png() -> Vec<u8> {
    let mut png = encode_png8("t.png", 2, 1, &[[0; 3]; 2]).unwrap();
    png[16..20].copy_from_slice(&20_000u32.to_be_bytes());
    let crc = png[12..29].iter().fold(!0u32, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 })
    });
    png[29..33].copy_from_slice(&(!crc).to_be_bytes());
    png
}
