//! `seeds scene author FILE`: write a scene on a page.

use super::open::{print_line, serve_at, until_interrupted};
use crate::runtime::cli::{self, BAD_INPUT, fail};
use crate::viewer_logger::Viewer;
use crate::viewer_logger::author::Author;
use crate::viewer_logger::server::{Operate, Page};
use clap::Args;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

/// Write a scene on a page: routes by click, sensors by drag with what they see, checked at every step; the file is changed when you save
#[derive(Args, Clone, Debug)]
pub struct AuthorArgs {
    /// Scene: a TOML file (`seeds scene new` makes one)
    #[arg(value_name = "FILE")]
    file: PathBuf,

    /// Address of the page, of this host only [default: 127.0.0.1 and the first free port from 8600 on]
    #[arg(long, value_name = "ADDR:PORT", value_parser = cli::page)]
    page: Option<SocketAddr>,
}

/// Serves the page until it is interrupted.
#[must_use]
pub fn run(args: &AuthorArgs) -> ExitCode {
    cli::log_to_stderr(cli::LogFormat::Text, "warn");
    if let Some(address) = args.page.filter(|a| !a.ip().is_loopback()) {
        let text = format!(
            "--page {address}: a scene is written from this host only, like 127.0.0.1:8600"
        );
        return fail(BAD_INPUT, text);
    }
    let author = match Author::of(&args.file) {
        Ok(author) => author,
        Err(error) => return fail(BAD_INPUT, error),
    };
    let page = Page::new(Viewer::new(HISTORY));
    page.let_write(Arc::new(author));
    let operate = || -> Operate {
        Box::new(|_, _| (false, "no run goes on here: a scene is written".to_owned()))
    };
    let server = match serve_at(args.page, &page, operate) {
        Ok(server) => server,
        Err(code) => return code,
    };
    print_line(&format!("{}author", server.access().url()));
    until_interrupted(server, || ())
}

/// No scan comes.
const HISTORY: usize = 1 << 16;
