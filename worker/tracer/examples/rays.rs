//! Traces rays from a file on one thread, on demand: one half of `benches/embree.py`.
//!
//! `rays MESH` reads triangles (nine little-endian f32 each) from the file MESH, builds the hierarchy and prints
//! `{"triangles", "build_seconds"}`. Then each line `QUERY RAYS OUT` on standard input traces the rays of the file RAYS
//! (eight f32 each: origin, direction, t_min, t_max) by QUERY, `closest`, `packet` or `occluded`, writes one f32 per ray
//! to OUT (t, or -1 for a miss; 1 or 0), and prints `{"query", "rays", "seconds", "mrays_per_second"}`.

use std::collections::HashMap;
use std::io::BufRead;
use std::time::Instant;

use anyhow::{Context, Result, bail, ensure};
use glam::Vec3;
use gonio_tracer::bvh::{Bvh, Ray};

fn main() -> Result<()> {
    let mesh = std::env::args().nth(1).context("usage: rays MESH, then lines QUERY RAYS OUT on standard input")?;
    let triangles: Vec<[Vec3; 3]> =
        records::<9>(&mesh)?.iter().map(|r| [point(r, 0), point(r, 3), point(r, 6)]).collect();
    let start = Instant::now();
    let bvh = Bvh::build(&triangles);
    let seconds = start.elapsed().as_secs_f64();
    println!("{{\"triangles\": {}, \"build_seconds\": {seconds}}}", triangles.len());

    let mut files: HashMap<String, Vec<Ray>> = HashMap::new();
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let [query, file, out] = line.split_whitespace().collect::<Vec<_>>()[..] else {
            bail!("expected QUERY RAYS OUT, got {line:?}");
        };
        if !files.contains_key(file) {
            files.insert(file.to_owned(), read_rays(file)?);
        }
        let rays = &files[file];
        let (seconds, answers) = trace(&bvh, query, rays)?;
        std::fs::write(out, answers.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>())
            .with_context(|| format!("cannot write {out}"))?;
        println!(
            "{{\"query\": \"{query}\", \"rays\": {}, \"seconds\": {seconds}, \"mrays_per_second\": {}}}",
            rays.len(),
            rays.len() as f64 / seconds / 1e6
        );
    }
    Ok(())
}

/// The time of the queries alone, and their answers.
fn trace(bvh: &Bvh, query: &str, rays: &[Ray]) -> Result<(f64, Vec<f32>)> {
    let mut answers = vec![0.0; rays.len()];
    let mut hits = vec![None; rays.len()];
    let start = Instant::now();
    match query {
        "closest" => {
            for (answer, ray) in answers.iter_mut().zip(rays) {
                *answer = bvh.closest(ray).map_or(-1.0, |hit| hit.t);
            }
        }
        "packet" => bvh.closest_packet(rays, &mut hits),
        "occluded" => {
            for (answer, ray) in answers.iter_mut().zip(rays) {
                *answer = f32::from(u8::from(bvh.occluded(ray)));
            }
        }
        _ => bail!("no query {query:?}: closest, packet or occluded"),
    }
    let seconds = start.elapsed().as_secs_f64();
    if query == "packet" {
        answers = hits.iter().map(|hit| hit.map_or(-1.0, |hit| hit.t)).collect();
    }
    Ok((seconds, answers))
}

fn read_rays(file: &str) -> Result<Vec<Ray>> {
    let ray = |r: &[f32; 8]| Ray { origin: point(r, 0), direction: point(r, 3), t_min: r[6], t_max: r[7] };
    Ok(records::<8>(file)?.iter().map(ray).collect())
}

fn point(record: &[f32], at: usize) -> Vec3 {
    Vec3::new(record[at], record[at + 1], record[at + 2])
}

/// A file of `N` little-endian f32 per record.
fn records<const N: usize>(file: &str) -> Result<Vec<[f32; N]>> {
    let bytes = std::fs::read(file).with_context(|| format!("cannot read {file}"))?;
    ensure!(bytes.len() % (4 * N) == 0, "{file} does not hold records of {N} f32");
    let number = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    Ok(bytes.chunks_exact(4 * N).map(|record| std::array::from_fn(|i| number(&record[4 * i..4 * i + 4]))).collect())
}
