//! The stations of the measurement chain, in the order in which motion becomes a recorded force.

/// A station of the chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Station {
    /// The drive: which speed the plate really has.
    Stage,
    /// What holds the specimen: cord, play, moving mass.
    Coupling,
    /// The law of friction in the contact.
    Law,
    /// Where on the plate the contact is.
    Surface,
    /// What happened before: wear, heat, set, rest.
    History,
    /// The normal load and the weight along the stage.
    Load,
    /// The force and velocity channels.
    Sensor,
    /// Time stamps of the channels.
    Clock,
}

impl Station {
    /// All stations, in the order of the chain.
    pub const ALL: [Station; 8] = [
        Station::Stage,
        Station::Coupling,
        Station::Law,
        Station::Surface,
        Station::History,
        Station::Load,
        Station::Sensor,
        Station::Clock,
    ];

    /// Name in files and figures.
    pub const fn id(self) -> &'static str {
        match self {
            Station::Stage => "stage",
            Station::Coupling => "coupling",
            Station::Law => "law",
            Station::Surface => "surface",
            Station::History => "history",
            Station::Load => "load",
            Station::Sensor => "sensor",
            Station::Clock => "clock",
        }
    }
}
