//! GLB files made by hand.

use serde_json::Value;

/// A GLB of a document and its binary chunk.
pub fn glb(document: &Value, chunk: &[u8]) -> Vec<u8> {
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((28 + json.len() as u32 + chunk.len() as u32).to_le_bytes());
    bytes.extend((json.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(&json);
    bytes.extend((chunk.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(chunk);
    bytes
}

/// The document of a GLB and its binary chunk.
pub fn parts(glb: &[u8]) -> (Value, &[u8]) {
    let json_end = 20 + u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    (serde_json::from_slice(&glb[20..json_end]).unwrap(), &glb[json_end + 8..])
}
