//! One file a law: its parameters and how they make a [`crate::Law`].

pub(crate) mod asymmetric_bristle;
pub(crate) mod coulomb_viscous;
pub(crate) mod dahl;
pub(crate) mod lugre;
pub(crate) mod lugre_tyre;
pub mod paper_form;
pub(crate) mod stribeck;
pub(crate) mod symmetric_bristle;
