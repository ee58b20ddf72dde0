//! `gonio-coordinator`: the farm's middle, as a process of its own.

mod arguments;

use anyhow::Context;
use arguments::{Arguments, Command};
use clap::Parser;
use gonio_coordinator::operations::{Operations, Phase};
use gonio_coordinator::store::Blobs;
use gonio_coordinator::{Coordinator, broker, journal, scaler, service};
use std::io::Write;
use tokio::net::TcpListener;

#[tokio::main]
async fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    if let Some(Command::Token(token)) = &arguments.command {
        return token.make();
    }
    let _logging = arguments.operations.log.start("gonio-coordinator", "info")?;
    let operations = std::sync::Arc::new(Operations::default());
    arguments.operations.serve(&operations)?;
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
        operations.enter(Phase::Standby);
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
    let scaler = match arguments.scaler {
        Some(address) => Some(scaler::Port::open(address, arguments.security.scaler_tls(address)?).await?),
        None => None,
    };
    let coordinator = if durable {
        Coordinator::durable(blobs, broker::SILENCE).await?
    } else {
        Coordinator::new(blobs, broker::SILENCE)
    };
    operations.serve(&coordinator);
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
        operations.enter(Phase::Draining);
    };
    let grace = std::time::Duration::from_secs_f64(arguments.grace);
    let scaling = scaler::serve(coordinator.clone(), scaler);
    tokio::select! {
        served = service::serve_protected(coordinator, listener, protection, stop, grace) => served?,
        failed = scaling => failed?,
    }
    match lost.get() {
        Some(why) => anyhow::bail!("{why}"),
        None => Ok(()),
    }
}
