//! `gonio-coordinator`: the farm's middle, as a process of its own.

mod arguments;

use anyhow::Context;
use arguments::{Arguments, Command};
use clap::Parser;
use gonio_coordinator::store::Blobs;
use gonio_coordinator::{Coordinator, broker, journal, service};
use std::io::Write;
use tokio::net::TcpListener;
use tracing_subscriber::EnvFilter;

#[tokio::main]
async fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    if let Some(Command::Token(token)) = &arguments.command {
        return token.make();
    }
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
    let address = listener.local_addr()?;
    let protection = arguments.security.protection(address)?;
    let scheme = if protection.tls.is_some() { "https" } else { "http" };
    let coordinator = if durable {
        Coordinator::durable(blobs, broker::SILENCE).await?
    } else {
        Coordinator::new(blobs, broker::SILENCE)
    };
    let page = match arguments.page {
        Some(address) => Some(arguments.security.page(address).await?),
        None => None,
    };
    println!("listening on {scheme}://{address}");
    if let Some(page) = page {
        // Whoever started it may have read no further than the line above.
        let _ = writeln!(std::io::stdout(), "page at {}", page.url());
        tokio::spawn(page.serve(coordinator.clone(), protection.guard.clone()));
    }
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
    service::serve_protected(coordinator, listener, protection, stop, grace).await?;
    match lost.get() {
        Some(why) => anyhow::bail!("{why}"),
        None => Ok(()),
    }
}
