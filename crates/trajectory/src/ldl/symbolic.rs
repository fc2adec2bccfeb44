//! Order, fronts and where every entry goes: what the pattern alone decides.

use crate::pattern::Pattern;
use clarabel::algebra::CscMatrix;
use clarabel::qdldl::{QDLDLFactorisation, QDLDLSettingsBuilder};

/// A front may hold this share of zeros if it has at most this many columns: fewer, larger fronts
/// cost some arithmetic on zeros and save sums through lists of indices.
const ZEROS: [(usize, f64); 2] = [(8, 0.3), (24, 0.1)];
/// The share of zeros that a front of any width may hold.
const FEW: f64 = 0.05;
/// No parent, or not yet known.
const NONE: usize = usize::MAX;

/// Columns of L that are eliminated together.
pub(super) struct Front {
    /// First column and number of columns.
    pub first: usize,
    pub width: usize,
    /// The rows below these columns, rising.
    pub rows: Vec<u32>,
    /// Where the panel begins.
    pub panel: usize,
    /// Children, rising: their remainders wait in this order.
    pub children: Vec<usize>,
    /// Where every row stands in the parent's front.
    pub into_parent: Vec<u32>,
    /// Entries of the panel that no column needs.
    zeros: usize,
}

impl Front {
    pub(super) fn height(&self) -> usize {
        self.width + self.rows.len()
    }

    fn end(&self) -> usize {
        self.first + self.width
    }
}

/// The layout of the factors.
pub(super) struct Symbolic {
    /// order[k] is the row that is eliminated as number k.
    pub order: Vec<usize>,
    /// Fronts, children before parents.
    pub fronts: Vec<Front>,
    /// Where every entry of the pattern goes.
    pub places: Vec<u32>,
    /// Length of all panels, rows of the largest remainder.
    pub panels: usize,
    pub largest: usize,
}

impl Symbolic {
    pub(super) fn new(pattern: &Pattern, order: &[usize]) -> Option<Self> {
        let (order, columns) = ordered_columns(pattern, order)?;
        let mut fronts = merged_fronts(&columns);
        let mut panels = 0;
        for front in &mut fronts {
            front.panel = panels;
            panels += front.width * front.height();
        }
        let mut front_of = vec![0; order.len()];
        for (f, front) in fronts.iter().enumerate() {
            front_of[front.first..front.end()].fill(f);
        }
        for f in 0..fronts.len() {
            let Some(&next) = fronts[f].rows.first() else {
                continue;
            };
            let next = next as usize;
            let parent = &fronts[front_of[next]];
            fronts[f].into_parent = fronts[f]
                .rows
                .iter()
                .map(|&row| place_in(parent, row as usize) as u32)
                .collect();
            fronts[front_of[next]].children.push(f);
        }
        let mut position = vec![0; order.len()];
        order
            .iter()
            .enumerate()
            .for_each(|(k, &row)| position[row] = k);
        let place = |(_, r, c): (usize, usize, usize)| {
            let (row, column) = (position[r].max(position[c]), position[r].min(position[c]));
            let front = &fronts[front_of[column]];
            (front.panel + (column - front.first) * front.height() + place_in(front, row)) as u32
        };
        Some(Self {
            places: pattern.entries().map(place).collect(),
            largest: fronts.iter().map(|f| f.rows.len()).max().unwrap_or(0),
            panels,
            order,
            fronts,
        })
    }
}

/// Where a row stands in a front that has it.
fn place_in(front: &Front, row: usize) -> usize {
    if row < front.end() {
        row - front.first
    } else {
        front.width + front.rows.partition_point(|&r| (r as usize) < row)
    }
}

/// An order of a pattern's rows with little fill: AMD, as QDLDL has it.
pub(crate) fn order(pattern: &Pattern) -> Option<Vec<usize>> {
    Some(plan(pattern, None)?.perm)
}

/// QDLDL's layout of the factors, in a given order or its own.
fn plan(pattern: &Pattern, order: Option<&[usize]>) -> Option<QDLDLFactorisation<f64>> {
    let n = pattern.columns;
    let (starts, row_of) = (pattern.starts.clone(), pattern.row_of.clone());
    let matrix = CscMatrix::new(n, n, starts, row_of, vec![1.0; pattern.len()]);
    let mut settings = QDLDLSettingsBuilder::default();
    settings.logical(true).regularize_enable(false);
    if let Some(order) = order {
        settings.perm(order.to_vec());
    }
    QDLDLFactorisation::new(&matrix, Some(settings.build().ok()?)).ok()
}

/// The order, changed so that every subtree of the elimination tree is contiguous, and the rows of every column of L below the diagonal.
fn ordered_columns(pattern: &Pattern, order: &[usize]) -> Option<(Vec<usize>, Vec<Vec<usize>>)> {
    let n = pattern.columns;
    let plan = plan(pattern, Some(order))?;
    let rows = |j: usize| &plan.L.rowval[plan.L.colptr[j]..plan.L.colptr[j + 1]];
    // The parent of a column is its first row below the diagonal.
    let parent: Vec<usize> = (0..n)
        .map(|j| rows(j).iter().copied().min().unwrap_or(NONE))
        .collect();
    let post = postorder(&parent, &|j| rows(j).len());
    let mut position = vec![0; n];
    post.iter().enumerate().for_each(|(k, &j)| position[j] = k);
    let columns = post.iter().map(|&j| {
        let mut list: Vec<usize> = rows(j).iter().map(|&r| position[r]).collect();
        list.sort_unstable();
        list
    });
    let columns = columns.collect();
    Some((post.iter().map(|&j| plan.perm[j]).collect(), columns))
}

/// Children before parents, subtrees contiguous; of all children the one with the most rows last, so that it can be merged with its parent.
fn postorder(parent: &[usize], rows: &dyn Fn(usize) -> usize) -> Vec<usize> {
    let n = parent.len();
    let mut children = vec![Vec::new(); n];
    let mut stack = Vec::new();
    for j in 0..n {
        match parent[j] {
            NONE => stack.push(j),
            p => children[p].push(j),
        }
    }
    // Depth first with parents before children gives the reverse of the order.
    let mut order = Vec::with_capacity(n);
    while let Some(j) = stack.pop() {
        order.push(j);
        children[j].sort_by_key(|&c| rows(c));
        stack.append(&mut children[j]);
    }
    order.reverse();
    order
}

/// Fronts of columns whose rows nest, merged with their last child where that brings few zeros.
fn merged_fronts(columns: &[Vec<usize>]) -> Vec<Front> {
    let mut fronts: Vec<Front> = Vec::new();
    for (j, rows) in columns.iter().enumerate() {
        let mut front = Front {
            first: j,
            width: 1,
            rows: rows.iter().map(|&row| row as u32).collect(),
            panel: 0,
            children: Vec::new(),
            into_parent: Vec::new(),
            zeros: 0,
        };
        while let Some(child) = fronts.pop_if(|child| {
            child.rows.first().is_some_and(|&row| row as usize <= j) && is_worth_it(child, &front)
        }) {
            front = merge(child, front);
        }
        fronts.push(front);
    }
    fronts
}

/// Zeros of the merged front: those of both, and the rows that the child lacks, in each of its columns.
fn zeros(child: &Front, front: &Front) -> usize {
    child.zeros + front.zeros + child.width * (front.height() - child.rows.len())
}

fn is_worth_it(child: &Front, front: &Front) -> bool {
    let width = child.width + front.width;
    let entries = width * (width + 1) / 2 + width * front.rows.len();
    let allowed = ZEROS
        .iter()
        .find(|(most, _)| width <= *most)
        .map_or(FEW, |(_, share)| *share);
    zeros(child, front) as f64 <= allowed * entries as f64
}

fn merge(child: Front, front: Front) -> Front {
    Front {
        zeros: zeros(&child, &front),
        first: child.first,
        width: child.width + front.width,
        ..front
    }
}
