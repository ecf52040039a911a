//! TensorBoard's event files: scalars in protocol-buffer messages, each framed by its length and
//! two checksums.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use copq::{Result, files};
use prost::Message;

/// `tensorflow.Event`, with the fields that scalars need.
#[derive(Clone, PartialEq, Message)]
struct Event {
    #[prost(double, tag = "1")]
    wall_time: f64,
    #[prost(int64, tag = "2")]
    step: i64,
    #[prost(oneof = "What", tags = "3, 5, 7")]
    what: Option<What>,
}

#[derive(Clone, PartialEq, prost::Oneof)]
enum What {
    #[prost(string, tag = "3")]
    FileVersion(String),
    #[prost(message, tag = "5")]
    Summary(Summary),
    #[prost(message, tag = "7")]
    Session(SessionLog),
}

#[derive(Clone, PartialEq, Message)]
struct Summary {
    #[prost(message, repeated, tag = "1")]
    values: Vec<Scalar>,
}

#[derive(Clone, PartialEq, Message)]
struct Scalar {
    #[prost(string, tag = "1")]
    tag: String,
    #[prost(float, tag = "2")]
    simple_value: f32,
}

#[derive(Clone, PartialEq, Message)]
struct SessionLog {
    /// 1: a session starts, and what earlier files say about its step and later ones is void.
    #[prost(int32, tag = "1")]
    status: i32,
}

/// One event file of a run's folder; a resumed run begins another, as TensorBoard expects.
#[derive(Debug)]
pub(crate) struct EventFile {
    path: PathBuf,
    file: File,
}

impl EventFile {
    /// Begins a file for the steps from `first` on; TensorBoard forgets what earlier files said
    /// about them.
    pub(crate) fn create(folder: &Path, first: u64) -> Result<Self> {
        let path = unused_name(folder);
        let file = File::options().create_new(true).append(true).open(&path);
        let mut events = Self { file: file.map_err(files::failed("making", &path))?, path };
        events.write(0, What::FileVersion("brain.Event:2".to_owned()))?;
        events.write(first, What::Session(SessionLog { status: 1 }))?;
        Ok(events)
    }

    /// Writes numbers at a step; tags that share what comes before the first `/` share a section of
    /// TensorBoard's page.
    pub(crate) fn scalars(&mut self, step: u64, numbers: &[(String, f64)]) -> Result<()> {
        let scalar = |(tag, number): &(String, f64)| Scalar {
            tag: tag.clone(),
            simple_value: *number as f32,
        };
        self.write(step, What::Summary(Summary { values: numbers.iter().map(scalar).collect() }))
    }

    fn write(&mut self, step: u64, what: What) -> Result<()> {
        let event = Event { wall_time: seconds_now(), step: step as i64, what: Some(what) };
        let record = frame(&event.encode_to_vec());
        self.file.write_all(&record).map_err(files::failed("writing", &self.path))
    }
}

fn seconds_now() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |since| since.as_secs_f64())
}

/// TensorBoard reads a folder's files in the order of their names, which begin with the time in
/// seconds; a run that is resumed within a second must still sort after the one before.
fn unused_name(folder: &Path) -> PathBuf {
    let seconds = newest_time(folder).map_or(0, |newest| newest + 1).max(seconds_now() as u64);
    folder.join(format!("events.out.tfevents.{seconds:010}.copq.{}.0", std::process::id()))
}

fn newest_time(folder: &Path) -> Option<u64> {
    let names = fs::read_dir(folder)
        .ok()?
        .flatten()
        .map(|entry| entry.file_name().to_string_lossy().into_owned());
    names
        .filter_map(|name| {
            name.strip_prefix("events.out.tfevents.")?.split('.').next()?.parse().ok()
        })
        .max()
}

/// A TFRecord: length, checksum of the length, content, checksum of the content.
fn frame(content: &[u8]) -> Vec<u8> {
    let length = (content.len() as u64).to_le_bytes();
    let mut record = Vec::with_capacity(content.len() + 16);
    record.extend(length);
    record.extend(masked_crc(&length).to_le_bytes());
    record.extend(content);
    record.extend(masked_crc(content).to_le_bytes());
    record
}

/// CRC-32C, rotated and shifted by a constant, so that a checksum of a checksum stays useful
/// (TensorFlow's `crc32c.h`).
fn masked_crc(bytes: &[u8]) -> u32 {
    crc32c::crc32c(bytes).rotate_right(15).wrapping_add(0xa282_ead8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_crc_32c_rotated_and_shifted() {
        // The check value of CRC-32C's catalogue entry.
        assert_eq!(crc32c::crc32c(b"123456789"), 0xe306_9283);
        assert_eq!(
            masked_crc(b"123456789"),
            0xe306_9283u32.rotate_right(15).wrapping_add(0xa282_ead8)
        );
    }

    #[test]
    fn a_second_file_sorts_after_the_first() {
        let folder = tempfile::tempdir().unwrap();
        let first = EventFile::create(folder.path(), 0).unwrap();
        let second = EventFile::create(folder.path(), 5).unwrap();
        assert!(second.path > first.path);
    }
}
