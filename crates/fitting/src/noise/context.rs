//! What the noise model must know of each sample, and the sizes of its parts.

use std::ops::Range;
use std::sync::Arc;

use super::averaged::Averaged;
use super::channel::{Channel, Undone};

/// Plain numbers a sample, stacked run after run.
#[derive(Clone, Debug)]
pub struct Context {
    /// Samples of each run, in order, without gaps between them.
    pub runs: Vec<Range<usize>>,
    /// Condition of each run: runs of one condition are repeats. Empty where the mean is trusted to tell conditions apart, so that what
    /// differs between them beyond it is scatter like any other.
    pub conditions: Vec<usize>,
    /// Time since the sample before, s; zero at the first sample of a run. Empty where the force channel cannot wander.
    pub steps_s: Vec<f64>,
    /// Distance slid since the start of the run, m (or rad), never decreasing within a run.
    pub sliding: Vec<f64>,
    /// Position on the plate, m (or rad).
    pub place: Vec<f64>,
    /// Signed friction force that roughness and scatter multiply, N (or N m, or 1 for mu).
    pub scale: Vec<f64>,
    /// The way from the force to the record.
    pub channel: Arc<Channel>,
    /// What each sample is the mean of; empty where each stands for itself.
    pub rows: Vec<Averaged>,
}

/// Sizes of the parts of the noise, see (N1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sizes {
    /// Standard deviation of the white sensor noise, in the unit of the data.
    pub sensor: f64,
    /// Standard deviation of the force channel's wander, in the unit of the data.
    pub wander: f64,
    /// Time over which the wander is correlated, s.
    pub wander_time_s: f64,
    /// Relative standard deviation of the roughness private to a run.
    pub private: f64,
    /// Relative standard deviation of the roughness fixed to the plate.
    pub plate: f64,
    /// Correlation length of the private roughness, m (or rad).
    pub length: f64,
    /// Length of the filter that both roughnesses have passed, as a share of their lengths: 0 is none, see [`super::Roughness`].
    pub smoothing: f64,
    /// Correlation length of the plate's roughness over that of the private one; 1 unless the record says otherwise.
    pub plate_ratio: f64,
    /// The smoothing of the plate's roughness where it has one of its own; 0: as the private one.
    pub plate_smoothing: f64,
    /// Relative standard deviation of the gain of a run.
    pub scatter: f64,
}

/// Nodes per correlation length of the plate's field, at least, where plate and private roughness are alike.
///
/// What the grid leaves between its nodes repeats with every run, but the filter along the runs takes it as private to each.
/// At wavelengths far above the spacing h its spectrum is plate^2 h^2 / (6 l); the private roughness that hides it has
/// 2 private^2 l / (1 + (2 pi l / wavelength)^2). With twelve nodes and equal sizes a line of 1.4 lengths in K runs has 1 + 0.02 K
/// times the variance that is reckoned; with four nodes it was 1 + 0.2 K, and smooth plates had false lines. White noise hides it as well:
/// over a step s between samples its spectrum is (sensor / f)^2 s.
const NODES_PER_LENGTH: f64 = 12.0;
/// Never finer than this many times the nodes of equal sizes, and never coarser than this share of them.
const FINEST: f64 = 3.0;
const COARSEST: f64 = 1.0 / 3.0;
/// White noise hides roughness as far as it is more than so many times the runs' own: where repeats pass the same places to the digit, a mark of
/// 4.2 standard deviations stood on a healthy plate with half as fine a grid, for white noise of a third of the private roughness.
const OUTWEIGHED: f64 = 3.0;
/// Spectrum of private roughness at a wavelength of 1.4 lengths, over its variance and length: 2 / (1 + (2 pi / 1.4)^2).
const AT_A_LINE: f64 = 0.094_6;

/// How densely a record is sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sampling {
    /// Way from sample to sample over which white noise hides roughness, in the mean, m (or rad); zero where a resonance amplifies what it
    /// would hide.
    step: f64,
    /// Root mean square of the force that roughness multiplies.
    force: f64,
}

impl Sizes {
    /// No noise at all.
    pub const NONE: Self = Self {
        sensor: 0.0,
        wander: 0.0,
        wander_time_s: 1.0,
        private: 0.0,
        plate: 0.0,
        length: 1.0,
        smoothing: 0.0,
        plate_ratio: 1.0,
        plate_smoothing: 0.0,
        scatter: 0.0,
    };

    /// Variance of what the force channel adds, white or wandering, in the squared unit of the data.
    pub fn of_the_channel(&self) -> f64 {
        self.sensor.powi(2) + self.wander.powi(2)
    }

    /// Correlation length of the plate's roughness, m (or rad).
    pub fn plate_length(&self) -> f64 {
        self.length * self.plate_ratio
    }

    /// Spacing of the grid that carries the plate's field, m (or rad): finer the more the plate outweighs the private roughness and the white
    /// noise, and a power of two.
    ///
    /// What lies between nodes depends on where they are. Where repeats pass the same places -2 log likelihood jumps by tens from one spacing to
    /// another a few percent finer; models whose noise differs little are on one grid this way, and the likelihood is smooth in their sizes.
    pub(super) fn node_spacing(&self, sampling: Sampling) -> f64 {
        let length = self.plate_length();
        let white = (self.sensor / sampling.force).powi(2) * sampling.step / (AT_A_LINE * length);
        let private = self.private.max(self.plate / FINEST);
        let beyond = (white - OUTWEIGHED * private.powi(2)).max(0.0);
        let hidden_by = (private.powi(2) + beyond).sqrt();
        let finer = (self.plate.max(private) / hidden_by).max(COARSEST);
        let coarsest = length / (NODES_PER_LENGTH * finer);
        coarsest.log2().floor().exp2()
    }
}

impl Context {
    /// What the record shows of a force: behind the filter of the channel.
    pub fn recorded(&self, force: &mut [f64]) {
        self.channel.lag.put_in(force);
    }

    /// How densely the record is sampled.
    pub(super) fn sampling(&self) -> Sampling {
        let n = self.samples() as f64;
        let slid =
            (self.runs.iter()).map(|run| self.sliding[run.end - 1] - self.sliding[run.start]);
        let force = (self.scale.iter().map(|f| f * f).sum::<f64>() / n).sqrt();
        Sampling {
            step: match self.channel.rings.is_empty() {
                true => slid.sum::<f64>() / n,
                false => 0.0,
            },
            force: force.max(f64::MIN_POSITIVE),
        }
    }

    /// The channel as it is undone under these sizes.
    pub(super) fn undone(&self, sizes: &Sizes) -> Undone {
        self.channel.undone(&self.sliding, sizes.length)
    }

    /// Number of samples.
    pub fn samples(&self) -> usize {
        self.scale.len()
    }

    /// Lowest and highest plate position.
    pub fn extent(&self) -> (f64, f64) {
        self.place
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), &x| {
                (lo.min(x), hi.max(x))
            })
    }

    /// Whether most runs go back and forth, so that places are passed at many speeds and times: what the law misses is then no field of
    /// the plate.
    pub fn goes_back_and_forth(&self) -> bool {
        let to_and_fro = |run: &&Range<usize>| {
            let places = &self.place[(*run).clone()];
            let lo = places.iter().copied().fold(f64::INFINITY, f64::min);
            let hi = places.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            self.sliding[run.end - 1] - self.sliding[run.start] > 1.5 * (hi - lo)
        };
        2 * self.runs.iter().filter(to_and_fro).count() > self.runs.len()
    }

    /// Share of the plate's occupied cells (a hundred of them) that at least two runs pass, or one run twice or more.
    ///
    /// Where this is zero the two roughnesses cannot be told apart.
    pub fn shared_places(&self) -> f64 {
        const CELLS: usize = 100;
        let (lo, hi) = self.extent();
        let width = (hi - lo) / CELLS as f64;
        if width.is_nan() || width <= 0.0 {
            return 0.0;
        }
        let mut passes = [0_usize; CELLS];
        for run in &self.runs {
            let mut last = usize::MAX;
            for i in run.clone() {
                let cell = (((self.place[i] - lo) / width) as usize).min(CELLS - 1);
                if cell != last {
                    passes[cell] += 1;
                    last = cell;
                }
            }
        }
        let occupied = passes.iter().filter(|&&p| p > 0).count();
        let shared = passes.iter().filter(|&&p| p > 1).count();
        shared as f64 / occupied.max(1) as f64
    }
}
