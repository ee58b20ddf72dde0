//! The page of a coordinator.

use super::run::look;
use gonio_coordinator::Coordinator;
use gonio_coordinator::jobs::Job;
use gonio_coordinator::page::{FarmPage, Port};
use gonio_coordinator::security::Guard;
use gonio_coordinator::store::Blobs;
use gonio_page::{Show, View};
use gonio_proto::Digest;
use gonio_proto::convert::request::Requester;
use gonio_proto::convert::task::Hello;
use gonio_tests::browser::{self, Browser};
use gonio_tests::captures;
use gonio_tests::cluster::{Cluster, PROGRAMS, Process};
use gonio_tests::pki::Authority;
use serde_json::json;
use std::net::TcpListener;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};
use tokio::sync::mpsc;

/// A port that was free just now, for a page that must come back at the same place.
fn address() -> String {
    TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string()
}

#[test]
fn the_page_survives_a_coordinator() {
    let Some(program) = browser::find() else { return };
    let page = address();
    let mut cluster = Cluster::start_with_more(&["--page", &page], 1);
    let mut browser = Browser::start(&program, 1280, 800);
    browser.open(&format!("http://{page}/"));
    browser.wait("document.querySelectorAll('#worker-rows tr').length === 1");
    assert_eq!(browser.value("document.body.dataset.status"), "live");
    let epoch = browser.value("document.getElementById('summary').textContent");
    assert!(epoch.as_str().unwrap().contains("up for"), "{epoch}");
    cluster.coordinator.signal("KILL");
    browser.wait("document.body.dataset.status === 'reconnecting'");
    assert_eq!(browser.value("document.getElementById('status').textContent"), "Reconnecting …");
    // Long enough for some tries in vain.
    std::thread::sleep(Duration::from_secs(3));
    let listen = cluster.url.strip_prefix("http://").unwrap().to_owned();
    let arguments = ["--listen", &listen, "--store", "memory://", "--page", &page];
    cluster.coordinator = Process::start("gonio-coordinator", &arguments);
    browser.wait("document.body.dataset.status === 'live'");
    // The worker has come back to the next coordinator, and the page shows that one's.
    browser.wait("document.querySelectorAll('#worker-rows tr').length === 1");
    // What the browser itself says of connections that were refused is no mistake of the page.
    let complaints = browser.complaints().into_iter().filter(|said| !said.contains("net::ERR_"));
    assert_eq!(complaints.collect::<Vec<_>>(), Vec::<String>::new());
}

/// A new token with a role, in a file of its own.
fn token(folder: &Path, role: &str) -> String {
    let grants = folder.join("grants");
    let arguments = ["token", role, "--roles", role, "--tokens", grants.to_str().unwrap()];
    let made = Command::new(PROGRAMS.join("gonio-coordinator")).args(arguments).output().unwrap();
    let token = String::from_utf8(made.stdout).unwrap().trim().to_owned();
    std::fs::write(folder.join(role), &token).unwrap();
    token
}

/// Types a token into the page.
fn show_token(browser: &mut Browser, token: &str) {
    let set = format!(
        "document.getElementById('token').value = '{token}'; document.querySelector('#token-form button').click()"
    );
    browser.value(&set);
}

#[test]
fn who_may_watch_sees_and_who_may_submit_cancels() {
    let Some(program) = browser::find() else { return };
    let top = tempfile::tempdir().unwrap();
    let [watch, submit, _work] = ["watch", "submit", "work"].map(|role| token(top.path(), role));
    let page = address();
    let (grants, work) = (top.path().join("grants"), top.path().join("work"));
    let mut cluster = Cluster::start_with_more(&["--page", &page, "--tokens", grants.to_str().unwrap()], 0);
    cluster.add_worker_with(&["--token", work.to_str().unwrap()]);
    let mut browser = Browser::start(&program, 1280, 800);
    browser.open(&format!("http://{page}/"));
    browser.wait("!document.getElementById('ask').hidden");
    show_token(&mut browser, "gonio_wrong");
    browser.wait("document.getElementById('refusal').textContent.includes('unknown here')");
    show_token(&mut browser, &watch);
    browser.wait("!document.getElementById('farm').hidden");
    let capture = captures().join("none-201");
    let (out, token_file) = (top.path().join("out"), top.path().join("submit"));
    // One evaluation that would take minutes: it is there whenever the page is clicked.
    let mut render = Process::start(
        "gonio",
        &[
            "render",
            capture.to_str().unwrap(),
            "--out",
            out.to_str().unwrap(),
            "--samples",
            "50000",
            "--farm",
            &cluster.url,
            "--token",
            token_file.to_str().unwrap(),
        ],
    );
    browser.wait("document.querySelector('#job-rows th')?.textContent.startsWith('render-')");
    assert_eq!(browser.value("document.querySelector('#job-rows button').hidden"), true);
    // Nor can it be done past the page.
    let ask = format!(
        "fetch('act/cancel', {{ method: 'POST', headers: {{ authorization: 'Bearer {watch}', 'x-gonio-page': '1' }}, body: '{{}}' }})\
         .then((answer) => answer.status)"
    );
    assert_eq!(browser.value(&ask), 403);
    browser.value("document.getElementById('forget').click()");
    browser.wait("!document.getElementById('ask').hidden");
    show_token(&mut browser, &submit);
    browser.wait("document.querySelector('#job-rows button:not([hidden])') !== null");
    browser.value("document.querySelector('#job-rows button[data-act=retry]').click()");
    browser.wait("document.getElementById('news').textContent.includes('handed out anew')");
    let begin = Instant::now();
    let status = loop {
        browser.value(
            "document.querySelector('#job-rows button[data-act=cancel]')?.click();\
             document.getElementById('sure').open && document.querySelector('#sure button[value=cancel]').click()",
        );
        if let Some(status) = render.wait_for(Duration::from_secs(1)) {
            break status;
        }
        assert!(begin.elapsed() < Duration::from_secs(60), "{}", browser.value("document.body.innerText"));
    };
    assert_eq!(status.code(), Some(130));
    browser.wait("document.querySelectorAll('#job-rows tr').length === 0");
    // The page's own question without a token, and this test's, are refused, which the browser notes.
    let complaints =
        browser.complaints().into_iter().filter(|said| !["401", "403", "404"].iter().any(|code| said.contains(code)));
    assert_eq!(complaints.collect::<Vec<_>>(), Vec::<String>::new());
}

#[test]
fn the_page_is_encrypted_as_the_farm_is() {
    let Some(program) = browser::find() else { return };
    let top = tempfile::tempdir().unwrap();
    let authority = Authority::new(top.path(), "authority");
    let server = authority.sign("server");
    token(top.path(), "watch");
    let page = address();
    let [cert, key, grants] =
        [server.cert, server.key, top.path().join("grants")].map(|p| p.to_str().unwrap().to_owned());
    let arguments = ["--page", &page, "--tls-cert", &cert, "--tls-key", &key, "--tokens", &grants];
    let _cluster = Cluster::start_with_more(&arguments, 0);
    // The test's authority is none of the browser's.
    let mut browser = Browser::start_with(&program, &["--ignore-certificate-errors"], 1280, 800);
    // By a name, too: whoever has a certificate need not fear one that points elsewhere.
    let port = page.rsplit_once(':').unwrap().1;
    browser.open(&format!("https://localhost:{port}/"));
    browser.wait("!document.getElementById('ask').hidden");
    assert_eq!(browser.value("location.protocol + window.isSecureContext"), "https:true");
    // Nobody is served in the clear.
    let mut plain = std::net::TcpStream::connect(&page).unwrap();
    std::io::Write::write_all(&mut plain, b"GET / HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n\r\n").unwrap();
    let mut answer = Vec::new();
    let _ = std::io::Read::read_to_end(&mut plain, &mut answer);
    assert!(!answer.starts_with(b"HTTP/"), "{}", String::from_utf8_lossy(&answer));
}

/// More than a coordinator takes at a time, so that the page is no bound.
const JOBS: u64 = 10_000;
const WORKERS: u32 = 1000;

/// A coordinator that seems to have much to do.
fn crowded() -> (Coordinator, mpsc::UnboundedReceiver<gonio_coordinator::broker::ToWorker>) {
    let coordinator = Coordinator::new(Blobs::in_memory(), Duration::from_secs(3600));
    let (outbound, hear) = mpsc::unbounded_channel();
    for worker in 0..WORKERS {
        let name = format!("worker-{worker:04}");
        let hello = Hello { name, slots: 8, version: gonio_proto::VERSION.to_owned(), reserved_credits: 0 };
        coordinator.broker.join(hello, outbound.clone());
    }
    (0..JOBS).for_each(|_| add(&coordinator));
    (coordinator, hear)
}

fn add(coordinator: &Coordinator) {
    let number = coordinator.broker.new_evaluation();
    let requester = Requester { client: format!("fit-{}-{number:x}", number % 40), ..Requester::default() };
    let digest = Digest::of(&number.to_le_bytes());
    coordinator.jobs.add(Job::new(None, digest, number, requester, digest)).unwrap();
}

#[test]
fn a_thousand_workers_and_ten_thousand_jobs_stay_usable() {
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build().unwrap();
    let (coordinator, _hear) = runtime.block_on(async { crowded() });
    let farm = FarmPage::new(coordinator.clone(), Guard::new(None));
    let view = View::of("jobs=9950,50&workers=950,50");
    let size = json!(farm.state(&view)).to_string().len();
    // The least of some, because others use this machine, too.
    let timed = |_| {
        let begin = Instant::now();
        farm.state(&view);
        begin.elapsed()
    };
    let state = (0..20).map(timed).min().unwrap();
    assert!(size < 64 << 10, "{size} bytes are sent for what is looked at");
    let Some(program) = browser::find() else { return };
    let url = runtime.block_on(async {
        let port = Port::open("127.0.0.1:0".parse().unwrap(), None).await.unwrap();
        let url = port.url();
        tokio::spawn(port.serve(coordinator.clone(), Guard::new(None)));
        url
    });
    // Jobs end and begin, so that the rows that are seen change with every update.
    let busy = coordinator.clone();
    runtime.spawn(async move {
        let mut ticks = tokio::time::interval(Duration::from_millis(20));
        let jobs = busy.jobs.all();
        for oldest in jobs {
            ticks.tick().await;
            busy.jobs.remove(&oldest);
            add(&busy);
        }
    });
    let mut browser = Browser::start(&program, 1280, 800);
    let noted = "new MutationObserver(() => { if (!window.firstRow && document.querySelector('#job-rows tr')) window.firstRow = performance.now(); })\
                 .observe(document, { childList: true, subtree: true })";
    browser.call("Page.addScriptToEvaluateOnNewDocument", &json!({ "source": noted }));
    browser.open(&url);
    browser.wait("document.querySelectorAll('#job-rows tr').length === 50 && document.querySelectorAll('#worker-rows tr').length === 50");
    let paint = browser.value("performance.getEntriesByName('first-contentful-paint')[0]?.startTime").as_f64().unwrap();
    let rows = browser.value("window.firstRow").as_f64().unwrap();
    let busy_seconds = |browser: &mut Browser| {
        let answer = browser.call("Performance.getMetrics", &json!({}));
        let metrics = answer["metrics"].as_array().unwrap().clone();
        metrics.iter().find(|m| m["name"] == "TaskDuration").unwrap()["value"].as_f64().unwrap()
    };
    browser.value("window.updates = 0; new MutationObserver(() => { window.updates += 1; }).observe(document.getElementById('job-rows'), { childList: true })");
    let before = busy_seconds(&mut browser);
    std::thread::sleep(Duration::from_secs(10));
    let updates = browser.value("window.updates").as_f64().unwrap();
    let each = (busy_seconds(&mut browser) - before) / updates.max(1.0);
    // The next page, and one name among ten thousand.
    browser.value("document.getElementById('jobs-on').click()");
    let turned = browser.wait("document.getElementById('jobs-range').textContent.startsWith('51')");
    browser.value("const box = document.getElementById('find-workers'); box.value = 'worker-0777'; box.dispatchEvent(new Event('input'))");
    let found = browser.wait("document.querySelectorAll('#worker-rows tr').length === 1");
    println!(
        "state {:.1} ms, {size} bytes; first paint {paint:.0} ms, first rows {rows:.0} ms; {updates} updates in 10 s, {:.1} ms of processor time each; \
         next page {:.0} ms, found {:.0} ms",
        state.as_secs_f64() * 1e3,
        1e3 * each,
        turned.as_secs_f64() * 1e3,
        found.as_secs_f64() * 1e3
    );
    // How long anything takes by the clock depends on who else uses the machine: the browser's own time does not.
    assert!((1.0..=21.0).contains(&updates), "{updates} updates in 10 s");
    assert!(each < 0.25, "an update takes {each} s of the browser's time");
    look(&mut browser, "farm");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}
