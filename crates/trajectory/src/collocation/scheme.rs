//! The coefficients of a collocation scheme, from its nodes alone.
//!
//! With Lagrange polynomials `l_j` on the nodes `c_j ∈ [0, 1]` of an interval of
//! length `h`:
//!
//! ```text
//! a(τ) = Σ_j l_j(τ) a_j
//! v_i  = v_0 + h Σ_j A_ij a_j                     A_ij = ∫₀^{c_i} l_j(τ) dτ
//! q_i  = q_0 + h c_i v_0 + h² Σ_j B_ij a_j        B_ij = ∫₀^{c_i} (c_i − τ) l_j(τ) dτ
//! ∫ℓ   ≈ h Σ_j b_j ℓ_j                            b_j  = ∫₀¹ l_j(τ) dτ
//! ```
//!
//! Radau IIA has its last node at the end of the interval and none at the
//! start; Hermite–Simpson and trapezoid have nodes at both ends, which
//! neighbouring intervals share.

/// Nodes and coefficients of a scheme on the unit interval.
#[derive(Clone, Debug, PartialEq)]
pub struct Scheme {
    /// Name for tables.
    pub name: &'static str,
    /// Nodes c_i, rising; the last is 1.
    pub nodes: Vec<f64>,
    /// A_ij: first integral, row i to node i.
    pub first: Vec<Vec<f64>>,
    /// B_ij: second integral, row i to node i.
    pub second: Vec<Vec<f64>>,
    /// b_j: quadrature weights.
    pub weights: Vec<f64>,
    /// Order with which the state at the end of the intervals converges.
    pub order: usize,
}

impl Scheme {
    /// Radau IIA with two stages (order 3).
    pub fn radau2() -> Self {
        Self::from_nodes("Radau IIA 2", vec![1.0 / 3.0, 1.0], 3)
    }

    /// Radau IIA with three stages (order 5).
    pub fn radau3() -> Self {
        let root = 6.0_f64.sqrt();
        Self::from_nodes(
            "Radau IIA 3",
            vec![(4.0 - root) / 10.0, (4.0 + root) / 10.0, 1.0],
            5,
        )
    }

    /// Second-order Hermite–Simpson (order 4).
    pub fn hermite_simpson() -> Self {
        Self::from_nodes("Hermite-Simpson", vec![0.0, 0.5, 1.0], 4)
    }

    /// Second-order trapezoid (order 2).
    pub fn trapezoid() -> Self {
        Self::from_nodes("trapezoid", vec![0.0, 1.0], 2)
    }

    /// Does the first node lie at the start of the interval?
    pub fn starts_at_node(&self) -> bool {
        self.nodes[0] == 0.0
    }

    fn from_nodes(name: &'static str, nodes: Vec<f64>, order: usize) -> Self {
        let k = nodes.len();
        let basis: Vec<Vec<f64>> = (0..k).map(|j| lagrange(&nodes, j)).collect();
        // ∫₀^c τᵖ dτ = c^{p+1}/(p+1);  ∫₀^c (c − τ) τᵖ dτ = c^{p+2}/((p+1)(p+2)).
        let once = |l: &[f64], c: f64| -> f64 {
            l.iter()
                .enumerate()
                .map(|(p, a)| a * c.powi(p as i32 + 1) / (p + 1) as f64)
                .sum()
        };
        let twice = |l: &[f64], c: f64| -> f64 {
            l.iter()
                .enumerate()
                .map(|(p, a)| a * c.powi(p as i32 + 2) / ((p + 1) * (p + 2)) as f64)
                .sum()
        };
        Self {
            name,
            first: nodes
                .iter()
                .map(|&c| basis.iter().map(|l| once(l, c)).collect())
                .collect(),
            second: nodes
                .iter()
                .map(|&c| basis.iter().map(|l| twice(l, c)).collect())
                .collect(),
            weights: basis.iter().map(|l| once(l, 1.0)).collect(),
            nodes,
            order,
        }
    }

    /// Values at `tau` of the Lagrange polynomials, and of their first and second integrals.
    pub fn basis_at(&self, tau: f64) -> [Vec<f64>; 3] {
        let mut out = [Vec::new(), Vec::new(), Vec::new()];
        for j in 0..self.nodes.len() {
            let l = lagrange(&self.nodes, j);
            let mut sums = [0.0; 3];
            for (p, a) in l.iter().enumerate() {
                let power = tau.powi(p as i32);
                sums[0] += a * power;
                sums[1] += a * power * tau / (p + 1) as f64;
                sums[2] += a * power * tau * tau / ((p + 1) * (p + 2)) as f64;
            }
            for (list, sum) in out.iter_mut().zip(sums) {
                list.push(sum);
            }
        }
        out
    }
}

/// Monomial coefficients of the Lagrange polynomial of node `j`.
fn lagrange(nodes: &[f64], j: usize) -> Vec<f64> {
    let mut polynomial = vec![1.0];
    for (m, &node) in nodes.iter().enumerate() {
        if m == j {
            continue;
        }
        // times (τ − node) / (c_j − node)
        let denominator = nodes[j] - node;
        let mut next = vec![0.0; polynomial.len() + 1];
        for (p, a) in polynomial.iter().enumerate() {
            next[p + 1] += a / denominator;
            next[p] -= a * node / denominator;
        }
        polynomial = next;
    }
    polynomial
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> Vec<Scheme> {
        vec![
            Scheme::radau2(),
            Scheme::radau3(),
            Scheme::hermite_simpson(),
            Scheme::trapezoid(),
        ]
    }

    /// Butcher table of Radau IIA with two stages: Hairer and Wanner, Solving
    /// Ordinary Differential Equations II, table IV.5.5.
    #[test]
    fn radau_has_the_published_table() {
        let scheme = Scheme::radau2();
        let table = [[5.0 / 12.0, -1.0 / 12.0], [3.0 / 4.0, 1.0 / 4.0]];
        for (row, published) in scheme.first.iter().zip(table) {
            for (a, b) in row.iter().zip(published) {
                assert!((a - b).abs() < 1e-15, "{a} instead of {b}");
            }
        }
        let root = 6.0_f64.sqrt();
        let three = Scheme::radau3();
        assert!((three.first[0][0] - (88.0 - 7.0 * root) / 360.0).abs() < 1e-15);
        assert!((three.first[1][0] - (296.0 + 169.0 * root) / 1800.0).abs() < 1e-15);
        assert!((three.weights[2] - 1.0 / 9.0).abs() < 1e-15);
    }

    #[test]
    fn simpson_has_its_weights() {
        let scheme = Scheme::hermite_simpson();
        for (a, b) in scheme.weights.iter().zip([1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0]) {
            assert!((a - b).abs() < 1e-15);
        }
        // q₁ = q₀ + h v₀ + h²/6 (a₀ + 2 a_m)
        for (a, b) in scheme.second[2].iter().zip([1.0 / 6.0, 2.0 / 6.0, 0.0]) {
            assert!((a - b).abs() < 1e-15);
        }
    }

    #[test]
    fn integrals_are_exact_for_the_polynomials_they_interpolate() {
        for scheme in all() {
            for p in 0..scheme.nodes.len() {
                for (i, &c) in scheme.nodes.iter().enumerate() {
                    let values: Vec<f64> = scheme.nodes.iter().map(|t| t.powi(p as i32)).collect();
                    let sum =
                        |row: &[f64]| -> f64 { row.iter().zip(&values).map(|(a, v)| a * v).sum() };
                    let once = c.powi(p as i32 + 1) / (p + 1) as f64;
                    let twice = c.powi(p as i32 + 2) / ((p + 1) * (p + 2)) as f64;
                    assert!(
                        (sum(&scheme.first[i]) - once).abs() < 1e-14,
                        "{}",
                        scheme.name
                    );
                    assert!(
                        (sum(&scheme.second[i]) - twice).abs() < 1e-14,
                        "{}",
                        scheme.name
                    );
                }
            }
        }
    }
}
