//! Decides again upon stored diagnoses: made captures with a number of the file wrong or with nothing hidden, and captures of another
//! renderer. A change of the rules or of the policy shows here in seconds. The evidence is renewed by the examples
//! `confusion` and `causes`, which take hours.

#![allow(clippy::unwrap_used)] // a test fails by panicking

use gonio_diagnose::Policy;
use gonio_diagnose::decide::{Action, Decision, Verdict, next};
use gonio_tests::evidence::{Stored, library};

fn decided(name: &str, stored: &Stored) -> Decision {
    match next(&stored.evidence, &Policy::default()) {
        Action::Finish(decision) => *decision,
        lacking => panic!("{name}: the rules ask for what was not learnt: {lacking:?}; make it again"),
    }
}

/// Name, expected causes, named sets.
fn outcomes(kind: &str) -> Vec<(String, Vec<String>, Vec<Vec<String>>)> {
    let of_kind = library().into_iter().filter(|(name, _)| name.starts_with(kind));
    let outcome = |(name, stored): (String, Stored)| {
        let decision = decided(&name, &stored);
        let named = match decision.verdict {
            Verdict::Named => decision.course.additions.into_iter().map(|a| a.effects).collect(),
            Verdict::None | Verdict::Unexplained => Vec::new(),
        };
        println!("{name}: expected {:?}, named {named:?}", stored.expected);
        (name, stored.expected, named)
    };
    of_kind.map(outcome).collect()
}

fn has(named: &[Vec<String>], name: &str) -> bool {
    named.iter().any(|set| set.iter().any(|n| n == name))
}

#[test]
fn captures_of_another_renderer_keep_their_names() {
    let all = outcomes("rendered-");
    assert!(all.len() >= 3, "{} captures", all.len());
    for (name, expected, named) in all {
        assert_eq!(named.len(), expected.len(), "{name}: {named:?}");
        assert!(expected.iter().all(|e| has(&named, e)), "{name}: {named:?}");
    }
}

#[test]
fn suspects_are_named_first() {
    let all = outcomes("suspects-");
    let right =
        all.iter().filter(|(_, expected, named)| named.first().is_some_and(|set| set.contains(&expected[0]))).count();
    assert!(all.len() >= 8 && right * 20 >= all.len() * 18, "{right} of {}", all.len());
}

#[test]
fn nothing_is_named_where_nothing_is_hidden_or_photographs_are_noisy() {
    let all = [outcomes("nothing-"), outcomes("noise-")].concat();
    assert!(all.len() >= 3, "{} captures", all.len());
    for (name, _, named) in all {
        assert!(named.is_empty(), "{name}: {named:?}");
    }
}
