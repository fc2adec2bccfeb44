//! Hops: new starts from strides that are carried off their place.

use biped::contact::Brush;
use biped::gait::book::Book;
use biped::gait::catalogue::{CONTACT, Mount, Name};
use biped::gait::file::StridesFile;
use biped::gait::{Contact, Goal};
use trajectory::{Options, Start};

mod sample;

fn ratio_within(a: f64, b: f64, most: f64) -> bool {
    a > 0.0 && b > 0.0 && (a / b).ln().abs() <= most
}

#[test]
fn a_seed_draws_one_problem_and_it_lies_beside() {
    let own = Name::compliant(CONTACT, Mount::Asymmetric, 1.0, 20.0)
        .problem(&sample::biped(), sample::brush());
    let mut seen: Vec<Brush> = Vec::new();
    for seed in 0..50 {
        let other = own.beside(seed);
        assert_eq!(other, own.beside(seed));
        assert!(
            !seen.contains(&other.brush),
            "seed {seed} draws a problem again"
        );
        seen.push(other.brush);
        let (Contact::Compliant(a), Contact::Compliant(b)) = (own.contact, other.contact) else {
            panic!("another kind of contact");
        };
        assert!(ratio_within(a.stiffness_n_m15, b.stiffness_n_m15, 0.4));
        assert!(ratio_within(a.loss_s_m, b.loss_s_m, 0.4));
        assert!(ratio_within(own.brush.forward, other.brush.forward, 0.2));
        assert_eq!(other.mesh, own.mesh);
        let (Goal::Speed { aim_m_s, .. }, Goal::Speed { aim_m_s: aim, .. }) =
            (own.goal, other.goal)
        else {
            panic!("another kind of goal");
        };
        assert_eq!(aim, aim_m_s);
    }
}

/// A book of two rigid problems, the second without a stride.
fn book(options: &Options) -> Book {
    let [known, open] =
        [Mount::Symmetric, Mount::Asymmetric].map(|mount| Name::rigid(mount, 0.01, 20.0));
    let file: StridesFile =
        serde_json::from_str(include_str!("../../../data/strides.json")).unwrap();
    let row = file
        .starts
        .into_iter()
        .find(|row| row.name == known)
        .unwrap();
    let problem = |name: Name| name.problem(&sample::biped(), sample::brush());
    let mut book = Book::default();
    let named = vec![
        (known, problem(known), vec![Start::cold(row.x)]),
        (open, problem(open), Vec::new()),
    ];
    book.add(named, options).unwrap();
    book
}

#[test]
fn hops_find_a_stride_and_its_own_hops_do_not_count() {
    let options = Options::default();
    let mut book = book(&options);
    // Without strides of its own an open problem has those of others to hop from.
    let looked = book.hop(1, 1.0, 3, &options).unwrap();
    assert_eq!(looked.ends.len(), 3);
    assert!(looked.better && book.entries[1].is_certified());
    let found = |book: &Book, k: usize| book.entries[k].outcome.as_ref().unwrap().found_by;
    // Nobody is near enough: only hops from its own stride are left, and they prove nothing.
    let (before, hops) = (found(&book, 0), 6);
    let looked = book.hop(0, 0.0, hops, &options).unwrap();
    let own = looked
        .ends
        .iter()
        .filter(|end| end.source.0 == book.entries[0].name);
    assert_eq!(own.count(), looked.ends.len());
    assert!(!looked.ends.is_empty() && looked.ends.len() <= hops);
    assert_eq!(book.entries[0].hops, looked.ends.len());
    let own_cost = book.entries[0].outcome.as_ref().unwrap().cost;
    let counted = looked
        .ends
        .iter()
        .filter(|end| end.source.1 != own_cost)
        .count();
    assert!(found(&book, 0) - before <= counted);
    assert!(looked.ends.iter().any(|end| end.status.is_solved()));
}

#[test]
fn hops_take_the_same_way_again() {
    let options = Options::default();
    let ends = || book(&options).hop(1, 1.0, 3, &options).unwrap().ends;
    let (once, again) = (ends(), ends());
    assert_eq!(once.len(), again.len());
    for (a, b) in once.iter().zip(&again) {
        assert_eq!(
            (a.cost.to_bits(), a.iterations),
            (b.cost.to_bits(), b.iterations)
        );
    }
}
