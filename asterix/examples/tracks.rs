//! Writes ten seconds of a system track to a file of bare blocks, reads it back and prints where it was:
//! `cargo run -p asterix --example tracks -- track.ast`.

#![expect(clippy::print_stdout, reason = "a program for a terminal")]

use asterix::files::{Form, frames};
use asterix::{DATAGRAM_LIMIT, Packer, blocks, cat062};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let name = std::env::args().nth(1).ok_or("which file?")?;
    let mut packer = Packer::new(DATAGRAM_LIMIT);
    for second in 0..10 {
        let time_s = f64::from(second);
        packer.record(&cat062::CATEGORY, |items| {
            items.put(&cat062::I010, &[0, 1])?;
            items.put(&cat062::I070, &[32_400.0 + time_s])?;
            items.put(&cat062::I100, &[100.0 + 7.5 * time_s, -40.0])?;
            items.put(&cat062::I185, &[7.5, 0.0])?;
            items.put(&cat062::I040, &[12])?;
            items.put(&cat062::I080, &[1])
        })?;
    }
    std::fs::write(&name, packer.take().concat())?;

    let file = std::fs::read(&name)?;
    for frame in frames(Form::Raw, &file) {
        for block in blocks(frame?.content) {
            for record in block?.records() {
                let record = record?;
                let (time_s, position) =
                    (record.number(&cat062::I070), record.numbers(&cat062::I100));
                if let (Some(time_s), Some([x_m, y_m])) = (time_s, position) {
                    println!("{time_s} s: {x_m} m east, {y_m} m north");
                }
            }
        }
    }
    Ok(())
}
