//! TensorBoard's event files: scalars in protocol-buffer messages, each framed by its length and
//! two checksums.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use copq::{Error, Result};
use prost::Message;

use copq::files;

/// `tensorflow.Event`, as far as scalars need it.
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
    /// 1: a session starts, and what earlier files say of its step and later ones is void.
    #[prost(int32, tag = "1")]
    status: i32,
}

/// One event file of a run's folder; a resumed run begins another, as TensorBoard expects.
///
/// ```
/// # let folder = tempfile::tempdir().expect("a temporary folder");
/// # let folder = folder.path();
/// use copq_experiments::tensorboard::{EventFile, read_scalars};
///
/// let mut events = EventFile::create(folder, 0)?;
/// events.scalars(1_000, &[("q/safety".to_owned(), 0.5)])?;
/// # let entry = std::fs::read_dir(folder).expect("a folder").next().expect("a file");
/// # let path = entry.expect("a file").path();
/// assert_eq!(read_scalars(&path)?, [(1_000, "q/safety".to_owned(), 0.5)]);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Debug)]
pub struct EventFile {
    path: PathBuf,
    file: File,
}

impl EventFile {
    /// Begins a file of the steps from `first` on; TensorBoard forgets what earlier files said of
    /// them.
    pub fn create(folder: &Path, first: u64) -> Result<Self> {
        let path = unused_name(folder);
        let file = File::options().create_new(true).append(true).open(&path);
        let mut events = Self { file: file.map_err(files::failed("making", &path))?, path };
        events.write(0, What::FileVersion("brain.Event:2".to_owned()))?;
        events.write(first, What::Session(SessionLog { status: 1 }))?;
        Ok(events)
    }

    /// Writes numbers at a step; tags that share what comes before the first `/` share a section of
    /// TensorBoard's page.
    pub fn scalars(&mut self, step: u64, numbers: &[(String, f64)]) -> Result<()> {
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

/// Every scalar of an event file in order, as (step, tag, value); a torn last record is left out.
///
/// Errors: a checksum or a message that is wrong, with the file's name.
pub fn read_scalars(path: &Path) -> Result<Vec<(u64, String, f32)>> {
    let bytes = fs::read(path).map_err(files::failed("reading", path))?;
    let mut scalars = Vec::new();
    let mut rest = bytes.as_slice();
    while let Some((content, after)) = unframe(rest).map_err(files::failed("reading", path))? {
        let event = Event::decode(content)
            .map_err(|e| Error::other(format!("reading '{}'", path.display()), e))?;
        if let Some(What::Summary(summary)) = event.what {
            scalars.extend(
                summary.values.into_iter().map(|s| (event.step as u64, s.tag, s.simple_value)),
            );
        }
        rest = after;
    }
    Ok(scalars)
}

/// The first record's content and what follows it; `None` if there is no whole record.
fn unframe(bytes: &[u8]) -> io::Result<Option<(&[u8], &[u8])>> {
    let Some((length, after)) = bytes.split_first_chunk::<8>() else { return Ok(None) };
    let Some((length_crc, after)) = after.split_first_chunk::<4>() else { return Ok(None) };
    check_crc(length, *length_crc)?;
    let Some((content, after)) = after.split_at_checked(u64::from_le_bytes(*length) as usize)
    else {
        return Ok(None);
    };
    let Some((content_crc, after)) = after.split_first_chunk::<4>() else { return Ok(None) };
    check_crc(content, *content_crc)?;
    Ok(Some((content, after)))
}

fn check_crc(bytes: &[u8], crc: [u8; 4]) -> io::Result<()> {
    if masked_crc(bytes) == u32::from_le_bytes(crc) {
        Ok(())
    } else {
        Err(io::Error::other("a checksum is wrong"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scalars_come_back_and_damage_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let mut events = EventFile::create(folder.path(), 0).unwrap();
        let numbers = vec![("q/safety".to_owned(), 1.5), ("loss/critic".to_owned(), -2.0)];
        events.scalars(1_000, &numbers).unwrap();
        events.scalars(2_000, &numbers[..1]).unwrap();
        let wanted =
            [(1_000, "q/safety", 1.5), (1_000, "loss/critic", -2.0), (2_000, "q/safety", 1.5)];
        let wanted = wanted.map(|(step, tag, value)| (step, tag.to_owned(), value));
        assert_eq!(read_scalars(&events.path).unwrap(), wanted);

        let mut bytes = fs::read(&events.path).unwrap();
        fs::write(&events.path, &bytes[..bytes.len() - 1]).unwrap();
        assert_eq!(read_scalars(&events.path).unwrap(), wanted[..2]);
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        fs::write(&events.path, &bytes).unwrap();
        assert!(read_scalars(&events.path).unwrap_err().to_string().contains("checksum"));
    }

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
