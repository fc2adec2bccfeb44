//! A campaign without the noise of the channels that a prediction is made from.

use std::borrow::Cow;

use campaign::Campaign;

use crate::load_noise::LoadNoise;
use crate::{load_noise, velocity_noise};

/// What was taken from the recorded channels as their noise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChannelNoise {
    /// Of the loads; `None` where none is recorded, or without noise.
    pub load: Option<LoadNoise>,
    /// Standard deviation of the velocities' noise, m/s; `None` where they have none.
    pub velocity_m_s: Option<f64>,
}

/// The campaign as predictions take it, and what was taken from it.
pub(crate) fn without_noise(campaign: &Campaign) -> (Cow<'_, Campaign>, ChannelNoise) {
    let mut clean = Cow::Borrowed(campaign);
    let mut noise = ChannelNoise::default();
    if let Some((loads, taken)) = load_noise::without_noise(campaign) {
        noise.load = Some(taken);
        for (run, load) in clean.to_mut().runs.iter_mut().zip(loads) {
            if load.is_some() {
                run.normal_force_n = load;
            }
        }
    }
    if let Some((velocities, sd_m_s)) = velocity_noise::without_noise(campaign) {
        noise.velocity_m_s = Some(sd_m_s);
        for (run, velocity) in clean.to_mut().runs.iter_mut().zip(velocities) {
            run.velocity_m_s = velocity;
        }
    }
    (clean, noise)
}
