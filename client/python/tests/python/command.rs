//! The command line in the process, and errors in its words.

use crate::interpreter::{capture, interpreter};

#[test]
fn the_command_has_its_exit_codes() {
    let Some(python) = interpreter() else { return };
    let at = tempfile::tempdir().unwrap();
    let help = python.gonio(at.path(), &["--help"]);
    assert_eq!(help.status.code(), Some(0));
    assert!(String::from_utf8_lossy(&help.stdout).contains("Usage: gonio"));
    let bad = python.gonio(at.path(), &["check", "nowhere"]);
    assert_eq!(bad.status.code(), Some(2));
    assert_eq!(String::from_utf8_lossy(&bad.stderr).trim_end(), format!("error: {}", NOWHERE));
    assert_eq!(python.gonio(at.path(), &["render"]).status.code(), Some(2));
}

const NOWHERE: &str = "nowhere: does not exist; name a capture's folder or its capture.toml";

/// Prints the text of each error, which must be an InputError.
const REFUSED: &str = "
import sys, gonio
capture = gonio.load(sys.argv[1])
def refused(work):
    try:
        work()
    except gonio.InputError as error:
        assert isinstance(error, gonio.GonioError)
        print(error)
    else:
        raise AssertionError('nothing was refused')
refused(lambda: gonio.load('nowhere'))
refused(lambda: capture['material.shell.gloss'])
refused(lambda: capture.__setitem__('material.shell.base_color', [1.0, 2.0]))
refused(lambda: capture.photos['99'])
refused(lambda: capture.render('99'))
refused(lambda: capture.render('00', samples=3))
refused(lambda: capture.fit(solver='newton'))
refused(lambda: capture.fit(free=['camera.width']))
refused(lambda: capture.export('maya', 'out'))
refused(lambda: list(gonio.sweep('sweep.toml')))
refused(lambda: gonio.evaluate('nowhere', 'results.csv'))
refused(lambda: gonio.Farm('not a url'))
assert 'material.shell.gloss' not in capture and 'material.shell.base_color' in capture
try:
    capture.render('00', farm='http://127.0.0.1:9')
except gonio.InputError:
    raise
except gonio.GonioError as error:
    print(error)
";

#[test]
fn errors_have_the_words_of_the_command() {
    let Some(python) = interpreter() else { return };
    let at = tempfile::tempdir().unwrap();
    let text = python.succeeds(at.path(), REFUSED, &[capture("none-201").to_str().unwrap()]);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], NOWHERE);
    let expected = [
        "nowhere",
        "material.shell.gloss",
        "base_color: is given 2 values; it is 3 numbers",
        "has no photo \"99\"; the photos are: 00, 01",
        "names \"99\", which is no photo",
        "invalid value '3' for '--samples <N>': write an even number",
        "invalid value 'newton' for '--solver <NAME>'",
        "camera.width",
        "maya: write one of: mitsuba, blender",
        "sweep.toml",
        "nowhere",
        "not a url",
        "127.0.0.1:9",
    ];
    assert_eq!(lines.len(), expected.len(), "{text}");
    for (line, words) in lines.iter().zip(expected) {
        assert!(line.contains(words), "no {words:?} in {line:?}");
    }
}

/// An export, as files and as a dictionary.
const EXPORT: &str = "
import os, sys, gonio
capture = gonio.load(sys.argv[1])
record = capture.export('gltf', 'out')
assert record['format'] == 'gltf' and os.path.exists('out/export.json'), record
scene = capture.to_mitsuba('03')
assert scene['type'] == 'scene' and 'sensor' in scene, scene
shape = next(part for part in scene.values() if isinstance(part, dict) and part.get('type') == 'ply')
assert os.path.exists(shape['filename']) and shape['to_world'].shape == (4, 4), shape
print(capture.to_mitsuba()['type'])
";

#[test]
fn exports_are_files_and_dictionaries() {
    let Some(python) = interpreter() else { return };
    let at = tempfile::tempdir().unwrap();
    assert_eq!(python.succeeds(at.path(), EXPORT, &[capture("none-201").to_str().unwrap()]).trim_end(), "scene");
}
