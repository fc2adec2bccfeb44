//! The model file `bristle/model/1`: a law's parameters with their uncertainty, and the extension that a diagnosis found.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use friction::LawKind;
use serde::{Deserialize, Serialize};

use crate::Cause;

/// A cause with its fitted parameters.
pub type Extension = (Box<dyn Cause>, Vec<f64>);

/// What stands under `schema`.
pub const SCHEMA: &str = "bristle/model/1";

/// Why a model file was refused. Every message names the file or the entry at fault.
#[derive(Debug, thiserror::Error)]
pub enum ModelFileError {
    /// It cannot be read.
    #[error("{path}: cannot be read: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// It cannot be written.
    #[error("{path}: cannot be written: {source}")]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// It is not JSON of this shape.
    #[error("{path}: not a model file: {message}")]
    Shape {
        /// The file.
        path: PathBuf,
        /// Line, column and what was expected.
        message: String,
    },
    /// Its content makes no sense.
    #[error("{path}: {message}")]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        message: String,
    },
}

/// A value with its name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ParameterEntry {
    /// Name.
    pub name: String,
    /// Value.
    pub value: f64,
    /// Unit.
    pub unit: String,
    /// Standard deviation, where it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sd: Option<f64>,
}

/// A cause with its parameters, under the catalogue's names.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExtensionEntry {
    /// Id of the cause.
    pub cause: String,
    /// Its parameters.
    pub parameters: Vec<ParameterEntry>,
}

/// A model file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelFile {
    /// [`SCHEMA`].
    pub schema: String,
    /// Id of the law.
    pub law: String,
    /// Speeds that the data covered, m/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub valid_speed_m_s: Option<[f64; 2]>,
    /// The law's parameters.
    pub parameters: Vec<ParameterEntry>,
    /// Covariance of the parameters, in their order.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub covariance: Option<Vec<Vec<f64>>>,
    /// Effects that extend the law.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub extension: Vec<ExtensionEntry>,
}

impl ModelFile {
    /// A model file without covariance and extension.
    pub fn new(law: LawKind, values: &[f64], sd: Option<&[f64]>) -> Self {
        let parameters = law
            .parameters()
            .iter()
            .enumerate()
            .map(|(i, spec)| ParameterEntry {
                name: spec.name.to_string(),
                value: values[i],
                unit: spec.unit.to_string(),
                sd: sd.map(|sd| sd[i]),
            })
            .collect();
        Self {
            schema: SCHEMA.to_owned(),
            law: law.id().to_owned(),
            valid_speed_m_s: None,
            parameters,
            covariance: None,
            extension: Vec::new(),
        }
    }

    /// Reads and checks a model file.
    ///
    /// # Errors
    /// See [`ModelFileError`]; never a panic, whatever the file holds.
    pub fn load(path: &Path) -> Result<Self, ModelFileError> {
        let text = std::fs::read_to_string(path).map_err(|source| ModelFileError::Read {
            path: path.to_owned(),
            source,
        })?;
        let file: Self = serde_json::from_str(&text).map_err(|e| ModelFileError::Shape {
            path: path.to_owned(),
            message: e.to_string(),
        })?;
        file.validate().map_err(|message| ModelFileError::Content {
            path: path.to_owned(),
            message,
        })?;
        Ok(file)
    }

    /// Writes the file whole or not at all.
    ///
    /// # Errors
    /// [`ModelFileError::Write`].
    pub fn save(&self, path: &Path) -> Result<(), ModelFileError> {
        let failed = |source| ModelFileError::Write {
            path: path.to_owned(),
            source,
        };
        let mut text = serde_json::to_string_pretty(self).map_err(|e| failed(e.into()))?;
        text.push('\n');
        campaign::write_atomically(path, text.as_bytes()).map_err(|error| failed(error.source))
    }

    /// The law.
    ///
    /// # Errors
    /// An unknown name.
    pub fn law_kind(&self) -> Result<LawKind, String> {
        LawKind::from_id(&self.law).map_err(|e| e.to_string())
    }

    /// The law's parameters in the law's order, by name.
    ///
    /// # Errors
    /// A name that is unknown, missing or doubled.
    pub fn law_values(&self) -> Result<Vec<f64>, String> {
        let law = self.law_kind()?;
        let specs = law.parameters();
        for (i, entry) in self.parameters.iter().enumerate() {
            if !specs.iter().any(|spec| spec.name == entry.name) {
                let names: Vec<&str> = specs.iter().map(|s| s.name.as_ref()).collect();
                return Err(format!(
                    "law {} has no parameter `{}`; it has {}",
                    law.id(),
                    entry.name,
                    names.join(", ")
                ));
            }
            if self.parameters[..i]
                .iter()
                .any(|other| other.name == entry.name)
            {
                return Err(format!("parameter `{}` stands twice", entry.name));
            }
        }
        specs
            .iter()
            .map(|spec| {
                self.parameters
                    .iter()
                    .find(|entry| entry.name == spec.name)
                    .map(|entry| entry.value)
                    .ok_or_else(|| format!("law {} needs parameter `{}`", law.id(), spec.name))
            })
            .collect()
    }

    /// Covariance in the law's order; zeros off the diagonal and `sd` on it where only standard deviations are given;
    /// `None` where neither is.
    ///
    /// # Errors
    /// As [`ModelFile::law_values`].
    pub fn law_covariance(&self) -> Result<Option<Vec<Vec<f64>>>, String> {
        self.law_values()?;
        let law = self.law_kind()?;
        let place: Vec<usize> = law
            .parameters()
            .iter()
            .filter_map(|spec| {
                self.parameters
                    .iter()
                    .position(|entry| entry.name == spec.name)
            })
            .collect();
        let n = place.len();
        if let Some(covariance) = &self.covariance {
            let entry = |i: usize, j: usize| covariance[place[i]][place[j]];
            return Ok(Some(
                (0..n)
                    .map(|i| (0..n).map(|j| entry(i, j)).collect())
                    .collect(),
            ));
        }
        let sd: Option<Vec<f64>> = place.iter().map(|&i| self.parameters[i].sd).collect();
        Ok(sd.map(|sd| {
            (0..n)
                .map(|i| {
                    (0..n)
                        .map(|j| if i == j { sd[i] * sd[i] } else { 0.0 })
                        .collect()
                })
                .collect()
        }))
    }

    /// The extension's causes with their fitted parameters, found in a catalogue.
    ///
    /// # Errors
    /// A cause that the catalogue does not have (the nearest ids are for the caller to suggest), one that cannot act on
    /// the law, one that stands twice, parameters that are missing, unknown, not finite or out of bounds.
    pub fn extension_from(&self, catalogue: &[Box<dyn Cause>]) -> Result<Vec<Extension>, String> {
        let law = self.law_kind()?;
        let mut found: Vec<Extension> = Vec::new();
        for entry in &self.extension {
            let forms: Vec<&dyn Cause> = catalogue
                .iter()
                .map(AsRef::as_ref)
                .filter(|cause| cause.id() == entry.cause)
                .collect();
            if forms.is_empty() {
                return Err(format!("extension: unknown cause `{}`", entry.cause));
            }
            let mut values = BTreeMap::new();
            for parameter in &entry.parameters {
                if values
                    .insert(parameter.name.clone(), parameter.value)
                    .is_some()
                {
                    return Err(format!(
                        "extension: {}: parameter `{}` stands twice",
                        entry.cause, parameter.name
                    ));
                }
            }
            let (cause, fitted) = pick_form(&forms, &values)
                .map_err(|m| format!("extension: {}: {m}", entry.cause))?;
            if !cause.applies_to(law) {
                return Err(format!(
                    "extension: cause `{}` cannot act on law {}",
                    entry.cause,
                    law.id()
                ));
            }
            if found
                .iter()
                .any(|(other, _)| other.id() == cause.id() && other.variant() == cause.variant())
            {
                return Err(format!("extension: cause `{}` stands twice", entry.cause));
            }
            for (spec, value) in cause.parameters().iter().zip(&fitted) {
                if !spec.admits(*value) {
                    return Err(format!(
                        "extension: {}: {} = {value} is outside [{}, {}]",
                        entry.cause, spec.name, spec.lower, spec.upper
                    ));
                }
            }
            found.push((cause.boxed(), fitted));
        }
        Ok(found)
    }

    /// An extension's entry for a cause with these fitted parameters; `covariance` is theirs.
    pub fn extension_entry(
        cause: &dyn Cause,
        fitted: &[f64],
        covariance: Option<&[Vec<f64>]>,
    ) -> ExtensionEntry {
        let parameters = cause
            .reported(fitted)
            .into_iter()
            .map(|reported| {
                let variance = covariance.map(|c| {
                    let g = &reported.gradient;
                    (0..g.len())
                        .map(|i| (0..g.len()).map(|j| g[i] * c[i][j] * g[j]).sum::<f64>())
                        .sum::<f64>()
                });
                ParameterEntry {
                    name: reported.name.to_owned(),
                    value: reported.value,
                    unit: reported.unit.to_owned(),
                    sd: variance
                        .map(|v| v.max(0.0).sqrt())
                        .filter(|sd| sd.is_finite()),
                }
            })
            .collect();
        ExtensionEntry {
            cause: cause.id().to_owned(),
            parameters,
        }
    }

    fn validate(&self) -> Result<(), String> {
        if self.schema != SCHEMA {
            return Err(format!("schema is `{}`, expected `{SCHEMA}`", self.schema));
        }
        let law = self.law_kind()?;
        let values = self.law_values()?;
        for (spec, value) in law.parameters().iter().zip(&values) {
            if !value.is_finite() {
                return Err(format!("{} = {value} is not finite", spec.name));
            }
            let positive = spec.lower > 0.0;
            if (positive && *value <= 0.0) || (spec.lower == 0.0 && *value < 0.0) {
                return Err(format!(
                    "{} = {value} must {}",
                    spec.name,
                    if positive {
                        "be positive"
                    } else {
                        "not be negative"
                    }
                ));
            }
        }
        for entry in &self.parameters {
            if entry.sd.is_some_and(|sd| !(sd.is_finite() && sd >= 0.0)) {
                return Err(format!(
                    "{}: sd must be finite and not negative",
                    entry.name
                ));
            }
        }
        if let Some([low, high]) = self.valid_speed_m_s
            && !(low.is_finite() && high.is_finite() && 0.0 <= low && low <= high)
        {
            return Err(format!(
                "valid_speed_m_s [{low}, {high}] must be two finite speeds, the smaller first"
            ));
        }
        if let Some(covariance) = &self.covariance {
            validate_covariance(covariance, self.parameters.len())?;
        }
        for entry in &self.extension {
            if entry.parameters.iter().any(|p| !p.value.is_finite()) {
                return Err(format!("extension: {}: a value is not finite", entry.cause));
            }
        }
        Ok(())
    }
}

fn validate_covariance(covariance: &[Vec<f64>], n: usize) -> Result<(), String> {
    if covariance.len() != n || covariance.iter().any(|row| row.len() != n) {
        return Err(format!(
            "covariance must have {n} rows of {n} numbers, as there are parameters"
        ));
    }
    for i in 0..n {
        for j in 0..n {
            let (a, b) = (covariance[i][j], covariance[j][i]);
            if !a.is_finite() || (a - b).abs() > 1e-9 * a.abs().max(b.abs()) {
                return Err("covariance must be finite and symmetric".to_owned());
            }
            let bound = (covariance[i][i] * covariance[j][j]).sqrt();
            if covariance[i][i] < 0.0 || a.abs() > bound * (1.0 + 1e-9) {
                return Err("covariance is not that of any distribution".to_owned());
            }
        }
    }
    Ok(())
}

/// The form of a cause whose parameters are exactly those that are given.
fn pick_form<'a>(
    forms: &[&'a dyn Cause],
    values: &BTreeMap<String, f64>,
) -> Result<(&'a dyn Cause, Vec<f64>), String> {
    let mut reason = String::new();
    for cause in forms {
        match cause.from_reported(values) {
            Ok(fitted) => {
                let names = cause.reported(&fitted);
                if let Some(extra) = values
                    .keys()
                    .find(|key| !names.iter().any(|r| r.name == key.as_str()))
                {
                    reason = format!("unknown parameter `{extra}`");
                    continue;
                }
                return Ok((*cause, fitted));
            }
            Err(missing) => reason = format!("parameter `{missing}` is missing"),
        }
    }
    Err(reason)
}
