//! Cancelling and resuming: what is done is kept, and a resumed fit ends with the same bits.

// Helpers of a test are its code too, which clippy's own exception does not see.
#![allow(clippy::unwrap_used)]

mod fake;

use fake::{Fake, Scene};
use gonio_fit::{Checkpoint, FitError, FitEvent, FitResult, Options, SolverName, fit};
use std::ops::ControlFlow;

fn scene() -> Scene {
    Scene { fit_photos: 3, held_out_photos: 1, pixels_per_photo: 80, ..Scene::default() }
}

fn run(fake: &mut Fake, options: &Options) -> Result<FitResult, FitError> {
    let capture = fake.capture.clone();
    fit(&capture, fake, options, &mut |_| ControlFlow::Continue(()))
}

#[test]
fn a_resumed_fit_ends_as_an_uninterrupted_one() {
    for solver in SolverName::ALL {
        let mut whole = Fake::new(&scene());
        let expected = run(&mut whole, &Options { solver, ..Options::default() }).unwrap();
        for at in [1, 3, whole.requests.len() - 2] {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("fit.checkpoint");
            let options = Options { solver, checkpoint: Some(path.clone()), ..Options::default() };
            let mut first = Fake::new(&scene());
            first.cancel_after = Some(at);
            let stopped = run(&mut first, &options).unwrap();
            assert!(!stopped.converged && stopped.held_out.is_none());
            assert!(stopped.warnings[0].starts_with("cancelled"));
            let mut second = Fake::new(&scene());
            let resume = Some(Checkpoint::read(&path).unwrap());
            let result = run(&mut second, &Options { resume, ..options }).unwrap();
            assert_eq!(FitResult { seconds: expected.seconds, ..result }, expected, "{solver} cut at {at}");
            assert_eq!(second.requests.len() + at, whole.requests.len(), "{solver} cut at {at}");
        }
    }
}

#[test]
fn an_observer_that_breaks_keeps_the_last_point() {
    let mut fake = Fake::new(&scene());
    let capture = fake.capture.clone();
    let mut last = Vec::new();
    let result = fit(&capture, &mut fake, &Options::default(), &mut |event| {
        if let FitEvent::IterationDone(iteration) = event {
            last.clone_from(&iteration.parameters);
            if iteration.iteration == 3 {
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(())
    })
    .unwrap();
    assert!(!result.converged);
    assert_eq!(result.iterations, 3);
    assert_eq!(result.parameters.iter().map(|p| p.value).collect::<Vec<_>>(), last);
    assert!(result.parameters.iter().all(|p| p.standard_error.is_some()));
}

#[test]
fn a_fit_cancelled_before_it_knows_anything_says_so() {
    let mut fake = Fake::new(&scene());
    fake.cancel_after = Some(0);
    assert!(matches!(run(&mut fake, &Options::default()), Err(FitError::Cancelled)));
}

#[test]
fn a_checkpoint_of_another_fit_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("c");
    run(&mut Fake::new(&scene()), &Options { checkpoint: Some(path.clone()), ..Options::default() }).unwrap();
    let resume = Some(Checkpoint::read(&path).unwrap());
    let error = run(&mut Fake::new(&scene()), &Options { resume, seed: 5, ..Options::default() }).unwrap_err();
    assert!(error.to_string().contains("its seed differs"), "{error}");
}
