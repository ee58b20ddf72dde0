//! Whose turn it is: clients share the farm by weight, however many evaluations each has under way.
//!
//! Stride scheduling (Waldspurger and Weihl 1995): every client has a pass, the render time that it was given over its
//! weight; the one with the smallest pass is next. A client that comes, or has nothing waiting for a while, goes on at
//! the pass that is being served: it neither makes up for the time that it was away, nor pays for it.

use gonio_proto::convert::request::{Class, Requester};
use std::collections::{BTreeMap, BTreeSet};

/// Render time of one interactive client for each of one batch client where both want the farm: a fit beside a sweep goes
/// on at four fifths of its speed, and the sweep never stops.
pub const INTERACTIVE_WEIGHT: u64 = 4;

/// A client with evaluations under way.
#[derive(Debug)]
struct Client {
    requester: Requester,
    /// Render time granted over weight, microseconds.
    pass: u64,
    /// Evaluations under way.
    evaluations: usize,
    /// Those of them with tasks to be handed out; the oldest goes first, so that its memory is free soon.
    waiting: BTreeSet<u64>,
}

/// Whose evaluation is served next.
#[derive(Debug, Default)]
pub struct Shares {
    /// The last number given to a client.
    last_client: u64,
    /// By number. Added with a client's first evaluation, removed with its last.
    clients: BTreeMap<u64, Client>,
    /// The numbers of clients that have a name.
    named: BTreeMap<Requester, u64>,
    /// The client of every evaluation under way.
    of: BTreeMap<u64, u64>,
    /// Pass and number of clients with something waiting: interactive ones, then batch ones.
    turns: [BTreeSet<(u64, u64)>; 2],
    /// The pass that was served last; it only grows.
    now: u64,
}

impl Shares {
    /// Adds an evaluation of `requester`, of which nothing waits yet.
    pub fn enter(&mut self, evaluation: u64, requester: &Requester) {
        let known = self.named.get(requester).copied();
        let number = known.unwrap_or_else(|| {
            self.last_client += 1;
            let client =
                Client { requester: requester.clone(), pass: self.now, evaluations: 0, waiting: BTreeSet::new() };
            self.clients.insert(self.last_client, client);
            if !requester.client.is_empty() {
                self.named.insert(requester.clone(), self.last_client);
            }
            self.last_client
        });
        if let Some(client) = self.clients.get_mut(&number) {
            client.evaluations += 1;
        }
        self.of.insert(evaluation, number);
    }

    /// Forgets an evaluation.
    pub fn leave(&mut self, evaluation: u64) {
        self.set_waiting(evaluation, false);
        let Some(number) = self.of.remove(&evaluation) else { return };
        let Some(client) = self.clients.get_mut(&number) else { return };
        client.evaluations -= 1;
        if client.evaluations == 0 {
            self.named.remove(&client.requester);
            self.clients.remove(&number);
        }
    }

    /// Says whether an evaluation has tasks to be handed out.
    pub fn set_waiting(&mut self, evaluation: u64, waits: bool) {
        let Some(number) = self.of.get(&evaluation) else { return };
        let Some(client) = self.clients.get_mut(number) else { return };
        let turns = &mut self.turns[client.requester.class as usize];
        if waits {
            if client.waiting.is_empty() {
                client.pass = client.pass.max(self.now);
                turns.insert((client.pass, *number));
            }
            client.waiting.insert(evaluation);
        } else if client.waiting.remove(&evaluation) && client.waiting.is_empty() {
            turns.remove(&(client.pass, *number));
        }
    }

    /// The evaluation that is next among those of the classes that can be served.
    pub fn next(&mut self, serves: impl Fn(Class) -> bool) -> Option<(u64, Class)> {
        let of = |class: Class| self.turns[class as usize].first().filter(|_| serves(class)).map(|turn| (*turn, class));
        // Of equal passes the interactive one, which comes first.
        let turns = [of(Class::Interactive), of(Class::Batch)];
        let ((pass, number), class) = turns.into_iter().flatten().min_by_key(|((pass, _), _)| *pass)?;
        self.now = self.now.max(pass);
        let evaluation = self.clients.get(&number)?.waiting.first()?;
        Some((*evaluation, class))
    }

    /// Charges the client of an evaluation for render time, microseconds; below zero where less was needed than charged.
    pub fn charge(&mut self, evaluation: u64, micros: i64) {
        let Some(number) = self.of.get(&evaluation) else { return };
        let Some(client) = self.clients.get_mut(number) else { return };
        let weight = match client.requester.class {
            Class::Interactive => INTERACTIVE_WEIGHT,
            Class::Batch => 1,
        };
        let turns = &mut self.turns[client.requester.class as usize];
        let waits = turns.remove(&(client.pass, *number));
        client.pass = client.pass.saturating_add_signed(micros / weight.cast_signed());
        if waits {
            turns.insert((client.pass, *number));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn requester(client: &str, class: Class) -> Requester {
        Requester { client: client.into(), class }
    }

    /// Serves `turns` grants of 1 ms; how many each evaluation got.
    fn serve(shares: &mut Shares, turns: usize) -> BTreeMap<u64, usize> {
        let mut served = BTreeMap::new();
        for _ in 0..turns {
            let (evaluation, _) = shares.next(|_| true).unwrap();
            shares.charge(evaluation, 1000);
            *served.entry(evaluation).or_default() += 1;
        }
        served
    }

    #[test]
    fn clients_share_by_weight_and_not_by_evaluations() {
        let mut shares = Shares::default();
        // A sweep of a thousand evaluations, another sweep of one, and a fit.
        for evaluation in 0..1000 {
            shares.enter(evaluation, &requester("sweep", Class::Batch));
            shares.set_waiting(evaluation, true);
        }
        shares.enter(1000, &requester("other", Class::Batch));
        shares.enter(1001, &requester("fit", Class::Interactive));
        for evaluation in [1000, 1001] {
            shares.set_waiting(evaluation, true);
        }
        let served = serve(&mut shares, 600);
        assert_eq!(served[&1001], 400);
        assert_eq!((served[&0], served[&1000]), (100, 100), "the oldest of the sweep's, as often as the other sweep's");
    }

    #[test]
    fn nobody_saves_turns_up() {
        let mut shares = Shares::default();
        for (evaluation, client) in ["a", "b"].into_iter().enumerate() {
            shares.enter(evaluation as u64, &requester(client, Class::Batch));
        }
        shares.set_waiting(0, true);
        serve(&mut shares, 100);
        shares.set_waiting(1, true);
        let served = serve(&mut shares, 10);
        assert!(served[&0] >= 4, "{served:?}");
    }

    #[test]
    fn what_was_charged_too_much_is_given_back() {
        let mut shares = Shares::default();
        for (evaluation, client) in ["a", "b"].into_iter().enumerate() {
            shares.enter(evaluation as u64, &requester(client, Class::Batch));
            shares.set_waiting(evaluation as u64, true);
        }
        shares.charge(0, 1_000_000);
        assert_eq!(shares.next(|_| true), Some((1, Class::Batch)));
        shares.charge(0, -999_000);
        shares.charge(1, 2000);
        assert_eq!(shares.next(|_| true), Some((0, Class::Batch)));
    }

    #[test]
    fn only_classes_that_can_be_served_are_and_nobodys_names_are_forgotten() {
        let mut shares = Shares::default();
        shares.enter(1, &requester("", Class::Batch));
        shares.enter(2, &requester("", Class::Batch));
        shares.set_waiting(1, true);
        assert_eq!(shares.next(|class| class == Class::Interactive), None);
        assert_eq!(shares.next(|_| true), Some((1, Class::Batch)));
        shares.charge(1, 5000);
        shares.set_waiting(2, true);
        shares.set_waiting(1, false);
        assert_eq!(shares.next(|_| true), Some((2, Class::Batch)), "without a name, a client of its own");
        shares.leave(1);
        shares.leave(2);
        assert!(shares.next(|_| true).is_none() && shares.clients.is_empty() && shares.of.is_empty());
    }
}
