//! Planar biped: rigid-body dynamics, foot contact, force envelope, the gait problem.
//!
//! Plain numbers come in (this crate reads no file), plain numbers go out (it draws nothing).
//! Every function of the mechanics is generic over the scalar, so that derivatives are exact.

pub mod contact;
pub mod dynamics;
pub mod envelope;
pub mod gait;
pub mod kinematics;
pub mod parameters;
