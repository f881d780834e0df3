//! The log of a run, at the conductor: pages of records, all but the last in a file that ends with the process.

use super::codec::{decode, encode};
use super::messages::{LogPage, LogRecord};
use std::fs::{File, OpenOptions};
use std::io::{Read as _, Seek as _, SeekFrom, Write as _};

/// Octets of a page, about: what is kept in memory.
const PAGE_OCTETS: usize = 256 << 10;

/// Records of one run.
#[derive(Debug, Default)]
pub struct RunLog {
    run: u32,
    file: Option<File>,
    /// Begin and length of each page in the file.
    pages: Vec<(u64, usize)>,
    end: u64,
    /// The page that is being filled.
    open: Vec<Vec<u8>>,
    octets: usize,
    lost: String,
}

impl RunLog {
    /// Adds a record; one of a later run begins a new log.
    pub fn append(&mut self, run: u32, record: &LogRecord) {
        if run != self.run {
            *self = Self { run, ..Self::default() };
        }
        let record = encode(record);
        if self.octets + record.len() > PAGE_OCTETS && !self.open.is_empty() {
            self.close_page();
        }
        self.octets += record.len();
        self.open.push(record);
    }

    fn close_page(&mut self) {
        let records = std::mem::take(&mut self.open);
        self.octets = 0;
        if !self.lost.is_empty() {
            return;
        }
        let octets = encode(&records);
        match self.write(&octets) {
            Ok(()) => {
                self.pages.push((self.end, octets.len()));
                self.end += octets.len() as u64;
            }
            Err(e) => {
                let folder = std::env::temp_dir();
                self.lost = format!(
                    "the log of the run could not be written to {}: {e}; set TMPDIR to a folder with room",
                    folder.display()
                );
                tracing::warn!("{}; who is lost from now on may not be able to return", self.lost);
            }
        }
    }

    fn write(&mut self, octets: &[u8]) -> std::io::Result<()> {
        if self.file.is_none() {
            let name = format!("seeds-run-{:032x}.log", super::process::random_id());
            let path = std::env::temp_dir().join(name);
            let options = OpenOptions::new().read(true).write(true).create_new(true).open(&path)?;
            // Without a name it is gone with this process, however that ends.
            let _ = std::fs::remove_file(&path);
            self.file = Some(options);
        }
        let Some(file) = &mut self.file else { return Ok(()) };
        file.seek(SeekFrom::Start(self.end))?;
        file.write_all(octets)
    }

    /// A page of the log of a run.
    pub fn page(&mut self, run: u32, page: u64) -> LogPage {
        if !self.lost.is_empty() {
            return LogPage { lost: self.lost.clone(), ..LogPage::default() };
        }
        if run != self.run {
            return LogPage::default();
        }
        let Some(&(begin, length)) = self.pages.get(page as usize) else {
            let last = page == self.pages.len() as u64;
            let records = if last { self.open.clone() } else { Vec::new() };
            return LogPage { records, ..LogPage::default() };
        };
        match self.read(begin, length) {
            Ok(records) => LogPage { records, more: true, ..LogPage::default() },
            Err(e) => LogPage {
                lost: format!("page {page} of the log of the run cannot be read: {e}"),
                ..LogPage::default()
            },
        }
    }

    fn read(&mut self, begin: u64, length: usize) -> Result<Vec<Vec<u8>>, String> {
        let file = self.file.as_mut().ok_or("it has no file")?;
        let mut octets = vec![0; length];
        file.seek(SeekFrom::Start(begin)).map_err(|e| e.to_string())?;
        file.read_exact(&mut octets).map_err(|e| e.to_string())?;
        decode(&octets).map_err(|e| e.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(frame: u64) -> LogRecord {
        let octets = vec![frame as u8; 1_000];
        LogRecord::Whole { name: "visitors".into(), pdus: vec![(frame, octets)] }
    }

    fn read(log: &mut RunLog, run: u32) -> (Vec<LogRecord>, u64) {
        let (mut all, mut page) = (Vec::new(), 0);
        loop {
            let told = log.page(run, page);
            assert_eq!(told.lost, "");
            all.extend(told.records.iter().map(|r| decode::<LogRecord>(r).expect("a record")));
            page += 1;
            if !told.more {
                return (all, page);
            }
        }
    }

    #[test]
    fn a_log_of_many_pages_is_read_as_it_was_written_and_one_page_of_it_is_in_memory() {
        let mut log = RunLog::default();
        let written: Vec<_> = (0..3_000).map(record).collect();
        written.iter().for_each(|r| log.append(1, r));
        let (all, pages) = read(&mut log, 1);
        assert!(all == written, "{} records of {}", all.len(), written.len());
        assert!(pages > 10 && log.octets <= PAGE_OCTETS, "{pages} pages, {} octets", log.octets);
        assert_eq!(read(&mut log, 2).0, []);
        // What is read in between disturbs nothing that is written.
        log.append(1, &record(3_000));
        assert_eq!(read(&mut log, 1).0.len(), 3_001);
        log.append(2, &record(7));
        assert_eq!(read(&mut log, 2).0, [record(7)]);
    }

    #[test]
    fn a_log_without_a_disk_says_so_and_keeps_nothing() {
        let lost = "no room".to_owned();
        let mut log = RunLog { run: 1, lost: lost.clone(), ..RunLog::default() };
        (0..3_000).for_each(|frame| log.append(1, &record(frame)));
        assert_eq!(log.page(1, 0), LogPage { lost, ..LogPage::default() });
        assert!(log.octets <= PAGE_OCTETS && log.pages.is_empty());
    }
}
