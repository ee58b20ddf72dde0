use gonio_pose::bop::{Dataset, ModelsFolder};
use gonio_pose::errors::Shape;
use gonio_estimate::{Estimator, Settings};
use std::time::Instant;
fn main() {
    let path = std::env::args().nth(1).unwrap();
    let n: usize = std::env::args().nth(2).map_or(40, |s| s.parse().unwrap());
    let dataset = Dataset::open(path.as_ref(), None).unwrap();
    let models = dataset.models(ModelsFolder::Evaluation).unwrap();
    let (id, model) = models.iter().next().unwrap();
    let shape = Shape::new(model);
    let t = Instant::now();
    let estimator = Estimator::new(model);
    println!("object {id} prepared in {:?}", t.elapsed());
    let (mut hit, mut all) = (0, 0);
    for (scene, image, frame) in dataset.frames().take(n) {
        let pixels = dataset.colour(scene, image).unwrap();
        let t = Instant::now();
        let found = estimator.find(&pixels, &frame.camera, &Settings::default());
        let s = t.elapsed().as_secs_f64();
        let truth = frame.truths[0].pose;
        let errors: Vec<String> = found.iter().take(4).map(|f| format!("{:.3}({:.0}) dz {:+.3}", shape.mssd(&f.pose, &truth) / model.diameter, f.score, f.pose.translation.z/truth.translation.z-1.0)).collect();
        let e = found.first().map_or(9.0, |f| shape.mssd(&f.pose, &truth) / model.diameter);
        hit += usize::from(e < 0.1); all += 1;
        println!("{image:3} {s:.2}s {}", errors.join(" "));
    }
    println!("{hit}/{all}");
}
