//! `gonio dprime`.

use crate::fixture::{json, refused, succeeds};

const HEAD: &str = "observer,image,truth,rating\n";

#[test]
fn answers_become_a_sensitivity_and_bad_tables_are_refused_by_line_and_column() {
    let top = tempfile::tempdir().unwrap();
    let at = top.path();
    let write = |text: &str| std::fs::write(at.join("r.csv"), text).unwrap();
    let mut table = HEAD.to_owned();
    for observer in ["Ann", "Bob", "Cid"] {
        for k in 0..20 {
            // Four of five images are told rightly, with all five levels in use.
            let (truth, right) = if k % 2 == 0 { ("real", 1 + k / 2 % 2) } else { ("synthetic", 5 - k / 2 % 2) };
            let rating = if k % 5 == 4 { 6 - right } else { right };
            table += &format!("{observer},{k}.png,{truth},{rating}\n");
        }
    }
    write(&table);
    let result = json(&succeeds(at, &["dprime", "r.csv", "--json", "--plot", "roc.svg", "--resamples", "200"]));
    // z(8.5 / 11) - z(2.5 / 11): the log-linear correction of eight hits and two false alarms in ten.
    let found = result["d_prime"]["value"].as_f64().unwrap();
    assert!((found - 1.4957).abs() < 1e-3, "{result}");
    assert!(std::fs::read_to_string(at.join("roc.svg")).unwrap().contains("<svg"));

    refused(at, &["dprime", "none.csv"], &["none.csv: cannot be read", "observer,image,truth,rating"]);
    for (text, says) in [
        ("", "r.csv: observer: is not among the columns"),
        ("observer,image,rating\na,x,3\n", "r.csv: truth: is not among the columns (observer,image,rating)"),
        (
            &format!("{HEAD}a,x,real,3\na,y,synthetic,6\n"),
            "r.csv: line 3: rating: is \"6\"; write a whole number from 1",
        ),
        (&format!("{HEAD}a,x,real,2.5\n"), "r.csv: line 2: rating: is \"2.5\""),
        (&format!("{HEAD}a,x,fake,3\n"), "r.csv: line 2: truth: is \"fake\"; write real or synthetic"),
        (&format!("{HEAD},x,real,3\n"), "r.csv: line 2: observer: is empty; write a name"),
        (&format!("{HEAD}a,x,real\n"), "r.csv: is no table"),
        (&format!("{HEAD}a,x,real,3\na,x,synthetic,3\n"), "r.csv: truth: is both real and synthetic"),
        (&format!("{HEAD}a,x,real,3\na,y,real,1\n"), "r.csv: "),
        (HEAD, "r.csv: "),
    ] {
        write(text);
        refused(at, &["dprime", "r.csv"], &[says]);
    }
    std::fs::write(at.join("r.csv"), [0xff, 0xfe, b'a']).unwrap();
    refused(at, &["dprime", "r.csv"], &["r.csv: cannot be read"]);
    write(&table);
    refused(at, &["dprime", "r.csv", "--criterion", "1"], &["--criterion", "2..=5"]);
    refused(at, &["dprime", "r.csv", "--resamples", "3"], &["--resamples"]);
}
