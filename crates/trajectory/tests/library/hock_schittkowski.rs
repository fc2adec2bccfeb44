//! Problems of W. Hock and K. Schittkowski, Test Examples for Nonlinear
//! Programming Codes, Lecture Notes in Economics and Mathematical Systems 187,
//! Springer 1981, under their numbers there, with starts and published minima.

use trajectory::{Block, Programme, Row, Scalar, Variable};

/// One problem of the collection by its number.
#[derive(Clone, Copy, Debug)]
pub struct HockSchittkowski(pub u32);

/// Start and published minimum.
pub struct Published {
    pub start: &'static [f64],
    pub minimum: f64,
}

/// The numbers in the library.
pub const NUMBERS: &[u32] = &[
    1, 6, 7, 10, 11, 12, 14, 26, 28, 35, 38, 39, 40, 43, 63, 66, 71, 76, 77, 78, 79, 80, 100, 113,
];

const ANY: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);
const POSITIVE: (f64, f64) = (0.0, f64::INFINITY);

impl HockSchittkowski {
    pub fn published(self) -> Published {
        let (start, minimum): (&'static [f64], f64) = match self.0 {
            1 => (&[-2.0, 1.0], 0.0),
            6 => (&[-1.2, 1.0], 0.0),
            7 => (&[2.0, 2.0], -(3.0_f64.sqrt())),
            10 => (&[-10.0, 10.0], -1.0),
            11 => (&[4.9, 0.1], -8.498464223),
            12 => (&[0.0, 0.0], -30.0),
            14 => (&[2.0, 2.0], 9.0 - 2.875 * 7.0_f64.sqrt()),
            26 => (&[-2.6, 2.0, 2.0], 0.0),
            28 => (&[-4.0, 1.0, 1.0], 0.0),
            35 => (&[0.5, 0.5, 0.5], 1.0 / 9.0),
            38 => (&[-3.0, -1.0, -3.0, -1.0], 0.0),
            39 => (&[2.0, 2.0, 2.0, 2.0], -1.0),
            40 => (&[0.8, 0.8, 0.8, 0.8], -0.25),
            43 => (&[0.0, 0.0, 0.0, 0.0], -44.0),
            63 => (&[2.0, 2.0, 2.0], 961.7151721),
            66 => (&[0.0, 1.05, 2.9], 0.5181632741),
            71 => (&[1.0, 5.0, 5.0, 1.0], 17.0140173),
            76 => (&[0.5, 0.5, 0.5, 0.5], -4.681818181),
            77 => (&[2.0, 2.0, 2.0, 2.0, 2.0], 0.24150513),
            78 => (&[-2.0, 1.5, 2.0, -1.0, -1.0], -2.91970041),
            79 => (&[2.0, 2.0, 2.0, 2.0, 2.0], 0.0787768209),
            80 => (&[-2.0, 2.0, 2.0, -1.0, -1.0], 0.0539498478),
            100 => (&[1.0, 2.0, 0.0, 4.0, 0.0, 1.0, 1.0], 680.6300573),
            113 => (
                &[2.0, 3.0, 5.0, 5.0, 1.0, 2.0, 7.0, 3.0, 6.0, 10.0],
                24.3062091,
            ),
            other => panic!("problem {other} is not in the library"),
        };
        Published { start, minimum }
    }

    fn bounds(self) -> Vec<(f64, f64)> {
        let n = self.published().start.len();
        match self.0 {
            1 => vec![ANY, (-1.5, f64::INFINITY)],
            35 | 63 | 76 => vec![POSITIVE; n],
            38 => vec![(-10.0, 10.0); n],
            66 => vec![(0.0, 100.0), (0.0, 100.0), (0.0, 10.0)],
            71 => vec![(1.0, 5.0); n],
            80 => vec![
                (-2.3, 2.3),
                (-2.3, 2.3),
                (-3.2, 3.2),
                (-3.2, 3.2),
                (-3.2, 3.2),
            ],
            _ => vec![ANY; n],
        }
    }

    fn rows(self) -> Vec<Row> {
        let (equal, least) = (Row::equal(1.0), Row::at_least(1.0));
        match self.0 {
            1 | 38 => vec![],
            6 | 7 | 26 | 28 => vec![equal],
            10 | 11 | 12 | 35 => vec![least],
            14 => vec![equal, least],
            39 | 63 | 77 => vec![equal; 2],
            40 | 78 | 79 | 80 => vec![equal; 3],
            43 | 76 => vec![least; 3],
            66 => vec![least; 2],
            71 => vec![least, equal],
            100 => vec![least; 4],
            _ => vec![least; 8],
        }
    }
}

impl Programme for HockSchittkowski {
    fn variables(&self) -> Vec<Variable> {
        let bounds = self.bounds();
        bounds
            .iter()
            .enumerate()
            .map(|(k, &(l, u))| Variable::new(format!("x{}", k + 1), l, u, 1.0))
            .collect()
    }

    fn blocks(&self) -> Vec<Block> {
        vec![Block::new(
            format!("HS{}", self.0),
            (0..self.published().start.len()).collect(),
            self.rows(),
        )]
    }

    fn evaluate<D: Scalar>(&self, _: usize, x: &[D], f: &mut D, c: &mut [D]) {
        let sq = |v: D| v * v;
        match self.0 {
            1 => *f = sq(x[1] - sq(x[0])) * 100.0 + sq(-x[0] + 1.0),
            6 => {
                *f = sq(-x[0] + 1.0);
                c[0] = (x[1] - sq(x[0])) * 10.0;
            }
            7 => {
                *f = (sq(x[0]) + 1.0).ln() - x[1];
                c[0] = sq(sq(x[0]) + 1.0) + sq(x[1]) - 4.0;
            }
            10 => {
                *f = x[0] - x[1];
                c[0] = sq(x[0]) * -3.0 + x[0] * x[1] * 2.0 - sq(x[1]) + 1.0;
            }
            11 => {
                *f = sq(x[0] - 5.0) + sq(x[1]) - 25.0;
                c[0] = x[1] - sq(x[0]);
            }
            12 => {
                *f = sq(x[0]) * 0.5 + sq(x[1]) - x[0] * x[1] - x[0] * 7.0 - x[1] * 7.0;
                c[0] = -sq(x[0]) * 4.0 - sq(x[1]) + 25.0;
            }
            14 => {
                *f = sq(x[0] - 2.0) + sq(x[1] - 1.0);
                c[0] = x[0] - x[1] * 2.0 + 1.0;
                c[1] = -sq(x[0]) * 0.25 - sq(x[1]) + 1.0;
            }
            26 => {
                *f = sq(x[0] - x[1]) + (x[1] - x[2]).powi(4);
                c[0] = (sq(x[1]) + 1.0) * x[0] + x[2].powi(4) - 3.0;
            }
            28 => {
                *f = sq(x[0] + x[1]) + sq(x[1] + x[2]);
                c[0] = x[0] + x[1] * 2.0 + x[2] * 3.0 - 1.0;
            }
            35 => {
                *f = x[0] * -8.0 - x[1] * 6.0 - x[2] * 4.0
                    + sq(x[0]) * 2.0
                    + sq(x[1]) * 2.0
                    + sq(x[2])
                    + x[0] * x[1] * 2.0
                    + x[0] * x[2] * 2.0
                    + 9.0;
                c[0] = -x[0] - x[1] - x[2] * 2.0 + 3.0;
            }
            38 => {
                *f = sq(x[1] - sq(x[0])) * 100.0
                    + sq(-x[0] + 1.0)
                    + sq(x[3] - sq(x[2])) * 90.0
                    + sq(-x[2] + 1.0)
                    + (sq(x[1] - 1.0) + sq(x[3] - 1.0)) * 10.1
                    + (x[1] - 1.0) * (x[3] - 1.0) * 19.8;
            }
            39 => {
                *f = -x[0];
                c[0] = x[1] - x[0].powi(3) - sq(x[2]);
                c[1] = sq(x[0]) - x[1] - sq(x[3]);
            }
            40 => {
                *f = -x[0] * x[1] * x[2] * x[3];
                c[0] = x[0].powi(3) + sq(x[1]) - 1.0;
                c[1] = sq(x[0]) * x[3] - x[2];
                c[2] = sq(x[3]) - x[1];
            }
            43 => {
                *f = sq(x[0]) + sq(x[1]) + sq(x[2]) * 2.0 + sq(x[3])
                    - x[0] * 5.0
                    - x[1] * 5.0
                    - x[2] * 21.0
                    + x[3] * 7.0;
                c[0] = -sq(x[0]) - sq(x[1]) - sq(x[2]) - sq(x[3]) - x[0] + x[1] - x[2] + x[3] + 8.0;
                c[1] = -sq(x[0]) - sq(x[1]) * 2.0 - sq(x[2]) - sq(x[3]) * 2.0 + x[0] + x[3] + 10.0;
                c[2] = -sq(x[0]) * 2.0 - sq(x[1]) - sq(x[2]) - x[0] * 2.0 + x[1] + x[3] + 5.0;
            }
            63 => {
                *f = -sq(x[0]) - sq(x[1]) * 2.0 - sq(x[2]) - x[0] * x[1] - x[0] * x[2] + 1000.0;
                c[0] = x[0] * 8.0 + x[1] * 14.0 + x[2] * 7.0 - 56.0;
                c[1] = sq(x[0]) + sq(x[1]) + sq(x[2]) - 25.0;
            }
            66 => {
                *f = x[2] * 0.2 - x[0] * 0.8;
                c[0] = x[1] - x[0].exp();
                c[1] = x[2] - x[1].exp();
            }
            71 => {
                *f = x[0] * x[3] * (x[0] + x[1] + x[2]) + x[2];
                c[0] = x[0] * x[1] * x[2] * x[3] - 25.0;
                c[1] = sq(x[0]) + sq(x[1]) + sq(x[2]) + sq(x[3]) - 40.0;
            }
            76 => {
                *f = sq(x[0]) + sq(x[1]) * 0.5 + sq(x[2]) + sq(x[3]) * 0.5 - x[0] * x[2]
                    + x[2] * x[3]
                    - x[0]
                    - x[1] * 3.0
                    + x[2]
                    - x[3];
                c[0] = -x[0] - x[1] * 2.0 - x[2] - x[3] + 5.0;
                c[1] = x[0] * -3.0 - x[1] - x[2] * 2.0 + x[3] + 4.0;
                c[2] = x[1] + x[2] * 4.0 - 1.5;
            }
            77 => {
                *f = sq(x[0] - 1.0)
                    + sq(x[0] - x[1])
                    + sq(x[2] - 1.0)
                    + (x[3] - 1.0).powi(4)
                    + (x[4] - 1.0).powi(6);
                c[0] = sq(x[0]) * x[3] + (x[3] - x[4]).sin() - 2.0 * 2.0_f64.sqrt();
                c[1] = x[1] + x[2].powi(4) * sq(x[3]) - 8.0 - 2.0_f64.sqrt();
            }
            78 | 80 => {
                let product = x[0] * x[1] * x[2] * x[3] * x[4];
                *f = if self.0 == 78 { product } else { product.exp() };
                c[0] = x.iter().map(|&v| sq(v)).sum::<D>() - 10.0;
                c[1] = x[1] * x[2] - x[3] * x[4] * 5.0;
                c[2] = x[0].powi(3) + x[1].powi(3) + 1.0;
            }
            79 => {
                *f = sq(x[0] - 1.0)
                    + sq(x[0] - x[1])
                    + sq(x[1] - x[2])
                    + (x[2] - x[3]).powi(4)
                    + (x[3] - x[4]).powi(4);
                let root = 2.0_f64.sqrt();
                c[0] = x[0] + sq(x[1]) + x[2].powi(3) - 2.0 - 3.0 * root;
                c[1] = x[1] - sq(x[2]) + x[3] + 2.0 - 2.0 * root;
                c[2] = x[0] * x[4] - 2.0;
            }
            100 => {
                *f = sq(x[0] - 10.0)
                    + sq(x[1] - 12.0) * 5.0
                    + x[2].powi(4)
                    + sq(x[3] - 11.0) * 3.0
                    + x[4].powi(6) * 10.0
                    + sq(x[5]) * 7.0
                    + x[6].powi(4)
                    - x[5] * x[6] * 4.0
                    - x[5] * 10.0
                    - x[6] * 8.0;
                c[0] = sq(x[0]) * -2.0 - x[1].powi(4) * 3.0 - x[2] - sq(x[3]) * 4.0 - x[4] * 5.0
                    + 127.0;
                c[1] = x[0] * -7.0 - x[1] * 3.0 - sq(x[2]) * 10.0 - x[3] + x[4] + 282.0;
                c[2] = x[0] * -23.0 - sq(x[1]) - sq(x[5]) * 6.0 + x[6] * 8.0 + 196.0;
                c[3] = sq(x[0]) * -4.0 - sq(x[1]) + x[0] * x[1] * 3.0 - sq(x[2]) * 2.0 - x[5] * 5.0
                    + x[6] * 11.0;
            }
            _ => {
                *f = sq(x[0]) + sq(x[1]) + x[0] * x[1] - x[0] * 14.0 - x[1] * 16.0
                    + sq(x[2] - 10.0)
                    + sq(x[3] - 5.0) * 4.0
                    + sq(x[4] - 3.0)
                    + sq(x[5] - 1.0) * 2.0
                    + sq(x[6]) * 5.0
                    + sq(x[7] - 11.0) * 7.0
                    + sq(x[8] - 10.0) * 2.0
                    + sq(x[9] - 7.0)
                    + 45.0;
                c[0] = x[0] * -4.0 - x[1] * 5.0 + x[6] * 3.0 - x[7] * 9.0 + 105.0;
                c[1] = x[0] * -10.0 + x[1] * 8.0 + x[6] * 17.0 - x[7] * 2.0;
                c[2] = x[0] * 8.0 - x[1] * 2.0 - x[8] * 5.0 + x[9] * 2.0 + 12.0;
                c[3] = sq(x[0] - 2.0) * -3.0 - sq(x[1] - 3.0) * 4.0 - sq(x[2]) * 2.0
                    + x[3] * 7.0
                    + 120.0;
                c[4] = sq(x[0]) * -5.0 - x[1] * 8.0 - sq(x[2] - 6.0) + x[3] * 2.0 + 40.0;
                c[5] = sq(x[0] - 8.0) * -0.5 - sq(x[1] - 4.0) * 2.0 - sq(x[4]) * 3.0 + x[5] + 30.0;
                c[6] =
                    -sq(x[0]) - sq(x[1] - 2.0) * 2.0 + x[0] * x[1] * 2.0 - x[4] * 14.0 + x[5] * 6.0;
                c[7] = x[0] * 3.0 - x[1] * 6.0 - sq(x[8] - 8.0) * 12.0 + x[9] * 7.0;
            }
        }
    }
}
