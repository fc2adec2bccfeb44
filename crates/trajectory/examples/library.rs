//! Solves the control problems of the test library and prints one line of JSON
//! each: for the comparison under `benches/ipopt`.

#[path = "../tests/library/mod.rs"]
mod library;

use library::control::{Brachistochrone, CartPole, DoubleIntegrator};
use library::five_link::{FiveLink, LINKS};
use std::time::Instant;
use trajectory::collocation::{OptimalControl, Scheme, Transcription};
use trajectory::{Options, Start, solve};

const REPEATS: usize = 5;

fn line<P: OptimalControl>(
    problem: &str,
    t: &Transcription<'_, P>,
    scheme: &Scheme,
    start: Vec<f64>,
) {
    let start = Start::cold(start);
    let mut seconds = f64::INFINITY;
    let mut last = None;
    for _ in 0..REPEATS {
        let clock = Instant::now();
        last = Some(solve(t, &start, &Options::default()));
        seconds = seconds.min(clock.elapsed().as_secs_f64());
    }
    let Some(Ok(s)) = last else { return };
    println!(
        "{{\"problem\": \"{problem}\", \"scheme\": \"{}\", \"variables\": {}, \"status\": \"{:?}\", \"cost\": {:.15e}, \
         \"iterations\": {}, \"subproblems\": {}, \"seconds\": {seconds:.6}}}",
        scheme.name,
        s.x.len(),
        s.status,
        s.cost,
        s.counters.iterations,
        s.counters.subproblems,
    );
}

fn main() {
    for scheme in [
        Scheme::trapezoid(),
        Scheme::hermite_simpson(),
        Scheme::radau2(),
        Scheme::radau3(),
    ] {
        let problem = DoubleIntegrator {
            distance: 1.0,
            intervals: 10,
        };
        let t = Transcription::new(&problem, scheme.clone());
        line(
            "double-integrator",
            &t,
            &scheme,
            DoubleIntegrator::start(&t, 1.0),
        );
        let problem = Brachistochrone {
            x: 10.0,
            y: 5.0,
            g: 9.81,
            intervals: 20,
        };
        let t = Transcription::new(&problem, scheme.clone());
        line("brachistochrone", &t, &scheme, problem.start(&t));
        for intervals in [25, 100] {
            let problem = CartPole { intervals };
            let t = Transcription::new(&problem, scheme.clone());
            line(
                &format!("cart-pole-{intervals}"),
                &t,
                &scheme,
                CartPole::start(&t),
            );
        }
        for (name, problem) in [
            ("five-link", FiveLink::published(25)),
            ("five-link-held", FiveLink::held(25)),
        ] {
            let t = Transcription::new(&problem, scheme.clone());
            line(name, &t, &scheme, problem.start(&t, [[0.0; LINKS]; 2]));
        }
    }
}
