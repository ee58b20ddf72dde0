//! The real programs, where the Python of this machine has them: Mitsuba 3, Blender as the module `bpy`, OpenUSD, trimesh.

use crate::fixture::{exported, full, plain, written};
use gonio_export::Format;
use std::path::Path;
use std::process::Command;

/// The interpreter: the variable `GONIO_TEST_PYTHON`, or `python3`.
fn interpreter() -> String {
    std::env::var("GONIO_TEST_PYTHON").unwrap_or_else(|_| "python3".to_owned())
}

/// What runs a program of Python in a folder and gives its last line, if the interpreter has all of `modules`.
pub fn python(modules: &[&str]) -> Option<impl Fn(&str, &Path) -> String> {
    let program = format!("import {}", modules.join(", "));
    let found = Command::new(interpreter()).args(["-c", &program]).output().is_ok_and(|output| output.status.success());
    if !found {
        eprintln!("skipped: {} has not all of {modules:?}", interpreter());
        return None;
    }
    Some(|program: &str, folder: &Path| {
        let output = Command::new(interpreter()).args(["-B", "-c", program]).current_dir(folder).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).trim_end().lines().last().unwrap_or_default().to_owned()
    })
}

#[test]
fn mitsuba_loads_and_renders_files_and_objects() {
    let Some(python) = python(&["mitsuba", "numpy"]) else { return };
    for description in [plain(), full()] {
        let folder = written(&exported(&description, Format::Mitsuba));
        let program = "import mitsuba as mi, numpy as np\n\
            mi.set_variant('scalar_rgb')\n\
            import scene\n\
            for name in scene.names():\n\
            \x20   a = np.array(mi.render(mi.load_file(name + '.xml'), spp=4))\n\
            \x20   b = np.array(mi.render(scene.load(name), spp=4))\n\
            \x20   assert a.shape == (30, 40, 3) and np.isfinite(a).all()\n\
            \x20   assert np.allclose(a, b, rtol=1e-3), np.abs(a - b).max()\n\
            print(a.mean())\n";
        assert!(python(program, folder.path()).parse::<f64>().unwrap() > 0.0);
    }
}

#[test]
fn blender_builds_and_renders() {
    let Some(python) = python(&["bpy"]) else { return };
    for description in [plain(), full()] {
        let folder = written(&exported(&description, Format::Blender));
        let program = "import os, sys\nsys.path.insert(0, '.')\nimport scene\n\
            for name in scene.names():\n\
            \x20   scene.build(name)\n\
            \x20   scene.render(name + '.exr', 2)\n\
            \x20   assert os.path.getsize(name + '.exr') > 0\n";
        python(program, folder.path());
    }
}

#[test]
fn openusd_opens_the_stage() {
    let Some(python) = python(&["pxr"]) else { return };
    for (description, lights) in [(plain(), [1, 2]), (full(), [1, 5])] {
        let folder = written(&exported(&description, Format::Usd));
        let program = "import json\nfrom pxr import Usd, UsdGeom, UsdLux, UsdShade\n\
            stage = Usd.Stage.Open('scene.usda')\n\
            assert UsdGeom.GetStageMetersPerUnit(stage) == 1 and UsdGeom.GetStageUpAxis(stage) == 'Z'\n\
            photo = stage.GetDefaultPrim().GetVariantSets().GetVariantSet('photo')\n\
            count = []\n\
            for name in photo.GetVariantNames():\n\
            \x20   photo.SetVariantSelection(name)\n\
            \x20   prims = list(stage.Traverse())\n\
            \x20   count.append(sum(p.HasAPI(UsdLux.LightAPI) for p in prims))\n\
            \x20   for p in prims:\n\
            \x20       if p.IsA(UsdGeom.Mesh):\n\
            \x20           assert len(UsdGeom.Mesh(p).GetPointsAttr().Get()) == 4\n\
            \x20           assert UsdShade.MaterialBindingAPI(p).ComputeBoundMaterial()[0]\n\
            assert sum(p.IsA(UsdGeom.Camera) for p in prims) == 2\n\
            print(json.dumps(count))\n";
        assert_eq!(python(program, folder.path()), format!("{lights:?}"));
    }
}

#[test]
fn trimesh_opens_the_glb() {
    let Some(python) = python(&["trimesh"]) else { return };
    let folder = written(&exported(&full(), Format::Gltf));
    let program = "import trimesh\nscene = trimesh.load('scene.glb')\nprint(len(scene.geometry))\n";
    assert_eq!(python(program, folder.path()), "2");
}
