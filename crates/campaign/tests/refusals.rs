//! Every kind of bad input has its exact message, and nothing panics.

use std::fs;
use std::path::Path;

use proptest::prelude::*;
use serde_json::{Value, json};
use tempfile::TempDir;

/// A package of two ramps, forward and reverse, that the door lets in.
struct Package {
    folder: TempDir,
    description: Value,
}

const FILE: &str = "runs/a.csv";

impl Package {
    fn new() -> Self {
        let folder = TempDir::new().unwrap();
        fs::create_dir(folder.path().join("runs")).unwrap();
        for (name, sign) in [("a", 1.0), ("b", -1.0)] {
            let mut text = String::from("time_s,velocity_mm_s,force_n\n");
            for sample in 0..30 {
                let v = sign * 2.0 * f64::from(sample);
                text += &format!("{},{v},{}\n", f64::from(sample) / 8.0, sign * 1.5);
            }
            fs::write(folder.path().join(format!("runs/{name}.csv")), text).unwrap();
        }
        let run = |name: &str, direction: &str| {
            json!({"name": name, "path": format!("runs/{name}.csv"), "profile": "tabular-data-resource",
                "schema": {"fields": [
                    {"name": "time_s", "type": "number", "unit": "s"},
                    {"name": "velocity_mm_s", "type": "number", "unit": "mm/s"},
                    {"name": "force_n", "type": "number", "unit": "N"}]},
                "run": {"direction": direction, "protocol": "ramp", "normal_load_n": 2.0}})
        };
        let description = json!({"profile": "tabular-data-package", "name": "p",
            "campaign": {"provenance": "measured"},
            "resources": [run("a", "forward"), run("b", "reverse")]});
        Self {
            folder,
            description,
        }
    }

    /// The same with one entry of the description replaced, added (`Some`) or removed (`None`).
    fn with(mut self, pointer: &str, value: Option<Value>) -> Self {
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        let parent = self.description.pointer_mut(parent).unwrap();
        match (parent, value) {
            (Value::Array(items), Some(value)) => items[key.parse::<usize>().unwrap()] = value,
            (Value::Array(items), None) => drop(items.remove(key.parse().unwrap())),
            (Value::Object(map), Some(value)) => drop(map.insert(key.to_owned(), value)),
            (Value::Object(map), None) => drop(map.remove(key)),
            _ => unreachable!(),
        }
        self
    }

    /// The same with a line of the first run's file replaced; line 1 is the header.
    fn line(self, number: usize, text: &str) -> Self {
        let path = self.folder.path().join(FILE);
        let file = fs::read_to_string(&path).unwrap();
        let mut lines: Vec<&str> = file.lines().collect();
        lines[number - 1] = text;
        fs::write(path, lines.join("\n") + "\n").unwrap();
        self
    }

    fn file(self, text: &[u8]) -> Self {
        fs::write(self.folder.path().join(FILE), text).unwrap();
        self
    }

    fn open(&self) -> Result<campaign::Campaign, String> {
        let path = self.folder.path().join("datapackage.json");
        fs::write(path, self.description.to_string()).unwrap();
        let inside = format!("{}/", self.folder.path().display());
        campaign::open(self.folder.path())
            .map_err(|refusal| refusal.to_string().replace(&inside, ""))
    }
}

#[track_caller]
fn refused(package: &Package, message: &str) {
    assert_eq!(package.open().unwrap_err(), message);
}

#[test]
fn the_package_that_the_cases_spoil_is_a_good_one() {
    assert_eq!(Package::new().open().unwrap().runs.len(), 2);
}

#[test]
fn cells() {
    let cases = [
        ("0.875,14,", "column force_n: the cell is empty"),
        ("0.875,14,abc", "column force_n: `abc` is not a number"),
        ("0.875,14,1,5", ": has 4 cells, but the header has 3"),
        ("0.875,14", ": has 2 cells, but the header has 3"),
        ("", ": the row is empty"),
        (
            "0.875,14,NaN",
            "column force_n: `NaN` is not a finite number",
        ),
        (
            "0.875,inf,1.5",
            "column velocity_mm_s: `inf` is not a finite number",
        ),
        (
            "0.875,14,1e400",
            "column force_n: `1e400` is not a finite number",
        ),
        ("0.875,14,0x10", "column force_n: `0x10` is not a number"),
        (
            "0.75,14,1.5",
            "column time_s: time does not increase: 0.75 s after 0.75 s",
        ),
        (
            "0.5,14,1.5",
            "column time_s: time does not increase: 0.5 s after 0.75 s",
        ),
        (
            "0.875,-14,1.5",
            "column velocity_mm_s: the direction is `forward`, but the velocity is -0.014 m/s",
        ),
        (",14,1.5", "column time_s: the cell is empty"),
    ];
    for (line, message) in cases {
        let joint = if message.starts_with(':') { "" } else { ", " };
        refused(
            &Package::new().line(9, line),
            &format!("{FILE}, row 9{joint}{message}"),
        );
    }
}

/// An encoder that scatters by 0.8 mm/s reads -1.2 mm/s at rest, 2 % of the run's largest speed; the same reading beside a clean ramp
/// is a motion, and so is three times as much beside noise.
#[test]
fn an_encoders_noise_contradicts_no_direction() {
    let recorded = |at_rest: &str| {
        let noise = [-1.2, 0.8, -0.5, 1.1, -0.9, 0.3, 0.7, -0.6];
        let mut text = format!("time_s,velocity_mm_s,force_n\n0,{at_rest},1.5\n");
        for sample in 1..30_usize {
            let v = 2.0 * sample as f64 + noise[sample % noise.len()];
            text += &format!("{},{v},1.5\n", sample as f64 / 8.0);
        }
        Package::new().file(text.as_bytes())
    };
    assert_eq!(recorded("-1.2").open().unwrap().runs.len(), 2);
    let contradicts = |v: &str| {
        format!(
            "{FILE}, row 2, column velocity_mm_s: the direction is `forward`, but the velocity is -0.00{v} m/s"
        )
    };
    refused(&recorded("-3.6"), &contradicts("36"));
    refused(&Package::new().line(2, "0,-1.2,1.5"), &contradicts("12"));
}

#[test]
fn headers() {
    let header = |text: &str| Package::new().line(1, text);
    refused(
        &header("time_s,velocity_mm_s"),
        "runs/a.csv, column force_n: the column is missing",
    );
    refused(
        &header("time_s,velocity_mm_s,force_n,force_n"),
        "runs/a.csv, row 1, column force_n: the column stands twice",
    );
    refused(
        &header("time_s,velocity_mm_s,force_n,extra"),
        "runs/a.csv, row 1, column extra: the column is not in the schema",
    );
    let fields = "/resources/0/schema/fields";
    let renamed = Package::new()
        .with(&format!("{fields}/2/name"), Some(json!("tension")))
        .line(1, "time_s,velocity_mm_s,tension");
    refused(&renamed, "runs/a.csv: no column holds force");
    let doubled = Package::new()
        .with(
            &format!("{fields}/2"),
            Some(json!({"name": "velocity_m_s", "unit": "m/s"})),
        )
        .line(1, "time_s,velocity_mm_s,velocity_m_s");
    refused(
        &doubled,
        "runs/a.csv: `velocity_mm_s` and `velocity_m_s` both hold velocity",
    );
    let mixed = Package::new()
        .with(
            &format!("{fields}/2"),
            Some(json!({"name": "torque_n_m", "unit": "N m"})),
        )
        .line(1, "time_s,velocity_mm_s,torque_n_m");
    refused(
        &mixed,
        "runs/a.csv: linear and rotary columns are mixed (velocity_mm_s and torque_n_m)",
    );
}

#[test]
fn units() {
    let unit = |unit| Package::new().with("/resources/0/schema/fields/2/unit", unit);
    refused(
        &unit(Some(json!("lbf"))),
        "runs/a.csv, column force_n: `lbf` is not a unit of force (N, mN)",
    );
    refused(
        &unit(Some(json!("mm"))),
        "runs/a.csv, column force_n: `mm` is not a unit of force (N, mN)",
    );
    refused(
        &unit(Some(json!(3))),
        "datapackage.json, resources[0].schema.fields[2].unit: must be a text",
    );
    let bare = unit(None)
        .with("/resources/0/schema/fields/2/name", Some(json!("force")))
        .line(1, "time_s,velocity_mm_s,force");
    refused(&bare, "runs/a.csv, column force: has no unit");
    assert!(
        unit(None).open().is_ok(),
        "the contract's own name states the unit"
    );
}

#[test]
fn lengths() {
    let text: String = fs::read_to_string(Package::new().folder.path().join(FILE)).unwrap();
    let rows = |count: usize| text.lines().take(count + 1).collect::<Vec<_>>().join("\n");
    refused(
        &Package::new().file(rows(19).as_bytes()),
        "runs/a.csv: has 19 samples, but at least 20 are needed",
    );
    assert!(Package::new().file(rows(20).as_bytes()).open().is_ok());
    refused(
        &Package::new().file(rows(0).as_bytes()),
        "runs/a.csv: has 0 samples, but at least 20 are needed",
    );
    refused(
        &Package::new().file(b""),
        "runs/a.csv, column time_s: the column is missing",
    );
    let gap: String = text
        .lines()
        .enumerate()
        .filter(|(i, _)| *i != 12)
        .map(|(_, line)| format!("{line}\n"))
        .collect();
    assert!(
        Package::new().file(gap.as_bytes()).open().is_ok(),
        "a missing row is a gap in time"
    );
}

#[test]
fn loads() {
    let load = |load| Package::new().with("/resources/0/run/normal_load_n", load);
    let place = "datapackage.json, resources[0].run.normal_load_n";
    refused(
        &load(Some(json!(-1.5))),
        &format!("{place}: the normal load is -1.5 N, below zero"),
    );
    refused(
        &load(Some(json!(0))),
        &format!("{place}: the normal load is zero, which only the protocol `unloaded` may have"),
    );
    refused(
        &load(Some(json!("2 N"))),
        &format!("{place}: must be a finite number"),
    );
    let unloaded = |n| load(n).with("/resources/0/run/protocol", Some(json!("unloaded")));
    refused(
        &unloaded(Some(json!(1))),
        &format!("{place}: the protocol is `unloaded`, but the normal load is 1 N"),
    );
    assert!(unloaded(Some(json!(0))).open().is_ok());
    assert!(load(None).open().unwrap().runs[0].normal_load_n.is_none());
    let field = json!({"name": "normal_force_n", "unit": "N"});
    let recorded = |cell: &str| {
        let mut package = Package::new();
        let fields = package
            .description
            .pointer_mut("/resources/0/schema/fields")
            .unwrap();
        fields.as_array_mut().unwrap().push(field.clone());
        let path = package.folder.path().join(FILE);
        let text = fs::read_to_string(&path).unwrap();
        let lines = text.lines().enumerate().map(|(i, line)| match i {
            0 => format!("{line},normal_force_n\n"),
            7 => format!("{line},{cell}\n"),
            _ => format!("{line},2\n"),
        });
        let text: String = lines.collect();
        fs::write(path, text).unwrap();
        package
    };
    refused(
        &recorded("-0.5"),
        "runs/a.csv, row 8, column normal_force_n: the normal load is -0.5 N, below zero",
    );
    refused(
        &recorded("0"),
        "runs/a.csv, row 8, column normal_force_n: the normal load is zero, which only the protocol `unloaded` may have",
    );
}

#[test]
fn paths() {
    let path = |path: &str| Package::new().with("/resources/0/path", Some(json!(path)));
    let leaves = |path: &str| {
        format!(
            "datapackage.json, resources[0].path: the path `{path}` leaves the folder of the package"
        )
    };
    for outside in [
        "../a.csv",
        "/etc/passwd",
        "runs/../../a.csv",
        "https://example.org/a.csv",
    ] {
        refused(&path(outside), &leaves(outside));
    }
    refused(
        &path("runs/none.csv"),
        "runs/none.csv: cannot be read: there is no such file",
    );
    refused(&path("runs"), "runs: is not a regular file");
    refused(
        &path("runs/b.csv"),
        "datapackage.json, resources[1]: the runs `a` and `b` read the same file",
    );
}

#[cfg(unix)]
#[test]
fn links_out_of_the_folder() {
    let outside = TempDir::new().unwrap();
    let target = outside.path().join("a.csv");
    let package = Package::new();
    fs::copy(package.folder.path().join(FILE), &target).unwrap();
    std::os::unix::fs::symlink(&target, package.folder.path().join("runs/link.csv")).unwrap();
    refused(
        &package.with("/resources/0/path", Some(json!("runs/link.csv"))),
        "datapackage.json, resources[0].path: the path `runs/link.csv` leaves the folder of the package",
    );
    let within = Package::new();
    std::os::unix::fs::symlink("a.csv", within.folder.path().join("runs/link.csv")).unwrap();
    assert!(
        within
            .with("/resources/0/path", Some(json!("runs/link.csv")))
            .open()
            .is_ok()
    );
}

#[test]
fn descriptions() {
    let set = |pointer: &str, value| Package::new().with(pointer, value);
    refused(
        &set("/resources/1/name", Some(json!("a"))),
        "datapackage.json, resources[1]: two runs are called `a`",
    );
    refused(
        &set("/campaign", None),
        "datapackage.json, campaign: is missing",
    );
    refused(
        &set("/campaign/provenance", None),
        "datapackage.json, campaign.provenance: is missing",
    );
    refused(
        &set("/campaign/provenance", Some(json!("simulated"))),
        "datapackage.json, campaign.provenance: `simulated` is not one of measured, synthetic",
    );
    refused(
        &set("/resources/0/run/direction", Some(json!("sideways"))),
        "datapackage.json, resources[0].run.direction: `sideways` is not one of forward, reverse, both",
    );
    refused(
        &set("/resources/0/run", None),
        "datapackage.json, resources[0].run: is missing",
    );
    refused(
        &set("/resources/0/run/protocol", None),
        "datapackage.json, resources[0].run.protocol: is missing",
    );
    refused(
        &set("/resources/0/name", None),
        "datapackage.json, resources[0].name: is missing",
    );
    refused(
        &set("/resources", Some(json!([]))),
        "datapackage.json: the package holds no run",
    );
    refused(
        &set("/resources", Some(json!({}))),
        "datapackage.json, resources: must be an array",
    );
    refused(
        &set("/resources/0", Some(json!(7))),
        "datapackage.json, resources[0]: must be an object",
    );
    refused(
        &set("/profile", Some(json!("data-package"))),
        "datapackage.json, profile: `data-package` is not one of tabular-data-package",
    );
    refused(
        &set("/campaign/rig", Some(json!({"travel_mm": -3}))),
        "datapackage.json, campaign.rig.travel_mm: must be above zero, but is -3",
    );
    refused(
        &set("/resources/0/dialect", Some(json!({"delimiter": "::"}))),
        "datapackage.json, resources[0].dialect.delimiter: this delimiter is not supported",
    );
    refused(
        &set("/resources/0/name", Some(json!("a\nb\u{1b}[31m")))
            .with("/resources/1/name", Some(json!("a\nb\u{1b}[31m"))),
        "datapackage.json, resources[1]: two runs are called `a\\nb\\u{1b}[31m`",
    );
}

#[test]
fn files_of_the_package() {
    let folder = TempDir::new().unwrap();
    let shown = |path: &Path| campaign::open(path).unwrap_err().to_string();
    let home = folder.path().display().to_string();
    assert_eq!(
        shown(folder.path()),
        format!("{home}/datapackage.json: cannot be read: there is no such file")
    );
    assert_eq!(
        shown(&folder.path().join("none")),
        format!("{home}/none: cannot be read: there is no such folder")
    );
    fs::write(folder.path().join("datapackage.json"), "{\"profile\": ").unwrap();
    assert_eq!(
        shown(folder.path()),
        format!(
            "{home}/datapackage.json: is not JSON: EOF while parsing a value at line 1 column 12"
        )
    );
    fs::write(folder.path().join("datapackage.json"), "[]").unwrap();
    assert_eq!(
        shown(folder.path()),
        format!("{home}/datapackage.json: must be an object")
    );
    // A description may be deeper than any stack.
    fs::write(
        folder.path().join("datapackage.json"),
        "[".repeat(1_000_000),
    )
    .unwrap();
    assert!(shown(folder.path()).contains("is not JSON: recursion limit exceeded"));
}

/// Which of two values under one key is meant, nobody can tell: not even deep inside metadata that is not read.
#[test]
fn a_key_that_stands_twice_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (text, what) in [
        (
            "{\"name\": \"a\",\n \"name\": \"b\"}",
            "the key `name` stands twice at line 2 column 7",
        ),
        (
            "{\"more\": [{\"x\": 1, \"y\": null, \"x\": 1}]}",
            "the key `x` stands twice at line 1 column 33",
        ),
    ] {
        std::fs::write(folder.path().join("datapackage.json"), text).unwrap();
        let home = folder.path().display();
        let refusal = campaign::open(folder.path()).unwrap_err().to_string();
        assert_eq!(refusal, format!("{home}/datapackage.json: {what}"));
    }
}

#[test]
fn a_description_that_is_too_large_is_refused_before_it_is_parsed() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("datapackage.json");
    let file = fs::File::create(&path).unwrap();
    file.set_len(16 * 1024 * 1024 + 1).unwrap();
    let message = campaign::open(folder.path()).unwrap_err().to_string();
    assert_eq!(
        message,
        format!("{}: is larger than 16 MiB", path.display())
    );
}

proptest! {
    /// Whatever stands in the files, the door answers; and what it says fits on one line.
    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let package = Package::new().file(&bytes);
        if let Err(message) = package.open() {
            prop_assert!(!message.contains('\n') && message.starts_with("runs/a.csv"));
        }
        fs::write(package.folder.path().join("datapackage.json"), &bytes).unwrap();
        let message = campaign::open(package.folder.path()).unwrap_err().to_string();
        prop_assert!(!message.contains('\n'));
    }

    /// A good package with one byte changed, in either file.
    #[test]
    fn one_changed_byte_never_panics(place in 0_usize..4000, byte in any::<u8>(), description in any::<bool>()) {
        let package = Package::new();
        prop_assert!(package.open().is_ok());
        let path = package.folder.path().join(if description { "datapackage.json" } else { FILE });
        let mut bytes = fs::read(&path).unwrap();
        let place = place % bytes.len();
        bytes[place] = byte;
        fs::write(&path, bytes).unwrap();
        if let Err(refusal) = campaign::open(package.folder.path()) {
            prop_assert!(!refusal.to_string().contains('\n'));
        }
    }

    /// Any entry of the description replaced by a value of any type.
    #[test]
    fn a_wrong_type_anywhere_never_panics(which in 0_usize..12, kind in 0_usize..6) {
        let pointers = ["/name", "/campaign", "/campaign/provenance", "/resources", "/resources/0",
            "/resources/0/path", "/resources/0/schema", "/resources/0/schema/fields",
            "/resources/0/schema/fields/1", "/resources/0/run", "/resources/0/run/direction", "/resources/0/run/normal_load_n"];
        let values = [json!(null), json!(true), json!(-1e308), json!("x"), json!([]), json!({})];
        let _ = Package::new().with(pointers[which], Some(values[kind].clone())).open();
    }
}
