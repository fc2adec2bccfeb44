//! Problems with one difficulty each: the part that must answer is counted.

mod library;

use library::special::{
    ContradictingLinearisation, DoubledRow, FlatValley, Impossible, LightLimit, Maratos,
    OutsideDomain, Saddle,
};
use trajectory::{
    Block, Multipliers, Options, Programme, ProgrammeError, Row, Scalar, Solution, Start, Status,
    StepKind, Variable, multistart, solve,
};

fn run<P: Programme>(problem: &P, start: &[f64], options: &Options) -> Solution {
    solve(problem, &Start::cold(start.to_vec()), options).expect("the library is consistent")
}

fn with_history() -> Options {
    Options {
        history: true,
        ..Options::default()
    }
}

#[test]
fn the_correction_answers_the_maratos_effect() {
    let angle = 0.5_f64;
    let start = [angle.cos(), angle.sin()];
    let monotone = Options {
        memory: 0,
        ..with_history()
    };
    let corrected = run(&Maratos, &start, &monotone);
    assert_eq!(corrected.status, Status::Solved);
    assert!(corrected.counters.corrections_accepted > 0);
    assert!((corrected.cost + 1.0).abs() < 1e-12);
    assert!(
        corrected.history.iter().all(|step| step.alpha == 1.0),
        "every step is full"
    );

    let plain = run(
        &Maratos,
        &start,
        &Options {
            second_order_correction: false,
            ..monotone
        },
    );
    assert_eq!(plain.counters.corrections, 0);
    assert!(
        plain.history.iter().any(|step| step.alpha < 1.0),
        "without it steps are cut"
    );
    assert!(plain.counters.iterations > corrected.counters.iterations);
}

#[test]
fn the_elastic_subproblem_answers_contradicting_rows() {
    let solution = run(
        &ContradictingLinearisation,
        &[-4.0, 1.0, 1.0],
        &with_history(),
    );
    assert!(solution.counters.elastic > 0);
    assert_eq!(solution.history[0].kind, StepKind::Elastic);
    // From x₁ < 0 the violation has a local minimum of 3 at (−1, 0, 0):
    // |x₁² − x₂ − 1| + |x₁ − x₃ − 2| grows in every direction that the bounds allow.
    assert_eq!(solution.status, Status::LocallyInfeasible);
    assert!((solution.x[0] + 1.0).abs() < 1e-5, "{:?}", solution.x);
    // From the other side the minimum is found.
    let solved = run(
        &ContradictingLinearisation,
        &[4.0, 1.0, 1.0],
        &with_history(),
    );
    assert_eq!(solved.status, Status::Solved);
    assert!((solved.cost - 2.0).abs() < 1e-10);
}

#[test]
fn impossible_rows_are_named() {
    let solution = run(&Impossible, &[1.0, 1.0], &Options::default());
    assert_eq!(solution.status, Status::LocallyInfeasible);
    assert!(solution.counters.elastic > 0);
    assert!(solution.certificate.error.violation > 1.0);
    assert!(!solution.status.is_solved());
}

#[test]
fn a_saddle_is_not_certified() {
    let on = run(&Saddle { bounded: true }, &[1.0, 0.0], &Options::default());
    assert_eq!(on.status, Status::Uncertified);
    assert!(!on.certificate.positive_definite);
    let off = run(&Saddle { bounded: true }, &[1.0, 0.1], &Options::default());
    assert_eq!(off.status, Status::Solved);
    assert!((off.cost + 4.0).abs() < 1e-12 && (off.multipliers.bounds[1] - 4.0).abs() < 1e-9);
    let endless = run(&Saddle { bounded: false }, &[1.0, 0.1], &Options::default());
    assert!(!endless.status.is_solved(), "{:?}", endless.status);
}

/// The sign of a multiplier is judged as the optimality error judges it, not by the size of the others: else the limit that it
/// belongs to is never left, and the error never falls.
#[test]
fn a_light_limit_beside_a_heavy_one_is_left() {
    let start = Start {
        x: vec![0.0, 0.0],
        multipliers: Some(Multipliers {
            rows: vec![-LightLimit::HEAVY],
            bounds: vec![0.0, LightLimit::LIGHT],
        }),
    };
    let solution = solve(&LightLimit, &start, &Options::default()).expect("a programme");
    assert_eq!(solution.status, Status::Solved);
    assert!((solution.x[1] - LightLimit::LIGHT).abs() < 1e-12);
    assert_eq!(solution.multipliers.bounds[1], 0.0);
}

/// Without pivoting and with unscaled rows, rounding drowns this curvature; shifts may bend neither step nor certificate.
#[test]
fn a_flat_valley_between_steep_rows_is_certified_with_its_own_curvature() {
    for curvature in [1.0, 1e-3, 3e-5] {
        let solution = run(&FlatValley { curvature }, &[5.0; 4], &Options::default());
        assert_eq!(
            solution.status,
            Status::Solved,
            "{curvature} {:?} {:?}",
            solution.certificate,
            solution.x
        );
        for (x, expected) in solution.x.iter().zip([0.0, 1.0, 4.0, 3.0]) {
            assert!((x - expected).abs() < 1e-6, "{curvature}: {:?}", solution.x);
        }
        let found = solution.certificate.smallest_curvature;
        assert!(
            (found - curvature).abs() < 1e-3 * curvature,
            "{found} / {curvature}"
        );
    }
    let flat = run(
        &FlatValley { curvature: 0.0 },
        &[5.0; 4],
        &Options::default(),
    );
    assert!(!flat.status.is_solved(), "{:?}", flat.status);
}

#[test]
fn dependent_rows_show_in_the_certificate() {
    let solution = run(&DoubledRow, &[1.0, 0.1], &Options::default());
    assert_eq!(
        solution.status,
        Status::Solved,
        "a strict minimum all the same"
    );
    assert!(!solution.certificate.independent());
    assert!((solution.cost - 0.5).abs() < 1e-9);
}

#[test]
fn a_start_outside_the_domain_is_named() {
    let solution = run(&OutsideDomain, &[-1.0, 0.1], &Options::default());
    assert_eq!(solution.status, Status::NonFiniteStart);
    assert!(
        solution
            .status
            .to_string()
            .contains("start inside its domain")
    );
}

#[test]
fn a_warm_start_costs_less() {
    use library::hock_schittkowski::HockSchittkowski;
    let problem = HockSchittkowski(71);
    let cold = run(&problem, problem.published().start, &Options::default());
    let warm = solve(&problem, &Start::warm(&cold), &Options::default()).expect("consistent");
    assert_eq!(warm.status, Status::Solved);
    assert_eq!(warm.counters.iterations, 0);
    assert_eq!(warm.counters.subproblems, 0);
    assert!((warm.cost - cold.cost).abs() < 1e-12);
}

#[test]
fn minima_are_named_whatever_the_order_of_starts() {
    let problem = Saddle { bounded: true };
    let starts: Vec<Start> = [-1.5, -0.3, 0.2, 0.9, 1.9]
        .iter()
        .map(|&x2| Start::cold(vec![1.0, x2]))
        .collect();
    let forward = multistart(&problem, &starts, &Options::default(), 1e-3).expect("consistent");
    assert_eq!(forward.minima.len(), 2);
    assert_eq!(
        forward.minima.iter().map(|m| m.starts.len()).sum::<usize>(),
        5
    );
    assert_eq!(forward.best().map(|m| m.name.as_str()), Some("A"));
    assert_eq!(
        forward.minima[0].solution.certificate.starts,
        Some((forward.minima[0].starts.len(), 5))
    );
    let backward: Vec<Start> = starts.into_iter().rev().collect();
    let backward = multistart(&problem, &backward, &Options::default(), 1e-3).expect("consistent");
    assert_eq!(backward.minima.len(), 2);
}

/// A programme that is wrong in the way the test asks for.
struct Wrong {
    variables: Vec<Variable>,
    block: Block,
}

impl Programme for Wrong {
    fn variables(&self) -> Vec<Variable> {
        self.variables.clone()
    }

    fn blocks(&self) -> Vec<Block> {
        vec![self.block.clone()]
    }

    fn evaluate<D: Scalar>(&self, _: usize, x: &[D], cost: &mut D, _: &mut [D]) {
        *cost = x[0] * x[0];
    }
}

#[test]
fn contradictions_in_the_programme_are_errors() {
    let error = |variable: Variable, list: Vec<usize>, row: Row| {
        let wrong = Wrong {
            variables: vec![variable],
            block: Block::new("b", list, vec![row]),
        };
        solve(&wrong, &Start::cold(vec![1.0]), &Options::default())
            .expect_err("it is wrong")
            .to_string()
    };
    let fine = Variable::free("x", 1.0);
    assert_eq!(
        error(Variable::free("x", 0.0), vec![0], Row::equal(1.0)),
        "variable `x` has scale 0, which must be positive and finite"
    );
    assert_eq!(
        error(Variable::new("x", 2.0, 1.0, 1.0), vec![0], Row::equal(1.0)),
        "variable `x` has the limits 2 and 1, which exclude each other"
    );
    assert_eq!(
        error(fine.clone(), vec![1], Row::equal(1.0)),
        "`b` names variable 1, but there are only 1"
    );
    assert_eq!(
        error(fine.clone(), vec![0, 0], Row::equal(1.0)),
        "`b` names variable 0 twice"
    );
    assert_eq!(
        error(fine, vec![0], Row::between(f64::NAN, 1.0, 1.0)),
        "row `b` has the limits NaN and 1, which exclude each other"
    );
    let short = solve(&Maratos, &Start::cold(vec![1.0]), &Options::default());
    assert_eq!(
        short,
        Err(ProgrammeError::WrongLength {
            what: "the start",
            got: 1,
            need: 2
        })
    );
    let start = Start {
        x: vec![1.0, 0.0],
        multipliers: Some(Multipliers::default()),
    };
    assert!(solve(&Maratos, &start, &Options::default()).is_err());
}
