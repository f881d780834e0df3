//! `seeds verify DIR`: reference vectors through the product's own functions.

use crate::runtime::cli::out;
use crate::runtime::cli::{BAD_INPUT, FAILED, fail};
use clap::Args;
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;

/// Run every reference vector file (*.json) below a folder
#[derive(Args, Clone, Debug)]
pub struct VerifyArgs {
    /// Folder, or one file
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,

    /// One JSON object a file, and a closing one: {"passed","failed","not_covered"}
    #[arg(long)]
    pub json: bool,
}

/// Prints a line a file and the sum; 1 if any case failed.
#[must_use]
pub fn run(args: &VerifyArgs) -> ExitCode {
    let reports = match verify::run(&args.dir) {
        Ok(reports) => reports,
        Err(e) => return fail(BAD_INPUT, e),
    };
    let (mut passed, mut failed, mut not_covered) = (0, 0, Vec::new());
    for report in &reports {
        let file = report.path.display().to_string();
        passed += report.passed();
        failed += report.failed();
        if !report.covered {
            not_covered.push(file.clone());
        }
        let worst = report.worst();
        if args.json {
            let ratio = worst.map(|w| w.worst).filter(|w| w.is_finite());
            let line = json!({
                "file": file, "covered": report.covered, "passed": report.passed(),
                "failed": report.failed(), "worst_error_over_tolerance": ratio,
                "worst_case": worst.map(|w| &w.name), "worst_detail": worst.map(|w| &w.detail),
            });
            out!("{line}");
        } else if report.covered {
            let (ratio, name, detail) =
                worst.map_or((0.0, "", ""), |w| (w.worst, w.name.as_str(), w.detail.as_str()));
            let shown =
                if report.failed() > 0 { format!("  {name}: {detail}") } else { String::new() };
            out!(
                "{file}: {} passed, {} failed, worst error {ratio:.2e} of tolerance{shown}",
                report.passed(),
                report.failed()
            );
        } else {
            out!("{file}: not covered");
        }
    }
    if args.json {
        out!("{}", json!({"passed": passed, "failed": failed, "not_covered": not_covered}));
    } else {
        out!("{passed} passed, {failed} failed, {} files not covered", not_covered.len());
    }
    if failed > 0 { ExitCode::from(FAILED) } else { ExitCode::SUCCESS }
}
