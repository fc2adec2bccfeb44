//! Every collocation scheme on every control problem with a known answer.

mod library;

use library::control::{Brachistochrone, CartPole, DoubleIntegrator};
use trajectory::collocation::{Scheme, Transcription};
use trajectory::{Options, Solution, Start, solve};

fn schemes() -> Vec<Scheme> {
    vec![
        Scheme::trapezoid(),
        Scheme::hermite_simpson(),
        Scheme::radau2(),
        Scheme::radau3(),
    ]
}

fn show(name: &str, scheme: &Scheme, solution: &Solution) {
    println!(
        "{name} {} n {} {:?} cost {:.10} {:?} it {} qp {} el {} soc {}/{} newton {} ip {} fact {}",
        scheme.name,
        solution.x.len(),
        solution.status,
        solution.cost,
        solution.certificate,
        solution.counters.iterations,
        solution.counters.subproblems,
        solution.counters.elastic,
        solution.counters.corrections_accepted,
        solution.counters.corrections,
        solution.counters.newton_steps,
        solution.counters.interior_iterations,
        solution.counters.factorisations,
    );
    for h in &solution.history {
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

#[test]
fn double_integrator() {
    for scheme in schemes() {
        let problem = DoubleIntegrator {
            distance: 1.0,
            intervals: 10,
        };
        let t = Transcription::new(&problem, scheme.clone());
        let options = Options {
            history: true,
            ..Options::default()
        };
        let solution = solve(&t, &Start::cold(DoubleIntegrator::start(&t, 1.0)), &options).unwrap();
        show("double integrator", &scheme, &solution);
    }
}

#[test]
fn brachistochrone() {
    for scheme in schemes() {
        let problem = Brachistochrone {
            x: 10.0,
            y: 5.0,
            g: 9.81,
            intervals: 20,
        };
        let t = Transcription::new(&problem, scheme.clone());
        let options = Options {
            history: true,
            ..Options::default()
        };
        let solution = solve(&t, &Start::cold(problem.start(&t)), &options).unwrap();
        show("brachistochrone", &scheme, &solution);
        println!("{}", problem.shortest_time());
    }
}

#[test]
fn cart_pole() {
    for scheme in schemes() {
        let problem = CartPole { intervals: 25 };
        let t = Transcription::new(&problem, scheme.clone());
        let options = Options {
            history: true,
            ..Options::default()
        };
        let time = std::time::Instant::now();
        let solution = solve(&t, &Start::cold(CartPole::start(&t)), &options).unwrap();
        println!("{:?}", time.elapsed());
        show("cart-pole", &scheme, &solution);
    }
}
