//! Model files: there and back, and refused with one clear line.

mod campaigns;

use std::path::PathBuf;

use campaigns::{BRISTLE, Spring};
use friction::LawKind;
use rig::{Cause, ModelFile};

fn scratch(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("bristle-model-file-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("scratch folder");
    folder.join(name)
}

fn whole() -> ModelFile {
    let mut file = ModelFile::new(LawKind::AsymmetricBristle, &BRISTLE, Some(&[0.01; 7]));
    file.valid_speed_m_s = Some([0.0, 0.06]);
    let mut covariance = vec![vec![0.0; 7]; 7];
    for (i, row) in covariance.iter_mut().enumerate() {
        row[i] = 1e-4;
    }
    covariance[0][1] = 5e-5;
    covariance[1][0] = 5e-5;
    file.covariance = Some(covariance);
    let spring = Spring { mass_kg: 0.2 };
    file.extension = vec![ModelFile::extension_entry(
        &spring,
        &[1e-3, 0.5],
        Some(&[vec![1e-8, 0.0], vec![0.0, 0.04]]),
    )];
    file
}

#[test]
fn what_is_saved_is_what_is_loaded() {
    let path = scratch("there-and-back.json");
    let file = whole();
    file.save(&path).expect("written");
    let back = ModelFile::load(&path).expect("read");
    assert_eq!(back, file);
    assert_eq!(back.law_values().expect("complete"), BRISTLE);
    assert_eq!(
        back.law_covariance().expect("complete").expect("given")[1][0],
        5e-5
    );
    let catalogue: Vec<Box<dyn Cause>> = vec![Box::new(Spring { mass_kg: 0.2 })];
    let extension = back.extension_from(&catalogue).expect("known");
    assert_eq!(extension[0].1, vec![1e-3, 0.5]);
    assert_eq!(back.extension[0].parameters[1].sd, Some(0.2));
}

#[test]
fn order_of_entries_does_not_matter() {
    let path = scratch("order.json");
    let mut file = whole();
    file.parameters.reverse();
    file.covariance = file.covariance.map(|c| {
        c.into_iter()
            .rev()
            .map(|r| r.into_iter().rev().collect())
            .collect()
    });
    file.save(&path).expect("written");
    let back = ModelFile::load(&path).expect("read");
    assert_eq!(back.law_values().expect("complete"), BRISTLE);
    assert_eq!(
        back.law_covariance().expect("complete"),
        whole().law_covariance().expect("complete")
    );
}

#[test]
fn bad_files_are_refused_by_name() {
    let good = serde_json::to_value(whole()).expect("json");
    type Change = fn(&mut serde_json::Value);
    let cases: [(&str, Change, &str); 9] = [
        (
            "schema",
            |v| v["schema"] = "bristle/model/2".into(),
            "schema is `bristle/model/2`",
        ),
        (
            "law",
            |v| v["law"] = "lugree".into(),
            "unknown law `lugree`",
        ),
        (
            "missing",
            |v| drop(v["parameters"].as_array_mut().unwrap().pop()),
            "needs parameter `theta0`",
        ),
        (
            "unknown",
            |v| v["parameters"][0]["name"] = "sigma9".into(),
            "has no parameter `sigma9`",
        ),
        (
            "twice",
            |v| v["parameters"][0]["name"] = "sigma0".into(),
            "stands twice",
        ),
        (
            "negative",
            |v| v["parameters"][2]["value"] = (-1.0).into(),
            "sigma0 = -1 must be positive",
        ),
        (
            "shape",
            |v| v["covariance"] = serde_json::json!([[1.0]]),
            "7 rows of 7",
        ),
        (
            "symmetry",
            |v| v["covariance"][0][1] = 1.0.into(),
            "symmetric",
        ),
        (
            "speed",
            |v| v["valid_speed_m_s"] = serde_json::json!([0.1, 0.0]),
            "the smaller first",
        ),
    ];
    for (name, change, message) in cases {
        let path = scratch(&format!("{name}.json"));
        let mut bad = good.clone();
        change(&mut bad);
        std::fs::write(&path, bad.to_string()).expect("written");
        let refusal = ModelFile::load(&path).unwrap_err().to_string();
        assert!(
            refusal.contains(message) && refusal.contains(&format!("{name}.json")),
            "{refusal}"
        );
    }
    for (name, text) in [
        ("empty", ""),
        ("list", "[]"),
        ("cut", "{\"schema\": \"bristle"),
        ("extra", "{\"x\": 1}"),
    ] {
        let path = scratch(&format!("{name}.json"));
        std::fs::write(&path, text).expect("written");
        assert!(
            ModelFile::load(&path)
                .unwrap_err()
                .to_string()
                .contains("not a model file")
        );
    }
    assert!(
        ModelFile::load(&scratch("absent.json"))
            .unwrap_err()
            .to_string()
            .contains("cannot be read")
    );
}

#[test]
fn extensions_are_checked_against_a_catalogue() {
    let catalogue: Vec<Box<dyn Cause>> = vec![Box::new(Spring { mass_kg: 0.2 })];
    let refused = |change: &dyn Fn(&mut ModelFile)| {
        let mut file = whole();
        change(&mut file);
        file.extension_from(&catalogue).unwrap_err()
    };
    assert!(
        refused(&|f| f.extension[0].cause = "sprong".into()).contains("unknown cause `sprong`")
    );
    assert!(
        refused(&|f| drop(f.extension[0].parameters.pop())).contains("`damping_n_s_m` is missing")
    );
    assert!(refused(&|f| f.extension[0].parameters[0].value = 7.0).contains("outside [0, 1]"));
    assert!(refused(&|f| f.extension.push(f.extension[0].clone())).contains("stands twice"));
}
