//! `gonio study`: a page on which people rate images.

mod answers;
mod images;
mod server;

use crate::failure::Failure;
use crate::output::{tell, tell_error};
use answers::Answers;
use clap::Args;
use images::Images;
use std::net::SocketAddr;
use std::path::PathBuf;

/// `gonio study`.
#[derive(Debug, Args)]
pub struct StudyArguments {
    /// PNG or JPEG files; what each is says its folder, real/ or synthetic/, or --truth
    #[arg(required = true)]
    pub images: Vec<PathBuf>,
    /// Table of answers, observer,image,truth,rating; goes on where there is one
    #[arg(long, value_name = "FILE.csv")]
    pub out: PathBuf,
    /// Table of what images are: image (the file's name),truth (real or synthetic)
    #[arg(long, value_name = "FILE.csv")]
    pub truth: Option<PathBuf>,
    /// Seed of the orders; every observer has another, and the same after a restart
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
    /// Address to serve; anyone who reaches it may answer, so other than loopback only in a network that you trust
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:8017")]
    pub listen: SocketAddr,
    /// Write the address as one JSON object once the page is served, and a failure as JSON
    #[arg(long)]
    pub json: bool,
}

/// Serves until it is stopped.
///
/// # Errors
/// Images or answers that are missing or bad, or an address that cannot be served.
pub fn run(arguments: &StudyArguments) -> Result<(), Failure> {
    let images = Images::read(&arguments.images, arguments.truth.as_deref())?;
    let answers = Answers::open(&arguments.out, &images)?;
    let kept = answers.count();
    let study = server::Study::new(images, answers, arguments.seed);
    let failed = |error: std::io::Error| Failure::Failed(format!("--listen {}: {error}", arguments.listen));
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(failed)?;
    runtime.block_on(async {
        let listener = tokio::net::TcpListener::bind(arguments.listen).await.map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        if arguments.json {
            tell(&serde_json::json!({ "url": format!("http://{address}/"), "answers": kept }).to_string());
        } else {
            tell(&format!("http://{address}/"));
            tell_error(&format!("{kept} answers so far in {}; Ctrl-C ends", arguments.out.display()));
        }
        server::serve(listener, study).await.map_err(failed)
    })
}
