//! The stand-in behind the elastic cord: a plain fit follows the curves with wrong parameters; the diagnosis names the cord
//! and recovers the law's parameters as the rigid stand-in gives them.

use std::path::Path;

use diagnosis::{Diagnosed, Options, Status, diagnose_fully};
use rig::ModelFile;

fn diagnosed(name: &str) -> Diagnosed {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../data/campaigns")
        .join(name);
    let campaign = campaign::open(&folder).expect("a shipped campaign");
    let options = Options {
        quick: true,
        ..Options::default()
    };
    diagnose_fully(&campaign, &options).expect("an answer")
}

/// Largest difference of two models' parameters in their joint standard deviations.
fn disagreement(a: &ModelFile, b: &ModelFile) -> f64 {
    a.parameters
        .iter()
        .zip(&b.parameters)
        .map(|(p, q)| {
            assert_eq!(p.name, q.name);
            let sd = |x: Option<f64>| x.expect("a standard deviation");
            (p.value - q.value).abs() / sd(p.sd).hypot(sd(q.sd))
        })
        .fold(0.0, f64::max)
}

#[test]
fn the_cord_is_named_and_the_laws_parameters_are_recovered() {
    let rigid = diagnosed("brush-2x2-aluminium");
    let corded = diagnosed("brush-2x2-aluminium-cord");
    assert_eq!(rigid.answer.status, Status::Consistent);
    assert_eq!(corded.answer.status, Status::Explained);
    let named: Vec<&str> = corded
        .answer
        .findings
        .iter()
        .map(|f| f.cause.as_str())
        .collect();
    assert_eq!(named, ["cord-compliance"]);
    assert!(corded.answer.findings[0].equivalent.is_empty());
    // parameters of brush and cord together are not the brush's
    let plain = disagreement(&rigid.plain, &corded.plain);
    let extended = disagreement(&rigid.plain, &corded.extension);
    assert!(plain > 10.0, "{plain}");
    assert!(extended < 3.0, "{extended}");
    // the cord that the recipe states
    let compliance = &corded.answer.findings[0].parameters[0];
    let [low, high] = compliance.ci95.expect("an interval");
    assert!(low < 1e-3 && 1e-3 < high, "{low} to {high} m/N");
    assert!(high < 1.3 * low, "{low} to {high} m/N");
}
