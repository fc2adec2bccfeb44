//! Every collocation scheme on every control problem with a known answer.

mod library;

use library::control::{Brachistochrone, CartPole, DoubleIntegrator};
use std::fmt::Write;
use trajectory::collocation::{OptimalControl, PhaseTrajectory, Scheme, Transcription};
use trajectory::{Options, Solution, Start, Status, multistart, solve};

fn schemes() -> Vec<Scheme> {
    vec![
        Scheme::trapezoid(),
        Scheme::hermite_simpson(),
        Scheme::radau2(),
        Scheme::radau3(),
    ]
}

fn run<P: OptimalControl>(t: &Transcription<'_, P>, start: Vec<f64>) -> Solution {
    let solution =
        solve(t, &Start::cold(start), &Options::default()).expect("the library is consistent");
    assert_eq!(solution.status, Status::Solved);
    solution
}

fn cart_pole(scheme: Scheme, intervals: usize) -> (Solution, PhaseTrajectory) {
    let problem = CartPole { intervals };
    let t = Transcription::new(&problem, scheme);
    let solution = run(&t, CartPole::start(&t));
    let trajectory = t.trajectories(&solution.x).remove(0);
    (solution, trajectory)
}

fn brachistochrone(scheme: Scheme, intervals: usize) -> f64 {
    let problem = Brachistochrone {
        x: 10.0,
        y: 5.0,
        g: 9.81,
        intervals,
    };
    let t = Transcription::new(&problem, scheme);
    run(&t, problem.start(&t)).cost
}

#[test]
fn the_shortest_time_of_a_double_integrator_is_bang_bang() {
    for scheme in schemes() {
        let problem = DoubleIntegrator {
            distance: 1.0,
            intervals: 10,
        };
        let t = Transcription::new(&problem, scheme.clone());
        let solution = run(&t, DoubleIntegrator::start(&t, 1.0));
        let error = (solution.cost - problem.shortest_time()).abs();
        // The switch lies on the mesh. A trapezoid cannot jump there and loses its square in time.
        let tolerance = if scheme.name == "trapezoid" {
            0.02
        } else {
            1e-9
        };
        assert!(error < tolerance, "{}: off by {error}", scheme.name);
        if scheme.name != "trapezoid" {
            let trajectory = t.trajectories(&solution.x).remove(0);
            let inside = |share: f64| trajectory.at(share * trajectory.duration_s).a[0];
            assert!((inside(0.2) - 1.0).abs() < 1e-9 && (inside(0.8) + 1.0).abs() < 1e-9);
        }
    }
}

#[test]
fn the_brachistochrone_is_the_cycloid() {
    let exact = Brachistochrone {
        x: 10.0,
        y: 5.0,
        g: 9.81,
        intervals: 1,
    }
    .shortest_time();
    for (scheme, tolerance) in schemes().into_iter().zip([1e-3, 1e-7, 1e-5, 1e-8]) {
        let name = scheme.name;
        let time = brachistochrone(scheme, 20);
        assert!(
            (time - exact).abs() < tolerance,
            "{name}: {time} instead of {exact}"
        );
    }
}

/// The error of the shortest time falls with a power of the step that is at least the scheme's order.
#[test]
fn costs_converge_with_the_order_of_the_scheme() {
    let exact = Brachistochrone {
        x: 10.0,
        y: 5.0,
        g: 9.81,
        intervals: 1,
    }
    .shortest_time();
    for (scheme, meshes) in schemes()
        .into_iter()
        .zip([[20, 40], [6, 12], [10, 20], [4, 8]])
    {
        let [coarse, fine] = meshes.map(|n| (brachistochrone(scheme.clone(), n) - exact).abs());
        let slope = (coarse / fine).log2();
        assert!(
            slope > scheme.order as f64 - 0.4,
            "{}: order {slope:.2}",
            scheme.name
        );
    }
}

/// Defects by quadrature of the polynomials themselves, not by the scheme's tables.
#[test]
fn positions_and_velocities_are_integrals_on_a_separate_path() {
    for scheme in schemes() {
        let (_, trajectory) = cart_pole(scheme.clone(), 12);
        let h = trajectory.duration_s / 12.0;
        for interval in 0..12 {
            let (from, to) = (interval as f64 * h, (interval + 1) as f64 * h);
            for k in 0..2 {
                // Five-point Gauss-Legendre is exact for every polynomial here.
                let nodes = [
                    -0.906_179_845_938_664,
                    -0.538_469_310_105_683,
                    0.0,
                    0.538_469_310_105_683,
                    0.906_179_845_938_664,
                ];
                let weights = [
                    0.236_926_885_056_189,
                    0.478_628_670_499_366,
                    0.568_888_888_888_889,
                    0.478_628_670_499_366,
                    0.236_926_885_056_189,
                ];
                let integral = |pick: &dyn Fn(f64) -> f64| -> f64 {
                    let middle = 0.5 * (from + to);
                    nodes
                        .iter()
                        .zip(weights)
                        .map(|(x, w)| 0.5 * h * w * pick(middle + 0.5 * h * x))
                        .sum()
                };
                let dv = integral(&|time| trajectory.at(time).a[k]);
                let dq = integral(&|time| trajectory.at(time).v[k]);
                let (a, b) = (trajectory.at(from + 1e-12), trajectory.at(to - 1e-12));
                assert!((b.v[k] - a.v[k] - dv).abs() < 1e-8, "{}", scheme.name);
                assert!((b.q[k] - a.q[k] - dq).abs() < 1e-8, "{}", scheme.name);
            }
        }
    }
}

/// The optimised force drives the explicit equations of motion to the target.
#[test]
fn optimised_controls_reach_the_target_when_integrated() {
    let drift = |intervals: usize| {
        let (_, trajectory) = cart_pole(Scheme::radau3(), intervals);
        let steps = 40 * intervals;
        let h = trajectory.duration_s / steps as f64;
        let mut state = [0.0; 4];
        let rate = |time: f64, s: [f64; 4]| {
            let a = CartPole::accelerations([s[0], s[1]], [s[2], s[3]], trajectory.at(time).u[0]);
            [s[2], s[3], a[0], a[1]]
        };
        let along = |s: [f64; 4], h: f64, k: [f64; 4]| std::array::from_fn(|i| s[i] + h * k[i]);
        for n in 0..steps {
            let time = n as f64 * h;
            let k1 = rate(time + 1e-12, state);
            let k2 = rate(time + 0.5 * h, along(state, 0.5 * h, k1));
            let k3 = rate(time + 0.5 * h, along(state, 0.5 * h, k2));
            let k4 = rate(time + h - 1e-12, along(state, h, k3));
            for i in 0..4 {
                state[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
            }
        }
        (state[0] - CartPole::DISTANCE_M).abs() + (state[1] - std::f64::consts::PI).abs()
    };
    let (coarse, fine) = (drift(20), drift(40));
    // The pole is unstable where it ends: errors grow e-fold every 0.2 s.
    assert!(fine < 1e-3, "the target is missed by {fine}");
    assert!(
        fine < coarse / 8.0,
        "the drift falls only from {coarse} to {fine}"
    );
}

#[test]
fn fine_meshes_of_all_schemes_agree_on_the_cart_pole() {
    let reference = cart_pole(Scheme::radau3(), 60).0.cost;
    for (scheme, tolerance) in schemes().into_iter().zip([1e-2, 1e-4, 2e-4, 1e-5]) {
        let name = scheme.name;
        let cost = cart_pole(scheme, 50).0.cost;
        assert!(
            (cost - reference).abs() < tolerance * reference,
            "{name}: {cost} and {reference}"
        );
    }
}

/// The same transcription and start, solved by another code.
#[test]
fn minima_agree_with_ipopt() {
    let golden = include_str!("golden/ipopt.csv");
    let mut compared = 0;
    for line in golden.lines().filter(|line| !line.starts_with('#')) {
        let mut cells = line.split(',');
        let (problem, name, cost) = (cells.next(), cells.next(), cells.next());
        let scheme = schemes()
            .into_iter()
            .find(|s| Some(s.name) == name)
            .expect("a known scheme");
        let theirs: f64 = cost.and_then(|c| c.parse().ok()).expect("a number");
        let ours = match problem {
            Some("cart-pole") => cart_pole(scheme, 25).0.cost,
            _ => brachistochrone(scheme, 20),
        };
        // Their interior-point method stops a barrier parameter of about 1e-10 short.
        assert!(
            (ours - theirs).abs() < 1e-8 * theirs,
            "{line}: ours is {ours}"
        );
        compared += 1;
    }
    assert_eq!(compared, 8);
}

#[test]
fn one_thread_and_two_give_the_same_bits() {
    let problem = CartPole { intervals: 15 };
    let t = Transcription::new(&problem, Scheme::hermite_simpson());
    let starts: Vec<Start> = (0..4)
        .map(|k| {
            let mut x = CartPole::start(&t);
            let wiggle = x.len();
            x.iter_mut()
                .enumerate()
                .for_each(|(i, v)| *v += 0.02 * f64::from(k) * ((i * 7 % wiggle) as f64).sin());
            Start::cold(x)
        })
        .collect();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("a pool");
        pool.install(|| multistart(&t, &starts, &Options::default(), 1e-4))
            .expect("consistent")
    };
    let (one, two) = (on(1), on(2));
    let bits = |m: &trajectory::MultiStart| -> Vec<u64> {
        m.solutions
            .iter()
            .flat_map(|s| s.x.iter().map(|v| v.to_bits()))
            .collect()
    };
    assert_eq!(bits(&one), bits(&two));
    assert!(one.best().is_some());
}

#[test]
fn work_counters() {
    let mut table = String::new();
    let mut line = |name: &str, scheme: &Scheme, s: &Solution| {
        let c = s.counters;
        writeln!(
            table,
            "{name:<18} {:<16} variables {:>4}  iterations {:>3}  subproblems {:>3}  corrections {:>3} ({})  newton {:>3}",
            scheme.name, s.x.len(), c.iterations, c.subproblems, c.corrections, c.corrections_accepted, c.newton_steps,
        )
        .expect("a string takes any text");
    };
    for scheme in schemes() {
        let problem = DoubleIntegrator {
            distance: 1.0,
            intervals: 10,
        };
        let t = Transcription::new(&problem, scheme.clone());
        line(
            "double integrator",
            &scheme,
            &run(&t, DoubleIntegrator::start(&t, 1.0)),
        );
        let problem = Brachistochrone {
            x: 10.0,
            y: 5.0,
            g: 9.81,
            intervals: 20,
        };
        let t = Transcription::new(&problem, scheme.clone());
        line("brachistochrone", &scheme, &run(&t, problem.start(&t)));
        line("cart-pole", &scheme, &cart_pole(scheme.clone(), 25).0);
    }
    insta::assert_snapshot!(table);
}
