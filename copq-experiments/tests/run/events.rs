//! TensorBoard's event files, read back.

use std::path::Path;

use prost::Message;

/// `tensorflow.Event`, as far as tests look at it.
#[derive(Clone, PartialEq, Message)]
pub struct Event {
    #[prost(int64, tag = "2")]
    pub step: i64,
    #[prost(message, optional, tag = "5")]
    summary: Option<Summary>,
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
    value: f32,
}

/// Every event, each between checksums that are right.
pub fn read(path: &Path) -> Vec<Event> {
    let bytes = std::fs::read(path).unwrap();
    let mut events = Vec::new();
    let mut rest = bytes.as_slice();
    while let Some((length, _)) = rest.split_first_chunk::<8>() {
        let (record, after) = rest.split_at(16 + u64::from_le_bytes(*length) as usize);
        let (head, body) = record.split_at(12);
        let (content, end) = body.split_at(body.len() - 4);
        assert_eq!([&head[8..], end], [checksum(length), checksum(content)]);
        events.push(Event::decode(content).unwrap());
        rest = after;
    }
    assert!(rest.is_empty());
    events
}

/// TensorFlow's: CRC-32C, rotated and shifted.
fn checksum(bytes: &[u8]) -> [u8; 4] {
    crc32c::crc32c(bytes).rotate_right(15).wrapping_add(0xa282_ead8).to_le_bytes()
}

/// Every scalar, as (step, tag, value).
pub fn scalars(path: &Path) -> Vec<(u64, String, f32)> {
    let mut scalars = Vec::new();
    for Event { step, summary } in read(path) {
        let values = summary.unwrap_or_default().values;
        scalars.extend(values.into_iter().map(|scalar| (step as u64, scalar.tag, scalar.value)));
    }
    scalars
}
