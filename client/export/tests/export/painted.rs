//! Maps: what varies over a part, in every format; and pictures of the real programs against the texels that they show.

use crate::fixture::{HEAD, json, text, written};
use crate::programs::python;
use gonio_export::{Export, Format, export};
use gonio_scene::Capture;
use gonio_scene::files::MemoryFiles;
use gonio_scene::image::{Image, encode_exr};
use std::sync::Arc;

/// A square of 1 m that faces up, its texture's upper left corner at (-0.5, 0.5), each corner with a colour.
const SQUARE: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
    property float s\nproperty float t\nproperty float red\nproperty float green\nproperty float blue\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n\
    -0.5 -0.5 0 0 0 0.1 0.1 0.1\n0.5 -0.5 0 1 0 0.1 0.6 0.1\n0.5 0.5 0 1 1 0.6 0.1 0.1\n-0.5 0.5 0 0 1 0.1 0.1 0.6\n\
    4 0 1 2 3\n";

/// Two triangles of two materials.
const TWO: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nusemtl left\nf 1 2 3\nusemtl right\nf 2 4 3\n";

/// Four quadrants of 4 x 4 texels, as a picture shows them.
const QUADRANTS: [[f32; 3]; 4] = [[0.8, 0.1, 0.1], [0.1, 0.7, 0.1], [0.1, 0.2, 0.6], [0.5, 0.5, 0.2]];

fn quadrants() -> Image {
    let texel = |k: usize| QUADRANTS[(k / 32) * 2 + (k % 8) / 4];
    Image { width: 8, height: 8, pixels: (0..64).map(texel).collect() }
}

fn files() -> MemoryFiles {
    let mut files = MemoryFiles::default();
    let mut put = |name: &str, bytes: &[u8]| drop(files.0.insert(name.into(), Arc::from(bytes)));
    put("square.ply", SQUARE.as_bytes());
    put("two.obj", TWO.as_bytes());
    put("skin.exr", &encode_exr("skin.exr", &quadrants()).unwrap());
    files
}

fn exported(text: &str, format: Format) -> Export {
    export(&Capture::parse(text).unwrap(), &files(), format).unwrap()
}

/// The square from 1 m above, filling the middle 30 of 40 x 30 pixels, in light of radiance 1 from everywhere.
fn square(material: &str) -> String {
    format!(
        "{}[[material]]\nname = \"skin\"\n{material}\
         [[object]]\nname = \"square\"\nmesh = \"square.ply\"\nmaterial = \"skin\"\n\
         object_to_world = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n\
         [[light]]\nname = \"sky\"\nkind = \"environment\"\nradiance = [1, 1, 1]\n\
         [[photo]]\nfile = \"00.exr\"\ncamera_to_world = [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 2], [0, 0, 0, 1]]\n",
        HEAD
    )
}

fn lambert(map: &str) -> String {
    square(&format!("model = \"lambert\"\nbase_color = [0.5, 1.0, 1.0]\nbase_color_map = \"{map}\"\n"))
}

const PLASTIC: &str = "model = \"plastic\"\nbase_color = [0.5, 1.0, 1.0]\nroughness = 0.4\nior = 1.5\n\
    base_color_map = \"skin.exr\"\nroughness_map = \"skin.exr\"\n";

#[test]
fn every_format_has_the_texture_and_says_so() {
    let word = |format: Format, key: &str| {
        let export = exported(&square(PLASTIC), format);
        let name = format!("material.skin.{key}");
        export.record.numbers.iter().find(|entry| entry.name == name).unwrap().kept.word().to_owned()
    };
    let kept = |format| ["base_color_map", "roughness_map"].map(|key| word(format, key));
    assert_eq!(kept(Format::Mitsuba), ["exact", "approximated"]);
    assert_eq!(kept(Format::Pbrt), ["exact", "exact"]);
    assert_eq!(kept(Format::Blender), ["exact", "exact"]);
    assert_eq!(kept(Format::Usd), ["approximated", "approximated"]);
    assert_eq!(kept(Format::Gltf), ["approximated", "approximated"]);
    for format in [Format::Mitsuba, Format::Pbrt, Format::Blender, Format::Usd] {
        let export = exported(&square(PLASTIC), format);
        assert!(export.files.keys().any(|name| name.starts_with("textures/skin-square-base_color.")), "{format}");
    }
    let scene = &json(&exported(&square(PLASTIC), Format::Mitsuba), "scenes.json")["00"];
    assert_eq!(scene["material-skin-square"]["diffuse_reflectance"]["type"], "bitmap");
    // The mean of the green channel over the quadrants, 0.375, times the number.
    let alpha = scene["material-skin-square"]["alpha"].as_f64().unwrap();
    assert!((alpha.sqrt() - 0.4 * 0.375).abs() < 1e-6, "{alpha}");
    let pbrt = text(&exported(&square(PLASTIC), Format::Pbrt), "00.pbrt");
    assert!(pbrt.contains("\"texture roughness\" [ \"skin-square.float\" ]"), "{pbrt}");
}

#[test]
fn vertex_colours_are_kept_by_every_format() {
    let text = lambert("mesh");
    let word = |format: Format| {
        let numbers = exported(&text, format).record.numbers;
        numbers.into_iter().find(|entry| entry.name.ends_with("base_color_map")).unwrap().kept.word().to_owned()
    };
    assert_eq!(Format::ALL.map(word), ["exact"; 5]);
    // Two triangles: 4 x 2 texels of three corners each, and vertices of their own.
    for format in [Format::Mitsuba, Format::Pbrt] {
        let export = exported(&text, format);
        let mesh = String::from_utf8_lossy(&export.files["meshes/square.ply"]).into_owned();
        assert!(mesh.contains("element vertex 6\n") && mesh.contains("property float u\nproperty float v\n"), "{mesh}");
        let texture = "textures/skin-square-base_color.exr";
        let mut files = MemoryFiles::default();
        files.0.insert(texture.into(), Arc::from(export.files[texture].clone()));
        let image = gonio_scene::image::read_texture(&files, texture, gonio_scene::image::Curve::Linear).unwrap();
        assert_eq!((image.width, image.height), (4, 2));
        // The first triangle's corners are gray, green and red, their red halved; what lies across from gray is the rest.
        assert_eq!(image.pixels[..2], [[0.05, 0.1, 0.1], [0.05, 0.6, 0.1]], "{format}");
        assert_eq!(image.pixels[4], [0.3, 0.1, 0.1]);
        assert!((image.pixels[5][0] - 0.3).abs() < 1e-6 && (image.pixels[5][1] - 0.6).abs() < 1e-6);
    }
    let blender = exported(&text, Format::Blender);
    let mesh = String::from_utf8_lossy(&blender.files["meshes/square.ply"]).into_owned();
    assert!(mesh.contains("property float r\nproperty float g\nproperty float b\n"), "{mesh}");
}

#[test]
fn a_mesh_of_two_materials_is_two_shapes() {
    let two = square("model = \"lambert\"\nbase_color = [0.5, 0.5, 0.5]\n")
        .replace("square.ply", "two.obj")
        .replace("[[light]]", "[object.materials]\nright = \"other\"\n[[light]]")
        + "[[material]]\nname = \"other\"\nmodel = \"lambert\"\nbase_color = [0.1, 0.2, 0.3]\n";
    let export = exported(&two, Format::Mitsuba);
    let scene = &json(&export, "scenes.json")["00"];
    assert_eq!(scene["object-square-left"]["bsdf"]["id"], "material-skin");
    assert_eq!(scene["object-square-right"]["bsdf"]["id"], "material-other");
    let numbers = &export.record.numbers;
    assert_eq!(numbers.iter().find(|e| e.name == "object.square.materials.right").unwrap().kept.word(), "exact");
}

/// What a picture of 40 x 30 pixels shows of the square: the middles of its quadrants, in reading order.
const LOOK: &str = "def look(image):\n\
    \x20   return [[round(float(v), 3) for v in image[y, x, :3]] for y, x in [(7, 12), (7, 27), (22, 12), (22, 27)]]\n";

/// The corners' colours a quarter of the way in, in reading order: by hand from the two triangles' barycentric coordinates.
const OF_CORNERS: [[f32; 3]; 4] = [[0.225, 0.1, 0.35], [0.475, 0.1, 0.1], [0.225, 0.1, 0.1], [0.225, 0.35, 0.1]];

/// What it should show: texels, or the corners' colours, times the base colour (half in red).
fn expected(map: &str) -> [[f64; 3]; 4] {
    let half = |[r, g, b]: [f32; 3]| [f64::from(r) / 2.0, f64::from(g), f64::from(b)];
    if map == "mesh" {
        return OF_CORNERS.map(half);
    }
    QUADRANTS.map(half)
}

fn check(found: &str, map: &str) {
    let found: Vec<[f64; 3]> = serde_json::from_str(found).unwrap();
    for (found, expected) in found.iter().zip(expected(map)) {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.02), "{map}: {found:?} for {expected:?}");
    }
}

#[test]
fn mitsuba_shows_each_texel_at_its_place() {
    let Some(python) = python(&["mitsuba", "numpy"]) else { return };
    // A plastic's base needs what a lambert's does not: it has to load.
    let plastic = square(&PLASTIC.replace("base_color_map = \"skin.exr\"", "base_color_map = \"mesh\""));
    let folder = written(&exported(&plastic, Format::Mitsuba));
    let program = "import mitsuba as mi\nmi.set_variant('scalar_rgb')\nimport scene\nscene.load('00')\nprint('loaded')";
    assert_eq!(python(program, folder.path()), "loaded");
    for map in ["skin.exr", "mesh"] {
        let folder = written(&exported(&lambert(map), Format::Mitsuba));
        let program = format!(
            "import json, mitsuba as mi, numpy as np\nmi.set_variant('scalar_rgb')\nimport scene\n{LOOK}\
             print(json.dumps(look(np.array(mi.render(scene.load('00'), spp=1024)))))"
        );
        check(&python(&program, folder.path()), map);
    }
}

#[test]
fn cycles_shows_each_texel_at_its_place() {
    let Some(python) = python(&["bpy", "numpy"]) else { return };
    for map in ["skin.exr", "mesh"] {
        let folder = written(&exported(&lambert(map), Format::Blender));
        // Blender reads its own picture back, its rows from below.
        let program = format!(
            "import json, os, sys\nsys.path.insert(0, '.')\nimport bpy, numpy as np, scene\n{LOOK}\
             scene.build('00')\nscene.render('00.exr', 64)\n\
             image = bpy.data.images.load(os.path.abspath('00.exr'))\n\
             image = np.array(image.pixels[:]).reshape(30, 40, -1)[::-1]\n\
             print(json.dumps(look(image)))"
        );
        check(&python(&program, folder.path()), map);
    }
}

#[test]
fn openusd_and_trimesh_find_the_texture() {
    if let Some(python) = python(&["pxr"]) {
        let folder = written(&exported(&square(PLASTIC), Format::Usd));
        let program = "from pxr import Usd, UsdShade, UsdGeom\nimport os\nstage = Usd.Stage.Open('scene.usda')\n\
            mesh = [p for p in stage.Traverse() if p.IsA(UsdGeom.Mesh)][0]\n\
            assert len(UsdGeom.PrimvarsAPI(mesh).GetPrimvar('st').Get()) == 4\n\
            material = UsdShade.MaterialBindingAPI(mesh).ComputeBoundMaterial()[0]\n\
            shader = UsdShade.Shader(material.GetPrim().GetChild('Preview'))\n\
            source = shader.GetInput('diffuseColor').GetConnectedSource()[0]\n\
            print(os.path.exists(source.GetInput('file').Get().resolvedPath))\n";
        assert_eq!(python(program, folder.path()), "True");
    }
    if let Some(python) = python(&["trimesh", "PIL"]) {
        let folder = written(&exported(&square(PLASTIC), Format::Gltf));
        let program = "import trimesh\nscene = trimesh.load('scene.glb')\n\
            visual = list(scene.geometry.values())[0].visual\nprint(visual.material.baseColorTexture.size)\n";
        assert_eq!(python(program, folder.path()), "(8, 8)");
    }
}
