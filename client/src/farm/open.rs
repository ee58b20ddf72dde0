//! A capture that a farm has, ready to be evaluated.

use super::link::{Events, Link};
use super::{Farm, FarmError};
use futures::StreamExt;
use gonio_fit::evaluate::{Evaluate, EvaluateError, Watch};
use gonio_proto::convert::design::design_to_blob;
use gonio_proto::convert::event::{CANCELLED, Event, FilmCollector};
use gonio_proto::convert::manifest::Packed;
use gonio_proto::convert::request::{request_from_wire, request_to_wire};
use gonio_proto::{Digest, Key, WireError, wire};
use gonio_scene::design::Design;
use gonio_scene::files::Files;
use gonio_scene::{Evaluation, EvaluationRequest, Output, Progress};
use std::time::{Duration, Instant};
use tonic::{Code, Status};

/// How often the watcher is asked whether to go on.
const WATCH: Duration = Duration::from_millis(100);

/// How long a coordinator that cannot be reached is asked again: a standby takes over sooner.
const PATIENCE: Duration = Duration::from_secs(120);

/// The first and the longest pause between two such tries.
const PAUSES: (Duration, Duration) = (Duration::from_millis(250), Duration::from_secs(5));

/// How long a cancellation may take before the client ends without it.
const FAREWELL: Duration = Duration::from_secs(2);

/// A capture that a farm has. Its evaluations block the calling thread, which must not be a tokio runtime's; clones may
/// have others under way at the same time.
#[derive(Clone)]
pub struct OpenCapture {
    farm: Farm,
    digest: Digest,
    /// Its files, and the photos that cannot be compared with.
    packed: Packed,
    /// Of the pixels that statistics compare; absent, all.
    design: Option<Digest>,
}

impl OpenCapture {
    pub(super) fn new(farm: Farm, digest: Digest, packed: Packed) -> Self {
        Self { farm, digest, packed, design: None }
    }

    /// The same capture, of which statistics compare the pixels that `design` draws, each for as many as it stands for. What has
    /// films is compared as a whole.
    ///
    /// # Errors
    /// The farm cannot be reached.
    pub fn with_design(mut self, design: &Design) -> Result<Self, FarmError> {
        let blob = design_to_blob(design);
        let digest = Digest::of(&blob);
        self.farm.put(digest, blob)?;
        self.design = Some(digest);
        Ok(self)
    }

    /// The digest of the design, where there is one.
    #[must_use]
    pub fn design(&self) -> Option<Digest> {
        self.design
    }

    /// Another capture at the same farm.
    ///
    /// # Errors
    /// As [`Farm::open`].
    pub fn beside(&self, files: &dyn Files) -> Result<Self, FarmError> {
        self.farm.open(files)
    }

    /// The capture's digest: equal for equal files.
    #[must_use]
    pub fn digest(&self) -> Digest {
        self.digest
    }

    /// Each file that the capture names, photos and masks included, and the digest of what was sent under its name.
    pub fn files(&self) -> impl Iterator<Item = (&str, Digest)> {
        self.packed.manifest.files.iter().map(|(path, (digest, _))| (path.as_str(), *digest))
    }
}

impl Evaluate for OpenCapture {
    fn evaluate(&mut self, request: &EvaluationRequest, watch: &mut Watch<'_>) -> Result<Evaluation, EvaluateError> {
        if request.output.compares()
            && let Some(error) = request.photos.iter().find_map(|photo| self.packed.absent.get(photo))
        {
            return Err(EvaluateError::Refused(error.to_string()));
        }
        let mut message = request_to_wire(self.digest, request);
        if request.output == Output::Statistics {
            message.design_digest = self.design.map(|design| design.to_wire()).unwrap_or_default();
        }
        self.farm.requester.sign(&mut message);
        // What the coordinator would refuse is refused here: both check by the same code.
        request_from_wire(message.clone()).map_err(|error| EvaluateError::Refused(error.to_string()))?;
        let _span = tracing::info_span!("evaluate", photos = request.photos.len(), samples = request.samples).entered();
        let link = &self.farm.shared.link;
        if !link.is_remote() {
            return self.farm.block_on(async {
                let events = link.evaluate(message).await.map_err(|status| of_status(&status))?;
                follow(events, request, watch).await.map_err(|end| end.error)
            });
        }
        // The same key for every try: the coordinator, or the one that takes over, goes on where it is.
        let key = Key::fresh().map_err(|error| EvaluateError::Farm(error.to_string()))?.to_wire();
        message.key = key.clone();
        self.farm.block_on(async {
            let end = patiently(link, &message, request, watch).await;
            if matches!(end, Err(EvaluateError::Cancelled)) {
                // Otherwise it would go on for as long as somebody might come back for it.
                let cancel = link.cancel(wire::CancelRequest { key, client: String::new() });
                let _ = tokio::time::timeout(FAREWELL, cancel).await;
            }
            end
        })
    }
}

/// Why an evaluation was not followed to its end.
struct End {
    error: EvaluateError,
    /// Whether the coordinator has not said so itself: its stream broke.
    cut: bool,
}

impl From<EvaluateError> for End {
    fn from(error: EvaluateError) -> Self {
        Self { error, cut: false }
    }
}

/// Evaluates; a coordinator that went away is asked again, with pauses, for as long as [`PATIENCE`] since it last answered.
async fn patiently(
    link: &Link,
    message: &wire::EvaluationRequest,
    request: &EvaluationRequest,
    watch: &mut Watch<'_>,
) -> Result<Evaluation, EvaluateError> {
    let mut since = Instant::now();
    let mut pause = PAUSES.0;
    loop {
        let end = match link.evaluate(message.clone()).await {
            Ok(events) => {
                (since, pause) = (Instant::now(), PAUSES.0);
                match follow(events, request, watch).await {
                    Ok(evaluation) => return Ok(evaluation),
                    Err(end) => end,
                }
            }
            Err(status) => End { error: of_status(&status), cut: is_away(&status) },
        };
        if !end.cut || since.elapsed() > PATIENCE {
            return Err(end.error);
        }
        tracing::warn!(error = %end.error, ?pause, "the farm is asked again");
        let until = Instant::now() + pause;
        while Instant::now() < until {
            if watch(&Progress::default()).is_break() {
                return Err(EvaluateError::Cancelled);
            }
            tokio::time::sleep(WATCH.min(pause)).await;
        }
        pause = (2 * pause).min(PAUSES.1);
    }
}

/// Whether a call failed because nobody, or nobody who stays, was there to take it.
fn is_away(status: &Status) -> bool {
    matches!(status.code(), Code::Unavailable | Code::Unknown | Code::Internal | Code::Cancelled | Code::Aborted)
}

/// Collects an evaluation's events to its end. Returning early drops the stream, which cancels the evaluation.
async fn follow(mut events: Events, request: &EvaluationRequest, watch: &mut Watch<'_>) -> Result<Evaluation, End> {
    let mut evaluation = Evaluation::default();
    let mut films = FilmCollector::default();
    let mut progress = Progress::default();
    let mut ticks = tokio::time::interval(WATCH);
    ticks.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Skip);
    loop {
        let event = tokio::select! {
            event = events.next() => event,
            _ = ticks.tick() => {
                if watch(&progress).is_break() {
                    return Err(EvaluateError::Cancelled.into());
                }
                continue;
            }
        };
        let early = || End { error: EvaluateError::Farm("the answer ended early".to_owned()), cut: true };
        let event = event.ok_or_else(early)?;
        let event = event.map_err(|status| End { error: of_status(&status), cut: is_away(&status) })?;
        match Event::try_from(event).map_err(broken)? {
            Event::Accepted(number) => tracing::debug!(evaluation = number, "accepted"),
            Event::Progress(now) => progress = now,
            Event::Statistics(statistics) => evaluation.photos.push(statistics),
            Event::Film(chunk) => films.add(chunk).map_err(broken)?,
            // As if this client's own user had stopped it: what was done is kept.
            Event::Failed { text, .. } if text == CANCELLED => return Err(EvaluateError::Cancelled.into()),
            Event::Failed { request_at_fault: true, text } => return Err(EvaluateError::Refused(text).into()),
            Event::Failed { request_at_fault: false, text } => return Err(EvaluateError::Farm(text).into()),
            Event::Finished { primary_samples, invalid_samples } => {
                // The last word on progress, also for what took less than a tick; it is too late to break.
                let _ = watch(&progress);
                (evaluation.primary_samples, evaluation.invalid_samples) = (primary_samples, invalid_samples);
                evaluation.films = films.finish().map_err(broken)?;
                return Ok(check(evaluation, request)?);
            }
        }
    }
}

/// That the answer is one to this request.
fn check(evaluation: Evaluation, request: &EvaluationRequest) -> Result<Evaluation, EvaluateError> {
    let side = 1 + request.columns.len();
    let compared = if request.output.compares() { request.photos.as_slice() } else { &[] };
    let filmed = if request.output.has_films() { request.photos.as_slice() } else { &[] };
    let statistics_fit = evaluation.photos.iter().map(|s| s.photo).eq(compared.iter().copied())
        && evaluation.photos.iter().all(|s| s.gram.len() == side * side);
    if statistics_fit && evaluation.films.iter().map(|f| f.photo).eq(filmed.iter().copied()) {
        return Ok(evaluation);
    }
    Err(EvaluateError::Farm("the answer is not one to this request".to_owned()))
}

#[allow(clippy::needless_pass_by_value)] // Its place is in `map_err`.
fn broken(error: WireError) -> EvaluateError {
    EvaluateError::Farm(format!("the coordinator broke the protocol: {error}"))
}

fn of_status(status: &Status) -> EvaluateError {
    let text = gonio_worker::remote::text(status);
    match status.code() {
        Code::InvalidArgument | Code::NotFound | Code::FailedPrecondition | Code::ResourceExhausted => {
            EvaluateError::Refused(text)
        }
        _ => EvaluateError::Farm(text),
    }
}
