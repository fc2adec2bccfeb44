//! Packages that the program ships or writes, before the validator of the format (`pip install frictionless`). Where it
//! is not installed, the test says so on stderr.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use campaign::{Axis, Campaign, Direction, InitialState, Protocol};

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../data/campaigns")
        .join(name)
}

/// What the validator says of a package; `None` where there is no validator.
fn verdict(folder: &Path) -> Option<Result<(), String>> {
    let ran = Command::new("frictionless")
        .args(["validate", "datapackage.json"])
        .current_dir(folder)
        .output();
    match ran {
        Ok(output) if output.status.success() => Some(Ok(())),
        Ok(output) => Some(Err(String::from_utf8_lossy(&output.stdout).into_owned())),
        Err(error) => {
            // Straight to stderr, which the test harness does not capture; a closed stderr is no reason to fail.
            let _ = writeln!(
                std::io::stderr(),
                "validation of packages DID NOT RUN: frictionless could not be started ({error})"
            );
            None
        }
    }
}

/// The campaign with everything in it that a package can hold, on the other kind of rig.
fn with_everything(mut campaign: Campaign) -> Campaign {
    campaign.name = "Joint \u{e9}preuve, Nr. 1".into();
    campaign.axis = Axis::Rotary;
    campaign.rig.moving_mass_kg = Some(0.25);
    for run in &mut campaign.runs {
        let n = run.time_s.len();
        run.direction = Direction::Both;
        run.protocol = Protocol::Free;
        run.initial_state = InitialState::Unknown;
        run.position_m = Some((0..n).map(|i| 1e-3 * i as f64).collect());
        run.normal_force_n = Some(vec![2.0; n]);
        run.temperature_c = Some(vec![21.5; n]);
        run.stage_turned = true;
        // Reversals, as the direction says.
        for (i, v) in run.velocity_m_s.iter_mut().enumerate() {
            if i % 200 > 100 {
                *v = -*v;
            }
        }
    }
    campaign
}

#[test]
fn packages_are_what_the_format_asks_for() {
    let campaign = campaign::open(&shipped("brush-2x2-nylon")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let (plain, full) = (folder.path().join("plain"), folder.path().join("full"));
    campaign::write(&plain, &campaign).unwrap();
    campaign::write(&full, &with_everything(campaign)).unwrap();
    for package in [shipped("brush-3x3-aluminium"), plain, full] {
        campaign::open(&package).unwrap();
        match verdict(&package) {
            Some(answer) => assert_eq!(answer, Ok(()), "{}", package.display()),
            None => return,
        }
    }
    // The validator can say no.
    let broken = folder.path().join("plain/runs/01-forward-ramp.csv");
    std::fs::write(&broken, "time_s,velocity_mm_s,force_n\n0,zero,0\n").unwrap();
    assert!(verdict(&folder.path().join("plain")).unwrap().is_err());
}
