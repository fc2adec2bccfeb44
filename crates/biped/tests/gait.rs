//! Strides: the programme against its definition, and solutions against the physics.

mod sample;

use biped::contact::{Brush, Ground};
use biped::gait::book::{Book, Looked, Source};
use biped::gait::catalogue::{CONTACT, Choice, Kind, Mount, Name, all};
use biped::gait::chain::{Case, Outcome, solve_all};
use biped::gait::cold;
use biped::gait::file::{NamedStart, StridesFile};
use biped::gait::layout::Layout;
use biped::gait::motion::Motion;
use biped::gait::programme::Stride;
use biped::gait::refine::on_mesh;
use biped::gait::start::Guess;
use biped::gait::{Contact, Goal, Limits, Mesh, Problem, STANDING, Touchdown};
use biped::kinematics::{Leg, leg_points};
use trajectory::{Block, Options, Programme, Start};

fn problem(contact: Contact, brush: Brush, weight: f64, aim_m_s: f64) -> Problem {
    Problem {
        biped: sample::biped(),
        brush,
        contact,
        goal: Goal::Speed { weight, aim_m_s },
        limits: Limits::default(),
        mesh: Mesh::default(),
        rate_weight_s2: 1e-6,
    }
}

/// The shipped start of one problem, and the cost that a second program (CasADi with IPOPT) found from it.
fn shipped(kind: &str, brush: &str, weight: f64, aim: f64) -> Vec<f64> {
    let text = include_str!("../../../data/strides.json");
    let file: serde_json::Value = serde_json::from_str(text).unwrap();
    let row = file["starts"]
        .as_array()
        .unwrap()
        .iter()
        .find(|row| {
            row["kind"] == kind
                && row["brush"] == brush
                && row["weight"] == weight
                && row["aim"] == aim
                && (kind == "rigid" || (row["k"] == 2e5 && row["c"] == 1.0))
                && row.get("choice").is_none_or(|choice| choice == "own")
        })
        .unwrap();
    row["x"]
        .as_array()
        .unwrap()
        .iter()
        .map(|x| x.as_f64().unwrap())
        .collect()
}

fn solved(problem: Problem, start: Vec<f64>) -> Outcome {
    let options = Options {
        max_iterations: 60,
        ..Options::default()
    };
    solve_all(
        &[Case {
            problem,
            starts: vec![Start::cold(start)],
        }],
        &options,
    )
    .unwrap()
    .remove(0)
    .expect("a case with a start has an outcome")
}

const STIFF: Contact = Contact::Compliant(Ground {
    stiffness_n_m15: 2e5,
    loss_s_m: 1.0,
    slip_scale_m_s: 0.1,
});

/// On the coarse mesh, which is quick; the sweep on the stride's own mesh is the example `cold_sweep`.
#[test]
fn a_stride_on_the_stiff_contact_is_walked_to_from_a_guess() {
    let name = Name::compliant(CONTACT, Mount::Symmetric, 0.01, 20.0);
    let problem = Problem {
        mesh: Mesh::default(),
        ..name.problem(&sample::biped(), sample::brush())
    };
    let walk = cold::walk(&problem, &Guess::default()).unwrap();
    let stride = walk.stride.expect("the walk arrives");
    assert!(stride.is_certified());
    assert_eq!(stride.problem, problem);
    let parts: Vec<f64> = walk.treads.iter().map(|tread| tread.part).collect();
    assert_eq!(parts.first(), Some(&0.0));
    assert_eq!(parts.last(), Some(&1.0));
}

#[test]
fn a_compliant_stride_is_certified_and_obeys_the_physics() {
    let name = Name::compliant(CONTACT, Mount::Symmetric, 0.01, 20.0);
    let problem = name.problem(&sample::biped(), sample::brush());
    let outcome = solved(problem, shipped("compliant", "symmetric", 0.01, 20.0));
    assert!(outcome.is_certified(), "{:?}", outcome.status);
    let motion = &outcome.motion;
    // Cost from its definition.
    let cost = 0.01 * (motion.speed_m_s - 20.0).powi(2) + motion.effort(&problem);
    assert!(
        (cost - outcome.cost).abs() < 2e-3 * cost,
        "{cost} / {}",
        outcome.cost
    );
    // Impulses cancel over a period, up to the error of the mesh.
    let [forward, braking] = motion.forward_and_braking_n_s();
    assert!(
        forward > 1.0 && (forward - braking).abs() < 0.02 * forward,
        "{forward} {braking}"
    );
    assert!(motion.energy_gap(&problem) < 0.01);
    // Forces push only, and lie within the friction limits.
    let limit = sample::brush().symmetric().forward;
    for s in motion
        .samples
        .iter()
        .filter(|s| STANDING[s.phase].is_some())
    {
        assert!(s.force_n[1] >= -1e-6);
        assert!(s.force_n[0].abs() <= limit * s.force_n[1] + 1e-6);
    }
    // Distance over period is the mean speed.
    let end = motion.samples.last().unwrap();
    assert!((end.q[0] / motion.period_s() - motion.speed_m_s).abs() < 1e-9);
}

#[test]
fn a_rigid_foot_stands_still_and_its_impact_conserves_what_it_must() {
    let problem = problem(
        Contact::Rigid(Touchdown::Impact),
        sample::brush(),
        0.01,
        20.0,
    );
    let outcome = solved(problem, shipped("rigid", "asymmetric", 0.01, 20.0));
    assert!(outcome.is_certified(), "{:?}", outcome.status);
    for s in &outcome.motion.samples {
        if let Some(leg) = STANDING[s.phase] {
            let speed = biped::kinematics::foot_velocity(&problem.biped, &s.q, &s.v, leg);
            assert!(speed[0].hypot(speed[1]) < 1e-7, "{speed:?}");
        }
    }
    // Momentum jumps by the impulse: landing after the first flight.
    let before = outcome
        .motion
        .samples
        .iter()
        .rev()
        .find(|s| s.phase == 1)
        .unwrap();
    let after = outcome.motion.phase_starts[2];
    let p0 = biped::dynamics::momenta(&problem.biped, &before.q, &before.v).0;
    let p1 = biped::dynamics::momenta(&problem.biped, &before.q, &after).0;
    for k in 0..2 {
        assert!((p1[k] - p0[k] - outcome.motion.impulses_n_s[0][k]).abs() < 1e-7);
    }
    // Energy is lost in an impact, never won.
    let energy = |v| biped::dynamics::energies(&problem.biped, &before.q, v).0;
    assert!(energy(&after) <= energy(&before.v) + 1e-9);
}

#[test]
fn the_guess_puts_standing_feet_into_the_ground_and_the_others_above() {
    let problem = problem(STIFF, sample::brush(), 1.0, 20.0);
    let x = Guess::default().variables(&problem);
    let layout = Layout::new(&problem);
    assert_eq!(x.len(), layout.count());
    for place in layout
        .places()
        .into_iter()
        .filter(|&place| !layout.is_last(place))
    {
        let q = std::array::from_fn(|k| x[layout.q(place) + k]);
        for leg in Leg::BOTH {
            let height = leg_points(&problem.biped, &q, leg).foot[1];
            assert_eq!(
                height < 0.0,
                STANDING[place.phase] == Some(leg),
                "{place:?} {leg:?} {height}"
            );
        }
    }
}

/// Blocks name existing variables once, and every variable is used somewhere.
#[test]
fn the_programme_is_well_formed() {
    for contact in [
        STIFF,
        Contact::Rigid(Touchdown::Impact),
        Contact::Rigid(Touchdown::Still),
    ] {
        let stride = Stride::new(problem(contact, sample::brush(), 1.0, 20.0));
        let count = stride.layout.count();
        let mut used = vec![false; count];
        let blocks: Vec<Block> = stride.blocks();
        for index in blocks.iter().flat_map(|b| b.variables.iter().copied()) {
            used[index] = true;
        }
        for index in stride
            .linear()
            .iter()
            .flat_map(|row| row.terms.iter().map(|t| t.0))
        {
            used[index] = true;
        }
        assert_eq!(stride.variables().len(), count);
        // Only the fixed x at the start stands in bounds alone.
        let idle: Vec<usize> = (0..count).filter(|&k| !used[k]).collect();
        assert!(idle.is_empty(), "{contact:?}: {idle:?}");
    }
}

#[test]
fn neighbours_differ_in_one_choice_by_one_step() {
    let base = Name::compliant(CONTACT, Mount::Symmetric, 1.0, 20.0);
    let beside = [
        Name {
            brush: Mount::Backwards,
            ..base
        },
        Name {
            weight: 3.0,
            ..base
        },
        Name {
            weight: 0.3,
            ..base
        },
        Name { k: 4e5, ..base },
        Name { c: 0.3, ..base },
        Name { aim: 8.0, ..base },
        base.with_choice(Choice::LongStance),
    ];
    for other in beside {
        assert!(
            base.is_beside(&other) && other.is_beside(&base),
            "{other:?}"
        );
    }
    let far = [
        base,
        Name {
            weight: 10.0,
            ..base
        },
        Name { c: 3.0, ..base },
        Name {
            k: 4e5,
            c: 0.3,
            ..base
        },
        Name::rigid(Mount::Symmetric, 1.0, 20.0),
    ];
    for other in far {
        assert!(
            !base.is_beside(&other) && !other.is_beside(&base),
            "{other:?}"
        );
    }
    let long = base.with_choice(Choice::LongStance);
    assert!(!long.is_beside(&base.with_choice(Choice::ShortStance)));
    let names = all(8.0, 20.0);
    for (k, name) in names.iter().enumerate() {
        assert!(!names[..k].contains(name), "{name:?} stands twice");
        assert!(
            names.iter().any(|other| other.is_beside(name)),
            "{name:?} has no neighbour"
        );
    }
}

#[test]
fn a_stride_is_found_from_its_neighbours_and_kept_until_a_better_one_comes() {
    let weight = 0.01;
    let known = Name::rigid(Mount::Symmetric, weight, 20.0);
    let open = Name::rigid(Mount::Asymmetric, weight, 20.0);
    let start = shipped("rigid", "symmetric", weight, 20.0);
    let problem = |name: Name| name.problem(&sample::biped(), sample::brush());
    let mut book = Book::default();
    let options = Options::default();
    book.add(
        vec![
            (known, problem(known), vec![Start::cold(start)]),
            (open, problem(open), Vec::new()),
        ],
        &options,
    )
    .unwrap();
    let gaps = |book: &Book| -> Vec<Name> {
        let open = book.entries.iter().filter(|e| !e.is_certified());
        open.map(|e| e.name).collect()
    };
    assert_eq!(gaps(&book), [open]);
    assert_eq!(book.nearest(0), None);
    assert_eq!(book.look(0, 1.0, 9, &options).unwrap(), Looked::default());
    let near = book.nearest(1).unwrap();
    assert!(near > 0.0 && near < 1.0, "{near}");
    assert_eq!(
        book.look(1, 0.5 * near, 9, &options).unwrap(),
        Looked::default()
    );
    let looked = book.look(1, near, 9, &options).unwrap();
    assert!(looked.better && looked.ends.len() == 1, "{looked:?}");
    assert_eq!(gaps(&book).len(), 0);
    let cost = |book: &Book, k: usize| book.entries[k].outcome.as_ref().unwrap().cost;
    assert_eq!(book.entries[1].from, Some((known, cost(&book, 0))));
    // The way back is tried, and counts for nothing if it leads to the stride that the other one came from.
    let count = |book: &Book, k: usize| book.entries[k].outcome.as_ref().map(|o| o.found_by);
    let looked = book.look(0, 1.0, 9, &options).unwrap();
    assert_eq!((looked.ends.len(), looked.better), (1, false));
    assert_eq!(count(&book, 0), Some(1));
    for place in 0..2 {
        assert_eq!(
            book.look(place, 1.0, 9, &options).unwrap(),
            Looked::default()
        );
    }
    // More grip pays.
    assert!(cost(&book, 1) < cost(&book, 0));
}

#[test]
fn a_way_begins_and_ends_at_its_problems() {
    let problem = |name: Name| name.problem(&sample::biped(), sample::brush());
    let own = Name::compliant(CONTACT, Mount::Asymmetric, 1.0, 20.0);
    let other = Name {
        k: 5e4,
        c: 2.0,
        weight: 0.01,
        ..own.with_choice(Choice::NarrowHips)
    };
    let (from, to) = (problem(own), problem(other));
    assert_eq!(from.towards(&to, 1.0), Some(to));
    let half = from.towards(&to, 0.5).unwrap();
    let (Contact::Compliant(ground), Goal::Speed { weight, .. }) = (half.contact, half.goal) else {
        panic!("{half:?}");
    };
    assert!((ground.stiffness_n_m15 / 1e5 - 1.0).abs() < 1e-12);
    assert!((ground.loss_s_m - 1.5).abs() < 1e-12);
    assert!((weight - 0.1).abs() < 1e-12);
    let hips = [from, half, to].map(|p| p.limits.hip_rad[0]);
    assert!(hips[0] < hips[1] && hips[1] < hips[2], "{hips:?}");
    // There is none between two contacts or meshes.
    let rigid = problem(Name::rigid(Mount::Asymmetric, 1.0, 20.0));
    let fine = problem(own.with_choice(Choice::FineMesh));
    assert_eq!(from.towards(&rigid, 0.5), None);
    assert_eq!(from.towards(&fine, 0.5), None);
}

#[test]
fn starts_are_counted_by_the_list_of_those_tried() {
    let weight = 0.01;
    let name = Name::rigid(Mount::Symmetric, weight, 20.0);
    let start = Start::cold(shipped("rigid", "symmetric", weight, 20.0));
    let problem = name.problem(&sample::biped(), sample::brush());
    let mut book = Book::default();
    let options = Options::default();
    book.add(vec![(name, problem, vec![start.clone()])], &options)
        .unwrap();
    let count = |book: &Book| {
        let outcome = book.entries[0].outcome.as_ref().unwrap();
        (outcome.found_by, outcome.tried, book.entries[0].tried.len())
    };
    assert_eq!(count(&book), (1, 1, 1));
    book.offer(0, start.clone(), &options).unwrap();
    assert_eq!(count(&book), (2, 2, 2));
    // Which starts made the count is lost: it may contain any that comes.
    book.entries[0].tried.clear();
    book.offer(0, start, &options).unwrap();
    assert_eq!(count(&book), (1, 1, 1));
}

#[test]
fn the_shipped_counts_are_those_of_the_list_beside_them() {
    let file: StridesFile =
        serde_json::from_str(include_str!("../../../data/strides.json")).unwrap();
    let list: Vec<(Name, Source)> =
        serde_json::from_str(include_str!("../../../data/strides.json.tried")).unwrap();
    let mut searched = 0;
    for row in &file.starts {
        let search = row.search.expect("every shipped stride has a record");
        assert!(search.found <= search.tried, "{:?}", row.name);
        let listed = list.iter().filter(|(name, _)| *name == row.name).count();
        // Records without a list are older than it.
        assert!(
            listed + search.hops == 0 || listed + search.hops == search.tried,
            "{:?}: {listed} starts listed, {search:?}",
            row.name
        );
        searched += usize::from(listed > 0);
    }
    assert!(searched > 0);
}

/// On even intervals the best strides struck again late in a stance, between points: the work of torques and ground was 1.1 % beside the
/// energy, and half of their gain was gone with every interval halved.
#[test]
fn shipped_strides_do_not_live_on_their_mesh() {
    let file: StridesFile =
        serde_json::from_str(include_str!("../../../data/strides.json")).unwrap();
    let sweep =
        |row: &&NamedStart| row.name.kind == Kind::Compliant && (row.name.k, row.name.c) == CONTACT;
    for row in file.starts.iter().filter(sweep) {
        let problem = row.name.problem(&sample::biped(), sample::brush());
        let gap = Motion::new(&problem, &row.x).energy_gap(&problem);
        assert!(gap < 2e-3, "{:?}: {gap}", row.name);
    }
}

#[test]
fn a_finer_mesh_holds_the_same_stride_and_takes_its_error_away() {
    let problem = problem(
        Contact::Rigid(Touchdown::Impact),
        sample::brush(),
        0.01,
        20.0,
    );
    let coarse = solved(problem, shipped("rigid", "asymmetric", 0.01, 20.0));
    let mesh = problem.mesh.times(2);
    let finer = Problem { mesh, ..problem };
    let x = on_mesh(&problem, &coarse.x, mesh);
    // Read there and back again, a stride is what it was, up to what the method leaves open between its points.
    let back = on_mesh(&finer, &x, problem.mesh);
    let apart = trajectory::scaled_distance(&Stride::new(problem), &coarse.x, &back);
    assert!(apart < 0.02, "{apart}");
    let fine = solved(finer, x);
    assert!(fine.is_certified(), "{:?}", fine.status);
    assert!((fine.cost / coarse.cost - 1.0).abs() < 5e-3);
    let gaps = [(&coarse, &problem), (&fine, &finer)].map(|(o, p)| o.motion.energy_gap(p));
    assert!(gaps[1] < 0.3 * gaps[0], "{gaps:?}");
    let again = [(&coarse, &problem), (&fine, &finer)].map(|(o, p)| o.motion.reintegration(p, 8));
    // Third order: an eighth of the gap, more where a torque turns at its limit.
    assert!(again[1].gap_m_rad < 0.25 * again[0].gap_m_rad, "{again:?}");
    assert!(
        again[1].drift_m_rad < 0.3 * again[0].drift_m_rad,
        "{again:?}"
    );
}
