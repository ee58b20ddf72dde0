//! `gonio-coordinator`: the farm's middle, as a process of its own.

use anyhow::Context;
use clap::Parser;
use gonio_coordinator::store::Blobs;
use gonio_coordinator::{Coordinator, broker, journal, service};
use tokio::net::TcpListener;
use tracing_subscriber::EnvFilter;

/// Hands out the tasks of evaluations to workers and reduces what they render.
#[derive(Debug, Parser)]
#[command(version)]
struct Arguments {
    /// Address to listen on; port 0 takes a free one, which is printed
    #[arg(long, default_value = "127.0.0.1:7300")]
    listen: String,
    /// Where captures are kept: a folder, memory://, or s3://BUCKET/PREFIX
    #[arg(long, default_value = "gonio-store")]
    store: String,
    /// Wait until the coordinator that owns the store's farm stops, or has not been heard of for ten seconds; then listen
    /// and take over
    #[arg(long)]
    standby: bool,
    /// Seconds that evaluations which run have to finish once the coordinator is told to stop; then they fail
    #[arg(long, default_value_t = 10.0, value_parser = gonio_proto::limits::seconds)]
    grace: f64,
}

#[tokio::main]
async fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new("info"));
    tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr).init();
    let blobs = Blobs::open(&arguments.store)?;
    blobs.probe().await?;
    // Before anybody can know that it runs, so that who stops it at once is heard.
    let mut terminate = tokio::signal::unix::signal(tokio::signal::unix::SignalKind::terminate())?;
    let stop = async move {
        tokio::select! {
            _ = tokio::signal::ctrl_c() => {}
            _ = terminate.recv() => {}
        }
        tracing::info!("stopping");
    };
    let mut stop = std::pin::pin!(stop);
    // What is kept in memory is nobody's to take over.
    let durable = !arguments.store.starts_with("memory:");
    if arguments.standby {
        anyhow::ensure!(durable, "--standby: --store {} is nobody else's; name the owner's store", arguments.store);
        println!("standing by");
        tokio::select! {
            () = journal::wait_for_silence(&blobs) => {}
            () = &mut stop => return Ok(()),
        }
    }
    let listener = TcpListener::bind(&arguments.listen).await;
    let listener =
        listener.with_context(|| format!("cannot listen on {}; choose another --listen", arguments.listen))?;
    let coordinator = if durable {
        Coordinator::durable(blobs, broker::SILENCE).await?
    } else {
        Coordinator::new(blobs, broker::SILENCE)
    };
    println!("listening on http://{}", listener.local_addr()?);
    let lost = std::sync::Arc::new(std::sync::OnceLock::new());
    let (owner, why) = (coordinator.clone(), std::sync::Arc::clone(&lost));
    let stop = async move {
        tokio::select! {
            () = stop => {}
            text = owner.lost() => {
                let _ = why.set(text);
            }
        }
    };
    let grace = std::time::Duration::from_secs_f64(arguments.grace);
    service::serve(coordinator, listener, stop, grace).await?;
    match lost.get() {
        Some(why) => anyhow::bail!("{why}"),
        None => Ok(()),
    }
}
