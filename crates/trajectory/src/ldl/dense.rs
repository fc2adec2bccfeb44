//! Dense kernels on one front, by columns, four columns of L at a time.

/// Columns of L that are taken off others at once.
const BLOCK: usize = 4;

/// Runs a kernel compiled for the vectors of the processor at hand. No product is fused with a sum and sums keep their
/// order, so every width computes the same bits. Kernels are `#[inline(always)]`, or they would be compiled for the least of processors.
#[inline(always)]
pub(super) fn wide<R>(kernel: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(kernel)
}

/// Eliminates the first `width` columns of a front with `rest` rows below them: L and D into the panel, `−L₂₁ D L₂₁ᵀ`
/// onto the remainder (lower triangle by columns). False if there is nothing below the diagonal.
#[inline(always)]
pub(super) fn eliminate(
    panel: &mut [f64],
    width: usize,
    rest: usize,
    remainder: &mut [f64],
) -> bool {
    let height = width + rest;
    let mut any = false;
    for first in (0..width).step_by(BLOCK) {
        let end = (first + BLOCK).min(width);
        // The block's own columns, one by one: c_j −= l_jk d_k l_k.
        for k in first..end {
            let (done, open) = panel.split_at_mut((k + 1) * height);
            let column = &mut done[k * height..];
            let inverse = column[k].recip();
            for j in k + 1..end {
                let target = &mut open[(j - k - 1) * height..(j - k) * height];
                axpy(&mut target[j..], column[j] * inverse, &column[j..]);
            }
            column[k + 1..].iter_mut().for_each(|l| *l *= inverse);
        }
        // All later columns, the whole block at once.
        let (done, open) = panel.split_at_mut(end * height);
        let block = &done[first * height..];
        let mut below = &mut *remainder;
        for j in end..height {
            let target = if j < width {
                &mut open[(j - end) * height + j..(j - end + 1) * height]
            } else {
                let (column, others) = below.split_at_mut(height - j);
                below = others;
                column
            };
            let mut factors = [0.0; BLOCK];
            for k in first..end {
                let column = &block[(k - first) * height..(k - first + 1) * height];
                factors[k - first] = column[j] * column[k];
            }
            if factors != [0.0; BLOCK] {
                any = true;
                take_off(target, factors, block, height, end - first);
            }
        }
    }
    any
}

/// target −= factor · source.
#[inline(always)]
fn axpy(target: &mut [f64], factor: f64, source: &[f64]) {
    for (t, s) in target.iter_mut().zip(source) {
        *t -= factor * s;
    }
}

/// target −= Σ factors[k] · (the last rows of the block's column k).
#[inline(always)]
fn take_off(target: &mut [f64], factors: [f64; BLOCK], block: &[f64], height: usize, count: usize) {
    let size = target.len();
    let column = |k: usize| &block[(k + 1) * height - size..(k + 1) * height];
    if count == BLOCK {
        let (a, b) = (&column(0)[..size], &column(1)[..size]);
        let (c, d) = (&column(2)[..size], &column(3)[..size]);
        for i in 0..size {
            target[i] -=
                factors[0] * a[i] + factors[1] * b[i] + (factors[2] * c[i] + factors[3] * d[i]);
        }
    } else {
        for k in 0..count {
            axpy(target, factors[k], column(k));
        }
    }
}

/// x ← L₁₁⁻¹ x, below ← −L₂₁ x.
#[inline(always)]
pub(super) fn forward(panel: &[f64], x: &mut [f64], below: &mut [f64]) {
    let width = x.len();
    let height = width + below.len();
    for k in 0..width {
        let column = &panel[k * height..(k + 1) * height];
        let (solved, open) = x.split_at_mut(k + 1);
        axpy(open, solved[k], &column[k + 1..width]);
    }
    for first in (0..width).step_by(BLOCK) {
        let count = BLOCK.min(width - first);
        let mut factors = [0.0; BLOCK];
        factors[..count].copy_from_slice(&x[first..first + count]);
        let block = &panel[first * height..(first + count) * height];
        take_off(below, factors, block, height, count);
    }
}

/// x ← L₁₁⁻ᵀ (x − L₂₁ᵀ below).
#[inline(always)]
pub(super) fn backward(panel: &[f64], x: &mut [f64], below: &[f64]) {
    let width = x.len();
    let height = width + below.len();
    for k in (0..width).rev() {
        let column = &panel[k * height..(k + 1) * height];
        let (open, solved) = x.split_at_mut(k + 1);
        open[k] -= product(&column[k + 1..width], solved) + product(&column[width..], below);
    }
}

/// Scalar product in `BLOCK` partial sums.
#[inline(always)]
fn product(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; BLOCK];
    let (a, b) = (a.chunks_exact(BLOCK), b.chunks_exact(BLOCK));
    let tail: f64 = a
        .remainder()
        .iter()
        .zip(b.remainder())
        .map(|(a, b)| a * b)
        .sum();
    for (a, b) in a.zip(b) {
        for k in 0..BLOCK {
            sums[k] += a[k] * b[k];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + tail
}
