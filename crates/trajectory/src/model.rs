//! A programme laid out for the solver: fixed patterns, scaled evaluation.
//!
//! Everything here is in scaled variables and rows (see `scaling`). Hessian
//! blocks that share a group are summed before anything else happens to them.

use crate::pattern::Pattern;
use crate::scaling::Scaling;
use crate::tape::{BlockFirst, Sweeper};
use crate::{Block, LinearRow, Programme, ProgrammeError};
use std::collections::BTreeMap;

/// A convexification group: the variables of its blocks, and where its dense
/// upper triangle lands in the Hessian.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    /// The variables, rising.
    pub variables: Vec<usize>,
    /// Member blocks, each with the place of its variables in the group.
    pub members: Vec<(usize, Vec<usize>)>,
    /// Slot of the entry (i, j), i ≤ j, row by row of the upper triangle.
    pub slots: Vec<usize>,
    /// Equality rows over variables of this group alone.
    pub own_rows: Vec<OwnRow>,
}

/// An equality row that a group can account for by itself.
#[derive(Clone, Debug)]
pub(crate) struct OwnRow {
    /// The row.
    pub row: usize,
    /// Jacobian slot and place of its variable in the group.
    pub entries: Vec<(usize, usize)>,
}

/// Patterns, limits and groups of a programme, in scaled units.
#[derive(Clone, Debug)]
pub(crate) struct Structure {
    pub lower: Vec<f64>,
    pub upper: Vec<f64>,
    pub row_lower: Vec<f64>,
    pub row_upper: Vec<f64>,
    /// Rows × variables.
    pub jacobian: Pattern,
    /// Upper triangle, with the whole diagonal.
    pub hessian: Pattern,
    pub groups: Vec<Group>,
}

impl Structure {
    pub(crate) fn variables(&self) -> usize {
        self.lower.len()
    }

    pub(crate) fn rows(&self) -> usize {
        self.row_lower.len()
    }
}

/// What the solver asks of a programme; hides the programme's type.
pub(crate) trait Evaluator: Sync {
    fn structure(&self) -> &Structure;
    /// Cost; fills the rows.
    fn values(&self, x: &[f64], rows: &mut [f64]) -> f64;
    /// Cost; fills rows, gradient and Jacobian values.
    fn first(&self, x: &[f64], rows: &mut [f64], gradient: &mut [f64], jacobian: &mut [f64])
    -> f64;
    /// Dense Hessian (row-major) of every group of `weight·f + yᵀc`.
    fn second(&self, x: &[f64], weight: f64, y: &[f64], groups: &mut [Vec<f64>]);
}

/// A programme with its layout.
pub(crate) struct Model<'p, P> {
    programme: &'p P,
    blocks: Vec<Block>,
    linear: Vec<LinearRow>,
    pub scaling: Scaling,
    structure: Structure,
    /// Per block: first row.
    first_row: Vec<usize>,
    /// Per block: Jacobian slots, row-major.
    slots: Vec<Vec<usize>>,
    linear_slots: Vec<Vec<usize>>,
}

impl<'p, P: Programme> Model<'p, P> {
    pub(crate) fn new(programme: &'p P) -> Result<Self, ProgrammeError> {
        let variables = programme.variables();
        let blocks = programme.blocks();
        let linear = programme.linear();
        let scaling = Scaling::new(&variables, &blocks, &linear, programme.cost_scale())?;
        let n = variables.len();
        for block in &blocks {
            check_variables(&block.name, block.variables.iter().copied(), n)?;
        }
        for row in &linear {
            check_variables(&row.name, row.terms.iter().map(|t| t.0), n)?;
        }

        let mut first_row = Vec::with_capacity(blocks.len());
        let mut m = 0;
        for block in &blocks {
            first_row.push(m);
            m += block.rows.len();
        }
        let first_linear = m;
        m += linear.len();

        let mut entries = Vec::new();
        for (block, &start) in blocks.iter().zip(&first_row) {
            for r in 0..block.rows.len() {
                entries.extend(block.variables.iter().map(|&v| (start + r, v)));
            }
        }
        for (k, row) in linear.iter().enumerate() {
            entries.extend(row.terms.iter().map(|&(v, _)| (first_linear + k, v)));
        }
        let jacobian = Pattern::from_entries(m, n, entries);
        let slots = blocks
            .iter()
            .zip(&first_row)
            .map(|(b, &start)| {
                (0..b.rows.len())
                    .flat_map(|r| b.variables.iter().map(move |&v| (start + r, v)))
                    .map(|(r, v)| jacobian.slot(r, v))
                    .collect()
            })
            .collect();
        let linear_slots = linear
            .iter()
            .enumerate()
            .map(|(k, row)| {
                row.terms
                    .iter()
                    .map(|&(v, _)| jacobian.slot(first_linear + k, v))
                    .collect()
            })
            .collect();

        let (hessian, mut groups) = lay_out_groups(&blocks, n);
        let limits = |pick: fn(&crate::Row) -> f64| -> Vec<f64> {
            let block_rows = blocks.iter().flat_map(|b| b.rows.iter());
            block_rows
                .chain(linear.iter().map(|l| &l.row))
                .map(|r| pick(r) / r.scale)
                .collect()
        };
        let equal: Vec<bool> = limits(|r| r.lower)
            .iter()
            .zip(&limits(|r| r.upper))
            .map(|(l, u)| l == u)
            .collect();
        claim_rows(&mut groups, &jacobian, &equal);
        let structure = Structure {
            lower: variables.iter().map(|v| v.lower / v.scale).collect(),
            upper: variables.iter().map(|v| v.upper / v.scale).collect(),
            row_lower: limits(|r| r.lower),
            row_upper: limits(|r| r.upper),
            jacobian,
            hessian,
            groups,
        };
        Ok(Self {
            programme,
            blocks,
            linear,
            scaling,
            structure,
            first_row,
            slots,
            linear_slots,
        })
    }

    fn gather(&self, block: usize, x: &[f64], point: &mut Vec<f64>, seeds: &mut Vec<f64>) {
        point.clear();
        seeds.clear();
        for &v in &self.blocks[block].variables {
            let s = self.scaling.variables[v];
            point.push(x[v] * s);
            seeds.push(s);
        }
    }

    fn linear_values(&self, x: &[f64], rows: &mut [f64]) {
        let first = rows.len() - self.linear.len();
        for (row, out) in self.linear.iter().zip(&mut rows[first..]) {
            let sum: f64 = row
                .terms
                .iter()
                .map(|&(v, a)| a * self.scaling.variables[v] * x[v])
                .sum();
            *out = sum / row.row.scale;
        }
    }
}

impl<P: Programme> Evaluator for Model<'_, P> {
    fn structure(&self) -> &Structure {
        &self.structure
    }

    fn values(&self, x: &[f64], rows: &mut [f64]) -> f64 {
        let (mut point, mut seeds) = (Vec::new(), Vec::new());
        let mut cost = 0.0;
        for (b, block) in self.blocks.iter().enumerate() {
            self.gather(b, x, &mut point, &mut seeds);
            let start = self.first_row[b];
            let out = &mut rows[start..start + block.rows.len()];
            let mut share = 0.0;
            out.fill(0.0);
            self.programme.evaluate(b, &point, &mut share, out);
            cost += share;
            for (value, row) in out.iter_mut().zip(&block.rows) {
                *value /= row.scale;
            }
        }
        self.linear_values(x, rows);
        cost / self.scaling.cost
    }

    fn first(
        &self,
        x: &[f64],
        rows: &mut [f64],
        gradient: &mut [f64],
        jacobian: &mut [f64],
    ) -> f64 {
        let (mut point, mut seeds) = (Vec::new(), Vec::new());
        let (mut sweeper, mut out) = (Sweeper::default(), BlockFirst::default());
        let mut cost = 0.0;
        gradient.fill(0.0);
        for (b, block) in self.blocks.iter().enumerate() {
            self.gather(b, x, &mut point, &mut seeds);
            let m = block.rows.len();
            sweeper.first(self.programme, b, &point, &seeds, m, &mut out);
            cost += out.cost;
            let n = block.variables.len();
            for (&v, g) in block.variables.iter().zip(&out.gradient) {
                gradient[v] += g / self.scaling.cost;
            }
            for (r, row) in block.rows.iter().enumerate() {
                rows[self.first_row[b] + r] = out.rows[r] / row.scale;
                for k in 0..n {
                    jacobian[self.slots[b][r * n + k]] = out.jacobian[r * n + k] / row.scale;
                }
            }
        }
        self.linear_values(x, rows);
        for (row, slots) in self.linear.iter().zip(&self.linear_slots) {
            for (&(v, a), &slot) in row.terms.iter().zip(slots) {
                jacobian[slot] = a * self.scaling.variables[v] / row.row.scale;
            }
        }
        cost / self.scaling.cost
    }

    fn second(&self, x: &[f64], weight: f64, y: &[f64], groups: &mut [Vec<f64>]) {
        let (mut point, mut seeds, mut weights) = (Vec::new(), Vec::new(), Vec::new());
        let mut sweeper = Sweeper::default();
        let mut dense = Vec::new();
        for (group, out) in self.structure.groups.iter().zip(groups) {
            let size = group.variables.len();
            out.clear();
            out.resize(size * size, 0.0);
            for (b, places) in &group.members {
                let block = &self.blocks[*b];
                self.gather(*b, x, &mut point, &mut seeds);
                weights.clear();
                let start = self.first_row[*b];
                weights.extend(
                    block
                        .rows
                        .iter()
                        .enumerate()
                        .map(|(r, row)| y[start + r] / row.scale),
                );
                let n = block.variables.len();
                dense.clear();
                dense.resize(n * n, 0.0);
                let w = weight / self.scaling.cost;
                sweeper.second(self.programme, *b, &point, &seeds, w, &weights, &mut dense);
                for (i, &pi) in places.iter().enumerate() {
                    for (j, &pj) in places.iter().enumerate() {
                        out[pi * size + pj] += dense[i * n + j];
                    }
                }
            }
        }
    }
}

/// Sorts blocks into groups and finds where each group's triangle lands.
fn lay_out_groups(blocks: &[Block], n: usize) -> (Pattern, Vec<Group>) {
    let mut named: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    let mut lists: Vec<Vec<usize>> = Vec::new();
    for (b, block) in blocks.iter().enumerate() {
        match block.group {
            Some(g) => named.entry(g).or_default().push(b),
            None => lists.push(vec![b]),
        }
    }
    lists.extend(named.into_values());
    let mut entries: Vec<(usize, usize)> = (0..n).map(|v| (v, v)).collect();
    let mut groups: Vec<Group> = lists
        .into_iter()
        .map(|list| {
            let mut variables: Vec<usize> = list
                .iter()
                .flat_map(|&b| blocks[b].variables.iter().copied())
                .collect();
            variables.sort_unstable();
            variables.dedup();
            let members = list
                .into_iter()
                .map(|b| {
                    let places = blocks[b]
                        .variables
                        .iter()
                        .map(|v| variables.partition_point(|u| u < v))
                        .collect();
                    (b, places)
                })
                .collect();
            Group {
                variables,
                members,
                slots: Vec::new(),
                own_rows: Vec::new(),
            }
        })
        .collect();
    for group in &groups {
        for (i, &vi) in group.variables.iter().enumerate() {
            entries.extend(group.variables[i..].iter().map(|&vj| (vi, vj)));
        }
    }
    let pattern = Pattern::from_entries(n, n, entries);
    for group in &mut groups {
        for (i, &vi) in group.variables.iter().enumerate() {
            group
                .slots
                .extend(group.variables[i..].iter().map(|&vj| pattern.slot(vi, vj)));
        }
    }
    (pattern, groups)
}

/// Gives every equality row to the first group that has all its variables.
fn claim_rows(groups: &mut [Group], jacobian: &Pattern, equal: &[bool]) {
    let mut entries = vec![Vec::new(); jacobian.rows];
    for (slot, row, column) in jacobian.entries() {
        entries[row].push((slot, column));
    }
    let mut groups_of = vec![Vec::new(); jacobian.columns];
    for (g, group) in groups.iter().enumerate() {
        for &v in &group.variables {
            groups_of[v].push(g);
        }
    }
    for (row, list) in entries.iter().enumerate().filter(|(row, _)| equal[*row]) {
        let Some(&(_, first)) = list.first() else {
            continue;
        };
        let owner = groups_of[first].iter().find(|&&g| {
            list.iter()
                .all(|(_, v)| groups[g].variables.binary_search(v).is_ok())
        });
        if let Some(&g) = owner {
            let place = |v: usize| groups[g].variables.partition_point(|&u| u < v);
            let entries = list.iter().map(|&(slot, v)| (slot, place(v))).collect();
            groups[g].own_rows.push(OwnRow { row, entries });
        }
    }
}

fn check_variables(
    name: &str,
    variables: impl Iterator<Item = usize>,
    count: usize,
) -> Result<(), ProgrammeError> {
    let mut list: Vec<usize> = variables.collect();
    list.sort_unstable();
    if let Some(&index) = list.last()
        && index >= count
    {
        return Err(ProgrammeError::NoSuchVariable {
            name: name.to_owned(),
            index,
            count,
        });
    }
    match list.windows(2).find(|w| w[0] == w[1]) {
        Some(w) => Err(ProgrammeError::DoubledVariable {
            name: name.to_owned(),
            index: w[0],
        }),
        None => Ok(()),
    }
}
