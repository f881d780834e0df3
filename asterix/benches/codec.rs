//! Encode and decode with every field read, against the registry's `libasterix` in the same run.

use asterix::{Block, Packer, blocks, cat048, cat062};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;

const MOST: usize = 62_000;

type Reader = fn(&Block<'_>) -> f64;

/// Reads every field of every item in one pass, scaled.
fn read(block: &Block<'_>) -> f64 {
    let mut sum = 0.0;
    for record in block.records() {
        let Ok(record) = record else { break };
        record.each(|datum| sum += datum.number().unwrap_or(1.0));
    }
    sum
}

/// The same item by item.
fn read_items(block: &Block<'_>) -> f64 {
    let mut sum = 0.0;
    for record in block.records() {
        let Ok(record) = record else { break };
        for item in record.items() {
            for (_, value) in item.values() {
                sum += value.number().unwrap_or(1.0);
            }
            for sub in item.subitems() {
                for (_, value) in sub.values() {
                    sum += value.number().unwrap_or(1.0);
                }
            }
        }
    }
    sum
}

fn track_062(packer: &mut Packer, n: f64) {
    const STATUS: usize = cat062::I080.fields();
    let mut status = [0; STATUS];
    status[const { cat062::I080.field("SIM") }] = 1;
    status[const { cat062::I080.field("FPC") }] = 1;
    status[const { cat062::I080.field("SFC") }] = 1;
    packer
        .record(&cat062::CATEGORY, |items| {
            items.put(&cat062::I010, &[0, 200])?;
            items.put(&cat062::I015, &[1])?;
            items.put(&cat062::I070, &[36_002.0 + n])?;
            items.put(&cat062::I105, &[47.454_321, 8.556_789 + n * 1e-6])?;
            items.put(&cat062::I100, &[657.25 + n, -411.75])?;
            items.put(&cat062::I185, &[-7.75, 0.25])?;
            items.put(&cat062::I210, &[0.25, -0.5])?;
            items.compound(&cat062::I380, |sub| {
                sub.put(&cat062::I380_ADR, &[0x4b_1900])?;
                sub.put(&cat062::I380_ID, &["EDW229"])
            })?;
            items.put(&cat062::I040, &[321])?;
            items.put(&cat062::I080, &status)?;
            items.compound(&cat062::I290, |sub| {
                sub.put(&cat062::I290_TRK, &[12.0])?;
                sub.put(&cat062::I290_PSR, &[0.25])
            })?;
            items.compound(&cat062::I500, |sub| {
                sub.put(&cat062::I500_APC, &[1.5, 1.5])?;
                sub.put(&cat062::I500_ATV, &[0.25, 0.25])
            })
        })
        .expect("fits");
}

fn plot_048(packer: &mut Packer, n: f64) {
    packer
        .record(&cat048::CATEGORY, |items| {
            items.put(&cat048::I010, &[25, 10])?;
            items.put(&cat048::I140, &[36_000.5 + n])?;
            items.put(&cat048::I020, &[7, 1, 0, 0, 0])?;
            items.put(&cat048::I040, &[4.875, 137.46])?;
            items.put(&cat048::I070, &[0, 0, 0, 0o1234])?;
            items.put(&cat048::I090, &[0.0, 0.0, 24.25])?;
            items.compound(&cat048::I130, |sub| {
                sub.put(&cat048::I130_SRL, &[1.05])?;
                sub.put(&cat048::I130_SAM, &[-56.0])
            })?;
            items.put(&cat048::I220, &[0x3c_6586])?;
            items.put(&cat048::I240, &["DLH4TR"])?;
            items.put(&cat048::I161, &[301])?;
            items.put(&cat048::I042, &[3.297, -3.594])?;
            items.put(&cat048::I200, &[0.0389, 137.5])?;
            items.put(&cat048::I170, &[0, 2, 0, 0, 2])?;
            items.put(&cat048::I230, &[1, 0, 0, 1, 1, 1, 0, 0])
        })
        .expect("fits");
}

fn filled(write: fn(&mut Packer, f64)) -> (Vec<u8>, u64) {
    let mut packer = Packer::new(MOST);
    for n in 0..500 {
        write(&mut packer, f64::from(n));
    }
    let datagram = packer.take().swap_remove(0);
    let block = blocks(&datagram).next().expect("a block").expect("sound");
    let count = block.check().expect("sound") as u64;
    (datagram, count)
}

fn codec(c: &mut Criterion) {
    let mut group = c.benchmark_group("encode");
    for (name, write) in [("062", track_062 as fn(&mut Packer, f64)), ("048", plot_048)] {
        group.throughput(Throughput::Elements(500));
        let mut packer = Packer::new(MOST);
        group.bench_function(name, |b| {
            b.iter(|| {
                (0..500).for_each(|n| write(&mut packer, f64::from(black_box(n))));
                packer.take()
            });
        });
    }
    group.finish();

    let mut group = c.benchmark_group("decode");
    for (name, write) in [("062", track_062 as fn(&mut Packer, f64)), ("048", plot_048)] {
        let (datagram, count) = filled(write);
        group.throughput(Throughput::Elements(count));
        let ways: [(&str, Reader); 2] = [("", read), (" by items", read_items)];
        for (way, read) in ways {
            group.bench_function(format!("{name}{way}"), |b| {
                b.iter(|| {
                    let block = blocks(black_box(&datagram)).next().expect("a block");
                    read(&block.expect("sound"))
                });
            });
        }
    }
    let (datagram, count) = filled(plot_048);
    // It takes each of these records for two (0.1.0): only its time for the same octets can be compared.
    let theirs = libasterix::asterix::cat048::parse_cat048_block(&datagram).expect("they read it");
    assert!(theirs.len() as u64 >= count);
    group.throughput(Throughput::Elements(count));
    group.bench_function("048 libasterix", |b| {
        b.iter(|| libasterix::asterix::cat048::parse_cat048_block(black_box(&datagram)));
    });
    group.finish();
}

criterion_group!(benches, codec);
criterion_main!(benches);
