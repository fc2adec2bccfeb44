//! Hidden-effect cases: how large an effect must be to be found at all, what a protocol can tell apart, and how an
//! answer is judged.

pub mod ask;
pub mod carry_out;
pub mod judge;
pub mod oracle;
pub mod selection;
pub mod tally;
