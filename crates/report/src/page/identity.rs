//! The identity of the results, and the hash that lets the page's own script run.

use sha2::{Digest, Sha256};

/// SHA-256 of the canonical form of a JSON value: keys sorted, no white space, numbers as serde_json writes them. The
/// key `run` at the top level, which holds what differs between two runs, is left out.
pub fn identity(results: &serde_json::Value) -> String {
    let mut text = String::new();
    canonical(results, true, &mut text);
    hex(&Sha256::digest(text.as_bytes()))
}

/// Bytes of a digest as hexadecimal digits.
pub fn hex(digest: &[u8]) -> String {
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn canonical(value: &serde_json::Value, top: bool, out: &mut String) {
    match value {
        serde_json::Value::Object(map) => {
            let mut keys: Vec<&String> = map.keys().filter(|key| !(top && *key == "run")).collect();
            keys.sort();
            out.push('{');
            for (index, key) in keys.into_iter().enumerate() {
                if index > 0 {
                    out.push(',');
                }
                out.push_str(&serde_json::Value::from(key.as_str()).to_string());
                out.push(':');
                canonical(&map[key], false, out);
            }
            out.push('}');
        }
        serde_json::Value::Array(items) => {
            out.push('[');
            for (index, item) in items.iter().enumerate() {
                if index > 0 {
                    out.push(',');
                }
                canonical(item, false, out);
            }
            out.push(']');
        }
        other => out.push_str(&other.to_string()),
    }
}

/// SHA-256 of a script in base64, as a content security policy names it.
pub(super) fn script_hash(script: &str) -> String {
    base64(&Sha256::digest(script.as_bytes()))
}

fn base64(bytes: &[u8]) -> String {
    const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::new();
    for chunk in bytes.chunks(3) {
        let three = [
            chunk[0],
            chunk.get(1).copied().unwrap_or(0),
            chunk.get(2).copied().unwrap_or(0),
        ];
        let bits = u32::from_be_bytes([0, three[0], three[1], three[2]]);
        for place in 0..4 {
            if place <= chunk.len() {
                let index = (bits >> (18 - 6 * place)) & 63;
                out.push(char::from(ALPHABET[index as usize]));
            } else {
                out.push('=');
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_rfc_4648() {
        for (plain, coded) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
    }

    #[test]
    fn order_of_keys_and_run_do_not_count() {
        let one: serde_json::Value =
            serde_json::from_str(r#"{"b":[1,2.5],"a":"x","run":{"t":1}}"#).unwrap();
        let two: serde_json::Value =
            serde_json::from_str(r#"{"a":"x","run":{"t":2},"b":[1,2.5]}"#).unwrap();
        let three: serde_json::Value = serde_json::from_str(r#"{"a":"x","b":[1,2.6]}"#).unwrap();
        assert_eq!(identity(&one), identity(&two));
        assert_ne!(identity(&one), identity(&three));
        // sha256 of {"a":"x","b":[1,2.5]}
        assert_eq!(identity(&one).len(), 64);
    }
}
