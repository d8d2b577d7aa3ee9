//! PBF by hand: what no program writes.

// Each test program uses a part of it.
#![allow(dead_code)]
#![allow(unreachable_pub)]

/// A number in base 128, as protocol buffers have it.
pub fn varint(mut value: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    while value >= 128 {
        bytes.push(value as u8 | 128);
        value >>= 7;
    }
    bytes.push(value as u8);
    bytes
}

/// A field of bytes with its number.
pub fn field(number: u8, body: &[u8]) -> Vec<u8> {
    [vec![number << 3 | 2], varint(body.len() as u64), body.to_vec()].concat()
}

/// A field that is a number, with its own number of any size.
pub fn number_field(number: u64, value: u64) -> Vec<u8> {
    [varint(number << 3), varint(value)].concat()
}

/// Numbers with their sign in the lowest bit, one after the other.
pub fn packed(values: &[i64]) -> Vec<u8> {
    values.iter().flat_map(|value| varint(((value << 1) ^ (value >> 63)) as u64)).collect()
}

/// A blob's message with its header.
pub fn blob(kind: &str, blob: &[u8]) -> Vec<u8> {
    let header = [field(1, kind.as_bytes()), vec![3 << 3], varint(blob.len() as u64)].concat();
    [&(header.len() as u32).to_be_bytes(), header.as_slice(), blob].concat()
}

/// A map of one block, which is not packed.
pub fn map_of(block: &[u8]) -> Vec<u8> {
    [blob("OSMHeader", &field(1, &[])), blob("OSMData", &field(1, block))].concat()
}
