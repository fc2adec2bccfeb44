//! The number that tells a further form of a cause from its plain one in a file: it is 1, and moves with nothing.

use std::collections::BTreeMap;

use rig::Reported;

/// What the plain form reports, with the marker.
pub(super) fn marked(mut plain: Vec<Reported>, marker: &'static str) -> Vec<Reported> {
    let fitted = plain.first().map_or(0, |first| first.gradient.len());
    plain.push(Reported {
        name: marker,
        unit: "1",
        value: 1.0,
        gradient: vec![0.0; fitted],
    });
    plain
}

/// Whether a file means this form: the marker's name where it is missing.
pub(super) fn demanded(reported: &BTreeMap<String, f64>, marker: &str) -> Result<(), String> {
    reported
        .get(marker)
        .map(|_| ())
        .ok_or_else(|| marker.to_owned())
}
