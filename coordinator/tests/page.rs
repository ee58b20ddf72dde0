//! The farm's page: what it tells of jobs and workers, what it does, and to whom.

#![allow(clippy::unwrap_used)] // Its helpers may do what its tests may.

mod support;

use gonio_coordinator::Coordinator;
use gonio_coordinator::page::{FarmPage, Port};
use gonio_coordinator::security::{Guard, Roles, Tokens, fresh};
use gonio_page::{Refusal, Show, View, Visitor};
use gonio_proto::convert::event::CANCELLED;
use gonio_proto::wire::to_worker;
use serde_json::{Value, json};
use support::{Script, answer, bits, coordinator, request};

fn state(page: &FarmPage, view: &str) -> Value {
    Value::Object(page.state(&View::of(view)))
}

fn page(coordinator: &Coordinator) -> FarmPage {
    FarmPage::new(coordinator.clone(), Guard::new(None))
}

/// The one evaluation of a state.
fn only(state: &Value) -> (Value, Value) {
    let rows = state["jobs"]["rows"].as_object().unwrap();
    let (number, job) = rows.iter().next().unwrap();
    (json!({ "epoch": state["epoch"], "evaluation": number.parse::<u64>().unwrap() }), job.clone())
}

#[tokio::test(start_paused = true)]
async fn shows_who_works_on_what_and_how_far_it_is() {
    let (coordinator, digest) = coordinator().await;
    let page = page(&coordinator);
    let empty = state(&page, "");
    assert_eq!((&empty["jobs"]["total"], &empty["strength"]["workers"]), (&json!(0), &json!(0)));
    let mut request = request(digest, 2);
    request.client = "fit-7".to_owned();
    let events = coordinator.evaluate(request).unwrap();
    let mut worker = Script::join(&coordinator, 1).await;
    let task = worker.task().await;
    let now = state(&page, "");
    assert_eq!(now["queue"], json!({ "waiting": 3, "leased": 1 }));
    assert_eq!(now["strength"], json!({ "workers": 1, "silent": 0, "slots": 1, "busy": 1 }));
    let (_, job) = only(&now);
    assert_eq!(
        (&job["client"], &job["class"], &job["done"], &job["tasks"]),
        (&json!("fit-7"), &json!("interactive"), &json!(0), &json!(4))
    );
    worker.commits_slowly(&task).await;
    while coordinator.broker.counters().committed == 0 {
        tokio::task::yield_now().await;
    }
    let now = state(&page, "");
    assert_eq!(only(&now).1["done"], 1);
    let shown = now["workers"]["rows"].as_object().unwrap().values().next().unwrap().clone();
    assert_eq!((&shown["name"], &shown["state"], &shown["held"]), (&json!("script"), &json!("idle"), &json!(0)));
    assert!(shown["samples"].as_u64().unwrap() > 0 && shown["speed"].as_f64().unwrap() > 0.0, "{shown}");
    assert_eq!(now["speed"], shown["speed"]);
    // Of whom nobody of this name is, nothing is shown, but counted.
    let other = state(&page, "find_jobs=sweep&find_workers=script");
    assert_eq!(
        (&other["jobs"]["total"], &other["jobs"]["found"], &other["workers"]["found"]),
        (&json!(1), &json!(0), &json!(1))
    );
    drop(events);
}

#[tokio::test(start_paused = true)]
async fn cancels_and_knows_what_is_over() {
    let (coordinator, digest) = coordinator().await;
    let page = page(&coordinator);
    let events = coordinator.evaluate(request(digest, 1)).unwrap();
    tokio::task::yield_now().await;
    let (which, _) = only(&state(&page, ""));
    let earlier = json!({ "epoch": 1, "evaluation": which["evaluation"] });
    assert!(matches!(page.act("cancel", &earlier), Err(Refusal::Absent(_))), "another coordinator's number");
    assert!(matches!(page.act("cancel", &json!({ "evaluation": 1 })), Err(Refusal::Bad(_))));
    assert!(matches!(page.act("destroy", &which), Err(Refusal::Absent(_))));
    page.act("cancel", &which).unwrap();
    assert_eq!(answer(events).await.unwrap_err(), CANCELLED);
    tokio::task::yield_now().await;
    assert!(matches!(page.act("cancel", &which), Err(Refusal::Absent(_))));
}

#[tokio::test(start_paused = true)]
async fn another_try_takes_tasks_back_and_changes_no_bit() {
    let run = async |retry: bool| {
        let (coordinator, digest) = coordinator().await;
        let events = coordinator.evaluate(request(digest, 1)).unwrap();
        let mut stuck = Script::join(&coordinator, 2).await;
        let held = [stuck.task().await, stuck.task().await];
        let mut worker = stuck;
        let mut tasks = held.to_vec();
        if retry {
            let (which, _) = only(&state(&page(&coordinator), ""));
            let mut other = Script::join(&coordinator, 2).await;
            let said = page(&coordinator).act("retry", &which).unwrap();
            assert!(said.starts_with("2 tasks"), "{said}");
            for _ in 0..2 {
                assert!(matches!(worker.hears().await, to_worker::Message::Revoked(_)));
            }
            // Too late: whoever held them has nothing to commit.
            for task in &held {
                worker.commits(task).await;
            }
            tasks = vec![other.task().await, other.task().await];
            assert!(tasks.iter().all(|task| task.id.attempt == 1));
            while coordinator.broker.counters().refused < 2 {
                tokio::time::sleep(std::time::Duration::from_millis(1)).await;
            }
            worker = other;
        }
        for task in &tasks {
            worker.commits(task).await;
        }
        bits(&answer(events).await.unwrap())
    };
    assert_eq!(run(true).await, run(false).await);
}

#[tokio::test]
async fn tokens_say_who_sees_and_who_acts() {
    let (coordinator, _) = coordinator().await;
    let file = tempfile::NamedTempFile::new().unwrap();
    let mut lines = String::new();
    let [watch, submit, work] = ["watch", "submit", "work"].map(|role| {
        let roles: Roles = role.parse().unwrap();
        let (token, line) = fresh(role, roles).unwrap();
        lines += &line;
        format!("Bearer {token}")
    });
    std::fs::write(file.path(), lines).unwrap();
    let page = FarmPage::new(coordinator, Guard::new(Some(Tokens::read(file.path()).unwrap())));
    assert_eq!(page.admit(Some(&watch)), Ok(Visitor { may_act: false }));
    assert_eq!(page.admit(Some(&submit)), Ok(Visitor { may_act: true }));
    assert!(matches!(page.admit(Some(&work)), Err(Refusal::Forbidden(_))));
    for nobody in [None, Some(""), Some("Bearer gonio_wrong")] {
        assert!(matches!(page.admit(nobody), Err(Refusal::Unknown(_))), "{nobody:?}");
    }
}

#[tokio::test]
async fn an_address_that_is_taken_is_an_error_that_says_so() {
    let taken = Port::open("127.0.0.1:0".parse().unwrap(), None).await.unwrap();
    let address = taken.url().trim_start_matches("http://").trim_end_matches('/').parse().unwrap();
    let error = Port::open(address, None).await.unwrap_err().to_string();
    assert!(error.starts_with("--page 127.0.0.1:"), "{error}");
}
