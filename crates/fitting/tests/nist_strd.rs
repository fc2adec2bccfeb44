//! Certified nonlinear regressions of the NIST Statistical Reference Datasets.
//!
//! Source: NIST/ITL StRD, nonlinear regression, <https://www.itl.nist.gov/div898/strd/nls/nls_main.shtml>; the files under
//! `nist_strd/` are NIST's own, unchanged (public domain), with data, both published starts and certified values.

use fitting::{Bounds, Fit, Options, Residuals, minimise, multi_start, spread_starts};
use nalgebra::{DMatrix, DVector};
use num_dual::{Dual64, DualNum};

type Model = fn(Dual64, &[Dual64]) -> Dual64;

struct Dataset {
    starts: [Vec<f64>; 2],
    certified: Vec<f64>,
    deviations: Vec<f64>,
    residual_sum: f64,
    y: Vec<f64>,
    x: Vec<f64>,
}

/// Reads NIST's layout: parameter lines `b1 = start1 start2 value deviation`, the sum, then `y x` after the second `Data:`.
fn read(text: &str) -> Dataset {
    let numbers = |s: &str| -> Vec<f64> {
        s.split_whitespace()
            .map(|w| w.parse().expect("number"))
            .collect()
    };
    let mut rows: Vec<Vec<f64>> = Vec::new();
    let mut residual_sum = f64::NAN;
    let (mut y, mut x) = (Vec::new(), Vec::new());
    let mut data_marks = 0;
    for line in text.lines() {
        if line.starts_with("Data:") {
            data_marks += 1;
        } else if data_marks == 2 && !line.trim().is_empty() {
            let row = numbers(line);
            y.push(row[0]);
            x.push(row[1]);
        } else if let Some((name, rest)) = line.split_once('=') {
            let name = name.trim();
            if name.starts_with('b') && name[1..].parse::<u32>().is_ok() {
                rows.push(numbers(rest));
            }
        } else if let Some(rest) = line.strip_prefix("Residual Sum of Squares:") {
            residual_sum = numbers(rest)[0];
        }
    }
    let column = |k: usize| rows.iter().map(|r| r[k]).collect::<Vec<f64>>();
    Dataset {
        starts: [column(0), column(1)],
        certified: column(2),
        deviations: column(3),
        residual_sum,
        y,
        x,
    }
}

struct Regression<'a> {
    data: &'a Dataset,
    model: Model,
}

impl Residuals for Regression<'_> {
    fn residuals(&self, p: &[f64]) -> DVector<f64> {
        self.jacobian_columns(p, &[]).0
    }

    fn jacobian(&self, p: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        let columns: Vec<usize> = (0..p.len()).collect();
        self.jacobian_columns(p, &columns)
    }

    fn jacobian_columns(&self, p: &[f64], columns: &[usize]) -> (DVector<f64>, DMatrix<f64>) {
        let b: Vec<Dual64> = p.iter().map(|&v| Dual64::from_re(v)).collect();
        let d = self.data;
        let r = DVector::from_fn(d.y.len(), |i, _| {
            (self.model)(Dual64::from_re(d.x[i]), &b).re - d.y[i]
        });
        let j = DMatrix::from_fn(d.y.len(), columns.len(), |i, k| {
            let mut seeded = b.clone();
            seeded[columns[k]].eps = 1.0;
            (self.model)(Dual64::from_re(d.x[i]), &seeded).eps
        });
        (r, j)
    }
}

fn significant_digits(got: f64, certified: f64) -> f64 {
    -((got - certified).abs() / certified.abs())
        .max(1e-16)
        .log10()
}

/// Where the far start leads into a plateau from which no descent method returns.
enum Starts {
    /// Both published starts.
    Both,
    /// The near one, and a spread of starts over the box between the two.
    NearAndSpread,
}

/// From the published starts: certified values to `digits` significant digits, the residual sum to 1e-9, the
/// standard deviations to 1e-5.
fn certify(text: &str, model: Model, digits: f64, starts: Starts) {
    let data = read(text);
    let problem = Regression { data: &data, model };
    let n = data.certified.len();
    let options = Options {
        iteration_limit: 2000,
        ..Options::default()
    };
    for which in 0..2 {
        let fit: Fit = if which == 0 && matches!(starts, Starts::NearAndSpread) {
            let spread = spread_starts(&data.starts[1], &data.starts[0], 12);
            multi_start(&problem, &spread, &Bounds::free(n), &options)
                .unwrap()
                .best
        } else {
            minimise(&problem, &data.starts[which], &Bounds::free(n), &options).unwrap()
        };
        assert!(
            fit.status.converged(),
            "start {}: {} after {} steps at {:?}",
            which + 1,
            fit.status,
            fit.iterations,
            fit.parameters
        );
        for (got, certified) in fit.parameters.iter().zip(&data.certified) {
            let found = significant_digits(*got, *certified);
            assert!(
                found >= digits,
                "start {}: {got} against {certified}: {found:.1} digits",
                which + 1
            );
        }
        let sum = 2.0 * fit.cost;
        assert!(
            (sum / data.residual_sum - 1.0).abs() < 1e-9,
            "{sum} {}",
            data.residual_sum
        );
        let s2 = sum / (data.y.len() - n) as f64;
        for (j, certified) in data.deviations.iter().enumerate() {
            let deviation = fit.standard_deviation(j).unwrap() * s2.sqrt();
            assert!(
                (deviation / certified - 1.0).abs() < 1e-5,
                "deviation {deviation} against {certified}"
            );
        }
    }
}

macro_rules! certified {
    ($name:ident, $file:literal, $digits:literal, $starts:ident, $model:expr) => {
        #[test]
        fn $name() {
            certify(
                include_str!(concat!("nist_strd/", $file, ".dat")),
                $model,
                $digits,
                Starts::$starts,
            );
        }
    };
}

certified!(misra1a, "Misra1a", 6.0, Both, |x, b| b[0]
    * (-(-b[1] * x).exp() + 1.0));
certified!(chwirut2, "Chwirut2", 6.0, Both, |x, b| (-b[0] * x).exp()
    / (b[1] + b[2] * x));
certified!(lanczos3, "Lanczos3", 5.0, Both, |x, b| b[0]
    * (-b[1] * x).exp()
    + b[2] * (-b[3] * x).exp()
    + b[4] * (-b[5] * x).exp());
certified!(roszman1, "Roszman1", 6.0, Both, |x, b| b[0]
    - b[1] * x
    - (b[2] / (x - b[3])).atan() / std::f64::consts::PI);
certified!(mgh09, "MGH09", 6.0, Both, |x, b| b[0] * (x * x + x * b[1])
    / (x * x + x * b[2] + b[3]));
certified!(mgh10, "MGH10", 6.0, NearAndSpread, |x, b| b[0]
    * (b[1] / (x + b[2])).exp());
certified!(mgh17, "MGH17", 6.0, Both, |x, b| b[0]
    + b[1] * (-x * b[3]).exp()
    + b[2] * (-x * b[4]).exp());
certified!(thurber, "Thurber", 6.0, Both, |x, b| (b[0]
    + b[1] * x
    + b[2] * x * x
    + b[3] * x * x * x)
    / (b[4] * x + b[5] * x * x + b[6] * x * x * x + 1.0));
certified!(box_bod, "BoxBOD", 6.0, NearAndSpread, |x, b| b[0]
    * (-(-b[1] * x).exp() + 1.0));
certified!(rat42, "Rat42", 6.0, Both, |x, b| b[0]
    / ((b[1] - b[2] * x).exp() + 1.0));
certified!(rat43, "Rat43", 6.0, Both, |x, b| b[0]
    / ((b[1] - b[2] * x).exp() + 1.0).powd(b[3].recip()));
certified!(eckerle4, "Eckerle4", 6.0, Both, |x, b| b[0] / b[1]
    * (((x - b[2]) / b[1]).powi(2) * -0.5).exp());
certified!(bennett5, "Bennett5", 6.0, Both, |x, b| b[0]
    * (b[1] + x).powd(-b[2].recip()));
