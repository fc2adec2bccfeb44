//! The walker of five links by a second derivation: a chain that hangs from a free hip, its stance foot held by a force.
//!
//! ```text
//! w = (hip x, hip y, q_1 … q_5)         G_k = hip + Σ_j B_kj e_j        J_k = ∂G_k/∂w
//! M = Σ m_k J_kᵀ J_k + diag(0, 0, I)
//! [M  −Jᵀ] [ẅ]   [τ − Σ m_k J_kᵀ (g e_y − Σ_j B_kj e_j q̇_j²)]
//! [J   0 ] [f] = [Σ_j B_j e_j q̇_j²                         ]     J, B_j of the stance foot: it does not move
//!
//! [M  −Jᵀ] [ẇ⁺]   [M ẇ⁻]
//! [J   0 ] [p ] = [0   ]                                          J of the swing foot: it stops
//! ```
//!
//! The library's own equations are angular momenta of a chain that stands on its foot; nothing here is shared with them
//! but the numbers of the robot.

mod library;

use library::five_link::{
    FiveLink, G, INERTIA_KG_M2, LEG_M, LINKS, MASS_KG, SHIN_COM_M, THIGH_COM_M,
};
use nalgebra::{SMatrix, SVector};
use trajectory::collocation::{
    EndPoint, OptimalControl, PhaseTrajectory, Point, PointRows, Scheme, Transcription,
};
use trajectory::{Options, Start, Status, solve};

/// Coordinates: the hip and the five angles.
const ALL: usize = 2 + LINKS;
type Coordinates = SVector<f64, ALL>;
type Jacobian = SMatrix<f64, 2, ALL>;
/// Arms B_j of a point of the walker from its hip.
type Arms = [f64; LINKS];

const STANCE_FOOT: Arms = [-LEG_M, -LEG_M, 0.0, 0.0, 0.0];
const SWING_FOOT: Arms = [0.0, 0.0, 0.0, -LEG_M, -LEG_M];
/// Torque i turns the first link and pushes back on the second.
const MOTORS: [(usize, usize); LINKS - 1] = [(1, 0), (2, 1), (3, 2), (4, 3)];

/// A state of the walker, hip included.
#[derive(Clone, Copy)]
struct State {
    w: Coordinates,
    rate: Coordinates,
}

struct Walker {
    centres: [Arms; LINKS],
}

impl Walker {
    fn new(problem: &FiveLink) -> Self {
        let (l, shin, thigh) = (LEG_M, SHIN_COM_M, THIGH_COM_M);
        Self {
            centres: [
                [-shin, -l, 0.0, 0.0, 0.0],
                [0.0, -thigh, 0.0, 0.0, 0.0],
                [0.0, 0.0, problem.torso_com_m, 0.0, 0.0],
                [0.0, 0.0, 0.0, -thigh, 0.0],
                [0.0, 0.0, 0.0, -l, -shin],
            ],
        }
    }

    fn mass(&self, s: &State) -> SMatrix<f64, ALL, ALL> {
        let turn = |i: usize| if i < 2 { 0.0 } else { INERTIA_KG_M2[i - 2] };
        let mut mass = SMatrix::from_diagonal(&Coordinates::from_fn(|i, _| turn(i)));
        for (arms, m) in self.centres.iter().zip(MASS_KG) {
            let j = jacobian(s, arms);
            mass += j.transpose() * j * m;
        }
        mass
    }

    /// Accelerations, and the force of the ground on the stance foot in N.
    fn forward(&self, s: &State, torques_nm: &[f64]) -> (Coordinates, [f64; 2]) {
        let mut force = Coordinates::zeros();
        for (torque, (link, reaction)) in torques_nm.iter().zip(MOTORS) {
            force[2 + link] += torque;
            force[2 + reaction] -= torque;
        }
        for (arms, m) in self.centres.iter().zip(MASS_KG) {
            let held = SVector::from([0.0, G]) - inward(s, arms);
            force -= jacobian(s, arms).transpose() * held * m;
        }
        let (a, f) = held(
            self.mass(s),
            jacobian(s, &STANCE_FOOT),
            force,
            inward(s, &STANCE_FOOT),
        );
        (a, [f[0], f[1]])
    }

    /// Rates after the swing foot has struck, and the impulse on it in N s.
    fn strike(&self, s: &State) -> (Coordinates, [f64; 2]) {
        let mass = self.mass(s);
        let (rate, p) = held(
            mass,
            jacobian(s, &SWING_FOOT),
            mass * s.rate,
            SVector::zeros(),
        );
        (rate, [p[0], p[1]])
    }

    /// Kinetic plus potential energy in J.
    fn energy_j(&self, s: &State) -> f64 {
        let height = |arms: &Arms| place(s, arms)[1];
        let potential: f64 = self
            .centres
            .iter()
            .zip(MASS_KG)
            .map(|(a, m)| m * G * height(a))
            .sum();
        0.5 * s.rate.dot(&(self.mass(s) * s.rate)) + potential
    }
}

/// [M −Jᵀ; J 0] [x; f] = [right; stop].
fn held(
    mass: SMatrix<f64, ALL, ALL>,
    j: Jacobian,
    right: Coordinates,
    stop: SVector<f64, 2>,
) -> (Coordinates, SVector<f64, 2>) {
    let mut matrix = SMatrix::<f64, 9, 9>::zeros();
    matrix.fixed_view_mut::<ALL, ALL>(0, 0).copy_from(&mass);
    matrix.fixed_view_mut::<2, ALL>(ALL, 0).copy_from(&j);
    matrix
        .fixed_view_mut::<ALL, 2>(0, ALL)
        .copy_from(&-j.transpose());
    let mut all = SVector::<f64, 9>::zeros();
    all.fixed_rows_mut::<ALL>(0).copy_from(&right);
    all.fixed_rows_mut::<2>(ALL).copy_from(&stop);
    let x = matrix.lu().solve(&all).expect("the walker has mass");
    (x.fixed_rows::<ALL>(0).into(), x.fixed_rows::<2>(ALL).into())
}

fn place(s: &State, arms: &Arms) -> [f64; 2] {
    let mut at = [s.w[0], s.w[1]];
    for (arm, q) in arms.iter().zip(s.w.iter().skip(2)) {
        at = [at[0] - arm * q.sin(), at[1] + arm * q.cos()];
    }
    at
}

fn jacobian(s: &State, arms: &Arms) -> Jacobian {
    let mut j = Jacobian::identity();
    for (k, arm) in arms.iter().enumerate() {
        let (sin, cos) = s.w[2 + k].sin_cos();
        j.set_column(2 + k, &SVector::from([-arm * cos, -arm * sin]));
    }
    j
}

/// Σ_j B_j e_j q̇_j², the centripetal part of minus the acceleration.
fn inward(s: &State, arms: &Arms) -> SVector<f64, 2> {
    let mut sum = SVector::zeros();
    for (k, arm) in arms.iter().enumerate() {
        let (sin, cos) = s.w[2 + k].sin_cos();
        sum += SVector::from([-sin, cos]) * (arm * s.rate[2 + k] * s.rate[2 + k]);
    }
    sum
}

/// The state with these angles and rates whose stance foot rests in the origin.
fn standing(q: &[f64], v: &[f64]) -> State {
    let angles = |x: &[f64]| Coordinates::from_fn(|i, _| if i < 2 { 0.0 } else { x[i - 2] });
    let mut s = State {
        w: angles(q),
        rate: angles(v),
    };
    let foot = place(&s, &STANCE_FOOT);
    let speed = jacobian(&s, &STANCE_FOOT) * s.rate;
    for k in 0..2 {
        s.w[k] = -foot[k];
        s.rate[k] = -speed[k];
    }
    s
}

/// Angles or rates of a state, optionally with the legs' names changed.
fn links(w: &Coordinates, swapped: bool) -> [f64; LINKS] {
    std::array::from_fn(|j| w[2 + if swapped { LINKS - 1 - j } else { j }])
}

/// Numbers between −1 and 1 without order: the fractional parts of multiples of the golden section.
fn scattered(k: usize) -> f64 {
    (k as f64 * 0.618_033_988_749_895).fract() * 2.0 - 1.0
}

fn scattered_states() -> impl Iterator<Item = ([f64; LINKS], [f64; LINKS], [f64; LINKS - 1])> {
    (1..40).map(|n| {
        let number = |k: usize| scattered(17 * n + k);
        (
            std::array::from_fn(|j| 0.8 * number(j)),
            std::array::from_fn(|j| 5.0 * number(5 + j)),
            std::array::from_fn(|j| 60.0 * number(10 + j)),
        )
    })
}

fn equations_of_motion(problem: &FiveLink, q: &[f64], v: &[f64], a: &[f64], u: &[f64]) -> Vec<f64> {
    let mut rows = [0.0; 8];
    let (mut cost, none) = (0.0, [].as_slice());
    let at = Point {
        q,
        v,
        a,
        s: none,
        rate: none,
        u,
        p: none,
    };
    let out = PointRows {
        cost: &mut cost,
        rows: &mut rows,
    };
    problem.point(0, &at, out);
    rows[..LINKS].to_vec()
}

#[test]
fn both_derivations_have_the_same_accelerations() {
    for problem in [FiveLink::published(1), FiveLink::logged(1)] {
        let walker = Walker::new(&problem);
        for (q, v, u) in scattered_states() {
            let (a, _) = walker.forward(&standing(&q, &v), &u);
            let a = links(&a, false);
            for row in equations_of_motion(&problem, &q, &v, &a, &u) {
                assert!(row.abs() < 1e-10, "{row} N m are missing");
            }
            // The rows see an acceleration that is wrong by a millionth.
            let mut off = a;
            off[4] += 1e-6;
            let rows = equations_of_motion(&problem, &q, &v, &off, &u);
            assert!(rows[4].abs() > 5e-7);
        }
    }
}

/// Largest row of the strike (and of the change of legs) that these ends miss.
fn missed(problem: &FiveLink, before: [&[f64]; 2], after: [&[f64]; 2]) -> f64 {
    let ends = [before, after].map(|[q, v]| EndPoint {
        q,
        v,
        s: &[],
        duration: problem.duration_s,
    });
    let mut rows = [0.0; 14];
    problem.link(0, &ends, &[], &mut 0.0, &mut rows);
    rows[..10]
        .iter()
        .fold(0.0, |worst, row| worst.max(row.abs()))
}

#[test]
fn both_derivations_have_the_same_strike() {
    let problem = FiveLink::published(1);
    let walker = Walker::new(&problem);
    for (q, v, _) in scattered_states() {
        let s = standing(&q, &v);
        let swapped = links(&s.w, true);
        let with = |rate: Coordinates| missed(&problem, [&q, &v], [&swapped, &links(&rate, true)]);
        let gap = with(walker.strike(&s).0);
        assert!(gap < 1e-12, "{gap} kg m²/s are missing");
        assert!(with(s.rate) > 1e-3, "the strike changes nothing");
    }
}

fn step(problem: &FiveLink, scheme: Scheme) -> PhaseTrajectory {
    let t = Transcription::new(problem, scheme);
    let start = Start::cold(problem.start(&t, [[0.0; LINKS]; 2]));
    let solution = solve(&t, &start, &Options::default()).expect("the library is consistent");
    assert_eq!(solution.status, Status::Solved);
    t.trajectories(&solution.x).remove(0)
}

/// Power of the motors in W.
fn power_w(u: &[f64], v: &[f64]) -> f64 {
    let terms = u
        .iter()
        .zip(MOTORS)
        .map(|(u, (link, other))| u * (v[link] - v[other]));
    terms.sum()
}

/// Work of the motors over the step in J, by Gauss's rule of two points on 2,000 parts.
fn work_j(trajectory: &PhaseTrajectory) -> f64 {
    let parts = 2000;
    let h = trajectory.duration_s / f64::from(parts);
    let root = 0.5 / 3.0_f64.sqrt();
    let places = (0..parts).flat_map(|n| [-root, root].map(|x| (f64::from(n) + 0.5 + x) * h));
    let terms = places
        .map(|time| trajectory.at(time))
        .map(|k| power_w(&k.u, &k.v));
    0.5 * h * terms.sum::<f64>()
}

/// The walker under the optimised torques alone, by the classic method of Runge and Kutta: its last state, and the
/// work of the torques on the way in J.
fn integrated(walker: &Walker, trajectory: &PhaseTrajectory, steps: usize) -> (State, f64) {
    let h = trajectory.duration_s / steps as f64;
    let first = trajectory.at(0.0);
    let mut s = standing(&first.q, &first.v);
    let mut work = 0.0;
    let slope = |time: f64, s: &State| {
        let u = trajectory.at(time).u;
        (
            s.rate,
            walker.forward(s, &u).0,
            power_w(&u, &links(&s.rate, false)),
        )
    };
    let along = |s: &State, h: f64, k: &(Coordinates, Coordinates, f64)| State {
        w: s.w + k.0 * h,
        rate: s.rate + k.1 * h,
    };
    for n in 0..steps {
        // Just inside the step: with Radau points the torques may jump between intervals.
        let (from, to) = (n as f64 * h + 1e-12, (n + 1) as f64 * h - 1e-12);
        let k1 = slope(from, &s);
        let k2 = slope(0.5 * (from + to), &along(&s, 0.5 * h, &k1));
        let k3 = slope(0.5 * (from + to), &along(&s, 0.5 * h, &k2));
        let k4 = slope(to, &along(&s, h, &k3));
        s.w += (k1.0 + (k2.0 + k3.0) * 2.0 + k4.0) * (h / 6.0);
        s.rate += (k1.1 + (k2.1 + k3.1) * 2.0 + k4.1) * (h / 6.0);
        work += (k1.2 + (k2.2 + k3.2) * 2.0 + k4.2) * (h / 6.0);
    }
    (s, work)
}

/// |work of the motors − energy gained| in J, and the largest angle in rad by which the walker misses the end of its
/// optimised step when only the torques are left.
fn gaps(scheme: Scheme, intervals: usize) -> [f64; 2] {
    let problem = FiveLink::published(intervals);
    let (walker, trajectory) = (Walker::new(&problem), step(&problem, scheme));
    let [first, last] = [0.0, trajectory.duration_s].map(|time| trajectory.at(time));
    let [a, b] = [&first, &last].map(|k| standing(&k.q, &k.v));
    let gained = walker.energy_j(&b) - walker.energy_j(&a);

    // What the motors put in, the strike takes out.
    let after = State {
        rate: walker.strike(&b).0,
        ..b
    };
    let lost = walker.energy_j(&b) - walker.energy_j(&after);
    assert!(
        gained > 20.0 && (gained - lost).abs() < 1e-10,
        "{gained} J gained, {lost} J lost"
    );

    // Torques and second derivation alone: its energy balance and its foot stay, whatever the mesh.
    let (end, work) = integrated(&walker, &trajectory, 50 * intervals);
    let foot = place(&end, &STANCE_FOOT);
    assert!((walker.energy_j(&end) - walker.energy_j(&a) - work).abs() < 1e-7);
    assert!(foot[0].hypot(foot[1]) < 1e-9, "the stance foot slips");

    let angle = |j: usize| (end.w[2 + j] - last.q[j]).abs();
    let missed = (0..LINKS).map(angle).fold(0.0, f64::max);
    [(work_j(&trajectory) - gained).abs(), missed]
}

/// Between the collocation points nobody asks for the equations of motion: what is missing there falls with the order.
#[test]
fn energy_balance_and_integrated_torques_converge_to_the_optimised_step() {
    // Measured with 40 intervals: 6.6e-6 J and 1.9e-4 rad, 9.6e-8 J and 5.1e-6 rad. Open loop the walker is unstable:
    // what it misses grows by the way.
    for (scheme, energy_j, angle_rad) in [
        (Scheme::hermite_simpson(), 1e-5, 3e-4),
        (Scheme::radau3(), 2e-7, 1e-5),
    ] {
        let [coarse, fine] = [20, 40].map(|intervals| gaps(scheme.clone(), intervals));
        assert!(
            fine[0] < energy_j,
            "{}: {} J are missing",
            scheme.name,
            fine[0]
        );
        assert!(fine[1] < angle_rad, "{}: {} rad off", scheme.name, fine[1]);
        for (what, (coarse, fine)) in ["energy", "angle"].iter().zip(coarse.iter().zip(fine)) {
            let order = (coarse / fine).log2();
            assert!(
                order > scheme.order as f64 - 0.5,
                "{}, {what}: order {order:.2}",
                scheme.name
            );
        }
    }
}

/// What the problem takes for granted: the ground only pushes, the foot does not need glue, the swing foot is in the
/// air, the other foot leaves when this one strikes.
#[test]
fn one_foot_stands_and_the_other_swings() {
    for problem in [FiveLink::published(25), FiveLink::held(25)] {
        let (walker, trajectory) = (
            Walker::new(&problem),
            step(&problem, Scheme::hermite_simpson()),
        );
        let mut highest: f64 = 0.0;
        for n in 1..200 {
            let knot = trajectory.at(trajectory.duration_s * f64::from(n) / 200.0);
            let s = standing(&knot.q, &knot.v);
            let (_, [along, up]) = walker.forward(&s, &knot.u);
            assert!(
                up > 100.0 && along.abs() < 0.4 * up,
                "{along} N along, {up} N up"
            );
            let foot = place(&s, &SWING_FOOT);
            assert!(
                foot[1] > 0.0,
                "the swing foot is {} m under ground",
                -foot[1]
            );
            highest = highest.max(foot[1]);
        }
        // The free optimum lifts its foot by 7 cm.
        assert_eq!(
            highest > 0.1,
            problem.clearance_m > 0.0,
            "lifted by {highest} m"
        );
        let last = trajectory.at(trajectory.duration_s);
        let (_, [_, impulse]) = walker.strike(&standing(&last.q, &last.v));
        assert!(impulse > 0.0, "the strike pulls");
    }
}
