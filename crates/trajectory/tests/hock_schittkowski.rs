//! Every Hessian model on every problem of the Hock and Schittkowski library.

mod library;

use library::hock_schittkowski::{HockSchittkowski, NUMBERS};
use std::fmt::Write;
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

/// The minimum of problem 26 is flat to fourth order: (x₁ − x₂)² + (x₂ − x₃)⁴
/// has a singular reduced Hessian there. It may be found, not certified.
const FLAT: u32 = 26;

#[test]
fn published_minima_are_found_and_certified() {
    for hessian in [HessianModel::ExactClip, HessianModel::ExactMirror] {
        for &number in NUMBERS {
            let solution = run(number, hessian);
            let expected = if number == FLAT {
                Status::Uncertified
            } else {
                Status::Solved
            };
            assert_eq!(solution.status, expected, "HS{number} with {hessian:?}");
            // The collection prints nine or ten digits.
            let minimum = HockSchittkowski(number).published().minimum;
            let error = (solution.cost - minimum).abs() / minimum.abs().max(1.0);
            assert!(
                error < 1e-7,
                "HS{number} with {hessian:?}: {} instead of {minimum}",
                solution.cost
            );
        }
    }
}

/// Without the curvature of the constraints a solve may end without a solution,
/// but what it calls solved is a minimum, and it may not need fewer iterations overall.
#[test]
fn forgetting_the_constraints_curvature_costs_iterations() {
    let (mut exact, mut forgetful) = (0, 0);
    for &number in NUMBERS.iter().filter(|&&n| n != FLAT) {
        let options = |hessian| Options {
            hessian,
            newton_steps: false,
            ..Options::default()
        };
        let problem = HockSchittkowski(number);
        let start = Start::cold(problem.published().start.to_vec());
        let clip = solve(&problem, &start, &options(HessianModel::ExactClip)).expect("consistent");
        let cost = solve(&problem, &start, &options(HessianModel::CostOnly)).expect("consistent");
        exact += clip.counters.iterations;
        forgetful += cost.counters.iterations;
        assert!(
            cost.certificate.error.worst() < 1e-8 || !cost.status.is_solved(),
            "HS{number}"
        );
    }
    assert!(
        forgetful > exact,
        "{forgetful} iterations without, {exact} with the constraints' curvature"
    );
}

#[test]
fn work_counters() {
    let mut table = String::new();
    for &number in NUMBERS {
        let solution = run(number, HessianModel::ExactClip);
        let c = solution.counters;
        writeln!(
            table,
            "HS{number:<4} {:<12} iterations {:>3}  subproblems {:>3}  elastic {:>2}  corrections {:>3} ({})  newton {:>3}  values {:>3}",
            format!("{:?}", solution.status),
            c.iterations,
            c.subproblems,
            c.elastic,
            c.corrections,
            c.corrections_accepted,
            c.newton_steps,
            c.value_evaluations,
        )
        .expect("a string takes any text");
    }
    insta::assert_snapshot!(table);
}
