//! Where campaigns come from: the stand-ins that are shipped, or the reader's own measurements in their place.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use campaign::{Campaign, Refusal};

/// The campaigns of one reproduction, opened once.
#[derive(Debug)]
pub struct Campaigns {
    paths: BTreeMap<String, PathBuf>,
    opened: Mutex<BTreeMap<String, Arc<Campaign>>>,
}

/// `--data` brings a folder whose name is none of the stand-ins'.
#[derive(Debug, thiserror::Error)]
pub enum DataError {
    /// The folder cannot be listed.
    #[error("{}: {source}", path.display())]
    Read {
        /// The folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A subfolder replaces nothing.
    #[error("{}: no campaign is called `{name}`; the nearest name is `{nearest}`", path.display())]
    UnknownName {
        /// The folder given with `--data`.
        path: PathBuf,
        /// Its subfolder.
        name: String,
        /// The nearest right name.
        nearest: String,
    },
    /// The folder replaces nothing at all.
    #[error("{}: holds no subfolder named as in data/campaigns ({names})", path.display())]
    Nothing {
        /// The folder given with `--data`.
        path: PathBuf,
        /// The right names.
        names: String,
    },
}

impl Campaigns {
    /// The stand-ins under `shipped`, each replaced by the subfolder of the same name under `own` where there is one.
    ///
    /// # Errors
    /// Where `own` cannot be listed, or one of its subfolders has another name.
    pub fn new(shipped: &Path, own: Option<&Path>) -> Result<Self, DataError> {
        let shipped_names = subfolders(shipped)?;
        let names = || shipped_names.iter().map(String::as_str);
        let mut paths: BTreeMap<String, PathBuf> = names()
            .map(|name| (name.to_owned(), shipped.join(name)))
            .collect();
        if let Some(own) = own {
            let own_names = subfolders(own)?;
            if own_names.is_empty() {
                return Err(DataError::Nothing {
                    path: own.to_owned(),
                    names: shipped_names.join(", "),
                });
            }
            for name in own_names {
                let place = paths.get_mut(&name).ok_or_else(|| DataError::UnknownName {
                    path: own.to_owned(),
                    nearest: crate::names::nearest(&name, names()).to_owned(),
                    name: name.clone(),
                })?;
                *place = own.join(&name);
            }
        }
        Ok(Self {
            paths,
            opened: Mutex::default(),
        })
    }

    /// Opens a campaign, or hands out the one that is open already.
    ///
    /// # Errors
    /// What the door says.
    pub fn open(&self, name: &str) -> Result<Arc<Campaign>, Refusal> {
        // A poisoned lock means that another stage panicked while opening: the map itself is whole.
        let lock = || {
            self.opened
                .lock()
                .unwrap_or_else(std::sync::PoisonError::into_inner)
        };
        if let Some(campaign) = lock().get(name) {
            return Ok(Arc::clone(campaign));
        }
        let unknown = PathBuf::from(name);
        let opened = Arc::new(campaign::open(self.paths.get(name).unwrap_or(&unknown))?);
        lock().insert(name.to_owned(), Arc::clone(&opened));
        Ok(opened)
    }
}

/// Names of the folders in a folder, sorted.
fn subfolders(path: &Path) -> Result<Vec<String>, DataError> {
    let refuse = |source| DataError::Read {
        path: path.to_owned(),
        source,
    };
    let mut names = Vec::new();
    for entry in std::fs::read_dir(path).map_err(refuse)? {
        let entry = entry.map_err(refuse)?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if entry.path().is_dir() && !name.starts_with('.') {
            names.push(name);
        }
    }
    names.sort();
    Ok(names)
}
