//! The laws on a stand-in of known law: the true one is best by far, and what the gains of the runs could stand in for is last.

use std::path::Path;

use diagnosis::{Options, diagnose};

#[test]
fn laws_are_ranked_by_what_they_miss_and_not_by_what_gains_forgive() {
    let folder =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/campaigns/brush-2x2-aluminium");
    let campaign = campaign::open(&folder).expect("a shipped campaign");
    let answer = diagnose(&campaign, &Options::default()).expect("an answer");
    let laws = answer.laws;
    assert_eq!(laws.len(), 7);
    assert_eq!(laws[0].law, "asymmetric-bristle");
    assert_eq!(laws[0].delta_aicc, 0.0);
    assert_eq!(laws[0].rmse, answer.baseline.rmse);
    // No other law knows the direction, which is twenty times the noise here.
    for law in &laws[1..] {
        assert!(law.rmse > 15.0 * laws[0].rmse, "{law:?}");
        assert!(law.delta_aicc > 1000.0, "{law:?}");
    }
    assert_eq!(laws[6].law, "coulomb-viscous");
    // It predicts what friction it can: the best constant level errs by 0.239 (least squares), nothing at all by 0.64.
    assert!(laws[6].rmse < 0.3, "{:?}", laws[6]);
    // LuGre holds Dahl's law and can only fit better.
    let place = |name: &str| laws.iter().position(|law| law.law == name);
    assert!(place("lugre") < place("dahl"));
}
