//! Problems with one difficulty each: the part that must answer is counted.

mod library;

use library::special::*;
use trajectory::{Options, Programme, Solution, Start, solve};

fn run<P: Programme>(problem: &P, start: &[f64], options: &Options) -> Solution {
    solve(problem, &Start::cold(start.to_vec()), options).expect("the library is consistent")
}

fn options() -> Options {
    Options {
        history: true,
        ..Options::default()
    }
}

#[test]
fn show() {
    let angle = 0.5_f64;
    let s = [
        run(&Maratos, &[angle.cos(), angle.sin()], &options()),
        run(
            &Maratos,
            &[angle.cos(), angle.sin()],
            &Options {
                second_order_correction: false,
                ..options()
            },
        ),
        run(&ContradictingLinearisation, &[-4.0, 1.0, 1.0], &options()),
        run(&Impossible, &[1.0, 1.0], &options()),
        run(&Saddle { bounded: true }, &[1.0, 0.0], &options()),
        run(&Saddle { bounded: true }, &[1.0, 0.1], &options()),
        run(&Saddle { bounded: false }, &[1.0, 0.1], &options()),
        run(&DoubledRow, &[1.0, 0.1], &options()),
        run(&OutsideDomain, &[-1.0, 0.1], &options()),
    ];
    for s in s {
        println!(
            "{:?} {:?} {} {:?}\n {:?}",
            s.status, s.x, s.cost, s.counters, s.certificate
        );
        for h in s.history {
            println!(
                "   f {:.6e} v {:.2e} opt {:.2e} α {:.3} |d| {:.2e} ρ {:.1e} {:?} λ {:.2e} {}",
                h.cost,
                h.violation,
                h.optimality,
                h.alpha,
                h.step,
                h.penalty,
                h.kind,
                h.smallest_eigenvalue,
                h.changed_eigenvalues
            );
        }
    }
}
