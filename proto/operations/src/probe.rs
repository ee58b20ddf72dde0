//! What a program answers to whoever asks how it is.

use crate::Families;

/// Well, or why not, in words for people.
pub type Verdict = Result<(), String>;

/// Asked by [`serve`](crate::serve), on its own thread: an answer must not wait for what may hang.
pub trait Probe: Send + Sync + 'static {
    /// Whether the program has come up. Once it has, it stays so.
    fn startup(&self) -> Verdict;

    /// Whether it takes work.
    fn ready(&self) -> Verdict;

    /// Whether it goes on: an error means that only a restart helps.
    fn live(&self) -> Verdict;

    /// What it has done and holds. Called where waiting for a lock is allowed.
    fn metrics(&self) -> Families;
}
