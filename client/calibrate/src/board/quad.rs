//! Dark quadrilaterals on a bright ground: what may be markers.

use super::refine::Gray;

/// Half the width of the window whose mean tells dark from bright, as parts of the longer side: from narrow gaps
/// between markers to markers that are large and out of focus.
const WINDOWS: [f64; 3] = [0.008, 0.02, 0.05];
/// How much darker than the mean of its window a pixel must be, gray levels: above noise (OpenCV's default, too).
const DARKER: f64 = 7.0;
/// The shortest side of a marker that can be read, pixels: eight cells of a pixel and a half.
const SHORTEST: f64 = 12.0;
/// The part of a quadrilateral that its dark hull must fill: a blurred corner is worth a few hundredths.
const FILLED: f64 = 0.85;

/// Corners on the screen clockwise, from any of them; pixel centres are whole numbers.
pub(super) type Quad = [[f64; 2]; 4];

/// Sums over rectangles from the upper left, one wider and higher than the image.
struct Sums {
    width: usize,
    data: Vec<u64>,
}

impl Sums {
    fn new(gray: &Gray<'_>) -> Self {
        let width = gray.width + 1;
        let mut data = vec![0; width * (gray.height + 1)];
        for y in 0..gray.height {
            let mut row = 0;
            for x in 0..gray.width {
                row += u64::from(gray.data[y * gray.width + x]);
                data[(y + 1) * width + x + 1] = data[y * width + x + 1] + row;
            }
        }
        Self { width, data }
    }

    fn mean(&self, [x0, y0, x1, y1]: [usize; 4]) -> f64 {
        let at = |x: usize, y: usize| self.data[y * self.width + x];
        let sum = at(x1, y1) + at(x0, y0) - at(x1, y0) - at(x0, y1);
        sum as f64 / ((x1 - x0) * (y1 - y0)) as f64
    }
}

/// Dark quadrilaterals, some of them more than once.
pub(super) fn quads(gray: &Gray<'_>) -> Vec<Quad> {
    if gray.width < 8 || gray.height < 8 {
        return Vec::new();
    }
    let sums = Sums::new(gray);
    let longer = gray.width.max(gray.height) as f64;
    WINDOWS.iter().flat_map(|part| within(gray, &sums, ((part * longer) as usize).max(3))).collect()
}

fn within(gray: &Gray<'_>, sums: &Sums, half: usize) -> Vec<Quad> {
    let (width, height) = (gray.width, gray.height);
    let mut dark = vec![false; width * height];
    for y in 0..height {
        for x in 0..width {
            let window =
                [x.saturating_sub(half), y.saturating_sub(half), (x + half + 1).min(width), (y + half + 1).min(height)];
            dark[y * width + x] = f64::from(gray.data[y * width + x]) + DARKER < sums.mean(window);
        }
    }
    let mut found = Vec::new();
    let mut stack = Vec::new();
    for start in 0..dark.len() {
        if !dark[start] {
            continue;
        }
        // Neighbours by their sides only: squares that touch at a corner stay two.
        let mut rows = std::collections::BTreeMap::<usize, [usize; 2]>::new();
        let mut whole = true;
        dark[start] = false;
        stack.push(start);
        while let Some(at) = stack.pop() {
            let (x, y) = (at % width, at / width);
            let row = rows.entry(y).or_insert([x, x]);
            *row = [row[0].min(x), row[1].max(x)];
            if x == 0 || y == 0 || x + 1 == width || y + 1 == height {
                whole = false;
                continue;
            }
            for next in [at - 1, at + 1, at - width, at + width] {
                if std::mem::take(&mut dark[next]) {
                    stack.push(next);
                }
            }
        }
        // What leaves the picture has corners that are none.
        if whole && rows.len() as f64 >= 0.5 * SHORTEST {
            found.extend(quad(&hull(&rows)));
        }
    }
    found
}

fn cross(o: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
}

/// The convex hull of pixels (their squares, not their centres), clockwise on the screen (Andrew 1979).
fn hull(rows: &std::collections::BTreeMap<usize, [usize; 2]>) -> Vec<[f64; 2]> {
    let corners = rows.iter().flat_map(|(&y, &[left, right])| {
        let (y, left, right) = (y as f64, left as f64 - 0.5, right as f64 + 0.5);
        [[left, y - 0.5], [left, y + 0.5], [right, y - 0.5], [right, y + 0.5]]
    });
    let mut points: Vec<[f64; 2]> = corners.collect();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let chain = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..]
                && cross(a, b, point) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut hull = chain(&mut points.iter().copied());
    hull.extend(chain(&mut points.iter().rev().copied()));
    hull
}

fn area(polygon: &[[f64; 2]]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    0.5 * polygon.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>()
}

/// Where the lines a b and c d meet, beyond b and beyond c.
fn beyond([a, b, c, d]: [[f64; 2]; 4]) -> Option<[f64; 2]> {
    let (u, v) = ([b[0] - a[0], b[1] - a[1]], [c[0] - d[0], c[1] - d[1]]);
    let size = u[0] * v[1] - u[1] * v[0];
    let s = ((c[0] - b[0]) * v[1] - (c[1] - b[1]) * v[0]) / size;
    let t = ((c[0] - b[0]) * u[1] - (c[1] - b[1]) * u[0]) / size;
    (s >= 0.0 && t >= 0.0 && s.is_finite()).then(|| [b[0] + s * u[0], b[1] + s * u[1]])
}

/// The quadrilateral about a hull, by leaving out the edge whose neighbours enclose least more, again and again.
fn quad(hull: &[[f64; 2]]) -> Option<Quad> {
    let mut polygon = hull.to_vec();
    let inner = area(hull);
    while polygon.len() > 4 {
        let n = polygon.len();
        let without = |i: usize| {
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| polygon[(i + k) % n]);
            let tip = beyond([a, b, c, d])?;
            Some((0.5 * cross(b, tip, c).abs(), i, tip))
        };
        let (_, i, tip) = (0..n).filter_map(without).min_by(|a, b| a.0.total_cmp(&b.0))?;
        polygon[(i + 1) % n] = tip;
        polygon.remove((i + 2) % n);
    }
    let quad: Quad = polygon.try_into().ok()?;
    let sides = (0..4).map(|k| (quad[(k + 1) % 4][0] - quad[k][0]).hypot(quad[(k + 1) % 4][1] - quad[k][1]));
    let convex = (0..4).all(|k| cross(quad[k], quad[(k + 1) % 4], quad[(k + 2) % 4]) > 0.0);
    (convex && sides.fold(f64::INFINITY, f64::min) >= SHORTEST && inner >= FILLED * area(&quad)).then_some(quad)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_square_is_found_and_a_disc_is_not() {
        let (width, height) = (120_usize, 100_usize);
        let value = |k: usize| {
            let (x, y) = ((k % width) as f64, (k / width) as f64);
            let (u, v) = (0.8 * (x - 40.0) + 0.6 * (y - 50.0), -0.6 * (x - 40.0) + 0.8 * (y - 50.0));
            let disc = (x - 90.0).hypot(y - 50.0) < 18.0;
            if u.abs().max(v.abs()) < 20.0 || disc { 30 } else { 220 }
        };
        let data: Vec<u8> = (0..width * height).map(value).collect();
        let found = quads(&Gray { width, height, data: &data });
        assert!(!found.is_empty());
        for quad in found {
            let middle = [0, 1].map(|k| quad.iter().map(|corner| corner[k]).sum::<f64>() / 4.0);
            assert!((middle[0] - 40.0).abs() < 1.5 && (middle[1] - 50.0).abs() < 1.5, "{quad:?}");
            assert!((area(&quad) - 1600.0).abs() < 200.0, "{quad:?}");
        }
    }
}
