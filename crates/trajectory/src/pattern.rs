//! Sparsity patterns that are fixed once and addressed by slot.

/// A compressed-column pattern; values live beside it in plain vectors.
#[derive(Clone, Debug)]
pub(crate) struct Pattern {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub columns: usize,
    /// Start of every column, and the end of the last.
    pub starts: Vec<usize>,
    /// Row of every entry, rising within a column.
    pub row_of: Vec<usize>,
}

impl Pattern {
    /// The union of `entries` (row, column).
    pub(crate) fn from_entries(
        rows: usize,
        columns: usize,
        mut entries: Vec<(usize, usize)>,
    ) -> Self {
        entries.sort_unstable_by_key(|&(r, c)| (c, r));
        entries.dedup();
        let mut starts = vec![0; columns + 1];
        for &(_, c) in &entries {
            starts[c + 1] += 1;
        }
        for c in 0..columns {
            starts[c + 1] += starts[c];
        }
        Self {
            rows,
            columns,
            starts,
            row_of: entries.into_iter().map(|(r, _)| r).collect(),
        }
    }

    /// Number of entries.
    pub(crate) fn len(&self) -> usize {
        self.row_of.len()
    }

    /// The slot of an entry that is in the pattern.
    pub(crate) fn slot(&self, row: usize, column: usize) -> usize {
        match self.find(row, column) {
            Some(slot) => slot,
            None => panic!("entry ({row}, {column}) is not in the pattern"),
        }
    }

    /// The slot of an entry, if it is in the pattern.
    pub(crate) fn find(&self, row: usize, column: usize) -> Option<usize> {
        let (start, end) = (self.starts[column], self.starts[column + 1]);
        let place = self.row_of[start..end].binary_search(&row).ok()?;
        Some(start + place)
    }

    /// Every entry as (slot, row, column), column by column.
    pub(crate) fn entries(&self) -> impl Iterator<Item = (usize, usize, usize)> + Clone + '_ {
        (0..self.columns).flat_map(move |c| {
            (self.starts[c]..self.starts[c + 1]).map(move |k| (k, self.row_of[k], c))
        })
    }

    /// Adds `shift` to every entry of the diagonal, of a symmetric matrix whose upper triangle is stored and
    /// whose diagonal is in the pattern: it closes every column.
    pub(crate) fn add_to_diagonal(&self, values: &mut [f64], shift: f64) {
        for c in 0..self.columns {
            values[self.starts[c + 1] - 1] += shift;
        }
    }

    /// `out += Aᵀ y`.
    pub(crate) fn add_transposed_product(&self, values: &[f64], y: &[f64], out: &mut [f64]) {
        for c in 0..self.columns {
            let mut sum = 0.0;
            for k in self.starts[c]..self.starts[c + 1] {
                sum += values[k] * y[self.row_of[k]];
            }
            out[c] += sum;
        }
    }

    /// `out += A x`.
    pub(crate) fn add_product(&self, values: &[f64], x: &[f64], out: &mut [f64]) {
        for c in 0..self.columns {
            for k in self.starts[c]..self.starts[c + 1] {
                out[self.row_of[k]] += values[k] * x[c];
            }
        }
    }

    /// `out += A x` for a symmetric matrix of which the upper triangle is stored, with the whole diagonal: it closes every column.
    pub(crate) fn add_symmetric_product(&self, values: &[f64], x: &[f64], out: &mut [f64]) {
        for c in 0..self.columns {
            let (start, last) = (self.starts[c], self.starts[c + 1] - 1);
            let mut sum = values[last] * x[c];
            for (&r, value) in self.row_of[start..last].iter().zip(&values[start..last]) {
                sum += value * x[r];
                out[r] += value * x[c];
            }
            out[c] += sum;
        }
    }

    /// Largest row sum of absolute values of such a matrix.
    pub(crate) fn symmetric_norm(&self, values: &[f64]) -> f64 {
        let mut sums = vec![0.0; self.columns];
        for c in 0..self.columns {
            let (start, last) = (self.starts[c], self.starts[c + 1] - 1);
            let mut sum = values[last].abs();
            for (&r, value) in self.row_of[start..last].iter().zip(&values[start..last]) {
                sum += value.abs();
                sums[r] += value.abs();
            }
            sums[c] += sum;
        }
        max_abs(&sums)
    }

    /// `xᵀ A x` for a symmetric matrix of which the upper triangle is stored.
    pub(crate) fn quadratic_form(&self, values: &[f64], x: &[f64]) -> f64 {
        let mut ax = vec![0.0; self.columns];
        self.add_symmetric_product(values, x, &mut ax);
        dot(&ax, x)
    }
}

/// Scalar product in index order.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Largest absolute value; NaN counts as infinite.
pub(crate) fn max_abs(a: &[f64]) -> f64 {
    a.iter().fold(0.0, |m, &v| {
        if v.is_nan() {
            f64::INFINITY
        } else {
            m.max(v.abs())
        }
    })
}
