//! Which diagnosis was judged: a fingerprint of the sources that make an answer.

use std::path::{Path, PathBuf};

/// Crates whose sources can change an answer.
const CRATES: [&str; 5] = ["campaign", "friction", "rig", "fitting", "diagnosis"];

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    let Ok(listing) = std::fs::read_dir(folder) else {
        return;
    };
    for entry in listing.flatten() {
        let path = entry.path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|end| end == "rs") {
            found.push(path);
        }
    }
}

/// Sixteen hexadecimal digits that change with any source file below the crates of the diagnosis (FNV-1a, 64 bits).
pub fn of_diagnosis() -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates");
    let mut files = Vec::new();
    for name in CRATES {
        sources(&root.join(name).join("src"), &mut files);
    }
    files.sort();
    let mut hash: u64 = 0xcbf2_9ce4_8422_2325;
    for file in files {
        for byte in std::fs::read(&file).unwrap_or_default() {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
    format!("{hash:016x}")
}
