//! What the page of a command shows, as its thread writes and the server reads it.

use crate::interrupt::Interrupt;
use crate::output::tell_error;
use crate::progress::count;
use crate::report::Panel;
use bytes::Bytes;
use gonio_page::{Refusal, Show, View, Visitor};
use gonio_scene::Progress;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Instant, SystemTime, UNIX_EPOCH};

/// The names of a photo's pictures, in the order of a panel's.
const KINDS: [&str; 3] = ["photo", "render", "residual"];

/// The state of the page.
pub(super) struct Board {
    interrupt: Interrupt,
    inner: Mutex<Inner>,
}

struct Inner {
    state: Map<String, Value>,
    /// PNGs by name; of each, the newest alone.
    pictures: BTreeMap<String, Bytes>,
    /// Counts whatever has a version.
    version: u64,
    /// When the evaluation under way began, and under which label.
    evaluation: Option<(Instant, String)>,
}

impl Board {
    pub fn new(what: &str, capture: &str, interrupt: Interrupt) -> Self {
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs();
        let mut state = Map::new();
        state.insert("title".to_owned(), what.into());
        state.insert("capture".to_owned(), capture.into());
        state.insert("started".to_owned(), since.into());
        let inner = Inner { state, pictures: BTreeMap::new(), version: 0, evaluation: None };
        Self { interrupt, inner: Mutex::new(inner) }
    }

    fn inner(&self) -> MutexGuard<'_, Inner> {
        // What is shown is whole after every statement.
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sets a member of the state.
    pub fn set(&self, key: &str, value: impl Into<Value>) {
        self.inner().state.insert(key.to_owned(), value.into());
    }

    /// Removes members of the state.
    pub fn clear(&self, keys: &[&str]) {
        let mut inner = self.inner();
        for key in keys {
            inner.state.remove(*key);
        }
    }

    /// Sets a member of a member, which becomes an object if need be.
    pub fn put(&self, key: &str, name: &str, value: Value) {
        let mut inner = self.inner();
        if let Value::Object(members) = inner.state.entry(key.to_owned()).or_insert_with(|| json!({})) {
            members.insert(name.to_owned(), value);
        }
    }

    /// Sets a member of a member of a member that is there.
    pub fn amend(&self, key: &str, name: &str, member: &str, value: Value) {
        if let Some(Value::Object(members)) = self.inner().state.get_mut(key).and_then(|m| m.get_mut(name)) {
            members.insert(member.to_owned(), value);
        }
    }

    /// An evaluation under way, under the `label` of what it is for.
    pub fn advance(&self, label: &str, progress: &Progress) {
        let mut inner = self.inner();
        let ended = progress.tasks > 0 && progress.tasks_done >= progress.tasks;
        let known = inner.evaluation.take().filter(|(_, known)| known == label);
        let (begun, label) = known.unwrap_or_else(|| (Instant::now(), label.to_owned()));
        let seconds = begun.elapsed().as_secs_f64();
        let rate = if seconds > 0.0 { count(progress.primary_samples) / seconds } else { 0.0 };
        let shown = json!({
            "label": label, "done": progress.tasks_done, "total": progress.tasks, "rate": rate, "workers": progress.workers,
        });
        inner.state.insert("progress".to_owned(), shown);
        inner.evaluation = (!ended).then_some((begun, label));
    }

    /// Shows a photo's panel, the one with index `photo`; after which iteration, unless it is the last word.
    pub fn panel(&self, photo: usize, panel: &Panel, iteration: Option<u32>) {
        let mut inner = self.inner();
        inner.version += 1;
        let version = inner.version;
        for (kind, png) in KINDS.iter().zip(panel.pngs()) {
            inner.pictures.insert(format!("{photo}-{kind}"), png.clone());
        }
        let shown = json!({
            "name": panel.name, "held_out": panel.held_out, "version": version, "iteration": iteration,
            "chi_square": panel.reduced_chi_square, "rmse": panel.rmse,
        });
        drop(inner);
        self.put("pictures", &photo.to_string(), shown);
    }

    /// Shows another picture, and what is said of it under its name.
    pub fn picture(&self, name: &str, png: Bytes, mut said: Map<String, Value>) {
        let mut inner = self.inner();
        inner.version += 1;
        said.insert("version".to_owned(), inner.version.into());
        inner.pictures.insert(name.to_owned(), png);
        inner.state.insert(name.to_owned(), said.into());
    }

    /// Nothing changes any more.
    pub fn end(&self, how: &str, text: &str) {
        self.set("ended", json!({ "how": how, "text": text }));
    }
}

impl Show for Board {
    /// Whoever can reach it: it listens to this machine alone.
    fn admit(&self, _: Option<&str>) -> Result<Visitor, Refusal> {
        Ok(Visitor { may_act: true })
    }

    fn state(&self, _: &View) -> Map<String, Value> {
        let mut state = self.inner().state.clone();
        state.insert("stopping".to_owned(), self.interrupt.is_asked().into());
        state
    }

    fn is_over(&self) -> bool {
        self.inner().state.contains_key("ended")
    }

    /// By `NAME-VERSION`: an older version is not kept, and the newest sent instead.
    fn picture(&self, name: &str) -> Option<Bytes> {
        let (name, _version) = name.rsplit_once('-')?;
        self.inner().pictures.get(name).cloned()
    }

    fn act(&self, action: &str, _: &Value) -> Result<String, Refusal> {
        if action != "stop" {
            return Err(Refusal::Absent(format!("{action:?} is nothing that this page does")));
        }
        if self.is_over() {
            return Err(Refusal::Absent("it has ended already".to_owned()));
        }
        tell_error("stopping, as the page asks; Ctrl-C twice to kill");
        self.interrupt.ask();
        Ok("Stopping.".to_owned())
    }
}
