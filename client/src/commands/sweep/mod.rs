//! `gonio sweep`: many frames, one table.
//!
//! A frame is called by the digest of what it is made from, and its files lie below that name: whoever runs a sweep again
//! finds what is there, in whatever order and by however many runs it came.

mod bop;
mod estimate;
mod frame;
mod input;
mod place;
mod runner;
mod summary;
mod without;

use super::farm;
use crate::arguments::{Format, SweepArguments, SweepOptions};
use crate::failure::Failure;
use crate::farm::Farm;
use crate::interrupt::Interrupt;
use crate::output::Output as Folder;
use crate::progress::{Console, SweepConsole, count, plural};
use crate::relocate::relocate;
use crate::watch::{SheetWatch, Watch};
use gonio_scene::Film;
use gonio_scene::capture::{CAPTURE_FILE, Photo};
use gonio_sweep::{Batch, FrameDigest, Record, Sheet, Table};
use input::Planned;
use place::Place;
use runner::Runner;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64};
use std::time::Instant;
use summary::Summary;

const TABLE: [&str; 2] = ["table.csv", "table.parquet"];
const TIMINGS: &str = "timings.csv";
const SHEET: [&str; 2] = ["sheet.html", "sheet.png"];

/// Most camera samples of a batch: a few seconds of a core, all of which Ctrl-C may lose.
const BATCH_SAMPLES: u64 = 1 << 23;

/// Most pixels of frames under way, together.
const PIXELS: u64 = 1 << 26;

/// Evaluations under way where nobody says otherwise and memory allows.
const IN_FLIGHT: u64 = 16;

/// A frame of a sweep.
#[derive(Debug, Clone)]
pub struct Frame {
    /// Its place in the sweep's table.
    pub index: usize,
    /// Which point of the design it renders.
    pub point: usize,
    /// The photo or view.
    pub view: String,
    /// Every number that varies, by dotted name, in the table's order.
    pub numbers: Vec<(String, f64)>,
    /// What its files are called by.
    pub digest: String,
    /// Mean photo value per channel.
    pub mean: [f64; 3],
    /// Photo values: three channels, the top row first. Absent where the frame was there before and its files do not hold them all.
    pub image: Option<Film>,
}

/// What may be done with a finished frame: its index, its record, and its photo values unless it was there before.
type Seen<'a> = dyn FnMut(usize, &Record, Option<Film>) -> Result<(), Failure> + 'a;

/// Renders the frames of the sweep's file `path` on `farm` and gives each to `seen` as it is finished: first those that lie in `out`
/// already, then the others in whatever order they come. Writes what the command writes to `out`, where that is named.
///
/// # Errors
/// A broken sweep or capture, a farm that fails, a place that cannot be written to, an interruption (finished frames stay).
pub fn frames(
    path: &Path,
    out: Option<&str>,
    options: &SweepOptions,
    farm: &dyn Fn() -> Result<Farm, Failure>,
    console: &mut Console,
    interrupt: &Interrupt,
    seen: &mut dyn FnMut(Frame),
) -> Result<(), Failure> {
    let planned = Planned::read(path, options.diagnosis.as_deref(), &options.without)?;
    let place = match out {
        Some(out) => {
            let place = Place::open(out, false)?;
            planned.spare(&place)?;
            place
        }
        None => Place::nowhere()?,
    };
    let Planned { plan, digests, .. } = &planned;
    let mut alike: BTreeMap<FrameDigest, Vec<usize>> = BTreeMap::new();
    for (index, digest) in digests.iter().enumerate() {
        alike.entry(*digest).or_default().push(index);
    }
    let mut give = |first: usize, record: &Record, film: Option<Film>| -> Result<(), Failure> {
        let digest = digests[first];
        let image = match film {
            Some(film) => Some(film),
            None => place.image(plan.frames[first].photo, digest)?,
        };
        for &index in &alike[&digest] {
            let frame = &plan.frames[index];
            seen(Frame {
                index,
                point: frame.point,
                view: plan.capture.photos.get(frame.photo).map_or("?", Photo::name).to_owned(),
                numbers: plan.numbers(frame),
                digest: record.digest.clone(),
                mean: record.mean,
                image: image.clone(),
            });
        }
        Ok(())
    };
    let job = Job { path, options, dry_run: false, farm };
    job.work(&planned, &place, console, interrupt, &Watch::none(), &mut give)?;
    Ok(())
}

/// Renders what is missing, and writes the tables once all is there.
///
/// # Errors
/// A broken sweep or capture, a farm that fails, a place that cannot be written to, Ctrl-C (finished frames stay).
pub fn run(arguments: &SweepArguments) -> Result<(), Failure> {
    let begin = Instant::now();
    let note = "stopping and keeping what is done; again to kill";
    let interrupt = Interrupt::listen(if arguments.farm.json { "" } else { note })?;
    let options = &arguments.options;
    let planned = Planned::read(&arguments.sweep, options.diagnosis.as_deref(), &options.without)?;
    let plan = &planned.plan;
    let place = Place::open(&arguments.out, arguments.dry_run)?;
    if !arguments.dry_run {
        planned.spare(&place)?;
    }
    let dataset = match (arguments.format, place.folder()) {
        (Format::Frames, _) => None,
        (Format::Bop, Some(folder)) => Some((arguments.sweep.display().to_string(), folder)),
        (Format::Bop, None) => {
            return Err(Failure::Input("--format bop: writes a folder; name one by --out".to_owned()));
        }
    };
    let dataset = match &dataset {
        Some((sweep, folder)) => Some(bop::Dataset::new(&planned, sweep, folder)?),
        None => None,
    };
    let mut console = Console::new(arguments.farm.json);
    let watch = Watch::open(&arguments.watch, ("Sweep", &plan.capture.name), &interrupt, &console)?;
    let job = Job { path: &arguments.sweep, options, dry_run: arguments.dry_run, farm: &|| farm(&arguments.farm) };
    let told = job.work(&planned, &place, &mut console, &interrupt, &watch, &mut |_, _, _| Ok(()));
    let done = told.and_then(|(mut swept, left)| {
        if let (Some(dataset), false) = (&dataset, arguments.dry_run) {
            dataset.write(&mut console, &interrupt)?;
        }
        swept.seconds = (!arguments.dry_run).then(|| begin.elapsed().as_secs_f64());
        swept.tell(arguments.farm.json, left)
    });
    watch.end(&done);
    done
}

/// What is swept, how, and where.
struct Job<'a> {
    path: &'a Path,
    options: &'a SweepOptions,
    dry_run: bool,
    farm: &'a dyn Fn() -> Result<Farm, Failure>,
}

impl Job<'_> {
    /// Renders what is missing and writes the tables; gives what there is to tell, and how many camera samples were left to trace.
    fn work<'a>(
        &self,
        planned: &'a Planned,
        place: &'a Place,
        console: &mut Console,
        interrupt: &Interrupt,
        watch: &Watch,
        seen: &mut Seen<'_>,
    ) -> Result<(Summary<'a>, u64), Failure> {
        let Planned { plan, digests, .. } = planned;
        let first_of = first_of(digests);
        let mut finished = place.listed(&first_of.keys().copied().collect::<Vec<_>>(), &plan.outputs)?;
        let sheet = Sheet::of(plan);
        let shown: BTreeSet<FrameDigest> = sheet.frames().iter().map(|frame| digests[*frame]).collect();
        let keep = |digest: FrameDigest, mut record: Record| {
            if !shown.contains(&digest) {
                record.thumbnail.forget();
            }
            record
        };
        let mut records = if self.dry_run { BTreeMap::new() } else { place.records(&finished, &keep)? };
        if !self.dry_run {
            finished.retain(|digest| records.contains_key(digest));
        }
        for (digest, record) in records.iter().filter(|_| !self.dry_run) {
            seen(first_of[digest], record, None)?;
        }
        let mut wanted: Vec<usize> =
            first_of.iter().filter(|(digest, _)| !finished.contains(digest)).map(|(_, frame)| *frame).collect();
        wanted.sort_unstable();
        let samples = |frame: &usize| plan.pixels(&plan.frames[*frame]).saturating_mul(u64::from(plan.samples));
        let left: u64 = wanted.iter().map(samples).sum();
        let pixel_bytes: u64 = plan.outputs.iter().map(|output| output.pixel_bytes()).sum();
        let pixels: u64 = first_of.values().map(|frame| plan.pixels(&plan.frames[*frame])).sum();
        let mut swept = Summary {
            sweep: self.path.display().to_string(),
            capture: &plan.capture.name,
            out: place.url(),
            points: plan.points.len(),
            frames: plan.frames.len(),
            distinct: first_of.len(),
            finished_before: finished.len(),
            rendered: 0,
            bytes_at_most: pixels.saturating_mul(pixel_bytes),
            estimated_seconds: None,
            seconds: None,
        };
        let text = format!(
            "{} from {}: {} to render, {} there already",
            plural(swept.frames, "frame"),
            plural(swept.points, "point"),
            wanted.len(),
            swept.finished_before
        );
        console.line(&text);

        let batches = plan.batches(&wanted, BATCH_SAMPLES);
        let in_flight = self.options.in_flight.map_or_else(|| in_flight(plan, &batches), usize::from);
        if !wanted.is_empty() {
            let farm = (self.farm)()?.for_batches();
            let open = farm.open(&planned.files)?;
            let runner = Runner {
                plan,
                digests,
                files: &planned.files,
                place,
                farm: &farm,
                interrupt,
                stop: AtomicBool::new(false),
                traced: AtomicU64::new(0),
            };
            if self.dry_run {
                swept.estimated_seconds =
                    Some(count(left) / estimate::rate(&runner, &open, &batches, in_flight)?.max(1e-9));
            } else {
                let mut view = SweepConsole::new(console, watch, wanted.len(), left);
                let mut drawn = SheetWatch::new(watch);
                let mut refused = None;
                let result = runner.run(&open, batches, in_flight, &mut view, &mut |frame, record, image| {
                    if let Err(failure) = seen(frame, &record, Some(image)) {
                        refused.get_or_insert(failure);
                    }
                    records.insert(digests[frame], keep(digests[frame], record));
                    drawn.draw(&sheet, digests, &records, false);
                });
                drawn.draw(&sheet, digests, &records, true);
                console.end();
                swept.rendered = records.len() - finished.len();
                if interrupt.is_asked() && records.len() < first_of.len() {
                    let (done, all) = (records.len(), first_of.len());
                    let text =
                        format!("interrupted: {done} of {all} frames are there; the same command renders the others");
                    return Err(Failure::Interrupted(text));
                }
                result?;
                refused.map_or(Ok(()), Err)?;
            }
        } else if self.dry_run {
            swept.estimated_seconds = Some(0.0);
        }
        if !self.dry_run && place.keeps() {
            write(planned, place, &sheet, &records)?;
        }
        Ok((swept, left))
    }
}

/// The first frame of each digest.
fn first_of(digests: &[FrameDigest]) -> BTreeMap<FrameDigest, usize> {
    let mut first = BTreeMap::new();
    for (frame, digest) in digests.iter().enumerate() {
        first.entry(*digest).or_insert(frame);
    }
    first
}

/// As many evaluations as keep a farm busy within the memory for their pixels.
fn in_flight(plan: &gonio_sweep::Plan, batches: &[Batch]) -> usize {
    let pixels = |batch: &Batch| batch.frames.iter().map(|frame| plan.pixels(&plan.frames[*frame])).sum::<u64>();
    let largest = batches.iter().map(pixels).max().unwrap_or(1).max(1);
    usize::try_from((PIXELS / largest).clamp(1, IN_FLIGHT)).unwrap_or(1)
}

impl Planned {
    /// Makes the folder of the results where it is missing, and makes sure that it is not one whose files are those of the capture.
    ///
    /// # Errors
    /// It is, or cannot be made.
    fn spare(&self, place: &Place) -> Result<(), Failure> {
        let Some(folder) = place.folder() else { return Ok(()) };
        let names = [TABLE[0], TABLE[1], TIMINGS, SHEET[0], SHEET[1], CAPTURE_FILE].map(str::to_owned);
        Folder::create(&folder, &names, &self.input.root, &self.input.capture)?;
        Ok(())
    }
}

/// Writes what is about all frames.
fn write(
    planned: &Planned,
    place: &Place,
    sheet: &Sheet<'_>,
    records: &BTreeMap<FrameDigest, Record>,
) -> Result<(), Failure> {
    let Planned { plan, digests, input, .. } = planned;
    let lost = || Failure::Failed("a frame is missing, though all were rendered; run the command again".to_owned());
    let of_frames: Vec<&Record> =
        digests.iter().map(|digest| records.get(digest)).collect::<Option<_>>().ok_or_else(lost)?;
    let table = Table::of(plan, digests, &of_frames);
    place.put(TABLE[0], table.to_csv())?;
    place.put(TABLE[1], table.to_parquet(TABLE[1])?)?;
    place.put(TIMINGS, Table::timings(digests, &of_frames).to_csv())?;
    place.put(SHEET[1], sheet.picture(SHEET[1], &of_frames)?)?;
    place.put(SHEET[0], sheet.page(&plan.capture.name, SHEET[1], digests, &of_frames).into_bytes())?;
    let mut here = plan.capture.clone();
    // From a bucket no path leads to this machine but an absolute one.
    relocate(&mut here, &input.root, &place.folder().unwrap_or_else(|| Path::new("/").to_owned()))?;
    place.put(CAPTURE_FILE, here.to_toml()?.into_bytes())
}
