//! LuGre in its tyre form (Canudas de Wit, Tsiotras, Velenis, Basset, Gissinger, Vehicle System Dynamics 39, 2003):
//! a coefficient instead of a force, with g = mu_c + (mu_s - mu_c) exp(-sqrt(abs(v)/v_s)). The term of a rolling
//! contact patch is absent: a brush does not roll.

use super::lugre;
use crate::{Exponent, Law, LawKind, ParameterSpec, Scalar};

pub(crate) const PARAMETERS: &[ParameterSpec] = lugre::PARAMETERS;

pub(crate) fn build<D: Scalar>(p: &[D]) -> Law<D> {
    let mut law = lugre::build(p).with_exponent(Exponent::Half);
    law.kind = LawKind::LugreTyre;
    law
}
