//! Messages that break the protocol, each refused with an error that names the field, before anything of the size that
//! they announce is allocated. What a good message says must survive the wire unchanged.

#![allow(clippy::unwrap_used)] // Its helpers may do what its tests may.

use bytes::Bytes;
use gonio_proto::convert::digest::{Digest, digests_from_wire, digests_to_wire};
use gonio_proto::convert::request::{Class, Requester, request_from_wire, request_to_wire};
use gonio_proto::convert::task::{AttemptId, Hello, Setup, Task, tasks_from_wire};
use gonio_proto::{WireError, limits, wire};
use gonio_scene::capture::Range;
use gonio_scene::film::{PixelSet, Tile};
use gonio_scene::{EvaluationRequest, Output, Parameter, Term};
use proptest::prelude::*;
use prost::Message;

fn parameter(name: &str) -> Parameter {
    let terms =
        vec![Term { number: format!("{name}.r"), ratio: 0.5 }, Term { number: format!("{name}.g"), ratio: 1.5 }];
    Parameter { name: name.to_owned(), value: 0.25, range: Range::UNIT, terms, step: Some(0.125), channel: Some(2) }
}

fn request() -> EvaluationRequest {
    EvaluationRequest {
        numbers: vec![("material.a.roughness".into(), 0.3)],
        columns: vec![parameter("material.a.base_color")],
        photos: vec![3, 0, 7],
        samples: 16,
        difference_samples: 4,
        forward_samples: 4,
        seed: u64::MAX,
        output: Output::StatisticsAndFilms,
    }
}

fn digest() -> Digest {
    Digest::of(b"capture")
}

fn setup() -> Setup {
    let EvaluationRequest { numbers, columns, .. } = request();
    Setup {
        evaluation: 5,
        capture: digest(),
        numbers,
        columns,
        first_hits: false,
        class: Class::Batch,
        trace_parent: "00-1-2-01".to_owned(),
    }
}

fn task() -> Task {
    Task {
        id: AttemptId { epoch: 1, evaluation: 2, task: 3, attempt: 4 },
        photo: 9,
        tile: Tile { x: 64, y: 32, width: 10, height: 5 },
        pixels: PixelSet::from_flags((0..50).map(|i| i % 3 == 0)),
        samples: 64..100,
        difference_samples: 4,
        forward_samples: 4,
        seed: 11,
    }
}

/// Expects an error about `field`.
#[track_caller]
fn refused<T: std::fmt::Debug>(result: Result<T, WireError>, field: &str) {
    let error = result.expect_err("a broken message was taken");
    assert!(error.to_string().contains(field), "{error}");
}

#[test]
fn good_messages_survive() {
    let message = request_to_wire(digest(), &request());
    assert_eq!(request_from_wire(message).unwrap(), (digest(), request()));
    let requester = Requester { client: "fit".into(), class: Class::Batch };
    let mut signed = request_to_wire(digest(), &request());
    requester.sign(&mut signed);
    assert_eq!(Requester::of(&signed).unwrap(), requester);
    assert_eq!(request_from_wire(signed).unwrap(), (digest(), request()));
    assert_eq!(Setup::try_from(wire::Setup::from(&setup())).unwrap(), setup());
    assert_eq!(Task::try_from(wire::Task::from(&task())).unwrap(), task());
    let all = Task { pixels: PixelSet::from_flags([true; 50]), ..task() };
    assert!(wire::Task::from(&all).pixels.is_empty());
    assert_eq!(Task::try_from(wire::Task::from(&all)).unwrap(), all);
    let digests = [digest(), Digest::of(b"")];
    assert_eq!(digests_from_wire(&digests_to_wire(&digests)).unwrap(), digests);
}

#[test]
fn broken_requests_are_refused() {
    let broken = |change: &dyn Fn(&mut wire::EvaluationRequest), field: &str| {
        let mut message = request_to_wire(digest(), &request());
        change(&mut message);
        refused(request_from_wire(message), field);
    };
    broken(&|m| m.capture_digest = Bytes::new(), "capture_digest: has 0 bytes");
    broken(&|m| m.photos.clear(), "photos: is empty");
    broken(&|m| m.photos = vec![1, 2, 1], "photos: names photo 1 twice");
    broken(&|m| m.photos = (0..20_000).collect(), "photos: has 20000 entries");
    broken(&|m| m.samples = 0, "samples: is 0");
    broken(&|m| m.samples = 7, "samples: is 7");
    broken(&|m| m.samples = u32::MAX - 1, "samples: is 4294967294");
    broken(&|m| m.difference_samples = 18, "difference_samples: is 18, more than the 16 samples");
    broken(&|m| m.forward_samples = 18, "forward_samples: is 18, more than the 16 samples");
    broken(&|m| m.columns[0].step = Some(0.0), "has a step that is not above zero");
    broken(&|m| m.columns[0].step = Some(f64::NAN), "is NaN");
    broken(&|m| m.output = 17, "output: is 17");
    broken(&|m| m.numbers[0].name.clear(), "numbers: has 0 bytes");
    broken(&|m| m.numbers[0].name = "x".repeat(5000), "numbers: has 5000 bytes");
    broken(&|m| m.numbers[0].value = f64::INFINITY, "numbers.material.a.roughness: is inf");
    broken(&|m| m.numbers = vec![m.numbers[0].clone(); 10_001], "numbers: has 10001 entries");
    broken(&|m| m.columns = vec![m.columns[0].clone(); 257], "columns: has 257 entries");
    broken(&|m| m.columns[0].terms.clear(), "columns.material.a.base_color: moves no number");
    broken(&|m| m.columns[0].terms[1].ratio = f64::NAN, "columns.material.a.base_color: is NaN");
    broken(&|m| m.columns[0].minimum = 2.0, "has the bounds 2 to 1");
    broken(&|m| m.columns[0].value = f64::NEG_INFINITY, "is -inf");
    broken(&|m| m.columns[0].terms = vec![m.columns[0].terms[0].clone(); 1001], "has 1001 entries");
    let signed = |client: &str, class| {
        Requester::of(&wire::EvaluationRequest { client: client.to_owned(), class, ..Default::default() })
    };
    refused(signed(&"x".repeat(1025), 0), "client: has 1025 bytes");
    refused(signed("x", 2), "class: is 2");
}

#[test]
fn broken_tasks_and_hellos_are_refused() {
    let broken = |change: &dyn Fn(&mut wire::Task), field: &str| {
        let mut message = wire::Task::from(&task());
        change(&mut message);
        refused(Task::try_from(message), field);
    };
    broken(&|m| m.id = None, "Task.id: is absent");
    broken(&|m| m.difference_samples = 37, "difference_samples: is 37");
    broken(&|m| m.forward_samples = 37, "forward_samples: is 37");
    broken(&|m| m.tile = None, "Task.tile: is absent");
    let tile = |m: &mut wire::Task, change: &dyn Fn(&mut wire::Tile)| change(m.tile.as_mut().unwrap());
    broken(&|m| tile(m, &|t| t.width_pixels = 0), "Task.tile");
    broken(&|m| tile(m, &|t| t.height_pixels = u32::MAX), "Task.tile");
    broken(&|m| tile(m, &|t| t.x_pixels = u32::MAX), "Task.tile");
    broken(&|m| m.pixels = Bytes::from_static(&[1; 6]), "Task.pixels: has 6 bytes");
    broken(&|m| m.pixels = Bytes::from_static(&[0; 7]), "Task.pixels: wants no pixel");
    broken(&|m| m.end_sample = 3, "must ascend");
    broken(&|m| m.end_sample = u32::MAX, "must ascend");
    let tasks = |count| tasks_from_wire(wire::Tasks { tasks: vec![wire::Task::from(&task()); count] });
    assert_eq!(tasks(limits::TASKS_AT_ONCE).unwrap().len(), limits::TASKS_AT_ONCE);
    refused(tasks(0), "Tasks.tasks: is empty");
    refused(tasks(limits::TASKS_AT_ONCE + 1), "Tasks.tasks: has 65 entries");
    let hello =
        |slots, name: &str| wire::Hello { name: name.to_owned(), slots, version: "1".to_owned(), reserved_credits: 1 };
    refused(Hello::try_from(hello(0, "w")), "Hello.slots: is 0");
    refused(Hello::try_from(hello(5000, "w")), "Hello.slots: is 5000");
    refused(Hello::try_from(hello(1, "")), "Hello.name: has 0 bytes");
    refused(Setup::try_from(wire::Setup::default()), "Setup.capture_digest");
    refused(Setup::try_from(wire::Setup { class: 7, ..(&setup()).into() }), "Setup.class: is 7");
    let many = wire::BlobDigests { digests: vec![digest().to_wire(); limits::DIGESTS + 1] };
    refused(digests_from_wire(&many), "BlobDigests.digests: has 10001 entries");
}

#[test]
fn a_scene_is_named_by_what_it_depends_on() {
    let key = setup().scene_key();
    let trace_parent = String::new();
    let another = Setup { evaluation: 6, first_hits: true, class: Class::Interactive, trace_parent, ..setup() };
    assert_eq!(another.scene_key(), key);
    assert_ne!(Setup { numbers: vec![], ..setup() }.scene_key(), key);
    assert_ne!(Setup { columns: vec![], ..setup() }.scene_key(), key);
    assert_ne!(Setup { capture: Digest::of(b"another"), ..setup() }.scene_key(), key);
}

proptest! {
    /// Whatever bytes arrive, decoding and converting them ends in a value or an error.
    #[test]
    fn no_bytes_make_a_conversion_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        if let Ok(message) = wire::EvaluationRequest::decode(&*bytes) {
            let _ = request_from_wire(message);
        }
        if let Ok(message) = wire::Task::decode(&*bytes) {
            let _ = Task::try_from(message);
        }
        if let Ok(message) = wire::Setup::decode(&*bytes) {
            let _ = Setup::try_from(message);
        }
        let _ = gonio_proto::convert::manifest::Manifest::from_blob(bytes.into());
    }

    /// Nor do good messages with a few bytes changed.
    #[test]
    fn no_damage_makes_a_conversion_panic(damage in proptest::collection::vec((any::<u16>(), any::<u8>()), 1..6)) {
        let hurt = |mut bytes: Vec<u8>| {
            for (place, value) in &damage {
                let place = usize::from(*place) % bytes.len();
                bytes[place] = *value;
            }
            bytes
        };
        if let Ok(message) = wire::EvaluationRequest::decode(&*hurt(request_to_wire(digest(), &request()).encode_to_vec())) {
            let _ = request_from_wire(message);
        }
        if let Ok(message) = wire::Task::decode(&*hurt(wire::Task::from(&task()).encode_to_vec())) {
            let _ = Task::try_from(message);
        }
    }
}
