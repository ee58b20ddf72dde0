//! Numbers and pixels are those of the command line's files, bit for bit.

use crate::interpreter::{capture, interpreter, printed};
use gonio_scene::files::DirectoryFiles;
use gonio_scene::image;
use std::path::Path;

/// Saves renders as raw bytes: rows of pixels of 32-bit floats.
const RENDER: &str = "
import sys, gonio, numpy as np
capture = gonio.load(sys.argv[1])
capture['material.shell.roughness'] = 0.3
capture.save('changed')
image = capture.render('03', samples=4, seed=5)
assert image.dtype == np.float32 and image.flags.c_contiguous, (image.dtype, image.flags)
image.tofile('03.raw')
both = capture.render(['05', '03'], samples=4, seed=5, buffers=True)
assert list(both) == ['03', '05']
assert np.array_equal(both['03'].image, image)
hits = both['03']
height, width, _ = image.shape
for plane in (hits.depth, hits.objects, hits.half_angles, hits.incidence_angles):
    assert plane.shape == (height, width), plane.shape
for vectors in (hits.normals, hits.positions):
    assert vectors.shape == (height, width, 3), vectors.shape
# A point lies as far along the camera's axis as the depth says: camera_to_world's third column is that axis.
matrix = np.array([[capture[f'photo.03.camera_to_world.{i}.{j}'] for j in range(4)] for i in range(3)])
seen = hits.objects >= 0
along = (hits.positions[seen] - matrix[:, 3]) @ matrix[:, 2]
assert seen.any() and np.allclose(along, hits.depth[seen], atol=1e-5)
photo = capture.photos['03']
assert photo.shape == image.shape and photo.dtype == np.float32
photo.tofile('photo.raw')
assert capture.masks['03'].shape == (height, width)
";

fn raw(path: &Path) -> Vec<[f32; 3]> {
    let floats: Vec<f32> =
        std::fs::read(path).unwrap().chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    floats.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect()
}

#[test]
fn renders_have_the_bits_of_the_files() {
    let Some(python) = interpreter() else { return };
    let top = tempfile::tempdir().unwrap();
    let none = capture("none-201");
    python.succeeds(top.path(), RENDER, &[none.to_str().unwrap()]);
    let words = ["render", "changed", "--out", "out", "--samples", "4", "--seed", "5", "--photos", "03", "--json"];
    let told: serde_json::Value = serde_json::from_str(&printed(&python.gonio(top.path(), &words))).unwrap();
    assert_eq!(told["photos"][0]["name"], "03");
    let rendered = image::read(&DirectoryFiles::new(top.path().join("out")), "03.exr").unwrap();
    assert!(rendered.pixels == raw(&top.path().join("03.raw")), "the array differs from the file");
    let photo = image::read(&DirectoryFiles::new(&none), "photos/03.exr").unwrap();
    assert!(photo.pixels == raw(&top.path().join("photo.raw")), "the photo differs from its file");
}

/// Prints a fit's values, errors and covariance, with all digits.
const FIT: &str = "
import json, sys, gonio
lines = []
fit = gonio.load(sys.argv[1]).fit(samples=8, free=['material.shell.roughness', 'light.led.intensity'],
                                  start={'material.shell.roughness': 0.5}, progress=lines.append)
assert any('iterations' in line for line in lines), lines
assert fit.covariance.shape == (2, 2)
fit.save('saved')
print(json.dumps([fit.values, fit.errors, fit.covariance.tolist()]))
assert 'srcdoc' in fit._repr_html_() and 'Capture.fit(samples=8' in fit.report()
";

#[test]
fn a_fit_is_that_of_the_command() {
    let Some(python) = interpreter() else { return };
    let top = tempfile::tempdir().unwrap();
    let none = capture("none-201");
    let none = none.to_str().unwrap();
    let printed_fit = python.succeeds(top.path(), FIT, &[none]);
    let [values, errors, covariance]: [serde_json::Value; 3] = serde_json::from_str(&printed_fit).unwrap();
    let free = "material.shell.roughness,light.led.intensity";
    let start = "material.shell.roughness=0.5";
    let words = ["fit", none, "--out", "out", "--samples", "8", "--free", free, "--start", start, "--json"];
    let told: serde_json::Value = serde_json::from_str(&printed(&python.gonio(top.path(), &words))).unwrap();
    let parameters = told["parameters"].as_array().unwrap();
    assert_eq!(parameters.len(), 2);
    for (i, parameter) in parameters.iter().enumerate() {
        let name = parameter["name"].as_str().unwrap();
        assert_eq!(values[name], parameter["value"], "{name}");
        assert_eq!(errors[name], parameter["standard_error"], "{name}");
        let error = parameter["standard_error"].as_f64().unwrap();
        let variance = covariance[i][i].as_f64().unwrap();
        assert!((variance / (error * error) - 1.0).abs() < 1e-12, "{name}: {variance}");
    }
    let read = |folder: &str| std::fs::read_to_string(top.path().join(folder).join("capture.toml")).unwrap();
    assert_eq!(read("saved"), read("out"));
}

/// Frames of a sweep that is not kept, of one that is, and of one that finds it.
const SWEEP: &str = "
import pathlib, sys, gonio, numpy as np
text = f'''
format = 1
capture = {sys.argv[1]!r}
samples = 4
resolution = 0.25
photos = [\"00\", \"05\"]
outputs = [\"exr\"]
[[design]]
kind = \"grid\"
axes = [{{ name = \"material.shell.roughness\", values = [0.2, 0.5] }}]
'''
pathlib.Path('sweep.toml').write_text(text)
def frames(**options):
    return {frame.index: frame for frame in gonio.sweep('sweep.toml', **options)}
alone, kept, found = frames(), frames(out='out'), frames(out='out')
assert sorted(alone) == sorted(kept) == sorted(found) == [0, 1, 2, 3]
for index, frame in alone.items():
    for other in (kept[index], found[index]):
        assert np.array_equal(frame.image, other.image) and frame.digest == other.digest
    assert np.allclose(frame.image.mean(axis=(0, 1)), frame.mean, rtol=1e-5)
    assert frame.values == {'material.shell.roughness': [0.2, 0.5][frame.point]}, frame.values
assert pathlib.Path('out/table.csv').exists()
# Who leaves the loop ends the sweep.
for frame in gonio.sweep('sweep.toml'):
    break
print(alone[0].view)
";

#[test]
fn a_sweep_gives_what_it_keeps() {
    let Some(python) = interpreter() else { return };
    let top = tempfile::tempdir().unwrap();
    let none = capture("none-201");
    assert_eq!(python.succeeds(top.path(), SWEEP, &[none.to_str().unwrap()]).trim_end(), "00");
}
