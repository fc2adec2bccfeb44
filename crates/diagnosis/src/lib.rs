//! What a simulation gets wrong in a campaign, why, and what an extended model gains.

pub mod causes;
