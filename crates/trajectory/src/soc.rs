//! The second-order correction of a rejected trial point.
//!
//! A step that satisfies the linearised rows misses the curved ones by O(‖d‖²),
//! which may raise the merit function however close the solution is (Maratos,
//! 1978). The correction is the shortest move that takes this off again,
//! linearised at the old point:
//!
//! ```text
//! minimise ½ ‖p‖²   subject to   J_A p = −(m(x + αd) − (1 − α) m(x))
//!
//! ⎡ I   J_Aᵀ ⎤ ⎡ p ⎤   ⎡ 0                        ⎤
//! ⎣ J_A  0   ⎦ ⎣ · ⎦ = ⎣ −m(x + αd) + (1 − α) m(x) ⎦
//! ```
//!
//! `m` is how far a row lies beyond its limit, A the equalities and the limits
//! that the full step crosses. It has no inequalities, so it is solved directly,
//! with one factorisation for all trial points of a line search. Where the rows are curved, one correction
//! leaves a part of the miss: it is repeated from the corrected point, with the same factors (the chord method), as long as
//! it contracts.

use crate::iterate::Iterate;
use crate::model::Structure;
use crate::newton::{ActiveSet, NewtonSystem};

/// The factorised correction of one line search.
pub(crate) struct Correction {
    active: ActiveSet,
}

impl Correction {
    /// Prepares corrections along a line search whose full step ends at `x`, `rows`.
    pub(crate) fn prepare(
        s: &Structure,
        newton: &mut NewtonSystem,
        at: &Iterate,
        x: &[f64],
        rows: &[f64],
    ) -> Option<Self> {
        let active = ActiveSet {
            rows: (0..s.rows())
                .map(|r| s.row_lower[r] == s.row_upper[r] || excess(s, r, rows[r]) != 0.0)
                .collect(),
            bounds: (0..s.variables())
                .map(|v| x[v] <= s.lower[v] || x[v] >= s.upper[v])
                .collect(),
        };
        let identity: Vec<f64> = s
            .hessian
            .entries()
            .map(|(_, r, c)| if r == c { 1.0 } else { 0.0 })
            .collect();
        newton.factorise(s, &identity, &at.jacobian, &active)?;
        Some(Self { active })
    }

    /// The move that corrects the trial point with these rows, `alpha` along the step.
    pub(crate) fn step(
        &self,
        s: &Structure,
        newton: &mut NewtonSystem,
        at: &Iterate,
        alpha: f64,
        rows: &[f64],
    ) -> Option<Vec<f64>> {
        let n = s.variables();
        let mut rhs = vec![0.0; n + s.rows()];
        for r in (0..s.rows()).filter(|&r| self.active.rows[r]) {
            rhs[n + r] = (1.0 - alpha) * excess(s, r, at.rows[r]) - excess(s, r, rows[r]);
        }
        let mut p = newton.solve(&rhs)?;
        p.truncate(n);
        Some(p)
    }
}

/// How far a row lies beyond its limits, with its sign.
fn excess(s: &Structure, r: usize, value: f64) -> f64 {
    value - value.max(s.row_lower[r]).min(s.row_upper[r])
}
