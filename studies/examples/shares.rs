//! What share of the bound each rung reaches, cell by cell: eight scenes drawn from a seed (or the eight that are named) at five noises.
//!
//! `cargo run --release -p studies --example shares -- [--seeds A..B] [--runs N] [--rungs pair,imm3] [--cells] [--eight]`
#![allow(clippy::print_stdout, reason = "a tool for the terminal")]

use models::filter::Rung;
use std::error::Error;
use studies::unseen::{eight, generated, shares};

fn main() -> Result<(), Box<dyn Error>> {
    let (mut seeds, mut runs, mut cells, mut known) = (1..=1, 20, false, false);
    let mut rungs = vec![Rung::Pair];
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        match arg.as_str() {
            "--seeds" => {
                let text = args.next().unwrap_or_default();
                let (a, b) = text.split_once("..").unwrap_or((&text, &text));
                seeds = a.parse()?..=b.parse()?;
            }
            "--runs" => runs = args.next().unwrap_or_default().parse()?,
            "--cells" => cells = true,
            "--eight" => known = true,
            "--rungs" => {
                rungs.clear();
                for word in args.next().unwrap_or_default().split(',') {
                    let found = Rung::ALL.iter().find(|(rung, _)| rung.name() == word);
                    rungs.push(found.ok_or(format!("no rung {word}"))?.0);
                }
            }
            other => {
                return Err(format!("{other}: give --seeds, --runs, --rungs or --cells").into());
            }
        }
    }
    println!("seed rung: of 40 cells at or above 0.74, least, median, lost");
    for seed in seeds {
        for &rung in &rungs {
            let scenes = if known { eight() } else { generated(seed, 8) };
            let mut found = shares(&scenes, rung, seed, runs);
            if cells {
                for (n, cell) in found.iter().enumerate() {
                    println!("  {} / {}: {:.2}", n / 5 + 1, cell.noise, cell.share);
                }
            }
            let lost: u32 = found.iter().map(|c| c.lost).sum();
            let high = found.iter().filter(|c| c.share >= 0.74).count();
            found.sort_by(|a, b| a.share.total_cmp(&b.share));
            let (least, middle) = (found[0].share, found[found.len() / 2].share);
            println!("{seed} {}: {high} {least:.2} {middle:.2} {lost}", rung.name());
        }
    }
    Ok(())
}
