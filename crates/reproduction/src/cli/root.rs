//! Where the repository is: its data are read when the program runs, so that a changed number needs no build.

use std::path::{Path, PathBuf};

use super::Failure;

/// File that marks the repository.
const MARK: &str = "data/published.toml";

/// The repository: the nearest folder above the present one that has the published numbers, else the one that the
/// program was built from.
pub(super) fn root() -> Result<PathBuf, Failure> {
    let here = std::env::current_dir().unwrap_or_default();
    let built = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    here.ancestors()
        .chain(std::iter::once(built.as_path()))
        .find(|folder| folder.join(MARK).is_file())
        .map(Path::to_owned)
        .ok_or_else(|| Failure::Input(format!("{MARK} is neither here nor in a folder above")))
}

/// Default folders of results lie in the repository, wherever the command is called; a folder that the user names lies
/// where the user stands.
pub(super) fn out(root: &Path, named: &Path) -> PathBuf {
    if named == Path::new("target/reproduction") {
        root.join(named)
    } else {
        named.to_owned()
    }
}
