//! Which diagnosis was judged.

use std::path::Path;

/// The fingerprint of this checkout's diagnosis, as the report compares it.
pub fn of_diagnosis() -> String {
    reproduction::compose::diagnosis_fingerprint(&Path::new(env!("CARGO_MANIFEST_DIR")).join(".."))
}
