//! Exact derivatives of one block by dual numbers, a few directions at a time.
//!
//! A block has up to some thirty variables, too many for one dual number to
//! carry all second derivatives in registers. Directions are taken `WIDTH` at a
//! time; the Hessian is filled tile by tile above the diagonal.
//!
//! Seeds are the variables' scales, so derivatives come out with respect to
//! the scaled variables.

use crate::Programme;
use nalgebra::{SMatrix, SVector};
use num_dual::{Derivative, DualSVec64, HyperDualSVec64};

/// Directions carried by one dual number.
const WIDTH: usize = 8;

type First = DualSVec64<WIDTH>;
type Second = HyperDualSVec64<WIDTH, WIDTH>;

/// Value and first derivatives of a block, reused from call to call.
#[derive(Default)]
pub(crate) struct BlockFirst {
    /// Cost share.
    pub cost: f64,
    /// Gradient of the cost share with respect to the scaled variables.
    pub gradient: Vec<f64>,
    /// Row values.
    pub rows: Vec<f64>,
    /// Row-major Jacobian with respect to the scaled variables.
    pub jacobian: Vec<f64>,
}

/// Scratch space of evaluations, one set a scalar type.
#[derive(Default)]
pub(crate) struct Scratch {
    first_x: Vec<First>,
    first_rows: Vec<First>,
    second_x: Vec<Second>,
    second_rows: Vec<Second>,
}

/// Values of one block: adds to nothing, returns the cost share.
pub(crate) fn values<P: Programme>(
    programme: &P,
    block: usize,
    x: &[f64],
    rows: &mut [f64],
) -> f64 {
    rows.fill(0.0);
    let mut cost = 0.0;
    programme.evaluate(block, x, &mut cost, rows);
    cost
}

/// Values and first derivatives of one block at the physical point `x`.
pub(crate) fn first<P: Programme>(
    programme: &P,
    block: usize,
    x: &[f64],
    seeds: &[f64],
    rows: usize,
    scratch: &mut Scratch,
    out: &mut BlockFirst,
) {
    let n = x.len();
    out.gradient.clear();
    out.gradient.resize(n, 0.0);
    out.rows.clear();
    out.rows.resize(rows, 0.0);
    out.jacobian.clear();
    out.jacobian.resize(rows * n, 0.0);
    for tile in (0..n).step_by(WIDTH) {
        let end = (tile + WIDTH).min(n);
        scratch.first_x.clear();
        scratch
            .first_x
            .extend(x.iter().enumerate().map(|(k, &value)| {
                if (tile..end).contains(&k) {
                    First::new(value, Derivative::some(unit(k - tile, seeds[k])))
                } else {
                    First::from_re(value)
                }
            }));
        scratch.first_rows.clear();
        scratch.first_rows.resize(rows, First::from_re(0.0));
        let mut cost = First::from_re(0.0);
        programme.evaluate(block, &scratch.first_x, &mut cost, &mut scratch.first_rows);
        out.cost = cost.re;
        if let Some(eps) = cost.eps.0 {
            out.gradient[tile..end].copy_from_slice(&eps.as_slice()[..end - tile]);
        }
        for (r, row) in scratch.first_rows.iter().enumerate() {
            out.rows[r] = row.re;
            if let Some(eps) = row.eps.0 {
                out.jacobian[r * n + tile..r * n + end]
                    .copy_from_slice(&eps.as_slice()[..end - tile]);
            }
        }
    }
}

/// Adds the Hessian of `weight·f_b + Σ_r weights[r]·c_b,r` to `hessian`
/// (row-major n×n, both triangles), with respect to the scaled variables.
#[allow(clippy::too_many_arguments)]
pub(crate) fn second<P: Programme>(
    programme: &P,
    block: usize,
    x: &[f64],
    seeds: &[f64],
    weight: f64,
    weights: &[f64],
    scratch: &mut Scratch,
    hessian: &mut [f64],
) {
    let n = x.len();
    for tile1 in (0..n).step_by(WIDTH) {
        for tile2 in (tile1..n).step_by(WIDTH) {
            let end1 = (tile1 + WIDTH).min(n);
            let end2 = (tile2 + WIDTH).min(n);
            scratch.second_x.clear();
            scratch
                .second_x
                .extend(x.iter().enumerate().map(|(k, &value)| {
                    let mut v = Second::from_re(value);
                    if (tile1..end1).contains(&k) {
                        v.eps1 = Derivative::some(unit(k - tile1, seeds[k]));
                    }
                    if (tile2..end2).contains(&k) {
                        v.eps2 = Derivative::some(unit(k - tile2, seeds[k]).transpose());
                    }
                    v
                }));
            scratch.second_rows.clear();
            scratch
                .second_rows
                .resize(weights.len(), Second::from_re(0.0));
            let mut cost = Second::from_re(0.0);
            programme.evaluate(
                block,
                &scratch.second_x,
                &mut cost,
                &mut scratch.second_rows,
            );
            let mut tile = SMatrix::<f64, WIDTH, WIDTH>::zeros();
            if let Some(eps) = cost.eps1eps2.0 {
                tile += eps * weight;
            }
            for (row, &w) in scratch.second_rows.iter().zip(weights) {
                if let Some(eps) = row.eps1eps2.0
                    && w != 0.0
                {
                    tile += eps * w;
                }
            }
            for i in tile1..end1 {
                for j in tile2..end2 {
                    let value = tile[(i - tile1, j - tile2)];
                    hessian[i * n + j] += value;
                    if tile1 != tile2 {
                        hessian[j * n + i] += value;
                    }
                }
            }
        }
    }
}

fn unit(index: usize, size: f64) -> SVector<f64, WIDTH> {
    let mut v = SVector::zeros();
    v[index] = size;
    v
}
