//! What a fit promises whatever the data: held-out photos stay unseen, bounds hold, warnings name what they are about,
//! and bad input gives a clear error.

// Helpers of a test are its code too, which clippy's own exception does not see.
#![allow(clippy::unwrap_used)]

mod fake;

use fake::{Fake, Scene};
use gonio_fit::{Evaluate, EvaluateError, FitError, FitEvent, FitResult, Options, SolverName, Watch, fit};
use gonio_scene::{Evaluation, EvaluationRequest, Output, Stream};
use std::ops::ControlFlow;

fn scene() -> Scene {
    Scene { fit_photos: 3, held_out_photos: 2, pixels_per_photo: 100, ..Scene::default() }
}

fn try_fit(fake: &mut Fake, options: &Options) -> Result<FitResult, FitError> {
    let capture = fake.capture.clone();
    fit(&capture, fake, options, &mut |_| ControlFlow::Continue(()))
}

fn run(fake: &mut Fake, options: &Options) -> FitResult {
    try_fit(fake, options).unwrap()
}

#[test]
fn held_out_photos_are_asked_for_once_and_last() {
    for solver in SolverName::ALL {
        let mut fake = Fake::new(&scene());
        let result = run(&mut fake, &Options { solver, ..Options::default() });
        let (last, fitted) = fake.requests.split_last().unwrap();
        assert_eq!((last.photos.as_slice(), last.output, last.columns.len()), (&[3, 4][..], Output::Statistics, 0));
        assert!(fitted.iter().all(|r| r.photos == [0, 1, 2] && r.output == Output::Statistics), "{solver}");
        let score = result.held_out.unwrap();
        assert!(score.reduced_chi_square < 1.2 && score.psnr.unwrap() > 20.0, "{solver}: {score:?}");
    }
}

#[test]
fn every_request_has_the_same_seed_and_values_inside_the_bounds() {
    for solver in SolverName::ALL {
        let mut fake = Fake::new(&scene());
        let ranges = fake.capture.numbers();
        run(&mut fake, &Options { solver, seed: 9, ..Options::default() });
        for request in &fake.requests {
            assert_eq!(request.seed, Stream::Fit.seed(9));
            assert!(request.numbers.iter().all(|(n, v)| ranges[n].1.holds(*v)), "{solver}: {:?}", request.numbers);
        }
    }
}

#[test]
fn events_come_in_order_and_the_result_is_the_documented_json() {
    let mut fake = Fake::new(&scene());
    let capture = fake.capture.clone();
    let mut kinds = Vec::new();
    let result = fit(&capture, &mut fake, &Options::default(), &mut |event| {
        let json = serde_json::to_value(event).unwrap();
        kinds.push(json["event"].as_str().unwrap().to_owned());
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!((kinds.first().unwrap().as_str(), kinds.last().unwrap().as_str()), ("started", "finished"));
    assert_eq!(kinds.iter().filter(|k| *k == "iteration_done").count(), result.loss_curve.len());
    assert_eq!(kinds.iter().filter(|k| *k == "held_out").count(), 1);
    let json = serde_json::to_value(&result).unwrap();
    for key in ["capture", "converged", "iterations", "seconds", "primary_samples", "seed", "parameters", "warnings"] {
        assert!(!json[key].is_null(), "{key}");
    }
    assert_eq!(json["parameters"][0]["name"], "material.shell.base_color.r");
    assert_eq!(json["parameters"][0]["start"], 0.5);
    assert!(json["fit"]["rmse"].as_f64().unwrap() > 0.0 && json["held_out"]["psnr"].as_f64().unwrap() > 0.0);
    assert_eq!(json["correlations"].as_array().unwrap().len(), 6);
    // The photos' sums stay in memory.
    let written = FitResult { photos: Vec::new(), ..result.clone() };
    assert_eq!(serde_json::from_value::<FitResult>(json).unwrap(), written);
    let sampled: u64 = fake.requests.iter().map(|r| r.photos.len() as u64 * 100 * u64::from(r.samples)).sum();
    assert_eq!(result.primary_samples, sampled);
}

#[test]
fn the_fitted_capture_is_a_capture_with_the_estimates() {
    let mut fake = Fake::new(&scene());
    let result = run(&mut fake, &Options::default());
    let fitted = result.apply(&fake.capture).unwrap();
    let again = gonio_scene::Capture::parse(&fitted.to_toml().unwrap()).unwrap();
    assert_eq!(again.numbers()["material.shell.roughness"].0, result.parameters[3].value);
    let green = again.numbers()["light.led.intensity.g"].0;
    assert!((green / result.parameters[5].value - 1.0).abs() < 1e-12);
}

#[test]
fn an_inseparable_pair_is_named_with_its_remedy() {
    let free = vec!["material.shell.base_color", "photo.00.gain", "light.led.intensity"];
    let mut fake = Fake::new(&Scene { fit_photos: 1, free, ..scene() });
    let result = run(&mut fake, &Options::default());
    let warning = result.warnings.iter().find(|w| w.contains("hardly tell")).unwrap();
    assert!(warning.contains("photo.00.gain") && warning.contains("light.led.intensity"), "{warning}");
    assert!(warning.contains("fix one photo's gain"), "{warning}");
    assert!(!warning.contains("base_color"), "{warning}");
}

#[test]
fn a_separable_model_has_no_warnings() {
    let result = run(&mut Fake::new(&scene()), &Options::default());
    assert_eq!(result.warnings, Vec::<String>::new());
}

#[test]
fn a_parameter_without_effect_is_named_and_has_no_error() {
    let free = vec!["material.shell.roughness", "photo.04.gain"];
    let mut fake = Fake::new(&Scene { free, gray: vec![], start: [0.4, 1.52, 0.19], ..scene() });
    let result = run(&mut fake, &Options::default());
    assert!(
        result.warnings.iter().any(|w| w.starts_with("no fitted photo depends on photo.04.gain")),
        "{:?}",
        result.warnings
    );
    assert_eq!((result.parameters[1].value, result.parameters[1].standard_error), (1.0, None));
    assert!(result.parameters[0].standard_error.is_some());
}

#[test]
fn a_colour_brighter_than_white_stops_at_its_bound_with_a_warning() {
    let free = vec!["material.board.base_color"];
    let mut scene = Scene { free, gray: vec![], start: [0.36, 1.52, 0.1], ..scene() };
    scene.truth.push(("material.board.base_color.r".to_owned(), 0.9));
    let mut fake = Fake::new(&scene);
    let result = run(&mut fake, &Options::default());
    assert!(result.parameters.iter().all(|p| p.value < 1.0 && p.value > 0.995), "{:?}", result.parameters);
    assert!(
        result.warnings.iter().any(|w| w.contains("material.board.base_color.r is at its bound 1")),
        "{:?}",
        result.warnings
    );
}

#[test]
fn starts_on_the_bound_still_arrive() {
    let scene = Scene { start: [1.0, 1.01, 0.0], ..Scene::default() };
    let result = run(&mut Fake::new(&scene), &Options::default());
    for p in &result.parameters {
        let z = (p.value - scene.true_value(&p.name)) / p.standard_error.unwrap();
        assert!(z.abs() < 5.0, "{} = {} ({z})", p.name, p.value);
    }
    assert_eq!(result.parameters[3].start, 1.0);
}

#[test]
fn photos_that_disagree_widen_the_errors() {
    let mut fake = Fake::new(&Scene::default());
    let calm = run(&mut fake, &Options::default());
    fake.disturb(0.05);
    let result = run(&mut fake, &Options::default());
    assert!(
        result.warnings.iter().any(|w| w.contains("disagree about") && w.contains("light.led.intensity")),
        "{:?}",
        result.warnings
    );
    assert!(result.warnings.iter().any(|w| w.contains("does not explain")), "{:?}", result.warnings);
    assert!(result.parameters[5].standard_error.unwrap() > 2.0 * calm.parameters[5].standard_error.unwrap());
}

#[test]
fn nothing_free_is_a_score() {
    let mut fake = Fake::new(&Scene { free: vec![], gray: vec![], ..scene() });
    let result = run(&mut fake, &Options::default());
    assert!(result.converged && result.parameters.is_empty() && result.fit.reduced_chi_square > 1.0);
    assert_eq!(fake.requests.len(), 2);
    assert_eq!(result.correlations, Vec::<Vec<f64>>::new());
}

#[test]
fn black_photos_have_no_light() {
    let mut fake = Fake::new(&scene());
    fake.paint(0.0);
    let result = run(&mut fake, &Options { max_iterations: Some(30), ..Options::default() });
    let intensity = &result.parameters[5];
    assert!(intensity.value < 1e-2 && intensity.value > 0.0, "{intensity:?}");
    assert!(!result.warnings.is_empty());
}

#[test]
fn bad_input_gives_its_error() {
    let error = try_fit(&mut Fake::new(&Scene { fit_photos: 0, ..scene() }), &Options::default()).unwrap_err();
    assert!(matches!(error, FitError::NoFitPhotos), "{error}");
    let mut fake = Fake::new(&scene());
    fake.paint(f64::NAN);
    let error = try_fit(&mut fake, &Options::default()).unwrap_err().to_string();
    assert!(error.contains("photo 00") && error.contains("NaN") && error.contains("roughness = 0.4"), "{error}");
    let mut fake = Fake::new(&scene());
    fake.mask_everything();
    let error = try_fit(&mut fake, &Options::default()).unwrap_err();
    assert!(matches!(error, FitError::NoObservations), "{error}");
    let start = vec![("material.shell.ior".to_owned(), 0.5)];
    let error = try_fit(&mut Fake::new(&scene()), &Options { start, ..Options::default() }).unwrap_err().to_string();
    assert!(error.contains("material.shell.ior") && error.contains("1..=4"), "{error}");
}

/// Answers nonsense.
struct Broken(fn(Evaluation) -> Result<Evaluation, EvaluateError>, Fake);

impl Evaluate for Broken {
    fn evaluate(&mut self, request: &EvaluationRequest, watch: &mut Watch<'_>) -> Result<Evaluation, EvaluateError> {
        (self.0)(self.1.evaluate(request, watch)?)
    }
}

#[test]
fn a_broken_farm_gives_its_error() {
    let fails: [fn(Evaluation) -> Result<Evaluation, EvaluateError>; 3] = [
        |mut e| {
            e.photos.pop();
            Ok(e)
        },
        |mut e| {
            e.photos[0].gram.pop();
            Ok(e)
        },
        |_| Err(EvaluateError::Farm("no worker".to_owned())),
    ];
    for fail in fails {
        for solver in SolverName::ALL {
            let fake = Fake::new(&scene());
            let capture = fake.capture.clone();
            let options = Options { solver, ..Options::default() };
            let error =
                fit(&capture, &mut Broken(fail, fake), &options, &mut |_| ControlFlow::Continue(())).unwrap_err();
            assert!(matches!(error, FitError::Answer { .. } | FitError::Evaluate(EvaluateError::Farm(_))), "{error}");
        }
    }
}

#[test]
fn iterations_that_run_out_are_no_convergence() {
    for solver in SolverName::ALL {
        let result = run(&mut Fake::new(&scene()), &Options { solver, max_iterations: Some(2), ..Options::default() });
        assert!(!result.converged, "{solver}");
        assert!(result.iterations <= 3, "{solver}: {}", result.iterations);
        assert!(result.warnings[0].contains("iterations ran out"), "{solver}: {:?}", result.warnings);
    }
}

#[test]
fn a_started_event_lists_the_parameters() {
    let mut fake = Fake::new(&scene());
    let capture = fake.capture.clone();
    let mut started = None;
    let _ = fit(&capture, &mut fake, &Options::default(), &mut |event| {
        started.get_or_insert_with(|| event.clone());
        ControlFlow::Break(())
    });
    let Some(FitEvent::Started { parameters, start, fit_photos, held_out_photos, resumed, .. }) = started else {
        panic!("{started:?}")
    };
    assert_eq!((parameters.len(), start.len(), fit_photos, held_out_photos, resumed), (6, 6, 3, 2, false));
}
