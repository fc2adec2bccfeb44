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

/// What a further form of any kind shares with its plain one.
macro_rules! form_of {
    ($plain:ident, $variant:expr) => {
        $crate::causes::marker::form_of!($plain, $variant, $plain.reach());
    };
    ($plain:ident, $variant:expr, $reach:expr) => {
        fn id(&self) -> &'static str {
            $plain.id()
        }

        fn variant(&self) -> Option<&'static str> {
            Some($variant)
        }

        fn station(&self) -> rig::Station {
            $plain.station()
        }

        fn reach(&self) -> rig::Reach {
            $reach
        }

        fn describe(&self) -> &'static str {
            $plain.describe()
        }
    };
}
pub(super) use form_of;

/// What a form shares with its plain one that is asked only in another's place, and has these parameters: those of the plain one come first.
macro_rules! refining_form {
    ($plain:ident, $variant:expr, [$($parameter:expr),+]) => {
        $crate::causes::marker::form_of!($plain, $variant);

        fn rank(&self) -> u8 {
            $plain.rank()
        }

        fn parameters(&self) -> &'static [friction::ParameterSpec] {
            const ALL: &[friction::ParameterSpec] = &[$($parameter),+];
            ALL
        }

        fn requirements(&self) -> &'static [rig::Requirement] {
            $plain.requirements()
        }

        fn refines(&self) -> bool {
            true
        }
    };
}
pub(super) use refining_form;

/// What a marked form shares with its plain one: everything but the variant, what a campaign must have, where a scan looks, and the hook.
macro_rules! marked_form {
    ($plain:ident, $variant:literal, $marker:ident) => {
        $crate::causes::marker::form_of!($plain, $variant);

        fn parameters(&self) -> &'static [friction::ParameterSpec] {
            $plain.parameters()
        }

        fn parameters_for(&self, experiment: &rig::Experiment) -> Vec<friction::ParameterSpec> {
            $plain.parameters_for(experiment)
        }

        fn applies_to(&self, law: friction::LawKind) -> bool {
            $plain.applies_to(law)
        }

        fn memory(&self) -> usize {
            $plain.memory()
        }

        fn reported(&self, fitted: &[f64]) -> Vec<rig::Reported> {
            $crate::causes::marker::marked($plain.reported(fitted), $marker)
        }

        fn from_reported(
            &self,
            reported: &std::collections::BTreeMap<String, f64>,
        ) -> Result<Vec<f64>, String> {
            $crate::causes::marker::demanded(reported, $marker)?;
            $plain.from_reported(reported)
        }
    };
}
pub(super) use marked_form;
