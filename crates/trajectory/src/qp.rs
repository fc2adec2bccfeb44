//! The quadratic subproblem, solved by Clarabel.
//!
//! ```text
//! minimise    ½ dᵀH d + gᵀd
//! subject to  J d + s = b,   s ∈ {0} (equalities),  s ≥ 0 (limits)
//!
//! equality rows      J_r d = u_r − c_r            multiplier y_r
//! fixed variables    d_j   = x̄_j − x_j            multiplier z_j
//! upper limits       J_r d ≤ u_r − c_r            y_r ≥ 0
//! lower limits      −J_r d ≤ c_r − l_r            y_r ≤ 0
//! upper bounds       d_j   ≤ x̄_j − x_j            z_j ≥ 0
//! lower bounds      −d_j   ≤ x_j − x̲_j            z_j ≤ 0
//! ```
//!
//! The pattern hardly ever changes, so Clarabel is set up once and only data are
//! exchanged: its symbolic factorisation is reused. The elastic form adds the
//! columns `t ≥ 0` (see `elastic`).

use crate::iterate::Iterate;
use crate::model::Structure;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT,
    SolverStatus, ZeroConeT,
};

/// What a line of the subproblem stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Line {
    Row { row: usize, sign: f64 },
    Variable { variable: usize, sign: f64 },
    Slack,
}

/// Data of one subproblem.
pub(crate) struct QpData<'a> {
    pub hessian: &'a [f64],
    pub gradient: &'a [f64],
    pub jacobian: &'a [f64],
    pub x: &'a [f64],
    pub rows: &'a [f64],
}

impl<'a> QpData<'a> {
    /// The subproblem at a point, linearised from these row values.
    pub(crate) fn at(
        at: &'a Iterate,
        hessian: &'a [f64],
        gradient: &'a [f64],
        rows: &'a [f64],
    ) -> Self {
        Self {
            hessian,
            gradient,
            jacobian: &at.jacobian,
            x: &at.x,
            rows,
        }
    }
}

/// The answer to one subproblem.
#[derive(Clone, Debug)]
pub(crate) struct QpStep {
    pub d: Vec<f64>,
    /// Row multipliers, signed as in `Multipliers`.
    pub y: Vec<f64>,
    /// Bound multipliers, signed as in `Multipliers`.
    pub z: Vec<f64>,
    /// Rows that the step holds at a limit.
    pub active_rows: Vec<bool>,
    /// Variables that the step holds at a bound.
    pub active_bounds: Vec<bool>,
    /// Interior-point iterations.
    pub iterations: usize,
}

/// The subproblem and its solver.
pub(crate) struct Subproblem {
    lines: Vec<Line>,
    equalities: usize,
    /// Jacobian slot, place in A, sign.
    places: Vec<(usize, usize, f64)>,
    pattern: CscMatrix<f64>,
    p: CscMatrix<f64>,
    elastic: Option<Elastic>,
    solver: Option<DefaultSolver<f64>>,
    tolerance: f64,
}

struct Elastic {
    columns: usize,
    penalty: f64,
}

impl Subproblem {
    /// The plain subproblem of a structure; of the Jacobian only the entries in `known` may differ from nought.
    pub(crate) fn new(structure: &Structure, known: &[bool]) -> Self {
        Self::build(structure, known, false)
    }

    /// The subproblem with elastic rows: `J d` may miss its limits by `t ≥ 0`.
    pub(crate) fn new_elastic(structure: &Structure, known: &[bool]) -> Self {
        Self::build(structure, known, true)
    }

    fn build(s: &Structure, known: &[bool], elastic: bool) -> Self {
        let (n, m) = (s.variables(), s.rows());
        let mut lines = Vec::new();
        lines.extend(
            (0..m)
                .filter(|&r| s.row_lower[r] == s.row_upper[r])
                .map(|row| Line::Row { row, sign: 1.0 }),
        );
        lines.extend(
            (0..n)
                .filter(|&v| s.lower[v] == s.upper[v])
                .map(|variable| Line::Variable {
                    variable,
                    sign: 1.0,
                }),
        );
        let equalities = lines.len();
        for row in (0..m).filter(|&r| s.row_lower[r] < s.row_upper[r]) {
            if s.row_upper[row].is_finite() {
                lines.push(Line::Row { row, sign: 1.0 });
            }
            if s.row_lower[row].is_finite() {
                lines.push(Line::Row { row, sign: -1.0 });
            }
        }
        for variable in (0..n).filter(|&v| s.lower[v] < s.upper[v]) {
            if s.upper[variable].is_finite() {
                lines.push(Line::Variable {
                    variable,
                    sign: 1.0,
                });
            }
            if s.lower[variable].is_finite() {
                lines.push(Line::Variable {
                    variable,
                    sign: -1.0,
                });
            }
        }
        let mut entries: Vec<(usize, usize, Option<usize>, f64)> = Vec::new();
        let mut lines_of_row = vec![Vec::new(); m];
        let mut columns = n;
        for (k, line) in lines.iter().enumerate() {
            match *line {
                Line::Row { row, sign } => lines_of_row[row].push((k, sign)),
                Line::Variable { variable, sign } => entries.push((k, variable, None, sign)),
                Line::Slack => unreachable!("slacks are added below"),
            }
        }
        for (slot, row, column) in s.jacobian.entries().filter(|e| known[e.0]) {
            for &(line, sign) in &lines_of_row[row] {
                entries.push((line, column, Some(slot), sign));
            }
        }
        if elastic {
            // Equalities may be missed either way: J d + t₊ − t₋ = b. Limits only one way: J d − t ≤ b.
            for k in 0..lines.len() {
                if matches!(lines[k], Line::Row { .. }) {
                    entries.push((k, columns, None, -1.0));
                    columns += 1;
                    if k < equalities {
                        entries.push((k, columns, None, 1.0));
                        columns += 1;
                    }
                }
            }
            for t in n..columns {
                entries.push((lines.len(), t, None, -1.0));
                lines.push(Line::Slack);
            }
        }
        entries.sort_unstable_by_key(|e| (e.1, e.0));
        let mut starts = vec![0; columns + 1];
        let mut places = Vec::new();
        let mut values = vec![0.0; entries.len()];
        for (place, &(_, column, slot, sign)) in entries.iter().enumerate() {
            starts[column + 1] += 1;
            match slot {
                Some(slot) => places.push((slot, place, sign)),
                None => values[place] = sign,
            }
        }
        for c in 0..columns {
            starts[c + 1] += starts[c];
        }
        let row_of = entries.iter().map(|e| e.0).collect();
        let pattern = CscMatrix::new(lines.len(), columns, starts, row_of, values);
        let mut p_starts = s.hessian.starts.clone();
        let mut p_rows = s.hessian.row_of.clone();
        for t in n..columns {
            p_rows.push(t);
            p_starts.push(p_rows.len());
        }
        let mut p_values = vec![0.0; p_rows.len()];
        for value in &mut p_values[s.hessian.len()..] {
            *value = 1e-8; // keeps the slacks' columns of the factorisation alive
        }
        let p = CscMatrix::new(columns, columns, p_starts, p_rows, p_values);
        let elastic = elastic.then_some(Elastic {
            columns: columns - n,
            penalty: 1.0,
        });
        Self {
            lines,
            equalities,
            places,
            pattern,
            p,
            elastic,
            solver: None,
            tolerance: 1e-8,
        }
    }

    /// Price of a unit of missed constraint in the elastic form.
    pub(crate) fn set_penalty(&mut self, penalty: f64) {
        if let Some(elastic) = &mut self.elastic {
            elastic.penalty = penalty;
        }
    }

    /// Solves the subproblem; `Err` carries Clarabel's status when it ended without a solution.
    pub(crate) fn solve(
        &mut self,
        s: &Structure,
        data: &QpData<'_>,
        tolerance: f64,
    ) -> Result<QpStep, SolverStatus> {
        let n = s.variables();
        self.p.nzval[..data.hessian.len()].copy_from_slice(data.hessian);
        for &(slot, place, sign) in &self.places {
            self.pattern.nzval[place] = sign * data.jacobian[slot];
        }
        let mut q = data.gradient.to_vec();
        if let Some(elastic) = &self.elastic {
            q.extend(std::iter::repeat_n(elastic.penalty, elastic.columns));
        }
        let b: Vec<f64> = self
            .lines
            .iter()
            .map(|line| match *line {
                Line::Row { row, sign } if sign > 0.0 => s.row_upper[row] - data.rows[row],
                Line::Row { row, .. } => data.rows[row] - s.row_lower[row],
                Line::Variable { variable, sign } if sign > 0.0 => {
                    s.upper[variable] - data.x[variable]
                }
                Line::Variable { variable, .. } => data.x[variable] - s.lower[variable],
                Line::Slack => 0.0,
            })
            .collect();
        let finite = |v: &[f64]| v.iter().all(|x| x.is_finite());
        if !(finite(&self.p.nzval) && finite(&self.pattern.nzval) && finite(&q) && finite(&b)) {
            return Err(SolverStatus::NumericalError);
        }
        self.load(&q, &b, tolerance)?;
        let Some(solver) = self.solver.as_mut() else {
            return Err(SolverStatus::Unsolved);
        };
        solver.solve();
        let solution = &solver.solution;
        if !matches!(
            solution.status,
            SolverStatus::Solved | SolverStatus::AlmostSolved
        ) {
            return Err(solution.status);
        }
        let mut step = QpStep {
            d: solution.x[..n].to_vec(),
            y: vec![0.0; s.rows()],
            z: vec![0.0; n],
            active_rows: vec![false; s.rows()],
            active_bounds: vec![false; n],
            iterations: solution.iterations as usize,
        };
        for (k, line) in self.lines.iter().enumerate() {
            // At the solution either the slack or the multiplier is large; the larger one decides.
            let active = k < self.equalities || solution.z[k] > solution.s[k];
            match *line {
                Line::Row { row, sign } => {
                    step.y[row] += sign * solution.z[k];
                    step.active_rows[row] |= active;
                }
                Line::Variable { variable, sign } => {
                    step.z[variable] += sign * solution.z[k];
                    step.active_bounds[variable] |= active;
                }
                Line::Slack => {}
            }
        }
        Ok(step)
    }

    fn load(&mut self, q: &[f64], b: &[f64], tolerance: f64) -> Result<(), SolverStatus> {
        if let Some(solver) = self.solver.as_mut() {
            if tolerance != self.tolerance {
                solver
                    .update_settings(settings(tolerance))
                    .map_err(|_| SolverStatus::NumericalError)?;
                self.tolerance = tolerance;
            }
            return solver
                .update_data(&self.p.nzval, &q.to_vec(), &self.pattern.nzval, &b.to_vec())
                .map_err(|_| SolverStatus::NumericalError);
        }
        let mut cones = Vec::new();
        if self.equalities > 0 {
            cones.push(ZeroConeT(self.equalities));
        }
        if self.lines.len() > self.equalities {
            cones.push(NonnegativeConeT(self.lines.len() - self.equalities));
        }
        let solver = DefaultSolver::new(&self.p, q, &self.pattern, b, &cones, settings(tolerance))
            .map_err(|_| SolverStatus::NumericalError)?;
        self.solver = Some(solver);
        self.tolerance = tolerance;
        Ok(())
    }
}

/// One thread and one factorisation method: the bits of the answer depend on nothing else.
fn settings(tolerance: f64) -> DefaultSettings<f64> {
    let built = DefaultSettingsBuilder::default()
        .verbose(false)
        .max_threads(1)
        .direct_solve_method("qdldl".to_owned())
        .presolve_enable(false)
        .input_sparse_dropzeros(false)
        .max_iter(100)
        .iterative_refinement_reltol(1e-10)
        .iterative_refinement_abstol(1e-10)
        .iterative_refinement_max_iter(4)
        .tol_gap_abs(tolerance)
        .tol_gap_rel(tolerance)
        .tol_feas(tolerance)
        .build();
    match built {
        Ok(settings) => settings,
        Err(error) => panic!("fixed Clarabel settings were refused: {error}"),
    }
}
