//! The measurement chain as a diagram: stations from the stage to the recorded number, and the suspects at each.

use serde::{Deserialize, Serialize};

use crate::Prose;

/// What is known of a suspect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SuspectState {
    /// Named as a cause.
    Found,
    /// Fits as well as a named cause.
    Equivalent,
    /// Tested and not needed.
    RuledOut,
    /// This campaign cannot tell.
    Undecidable,
    /// Not tested.
    NotTested,
}

impl SuspectState {
    /// The words shown.
    pub fn words(self) -> &'static str {
        match self {
            Self::Found => "found",
            Self::Equivalent => "fits as well",
            Self::RuledOut => "not needed",
            Self::Undecidable => "cannot be told",
            Self::NotTested => "not tested",
        }
    }

    /// A sign that tells the states apart without colour.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Found => "●",
            Self::Equivalent => "◐",
            Self::RuledOut => "○",
            Self::Undecidable => "?",
            Self::NotTested => "–",
        }
    }
}

/// One thing that can be wrong at a station.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Suspect {
    /// Its id, such as `sensor-lag`.
    pub label: String,
    /// What is known of it.
    pub state: SuspectState,
    /// A few words: probability, gain, or why not.
    pub note: String,
}

/// One station of the chain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Station {
    /// Its name.
    pub name: String,
    /// What happens there.
    pub role: String,
    /// What can be wrong there; found ones are drawn first.
    pub suspects: Vec<Suspect>,
}

/// The whole chain, in the order in which truth travels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Chain {
    /// Id, unique on the page.
    pub id: String,
    /// What the diagram shows.
    pub caption: Prose,
    /// The stations.
    pub stations: Vec<Station>,
}
