//! The family of ways to read the envelope computation: its multiverse.
//!
//! The paper prints three gains and neither the equation's terms nor the model's
//! details. Every combination of the open choices is one reading; the natural one has no free
//! parameter, the others show how far the choices move the gains.

use super::{Body, EnvelopeError, Gain, Hip, Posture, Variant, gain};
use crate::contact::Brush;
use crate::parameters::Biped;
use serde::{Deserialize, Serialize};

/// How the table's inertias and mass centres are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum LinkReading {
    /// As printed.
    AsPrinted,
    /// Inertias about the upper joint instead of the mass centre.
    AboutTheJoint,
    /// Mass centres in the middle of the links.
    CentresInTheMiddle,
    /// Thin rods: inertia m L^2/12 about a centre in the middle.
    ThinRods,
}

impl LinkReading {
    /// All readings.
    pub const ALL: [LinkReading; 4] = [
        LinkReading::AsPrinted,
        LinkReading::AboutTheJoint,
        LinkReading::CentresInTheMiddle,
        LinkReading::ThinRods,
    ];

    /// The biped under this reading.
    pub fn apply(self, biped: &Biped) -> Biped {
        let mut read = *biped;
        for link in [&mut read.thigh, &mut read.shank] {
            let middle = 0.5 * link.length_m;
            match self {
                LinkReading::AsPrinted => {}
                LinkReading::AboutTheJoint => {
                    // Parallel axes: I_centre = I_joint - m l^2.
                    link.inertia_kg_m2 -= link.mass_kg * link.centre_m * link.centre_m;
                }
                LinkReading::CentresInTheMiddle => link.centre_m = middle,
                LinkReading::ThinRods => {
                    link.centre_m = middle;
                    link.inertia_kg_m2 = link.mass_kg * link.length_m * link.length_m / 12.0;
                }
            }
        }
        read
    }
}

/// One reading of the envelope and its gains in the postures asked for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// Bodies, hip and weight.
    pub variant: Variant,
    /// Links.
    pub links: LinkReading,
    /// One gain a posture.
    pub gains: Vec<Gain>,
}

/// Every reading of the family, the natural one first, in a fixed order.
///
/// A reading whose posture is singular would be an error; with the leg bent none is.
///
/// # Errors
/// Those of [`super::ForceMap::new`].
pub fn readings(
    biped: &Biped,
    postures: &[Posture],
    brush: Brush,
) -> Result<Vec<Reading>, EnvelopeError> {
    let mut readings = Vec::new();
    for body in [
        Body::FloatingOneLeg,
        Body::FixedTorso,
        Body::OtherLegLimp,
        Body::OtherLegDriven,
    ] {
        for hip in [Hip::Centre, Hip::FrontEnd, Hip::RearEnd] {
            for weight in [true, false] {
                for links in LinkReading::ALL {
                    let variant = Variant { body, hip, weight };
                    let read = links.apply(biped);
                    let gains = postures
                        .iter()
                        .map(|&posture| gain(&read, variant, posture, brush))
                        .collect::<Result<_, _>>()?;
                    readings.push(Reading {
                        variant,
                        links,
                        gains,
                    });
                }
            }
        }
    }
    Ok(readings)
}
