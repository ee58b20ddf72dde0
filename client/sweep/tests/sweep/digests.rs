//! What a frame is called: the same for the same content, another for another.

use crate::fixture::{CAPTURE, digests, plan, plan_of};
use gonio_scene::Capture;
use std::collections::BTreeSet;

const GRID: &str =
    "[[design]]\nkind = \"grid\"\naxes = [{ name = \"material.shell.roughness\", values = [0.1, 0.4] }]\n";

#[test]
fn frames_keep_their_names_when_a_sweep_grows() {
    let few = digests(&plan(GRID));
    let more = digests(&plan(&GRID.replace("[0.1, 0.4]", "[0.7, 0.1, 0.4]")));
    assert_eq!(few[..], more[2..]);
    // Views are photos behind the capture's own: they change no other's name.
    let dome = |count: u32| {
        let view = "[[view]]\nname = \"d\"\nkind = \"hemisphere\"\ntarget = [0, 0, 0]\nradius = 1\ncount = ";
        digests(&plan(&format!("photos = [\"00\", \"01\"]\n{view}{count}\n")))
    };
    let (three, five) = (dome(3), dome(5));
    assert_eq!(three[..], five[..5]);
    assert_eq!(digests(&plan("")), three[..2]);
}

#[test]
fn what_a_frame_does_not_follow_from_leaves_its_name() {
    let before = digests(&plan(GRID));
    let edits = [
        ("name = \"ball\"\n[camera]", "name = \"other\"\n[camera]"),
        ("parameters = [\"material.shell.roughness\"]", "parameters = []"),
        ("photos/00.exr", "elsewhere/00.png"),
        ("exposure = 2.0", "exposure = 2.0\nrole = \"held-out\""),
    ];
    for (from, to) in edits {
        assert!(CAPTURE.contains(from));
        let capture = Capture::parse(&CAPTURE.replace(from, to)).unwrap();
        assert_eq!(digests(&plan_of(&capture, GRID, "").unwrap()), before, "{to}");
    }
    // To set a number to what it is changes nothing either.
    assert_eq!(digests(&plan(""))[..], before[2..]);
}

#[test]
fn a_number_of_one_photo_is_nothing_to_another() {
    let plan = plan("[[design]]\nkind = \"grid\"\naxes = [{ name = \"photo.01.gain\", values = [1, 2, 3] }]\n");
    let digests = digests(&plan);
    assert_eq!(digests.len(), 6);
    assert!(digests[0] == digests[2] && digests[0] == digests[4], "three times the same photo 00");
    assert_eq!(digests.iter().collect::<BTreeSet<_>>().len(), 4);
}

#[test]
fn whatever_shapes_a_frame_changes_its_name() {
    let common = "photos = [\"00\"]\n";
    let mut seen = BTreeSet::new();
    for lines in [
        "",
        "samples = 66\n",
        "seed = 1\n",
        "resolution = 0.5\n",
        "outputs = [\"png\"]\n",
        "outputs = [\"png\"]\npng_stops = 1\n",
        "outputs = [\"exr\", \"buffers\"]\n",
    ] {
        assert!(seen.insert(digests(&plan(&format!("{common}{lines}")))), "{lines}");
    }
    for (from, to) in [
        ("width = 32", "width = 33"),
        ("roughness = 0.4", "roughness = 0.4000000000000001"),
        ("intensity = [0.2, 0.2, 0.2]", "intensity = [0.2, 0.2, 0.3]"),
        ("[0, 0, 1, -1]", "[0, 0, 1, -1.5]"),
    ] {
        let capture = Capture::parse(&CAPTURE.replace(from, to)).unwrap();
        assert!(seen.insert(digests(&plan_of(&capture, common, "").unwrap())), "{to}");
    }
    let plan = plan(common);
    for (mesh, version) in [("bb", "1.0"), ("aa", "1.1")] {
        assert!(seen.insert(plan.digests(&[("ball.ply".to_owned(), mesh.to_owned())], version).unwrap()));
    }
    // The same photo at another index has other random numbers.
    assert_ne!(digests(&plan_of(&Capture::parse(CAPTURE).unwrap(), "", "").unwrap())[1], digests(&plan)[0]);
}

#[test]
fn batches_hold_frames_of_one_point_within_their_bound() {
    let plan = plan(&format!(
        "samples = 2\n{GRID}[[view]]\nname = \"d\"\nkind = \"hemisphere\"\ntarget = [0, 0, 0]\nradius = 1\ncount = 5\n"
    ));
    let samples = 2 * 32 * 24;
    let wanted = [0, 1, 2, 4, 5, 6, 7, 9];
    let frames = |most: u64| plan.batches(&wanted, most).into_iter().map(|b| b.frames).collect::<Vec<_>>();
    assert_eq!(frames(u64::MAX), [vec![0, 1, 2, 4], vec![5, 6, 7, 9]]);
    assert_eq!(frames(3 * samples), [vec![0, 1, 2], vec![4], vec![5, 6, 7], vec![9]]);
    assert_eq!(frames(1), wanted.map(|frame| vec![frame]));
    assert!(frames(1).len() == wanted.len() && plan.batches(&[], 1).is_empty());
}
