//! The recursions' inner loops on the widest vectors that the processor has.

/// Runs a kernel compiled for the vectors of the processor at hand. Lanes are columns, and a product is
/// fused with a sum only where the kernel says so: every width computes the same bits. The kernel must be `#[inline(always)]`, or it is compiled for the least of processors.
#[inline(always)]
pub(super) fn wide<R>(kernel: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(kernel)
}

const LANES: usize = 8;

/// a'b in eight lanes.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    wide(
        #[inline(always)]
        || {
            let mut lanes = [0.0; LANES];
            let (left, right) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
            let rest = left.remainder().iter().zip(right.remainder());
            let rest: f64 = rest.map(|(x, y)| x * y).sum();
            for (a, b) in left.zip(right) {
                for k in 0..LANES {
                    lanes[k] = a[k].mul_add(b[k], lanes[k]);
                }
            }
            lanes.iter().sum::<f64>() + rest
        },
    )
}

/// Products of two columns with two.
#[inline(always)]
pub(super) fn dots(left: [&[f64]; 2], right: [&[f64]; 2]) -> [[f64; 2]; 2] {
    let mut lanes = [[[0.0; LANES]; 2]; 2];
    let mut chunks = [left[0], left[1], right[0], right[1]].map(|x| x.chunks_exact(LANES));
    let rest = [0, 1, 2, 3].map(|k: usize| chunks[k].remainder());
    let [a, b, c, d] = &mut chunks;
    for (((a, b), c), d) in a.zip(b).zip(c).zip(d) {
        for k in 0..LANES {
            lanes[0][0][k] = a[k].mul_add(c[k], lanes[0][0][k]);
            lanes[0][1][k] = a[k].mul_add(d[k], lanes[0][1][k]);
            lanes[1][0][k] = b[k].mul_add(c[k], lanes[1][0][k]);
            lanes[1][1][k] = b[k].mul_add(d[k], lanes[1][1][k]);
        }
    }
    let tail = |a: usize, b: usize| -> f64 {
        let pairs = rest[a].iter().zip(rest[2 + b]);
        pairs.map(|(x, y)| x * y).sum()
    };
    let sum = |a: usize, b: usize| lanes[a][b].iter().sum::<f64>() + tail(a, b);
    [[sum(0, 0), sum(0, 1)], [sum(1, 0), sum(1, 1)]]
}
