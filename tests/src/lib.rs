//! Tests that drive the program as a user does; the judge of its diagnoses.
//!
//! The judge knows both sides: it lets `planting` hide effects, lets `diagnosis` answer from the written package
//! alone, and compares. Neither of the two knows the other.

pub mod hidden;
pub mod identity;
pub mod measured;
pub mod proportion;
