//! Every Hessian model on every problem of the Hock and Schittkowski library.

mod library;

use library::hock_schittkowski::{HockSchittkowski, NUMBERS};
use trajectory::{HessianModel, Options, Solution, Start, Status, solve};

fn run(number: u32, hessian: HessianModel) -> Solution {
    let problem = HockSchittkowski(number);
    let options = Options {
        hessian,
        ..Options::default()
    };
    solve(
        &problem,
        &Start::cold(problem.published().start.to_vec()),
        &options,
    )
    .expect("the library is consistent")
}

#[test]
fn counters() {
    for hessian in [HessianModel::ExactClip, HessianModel::ExactMirror] {
        for &number in NUMBERS {
            let s = run(number, hessian);
            let p = HockSchittkowski(number).published();
            println!(
                "HS{number} {hessian:?} {:?} f {:.9} ({:.9}) {:?} err {:.1e} σ {:.1e} λ {:.1e}",
                s.status,
                s.cost,
                p.minimum,
                s.counters,
                s.certificate.error.worst(),
                s.certificate.smallest_singular_value,
                s.certificate.smallest_curvature
            );
            let _ = Status::Solved;
        }
    }
}
