//! The rating page as an observer meets it: in a real browser, on a desk and on a phone, by keyboard.

use crate::devtools::{NAMES, Page, browser};
use crate::study::{serve_at, shown};
use serde_json::Value;
use std::time::Duration;

const LEVELS: [&str; 5] =
    ["definitely real", "probably real", "not sure", "probably synthetic", "definitely synthetic"];
const ENABLED: &str = "!document.getElementById('levels').disabled";

/// Answers with a key once the page takes answers, and waits for `after`.
fn rate(page: &mut Page, rating: u8, after: &str) {
    page.wait(ENABLED);
    // An answer that comes sooner after the image than an eye could is none.
    std::thread::sleep(Duration::from_millis(250));
    page.press(&rating.to_string(), u32::from(b'0' + rating), &rating.to_string(), false);
    page.wait(after);
}

fn progress(text: &str) -> String {
    format!("document.getElementById('progress').textContent === '{text}'")
}

#[test]
fn an_observer_rates_by_keyboard_on_a_phone_and_goes_on_after_the_server_was_killed() {
    let Some(browser) = browser() else {
        eprintln!("skipped: none of {NAMES:?} is on the PATH");
        return;
    };
    let top = tempfile::tempdir().unwrap();
    let images = shown(top.path(), 5);
    let (mut server, host) = serve_at(top.path(), &images, "127.0.0.1:0");
    let mut page = Page::open(&browser, 360, 640, true);
    page.go(&format!("http://{host}/"));
    assert!(page.accessible().contains(&("textbox".into(), "Your name or number".into())), "{:?}", page.accessible());
    // Without a mouse: to the field, a name, Enter.
    page.press("Tab", 9, "", false);
    assert_eq!(page.value("document.activeElement.id"), "observer");
    page.write("Ann");
    page.press("Enter", 13, "\r", false);
    page.wait(&progress("Image 1 of 5"));
    page.wait(ENABLED);

    let names = page.accessible();
    for (k, level) in LEVELS.iter().enumerate() {
        assert!(names.contains(&("button".into(), format!("{} {level}", k + 1))), "{level}: {names:?}");
    }
    for wanted in [("image", "Image 1 of 5"), ("group", "This image is …"), ("progressbar", "Image 1 of 5")] {
        assert!(names.contains(&(wanted.0.into(), wanted.1.into())), "{wanted:?}: {names:?}");
    }
    // Nothing of it is wider than the phone, all of it is on one screen, every button is as high as a finger wants.
    assert_eq!(page.value("document.documentElement.scrollWidth <= innerWidth"), true);
    let low = page.value(
        "Math.max(...[...document.querySelectorAll('#levels button')].map(b => b.getBoundingClientRect().bottom))",
    );
    assert!(low.as_f64().unwrap() <= 640.0, "the last button ends at {low}");
    let least = page.value(
        "Math.min(...[...document.querySelectorAll('#levels button')].map(b => b.getBoundingClientRect().height))",
    );
    assert!(least.as_f64().unwrap() >= 44.0, "{least}");

    // A key that is held down and one that means nothing rate nothing.
    std::thread::sleep(Duration::from_millis(250));
    page.press("5", u32::from(b'5'), "5", true);
    page.press("6", u32::from(b'6'), "6", false);
    rate(&mut page, 1, &progress("Image 2 of 5"));
    rate(&mut page, 2, &progress("Image 3 of 5"));
    server.kill().unwrap();
    server.wait().unwrap();
    rate(&mut page, 3, "document.getElementById('problem').textContent.startsWith('The server does not answer')");
    let (mut server, same) = serve_at(top.path(), &images, &host);
    assert_eq!(same, host);
    rate(&mut page, 3, &progress("Image 4 of 5"));
    assert_eq!(page.value("document.getElementById('problem').textContent"), "");
    // The page is closed and opened again.
    page.go("about:blank");
    page.go(&format!("http://{host}/"));
    page.wait(&progress("Image 4 of 5"));
    rate(&mut page, 4, &progress("Image 5 of 5"));
    rate(&mut page, 5, "!document.getElementById('done').hidden");
    assert_eq!(page.value("document.activeElement.id"), "thanks");
    // The dead server is all that there was to complain of.
    page.complaints.retain(|text| !text.contains("ERR_CONNECTION_REFUSED") && !text.contains("favicon"));
    assert_eq!(page.complaints, Vec::<String>::new());
    server.kill().unwrap();
    server.wait().unwrap();

    let table = std::fs::read_to_string(top.path().join("answers.csv")).unwrap();
    let ratings: Vec<&str> = table.lines().skip(1).filter_map(|line| line.rsplit(',').next()).collect();
    assert_eq!(ratings, ["1", "2", "3", "4", "5"], "{table}");
}

#[test]
fn the_page_fits_a_desk_and_takes_clicks() {
    let Some(browser) = browser() else {
        eprintln!("skipped: none of {NAMES:?} is on the PATH");
        return;
    };
    let top = tempfile::tempdir().unwrap();
    let (mut server, host) = serve_at(top.path(), &shown(top.path(), 2), "127.0.0.1:0");
    let mut page = Page::open(&browser, 1280, 800, false);
    page.go(&format!("http://{host}/"));
    page.value("document.getElementById('observer').focus()");
    page.write("Bob");
    page.press("Enter", 13, "\r", false);
    page.wait(&progress("Image 1 of 2"));
    page.wait(ENABLED);
    // Five buttons side by side, and none hidden.
    let tops = page
        .value("[...document.querySelectorAll('#levels button')].map(b => Math.round(b.getBoundingClientRect().top))");
    let tops = tops.as_array().unwrap();
    assert!(tops.len() == 5 && tops.iter().all(|top| *top == tops[0]), "{tops:?}");
    assert_eq!(page.value("document.documentElement.scrollWidth <= innerWidth"), Value::Bool(true));
    std::thread::sleep(Duration::from_millis(250));
    page.value("document.querySelector('[data-rating=\"4\"]').click()");
    page.wait(&progress("Image 2 of 2"));
    server.kill().unwrap();
    server.wait().unwrap();
    let table = std::fs::read_to_string(top.path().join("answers.csv")).unwrap();
    assert!(table.lines().count() == 2 && table.trim_end().ends_with(",4"), "{table}");
}
