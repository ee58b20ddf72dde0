//! Where virtual cameras stand.

use crate::fixture::{capture, plan, plan_of};
use gonio_scene::capture::Photo;

const DOME: &str = "[[view]]\nname = \"dome\"\nkind = \"hemisphere\"\ntarget = [0.1, -0.2, 0.3]\n";

fn eye(photo: &Photo) -> [f64; 3] {
    [0, 1, 2].map(|i| photo.camera_to_world[i][3] - [0.1, -0.2, 0.3][i])
}

#[test]
fn a_hemisphere_is_covered_evenly_and_looks_inwards() {
    let plan = plan(&format!("{DOME}radius = 0.5\ncount = 1024\n"));
    let photos = &plan.capture.photos[2..];
    assert_eq!((photos.len(), plan.frames.len()), (1024, 1024));
    let mut octants = [0; 8];
    for photo in photos {
        let [x, y, z] = eye(photo);
        assert!(((x * x + y * y + z * z).sqrt() - 0.5).abs() < 1e-12 && z >= 0.0);
        // Forward is towards the target: minus the eye's direction.
        for (i, e) in [x, y, z].into_iter().enumerate() {
            assert!((photo.camera_to_world[i][2] + e / 0.5).abs() < 1e-12);
        }
        // Equal areas: quarters of azimuth by halves of height.
        octants[usize::from(x > 0.0) + 2 * usize::from(y > 0.0) + 4 * usize::from(z > 0.25)] += 1;
    }
    // Not 128 each by chance, but because the points are a net.
    assert_eq!(octants, [128; 8]);
}

#[test]
fn intervals_are_kept() {
    let lines =
        "radius = [0.2, 0.4]\nelevation = [0.3, 0.5]\nazimuth = [-1, 1]\nroll = [-0.1, 0.1]\ncount = 200\nseed = 9\n";
    let plan = plan(&format!("{DOME}{lines}"));
    let (mut nearest, mut farthest) = (f64::MAX, 0.0_f64);
    for photo in &plan.capture.photos[2..] {
        let [x, y, z] = eye(photo);
        let radius = (x * x + y * y + z * z).sqrt();
        (nearest, farthest) = (nearest.min(radius), farthest.max(radius));
        assert!((0.3 - 1e-9..=0.5 + 1e-9).contains(&(z / radius).asin()));
        assert!(libm::atan2(y, x).abs() <= 1.0 + 1e-9);
        // The image's rows are off level by the roll, seen along the view.
        assert!(photo.camera_to_world[2][0].abs() <= libm::sin(0.1) + 1e-9);
    }
    assert!((0.2..0.21).contains(&nearest) && (0.39..=0.4).contains(&farthest), "{nearest} {farthest}");
}

#[test]
fn views_have_names_keys_of_their_own_and_the_photos_before_them() {
    let lines = "[[view]]\nname = \"low\"\nkind = \"look-at\"\nposition = [1, 0, 0.1]\ntarget = [0, 0, 0]\nexposure = 3\nlights = []\n";
    assert!(plan_of(&capture(), lines, "").unwrap_err().to_string().contains("view[0].lights"));
    let lines = lines.replace("lights = []", "lights = [\"led\"]\n[view.camera]\nwidth = 48");
    let plan = plan(&format!("photos = [\"01\"]\n{DOME}radius = 1\ncount = 2\n{lines}"));
    let names: Vec<&str> = plan.frames.iter().map(|frame| plan.capture.photos[frame.photo].name()).collect();
    assert_eq!(names, ["01", "dome-000", "dome-001", "low"]);
    let low = &plan.capture.photos[4];
    assert_eq!((low.exposure, low.lights.as_deref()), (3.0, Some(&["led".to_owned()][..])));
    assert_eq!(plan.pixels(&plan.frames[3]), 48 * 24);
    // An extended capture is again a capture.
    let text = plan.capture.to_toml().unwrap();
    assert_eq!(gonio_scene::Capture::parse(&text).unwrap(), plan.capture);
}

#[test]
fn pairs_are_points_and_views_in_step() {
    let lines = "combine = \"pairs\"\n[[design]]\nkind = \"sobol\"\ncount = 4\naxes = [{ name = \"material.shell.ior\", from = 1.2, to = 1.8 }]\n";
    let plan = plan(&format!("{lines}{DOME}radius = 1\ncount = 4\n"));
    let pairs: Vec<(usize, usize)> = plan.frames.iter().map(|frame| (frame.point, frame.photo)).collect();
    assert_eq!(pairs, [(0, 2), (1, 3), (2, 4), (3, 5)]);
    let error = plan_of(&capture(), &format!("{lines}{DOME}radius = 1\ncount = 5\n"), "").unwrap_err();
    assert!(error.to_string().contains("sweep.toml: combine") && error.problem.contains("4 points and 5 views"));
}

#[test]
fn resolution_scales_every_camera() {
    let plan = plan("resolution = 0.25");
    let camera = plan.capture.camera_of(&plan.capture.photos[0]);
    assert_eq!((camera.width, camera.height, camera.fx, camera.cy), (8, 6, 12.0, 3.0));
}
