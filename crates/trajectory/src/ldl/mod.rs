//! LDLᵀ of a sparse symmetric matrix whose pattern never changes, without pivoting, by fronts.
//!
//! ```text
//! ⎡ F₁₁  ·   ⎤   ⎡ L₁₁  0 ⎤ ⎡ D   0 ⎤ ⎡ L₁₁ᵀ  L₂₁ᵀ ⎤
//! ⎢          ⎥ = ⎢        ⎥ ⎢       ⎥ ⎢            ⎥        U = F₂₂ − L₂₁ D L₂₁ᵀ
//! ⎣ F₂₁  F₂₂ ⎦   ⎣ L₂₁  I ⎦ ⎣ 0   U ⎦ ⎣  0     I   ⎦
//! ```
//!
//! Neighbouring columns of L with the same rows below them are one front F, a small dense matrix; its remainder U is added to
//! the front of its parent in the elimination tree (I. Duff and J. Reid, ACM Transactions on Mathematical Software 9, 1983).
//! So nearly all arithmetic runs along dense columns. Clarabel's QDLDL, which works column by column through lists
//! of indices, gives the order (AMD) and is what the tests compare with.
//!
//! The order of all sums is fixed by the pattern: the same values give the same bits.

mod dense;
mod symbolic;
#[cfg(test)]
mod tests;

use crate::pattern::Pattern;
pub(crate) use symbolic::order;
use symbolic::{Front, Symbolic};

/// The factors of a matrix.
pub(crate) struct Ldl {
    symbolic: Symbolic,
    /// The panels L₁₁, L₂₁ of all fronts, each by columns; D stands on the diagonals.
    panels: Vec<f64>,
    /// 1/D.
    inverse: Vec<f64>,
    /// Lower triangles of the remainders that wait for their parents, by columns, the last one on top.
    waiting: Vec<f64>,
    remainder: Vec<f64>,
    /// Fronts that left no remainder: their columns have no entries below the diagonal, as those of limits that do not hold.
    silent: Vec<bool>,
    permuted: Vec<f64>,
    below: Vec<f64>,
}

impl Ldl {
    /// Lays out the factors of matrices with a pattern (upper triangle with the whole diagonal), for an order of its rows
    /// (which is kept up to what changes no sum); `None` if it is none.
    pub(crate) fn new(pattern: &Pattern, order: &[usize]) -> Option<Self> {
        let symbolic = Symbolic::new(pattern, order)?;
        let n = pattern.columns;
        Some(Self {
            panels: vec![0.0; symbolic.panels],
            inverse: vec![0.0; n],
            waiting: Vec::new(),
            remainder: vec![0.0; packed(symbolic.largest)],
            silent: vec![false; symbolic.fronts.len()],
            permuted: vec![0.0; n],
            below: vec![0.0; symbolic.largest],
            symbolic,
        })
    }

    /// Factorises the matrix with these values; the number of positive pivots, `None` if a pivot vanishes or is not finite.
    pub(crate) fn factorise(&mut self, values: &[f64]) -> Option<usize> {
        self.panels.fill(0.0);
        for (value, &place) in values.iter().zip(&self.symbolic.places) {
            self.panels[place as usize] = *value;
        }
        dense::wide(|| self.eliminate());
        let mut positive = 0;
        for front in &self.symbolic.fronts {
            for k in 0..front.width {
                let d = self.panels[front.panel + k * (front.height() + 1)];
                self.inverse[front.first + k] = d.recip();
                positive += usize::from(d > 0.0);
            }
        }
        let usable = |d: &f64| d.is_finite() && *d != 0.0;
        self.inverse.iter().all(usable).then_some(positive)
    }

    #[inline(always)]
    fn eliminate(&mut self) {
        self.waiting.clear();
        for (f, front) in self.symbolic.fronts.iter().enumerate() {
            let (width, rest) = (front.width, front.rows.len());
            let panel = &mut self.panels[front.panel..][..width * front.height()];
            let remainder = &mut self.remainder[..packed(rest)];
            remainder.fill(0.0);
            self.silent[f] = true;
            for &child in front.children.iter().rev() {
                if self.silent[child] {
                    continue;
                }
                let child = &self.symbolic.fronts[child];
                let top = self.waiting.len() - packed(child.rows.len());
                extend(
                    &self.waiting[top..],
                    &child.into_parent,
                    width,
                    panel,
                    remainder,
                );
                self.waiting.truncate(top);
                self.silent[f] = false;
            }
            self.silent[f] &= !dense::eliminate(panel, width, rest, remainder);
            if !self.silent[f] {
                self.waiting.extend_from_slice(remainder);
            }
        }
    }

    /// Solves `LDLᵀ x = b` in place.
    pub(crate) fn solve(&mut self, b: &mut [f64]) {
        let order = &self.symbolic.order;
        for (x, &k) in self.permuted.iter_mut().zip(order) {
            *x = b[k];
        }
        dense::wide(|| self.substitute());
        for (x, &k) in self.permuted.iter().zip(&self.symbolic.order) {
            b[k] = *x;
        }
    }

    #[inline(always)]
    fn substitute(&mut self) {
        for front in &self.symbolic.fronts {
            if front.width == 1 {
                let (x, column) = (self.permuted[front.first], &front.of(&self.panels)[1..]);
                for (&row, l) in front.rows.iter().zip(column) {
                    self.permuted[row as usize] -= l * x;
                }
                continue;
            }
            let below = &mut self.below[..front.rows.len()];
            below.fill(0.0);
            let x = &mut self.permuted[front.first..front.first + front.width];
            dense::forward(front.of(&self.panels), x, below);
            for (&row, b) in front.rows.iter().zip(below) {
                self.permuted[row as usize] += *b;
            }
        }
        for (x, d) in self.permuted.iter_mut().zip(&self.inverse) {
            *x *= d;
        }
        for front in self.symbolic.fronts.iter().rev() {
            if front.width == 1 {
                let column = &front.of(&self.panels)[1..];
                let terms = front.rows.iter().zip(column);
                let sum: f64 = terms.map(|(&row, l)| l * self.permuted[row as usize]).sum();
                self.permuted[front.first] -= sum;
                continue;
            }
            let below = &mut self.below[..front.rows.len()];
            for (&row, b) in front.rows.iter().zip(below.iter_mut()) {
                *b = self.permuted[row as usize];
            }
            let x = &mut self.permuted[front.first..front.first + front.width];
            dense::backward(front.of(&self.panels), x, below);
        }
    }
}

impl Front {
    fn of<'p>(&self, panels: &'p [f64]) -> &'p [f64] {
        &panels[self.panel..self.panel + self.width * self.height()]
    }
}

/// Entries of the lower triangle of a matrix with `size` rows.
fn packed(size: usize) -> usize {
    size * (size + 1) / 2
}

/// Adds a child's remainder to its parent's front; `into[i]` is where the child's row i stands there.
#[inline(always)]
fn extend(child: &[f64], into: &[u32], width: usize, panel: &mut [f64], remainder: &mut [f64]) {
    let height = panel.len() / width;
    let rest = height - width;
    let mut child = child;
    for (j, &to) in into.iter().enumerate() {
        let (from, others) = child.split_at(into.len() - j);
        child = others;
        let to = to as usize;
        // Column `to` of the front, from its row `begin` on.
        let (column, begin) = if to < width {
            (&mut panel[to * height..][..height], 0)
        } else {
            let k = to - width;
            (
                &mut remainder[packed(rest) - packed(rest - k)..][..rest - k],
                to,
            )
        };
        for (&i, value) in into[j..].iter().zip(from) {
            column[i as usize - begin] += value;
        }
    }
}
