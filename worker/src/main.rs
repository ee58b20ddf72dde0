//! `gonio-worker`: renders for a coordinator, as a process of its own.

use clap::Parser;
use gonio_operations::OperationsArguments;
use gonio_store::Blobs;
use gonio_worker::Worker;
use gonio_worker::access::Access;
use gonio_worker::renderer::PathTracer;
use std::sync::Arc;
use tokio::signal::unix::{SignalKind, signal};

/// Renders tasks for a coordinator until it is told to stop.
#[derive(Debug, Parser)]
#[command(version = gonio_operations::VERSION)]
struct Arguments {
    /// The coordinator's address, such as http://127.0.0.1:7300
    #[arg(long)]
    coordinator: String,
    /// Render threads; one per core where it is absent
    #[arg(long, default_value_t = 0, hide_default_value = true)]
    threads: usize,
    /// Name in logs and progress; made of the process id where it is absent
    #[arg(long)]
    name: Option<String>,
    /// The coordinator's store, where this machine reaches it: a folder or s3://BUCKET/PREFIX. Captures' files are then
    /// read from there, and asked of the coordinator only where they are missing
    #[arg(long)]
    store: Option<String>,
    /// Seconds that tasks which are being rendered have to end once the worker is told to stop; then they are handed back
    #[arg(long, default_value_t = 10.0, value_parser = gonio_proto::limits::seconds)]
    grace: f64,
    #[command(flatten)]
    operations: OperationsArguments,
    #[command(flatten)]
    access: Access,
}

#[tokio::main(flavor = "multi_thread", worker_threads = 2)]
async fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    let _logging = arguments.operations.log.start("gonio-worker", "info")?;
    let name = arguments.name.unwrap_or_else(|| format!("worker-{}", std::process::id()));
    let mut worker = Worker::new(&name, arguments.threads, Arc::new(PathTracer))?;
    worker = worker.with_grace(std::time::Duration::from_secs_f64(arguments.grace));
    if let Some(url) = &arguments.store {
        worker = worker.with_store(open(url).await?);
    }
    arguments.operations.serve(&Arc::new(worker.clone()))?;
    let (mut interrupt, mut terminate) = (signal(SignalKind::interrupt())?, signal(SignalKind::terminate())?);
    let stop = async move {
        tokio::select! {
            _ = interrupt.recv() => {}
            _ = terminate.recv() => {}
        }
        tracing::info!("stopping");
    };
    worker.work_for(&arguments.coordinator, &arguments.access, stop).await?;
    Ok(())
}

/// The coordinator's store, seen from here: it must be there already.
async fn open(url: &str) -> anyhow::Result<Blobs> {
    if url.starts_with("memory://") {
        anyhow::bail!("--store {url}: only the coordinator sees its memory; leave --store out, or name its folder");
    }
    let folder = url.strip_prefix("file://").unwrap_or(url);
    if !folder.contains("://") && !std::path::Path::new(folder).is_dir() {
        anyhow::bail!("--store {url}: is no folder here; mount the coordinator's, or leave --store out");
    }
    let blobs = Blobs::open(url)?;
    blobs.probe().await?;
    Ok(blobs)
}
