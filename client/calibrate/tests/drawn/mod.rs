//! Photographs of boards, drawn: here and in the tests of the command line.

use super::markers::MARKERS;

/// Width and height of a photograph, pixels.
pub const SIZE: [u32; 2] = [640, 480];
/// Focal length along both axes, pixels; the principal point is the middle.
pub const FOCAL: f64 = 600.0;

/// Samples of a pixel each way: with three, an edge along the pixels is up to a sixth of one off.
const SAMPLES: u32 = 6;

/// Where the board's x and y axes point in camera coordinates, turned about the camera's x axis, then about its y axis, by
/// radians.
pub fn axes([about_x, about_y]: [f64; 2]) -> [[f64; 3]; 2] {
    let ((sx, cx), (sy, cy)) = (about_x.sin_cos(), about_y.sin_cos());
    [[cy, 0.0, -sy], [sy * sx, cx, cy * sx]]
}

/// The gray values of a board, whose point `middle` (metres) is in the middle of the picture, `distance` metres away. `board`
/// says how bright the board is at x and y, metres, from 0 to 1.
pub fn photograph(board: &dyn Fn(f64, f64) -> f64, middle: [f64; 2], turn: [f64; 2], distance: f64) -> Vec<u8> {
    let [along_x, along_y] = axes(turn);
    let origin: [f64; 3] =
        std::array::from_fn(|k| if k == 2 { distance } else { 0.0 } - middle[0] * along_x[k] - middle[1] * along_y[k]);
    let cross =
        |a: [f64; 3], b: [f64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let normal = cross(along_x, along_y);
    let [width, height] = SIZE;
    let sample = |x: f64, y: f64| {
        let ray = [(x - 0.5 * f64::from(width)) / FOCAL, (y - 0.5 * f64::from(height)) / FOCAL, 1.0];
        let depth = dot(origin, normal) / dot(ray, normal);
        let point = std::array::from_fn(|k| ray[k] * depth - origin[k]);
        board(dot(point, along_x), dot(point, along_y))
    };
    let pixel = |k: u32| {
        let (x, y) = (f64::from(k % width), f64::from(k / width));
        let part = |k: u32| (f64::from(k) + 0.5) / f64::from(SAMPLES);
        let all = (0..SAMPLES * SAMPLES).map(|s| sample(x + part(s % SAMPLES), y + part(s / SAMPLES)));
        (255.0 * all.sum::<f64>() / f64::from(SAMPLES * SAMPLES)).round() as u8
    };
    (0..width * height).map(pixel).collect()
}

/// How bright marker `index` is at `x` and `y`, in sides of the marker from its upper left.
pub fn marker(index: usize, x: f64, y: f64) -> f64 {
    let (column, row) = ((8.0 * x) as u64, (8.0 * y) as u64);
    let inner = (1..7).contains(&column) && (1..7).contains(&row);
    if inner && MARKERS[index] >> (35 - 6 * (row - 1) - (column - 1)) & 1 == 1 { 0.9 } else { 0.1 }
}

/// The board charuco:5x7:0.04:0.02:6X6_250.
pub fn charuco(x: f64, y: f64) -> f64 {
    let (u, v) = (x / 0.04, y / 0.04);
    if !(0.0..5.0).contains(&u) || !(0.0..7.0).contains(&v) {
        return 0.85;
    }
    let (i, j) = (u.floor(), v.floor());
    if (i + j) % 2.0 == 0.0 {
        return 0.1;
    }
    let (x, y) = (2.0 * (u - i - 0.25), 2.0 * (v - j - 0.25));
    if !(0.0..1.0).contains(&x) || !(0.0..1.0).contains(&y) {
        return 0.9;
    }
    marker((5 * j as usize + i as usize) / 2, x, y)
}
