//! Hidden effects: a fixed selection of what `bench hidden-effects` tries by the thousand.
//!
//! Sizes are multiples of the size that a test which knows the cause would find in 90 % of cases (see
//! `whole_program::hidden::oracle`). The finder gets the written package and nothing else.

use std::convert::Infallible;

use diagnosis::Options;
use planting::{Case, NoiseKind, Protocol};
use serde_json::Value;
use whole_program::hidden::ask::ask;
use whole_program::hidden::carry_out::{Workshop, side_by_side};
use whole_program::hidden::judge::{Judgement, Verdict};
use whole_program::hidden::selection::{Group, Trial};

/// Seeds of these tests: apart from those of the benchmark.
const SEED: u64 = 4_000_000;

fn trial(group: Group, case: Case, ratio: f64, without: Option<&str>) -> Trial {
    Trial {
        id: String::new(),
        group,
        case,
        ratio,
        without: without.map(Into::into),
    }
}

/// Carries trials out and returns a line for each whose verdict is not among the accepted ones.
fn complaints(trials: &[Trial], accepted: &[Verdict]) -> Vec<String> {
    let is_accepted = |judgement: &Judgement| accepted.contains(&judgement.verdict);
    judgements(trials)
        .into_iter()
        .filter(|(judgement, _)| !judgement.as_ref().is_some_and(is_accepted))
        .map(|(_, line)| line)
        .collect()
}

/// Carries trials out; the judgement (none: the law absorbs what was planted) and a line for each.
fn judgements(trials: &[Trial]) -> Vec<(Option<Judgement>, String)> {
    let workshop = Workshop::default();
    let mut judgements: Vec<(Option<Judgement>, String)> =
        vec![(None, String::new()); trials.len()];
    let Ok(()) = side_by_side::<_, Infallible>(
        trials,
        |trial| judgement(&workshop, trial),
        || false,
        |place, one| {
            println!("{}", one.1);
            judgements[place] = one;
            Ok(())
        },
    );
    judgements
}

fn judgement(workshop: &Workshop, trial: &Trial) -> (Option<Judgement>, String) {
    let planted = trial.case.planted.iter();
    let what: Vec<&str> = planted.map(|planted| planted.id.as_str()).collect();
    let protocol = trial.case.protocol.id();
    let (judged, _) = workshop
        .carry_out(trial, true)
        .expect("the package is a campaign");
    let line = match &judged.judgement {
        None => format!("{what:?}: the law absorbs it on {protocol}"),
        Some(judgement) => format!(
            "{what:?} on {protocol}: {:?}, {} {:?} (the protocol forces {:?})",
            judgement.verdict, judgement.status, judgement.named, judged.forced
        ),
    };
    (judged.judgement, line)
}

fn assert_none(complaints: &[String]) {
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

fn singles(causes: &[&str], protocol: Protocol, ratio: f64) -> Vec<Trial> {
    causes
        .iter()
        .enumerate()
        .map(|(i, cause)| {
            let case = Case::one(cause, 1.0, protocol, SEED + i as u64).of_specimen(SEED);
            trial(Group::Single, case, ratio, None)
        })
        .collect()
}

/// The causes that are another value of the law's own parameters: only a model from elsewhere shows them.
const THE_LAWS_OWN: [&str; 2] = ["lean-angle", "force-gain"];

/// Every cause is named on a day that can tell it; what it is tied to is named with it. Those that the law's own parameters absorb are
/// said to be absorbed, and are asked against a model from elsewhere below.
#[test]
fn every_cause_is_named_on_a_rich_day() {
    let mut trials = singles(&planting::species::CAUSES, Protocol::RichTurned, 5.0);
    for trial in &mut trials {
        // A gain for each load lives between runs only: two loads in a few runs leave it to the scatter.
        if trial.case.planted[0].id == "load-dependence" {
            trial.case.protocol = Protocol::Loads;
        }
    }
    let named = [Verdict::Right, Verdict::Tight, Verdict::Loose];
    let judgements = judgements(&trials);
    assert_eq!(judgements.len(), planting::species::CAUSES.len());
    let each = || judgements.iter().zip(planting::species::CAUSES);
    let wrong: Vec<String> = each()
        .filter(|((judgement, _), cause)| match judgement {
            Some(judgement) => !named.contains(&judgement.verdict),
            None => !THE_LAWS_OWN.contains(cause),
        })
        .map(|((_, line), _)| line.clone())
        .collect();
    assert_none(&wrong);
    // Planted in their plainest form, these are answered in it, whichever form came in first: another one has other parameters.
    for ((judgement, line), cause) in each() {
        if ["wear", "velocity-strengthening"].contains(&cause) {
            let intervals = judgement.iter().flat_map(|judgement| &judgement.intervals);
            let ratios: Vec<f64> = intervals.map(|size| size.value / size.truth).collect();
            let alike = |ratio: &f64| (0.6..1.6).contains(ratio);
            assert!(
                !ratios.is_empty() && ratios.iter().all(alike),
                "{line}: sizes {ratios:?} times those that were planted"
            );
        }
    }
}

/// On the paper's protocol a constant force, a tilt and crosstalk are one thing: the answer is the set.
#[test]
fn ties_of_the_papers_protocol_are_answered_by_the_set() {
    let trials = singles(
        &["force-zero-offset", "stage-tilt", "load-crosstalk"],
        Protocol::PaperBlocked,
        5.0,
    );
    assert_none(&complaints(&trials, &[Verdict::Right]));
}

/// Nothing planted: nothing named, and nothing unexplained but by chance.
#[test]
fn nothing_is_found_where_nothing_is() {
    let trials: Vec<Trial> = [
        (Protocol::PaperBlocked, NoiseKind::Usual),
        (Protocol::PaperAlternating, NoiseKind::HeavyTails),
        (Protocol::PaperBlocked, NoiseKind::WideScatter),
        (Protocol::Rich, NoiseKind::Usual),
        (Protocol::Speeds, NoiseKind::PlateRoughness),
        // Here inertia is in the record too, which neither roughness nor scatter multiplies.
        (Protocol::Drive, NoiseKind::WideScatter),
    ]
    .into_iter()
    .enumerate()
    .map(|(i, (protocol, noise))| {
        trial(
            Group::Nothing,
            Case::nothing(protocol, noise, SEED + 100 + i as u64),
            0.0,
            None,
        )
    })
    .collect();
    let judgements = judgements(&trials);
    let is = |judgement: &Option<Judgement>, verdict| {
        judgement.as_ref().is_some_and(|j| j.verdict == verdict)
    };
    let count = |verdict| judgements.iter().filter(|(j, _)| is(j, verdict)).count();
    let (right, refused) = (count(Verdict::Right), count(Verdict::Refused));
    assert_eq!(right + refused, trials.len(), "{judgements:?}");
    // The search for what has no name errs in four of a thousand campaigns: chance makes one of six unexplained in one draw of
    // forty, two in one of four thousand.
    assert!(refused <= 1, "{judgements:?}");
}

/// The noise of a cell that records the load is no cause: what smooths it or shifts it would fit better. A delay beside it is found.
#[test]
fn noise_of_a_load_cell_is_no_cause() {
    let healthy = [Protocol::Rich, Protocol::Speeds, Protocol::PaperAlternating];
    let trials = beside_channel_noise(NoiseKind::LoadCell, SEED + 620, healthy, "clock-offset");
    assert_none(&complaints(&trials, &[Verdict::Right]));
}

/// Nor is the noise of the velocity channel, a thousandth of the largest speed.
#[test]
fn noise_of_an_encoder_is_no_cause() {
    let healthy = [Protocol::Rich, Protocol::Loads, Protocol::PaperAlternating];
    let trials = beside_channel_noise(NoiseKind::Encoder, SEED + 640, healthy, "wear");
    assert_none(&complaints(&trials, &[Verdict::Right]));
}

/// Nor is an amplifier whose zero wanders by twice the sensor's noise, over a fifth of a second.
#[test]
fn a_wandering_amplifier_is_no_cause() {
    let healthy = [
        Protocol::Rich,
        Protocol::PaperBlocked,
        Protocol::PaperAlternating,
    ];
    let trials = beside_channel_noise(NoiseKind::Amplifier, SEED + 660, healthy, "wear");
    assert_none(&complaints(&trials, &[Verdict::Right]));
}

/// Roughness behind a lag is smooth in time, as an amplifier's wander is: one that wanders may swallow the lag (the draw is one of the
/// final ones that was looked at for having been missed).
#[test]
fn a_lag_is_not_taken_for_a_wander() {
    let case = Case::one("sensor-lag", 1.0, Protocol::PaperBlocked, 9_003_268);
    let lag = trial(Group::Single, case.of_specimen(9_500_002), 5.0, None);
    assert_none(&complaints(&[lag], &[Verdict::Right, Verdict::Tight]));
}

/// Smooth roughness of the plate takes up a texture, and what is left of it is little beside a strong lag.
#[test]
fn a_texture_is_found_beside_a_strong_lag_and_a_wander() {
    let pair = Case::nothing(Protocol::Rich, NoiseKind::Amplifier, SEED + 680)
        .with("sensor-lag", 1.0, false)
        .with("surface-texture", 1.0, false);
    let pair = trial(Group::Pair, pair, 5.0, None);
    assert_none(&complaints(&[pair], &[Verdict::Right]));
}

/// Nothing planted on these protocols, and one cause of five thresholds on a rich day, with a channel that has noise.
fn beside_channel_noise(
    noise: NoiseKind,
    seed: u64,
    healthy: [Protocol; 3],
    planted: &str,
) -> Vec<Trial> {
    let nothing = (seed..).zip(healthy).map(|(seed, protocol)| {
        let case = Case::nothing(protocol, noise, seed);
        trial(Group::Nothing, case, 0.0, None)
    });
    let one = Case::nothing(Protocol::Rich, noise, seed + 10).with(planted, 1.0, false);
    let one = trial(Group::Single, one, 5.0, None);
    nothing.chain([one]).collect()
}

/// What no cause of the catalogue makes is reported as unexplained, without a name. A lean that rocks at random times is, at five
/// thresholds of one who knows the times, no larger than the roughness: there it may be missed, but not named.
#[test]
fn aliens_are_refused() {
    let alien = |id: &str, place: u64, ratio: f64| {
        let case = Case::one(id, 1.0, Protocol::Rich, SEED + 200 + place).of_specimen(SEED);
        trial(Group::Alien, case, ratio, None)
    };
    let (mut seen, mut faint) = (Vec::new(), Vec::new());
    for (id, place) in planting::species::ALIENS.iter().zip(0..) {
        if *id == "alien-loose-clamp" {
            faint.push(alien(id, place, 5.0));
            seen.push(alien(id, place, 10.0));
        } else {
            seen.push(alien(id, place, 5.0));
        }
    }
    let mut wrong = complaints(&seen, &[Verdict::Right]);
    wrong.extend(complaints(&faint, &[Verdict::Right, Verdict::Missed]));
    assert_none(&wrong);
}

/// Shapes that the catalogue knows in a form of its own: an oscillation of the load that goes on between the runs, ageing that sliding
/// wears off, a play that a run finds as the one before left it, a square of the speed that is added to the force of a rig without a load, a
/// cube of it, friction that fades along the plate.
#[test]
fn second_forms_are_named_like_the_first() {
    // The specimen decides which of its second shapes a cause has.
    let of_specimen = |id: &str, protocol, place: u64, specimen: u64| {
        let case = Case::nothing(protocol, NoiseKind::Usual, SEED + 240 + place)
            .of_specimen(specimen)
            .with(id, 1.0, true);
        trial(Group::SecondShape, case, 5.0, None)
    };
    let second = |id: &str, protocol, place: u64| of_specimen(id, protocol, place, SEED);
    let trials = [
        second("load-oscillation", Protocol::PaperBlocked, 0),
        second("load-oscillation", Protocol::Rich, 1),
        second("dwell-ageing", Protocol::PaperAlternating, 2),
        second("dwell-ageing", Protocol::Rich, 3),
        second("backlash", Protocol::PaperAlternating, 4),
        second("velocity-strengthening", Protocol::Rich, 5),
        second("thermal-softening", Protocol::PaperBlocked, 6),
        second("bristle-set", Protocol::Rich, 7),
        second("velocity-strengthening", Protocol::Drive, 8),
        second("surface-gradient", Protocol::Rich, 9),
        of_specimen("velocity-strengthening", Protocol::Rich, 10, SEED + 1),
        of_specimen("velocity-strengthening", Protocol::Drive, 11, SEED + 1),
    ];
    assert_none(&complaints(&trials, &[Verdict::Right]));
}

/// A cord that hardens swings as stiffly as its tension makes it: with the stiffness of the slack cord what is left of the noise was a texture of
/// 2 mm, with which the cord itself was taken back. (The draw is a development trial of the benchmark that was refused.)
#[test]
fn a_cord_that_hardens_is_named() {
    let case = Case::nothing(Protocol::Rich, NoiseKind::Usual, 1_003_562)
        .of_specimen(1_500_000)
        .with("cord-compliance", 1.0, true);
    let cord = trial(Group::SecondShape, case, 5.0, None);
    assert_none(&complaints(&[cord], &[Verdict::Right]));
}

/// A gap is crossed between two samples: the likelihood of its width has treads, and the interval spans the one it is on. Of four
/// campaigns one may lie outside: right 95 % intervals miss two of four in one draw of seventy, those of the curvature at a
/// tread's edge miss most.
#[test]
fn the_width_of_play_lies_inside_its_interval() {
    let ratios = [2.5, 5.0, 10.0, 10.0];
    let play = |(ratio, seed): (f64, u64)| {
        let case = Case::one("backlash", 1.0, Protocol::Rich, seed).of_specimen(SEED);
        trial(Group::Single, case, ratio, None)
    };
    let trials: Vec<Trial> = ratios.into_iter().zip(SEED + 270..).map(play).collect();
    let mut outside = Vec::new();
    for ((judgement, _), ratio) in judgements(&trials).into_iter().zip(ratios) {
        let intervals = judgement.expect("not absorbed").intervals;
        assert_eq!(intervals.len(), 1, "at {ratio} thresholds play is named");
        println!("at {ratio}: {:?}", intervals[0]);
        if intervals[0].inside != Some(true) {
            outside.push(format!("at {ratio}: {:?}", intervals[0]));
        }
    }
    assert!(outside.len() <= 1, "{}", outside.join("\n"));
}

/// Behind a slow channel roughness looks smoother and longer than it is; with the filter taken out it has its size and length again.
#[test]
fn roughness_behind_a_slow_channel_keeps_its_size() {
    let case =
        Case::one("sensor-lag", 1.0, Protocol::PaperAlternating, SEED + 280).of_specimen(SEED);
    let (_, _, planted) = case.set_up().expect("a case of the catalogue");
    let trial = trial(Group::Single, case, 5.0, None);
    let (judged, answer) = Workshop::default()
        .carry_out(&trial, true)
        .expect("a campaign");
    assert_eq!(
        judged.judgement.map(|j| j.verdict),
        Some(Verdict::Right),
        "{answer}"
    );
    let found = |name: &str| answer["noise_floor"][name].as_f64().expect("a size");
    let private = planted.roughness * (1.0 - planted.plate_share).sqrt();
    for (name, size) in [
        ("roughness_private", private),
        ("roughness_length", planted.correlation_m),
    ] {
        let ratio = found(name) / size;
        assert!((ratio - 1.0).abs() < 0.25, "{name}: {ratio} of the planted");
    }
}

/// Stick-slip that comes back for a while in every other run is weak in each of them and seen in all together; a channel that drops out for a
/// moment is seen in the runs in which it does.
#[test]
fn bursts_and_dropouts_are_refused_on_the_papers_protocol() {
    let alien = |id: &str, place: u64| {
        let case = Case::one(id, 1.0, Protocol::PaperBlocked, SEED + 260 + place);
        trial(Group::Alien, case.of_specimen(SEED), 5.0, None)
    };
    let trials = [
        alien("alien-stick-slip-burst", 0),
        alien("alien-dropout", 1),
    ];
    assert_none(&complaints(&trials, &[Verdict::Right]));
}

/// A scratch that every run passes is no roughness of the plate, on the paper's protocol too.
#[test]
fn a_scratch_is_refused_on_the_papers_protocol() {
    let case =
        Case::one("alien-scratch", 1.0, Protocol::PaperBlocked, SEED + 250).of_specimen(SEED);
    assert_none(&complaints(
        &[trial(Group::Alien, case, 5.0, None)],
        &[Verdict::Right],
    ));
}

/// A groove that throws up an edge is told at its place, though neither a bell nor a step has its course.
#[test]
fn a_groove_with_its_edge_is_refused_where_it_is() {
    let case = Case::nothing(Protocol::Rich, NoiseKind::Usual, SEED + 255)
        .of_specimen(SEED)
        .with("alien-scratch", 1.0, true);
    assert_none(&complaints(
        &[trial(Group::Alien, case, 10.0, None)],
        &[Verdict::Right],
    ));
}

/// A coarse force channel is named, and what its rounding leaves is not called unexplained.
#[test]
fn a_coarse_channel_leaves_nothing_unexplained() {
    let trials = singles(&["force-resolution"], Protocol::PaperBlocked, 20.0);
    assert_none(&complaints(&trials, &[Verdict::Right]));
}

/// Without a recorded load an oscillation of it has no name, and is no noise either.
#[test]
fn an_oscillation_of_a_load_that_nobody_recorded_is_unexplained() {
    let trials = singles(&["load-oscillation"], Protocol::Drive, 5.0);
    assert_none(&complaints(&trials, &[Verdict::Refused]));
}

/// With the law's parameters known from elsewhere a specimen that leans otherwise is a cause, as is a force channel that reads too much, and
/// the unseen runs do not speak against them; a healthy campaign has none.
#[test]
fn what_only_shifts_the_law_is_a_cause_against_a_model_from_elsewhere() {
    let healthy = |seed: u64| {
        Case::nothing(Protocol::PaperBlocked, NoiseKind::Usual, seed)
            .of_specimen(SEED)
            .carry_out()
            .expect("a case of the catalogue")
    };
    let folder = tempfile::tempdir().expect("a temporary folder");
    planting::package::write(folder.path(), &healthy(SEED + 500).files).expect("it can be written");
    let campaign = campaign::open(folder.path()).expect("it is a campaign");
    let quick = Options {
        quick: true,
        ..Options::default()
    };
    let known = diagnosis::diagnose_fully(&campaign, &quick).expect("a brush");
    let against = Options {
        model: Some(known.plain),
        ..Options::default()
    };
    let same = ask(&healthy(SEED + 501).files, &against).expect("a campaign");
    assert_eq!(same.json["status"], "consistent", "{}", same.json);

    for (cause, seed) in THE_LAWS_OWN.into_iter().zip(502..) {
        let case = Case::one(cause, 1.0, Protocol::PaperBlocked, SEED + seed).of_specimen(SEED);
        let other = case.carry_out().expect("a case of the catalogue");
        let answer = ask(&other.files, &against).expect("a campaign").json;
        assert_eq!(answer["findings"][0]["cause"], cause, "{answer}");
        assert_eq!(answer["findings"].as_array().map(Vec::len), Some(1));
        assert_eq!(answer["findings"][0]["equivalent"], serde_json::json!([]));
        let parameter = &answer["findings"][0]["parameters"][0];
        use planting::effect::Effect::{ForceGain, LeanAngle};
        let planted = match other.key.effects[0] {
            LeanAngle { angle_rad } => angle_rad,
            ForceGain { gain_minus_1 } => gain_minus_1,
            ref other => panic!("{cause} was planted: {other:?}"),
        };
        let inside = |k: usize| parameter["ci95"][k].as_f64().expect("an interval");
        assert!(
            inside(0) < planted && planted < inside(1),
            "{planted}: {parameter}"
        );
        // With a run of each condition left out not every fold is sure of what lives between runs: less than all is gained, but not nothing.
        let gained = &answer["gain"]["ci95"][0];
        assert!(
            gained.as_f64().is_some_and(|least| least > 0.0),
            "{}",
            answer["gain"]
        );
    }
}

/// Two causes at once are two findings; a late sensor beside a ripple of the drive among them, which shifts the plate's roughness
/// against itself in the two directions and once brought in textures that nobody had made.
#[test]
fn a_pair_is_two_findings() {
    let drift = Case::one("surface-texture", 1.0, Protocol::Rich, SEED + 300)
        .of_specimen(SEED)
        .with("force-zero-drift", 1.0, false);
    let late = Case::one("stage-ripple", 1.0, Protocol::RichTurned, SEED + 301)
        .of_specimen(SEED)
        .with("sensor-lag", 1.0, false);
    let trials = [drift, late].map(|case| trial(Group::Pair, case, 5.0, None));
    assert_none(&complaints(&trials, &[Verdict::Right]));
}

/// With its cause taken out of the catalogue an effect is unexplained, not another name. (A texture is not among these:
/// fixed to the plate, it then counts as roughness of the plate, which repeats and is no error.)
#[test]
fn a_cause_taken_out_of_the_catalogue_is_refused() {
    let trials: Vec<Trial> = ["surface-gradient", "force-zero-drift", "bristle-set"]
        .iter()
        .enumerate()
        .map(|(i, cause)| {
            let case =
                Case::one(cause, 1.0, Protocol::Rich, SEED + 400 + i as u64).of_specimen(SEED);
            trial(Group::Control, case, 8.0, Some(cause))
        })
        .collect();
    assert_none(&complaints(&trials, &[Verdict::Right]));
}

/// A short filter of the velocity is a delay of the force but for the corners of the motion. A recorded position tells them apart, as the
/// stage goes further than the recorded speeds say; without that column the two are a set.
#[test]
fn a_recorded_position_tells_a_slow_velocity_from_a_late_force() {
    let case = Case::one("velocity-lag", 0.015, Protocol::RichTurned, SEED + 290).of_specimen(SEED);
    let files = case.carry_out().expect("a known cause").files;
    let options = Options {
        quick: true,
        ..Options::default()
    };
    let named = |files: &[(String, String)]| -> Vec<String> {
        let answer = ask(files, &options).expect("a campaign").json;
        let finding = &answer["findings"][0];
        let set = std::iter::once(&finding["cause"])
            .chain(finding["equivalent"].as_array().into_iter().flatten());
        set.map(|id| id.as_str().unwrap_or("none").to_owned())
            .collect()
    };
    assert_eq!(named(&files), ["velocity-lag"]);
    let mut blind = named(&without_position(&files));
    blind.sort();
    assert_eq!(blind, ["clock-offset", "velocity-lag"]);
}

/// A package without its column of positions.
fn without_position(files: &[(String, String)]) -> Vec<(String, String)> {
    let table = |text: &str| -> String {
        let cells = |line: &str| -> String {
            let kept = line
                .split(',')
                .enumerate()
                .filter(|(column, _)| *column != 2);
            let kept: Vec<&str> = kept.map(|(_, cell)| cell).collect();
            kept.join(",") + "\n"
        };
        assert_eq!(
            text.lines().next(),
            Some("time_s,velocity_mm_s,position_mm,force_n")
        );
        text.lines().map(cells).collect()
    };
    let description = |text: &str| -> String {
        let mut package: Value = serde_json::from_str(text).expect("a data package");
        for resource in package["resources"].as_array_mut().expect("resources") {
            let fields = resource["schema"]["fields"].as_array_mut().expect("fields");
            fields.retain(|field| field["name"] != "position_mm");
        }
        package.to_string()
    };
    let each = files.iter().map(|(path, text)| {
        let text = if path == "datapackage.json" {
            description(text)
        } else {
            table(text)
        };
        (path.clone(), text)
    });
    each.collect()
}

/// Renames every run and file, lists the runs the other way round, and adds metadata that mean nothing.
fn disguise(files: &[(String, String)]) -> Vec<(String, String)> {
    let mut disguised = Vec::new();
    for (path, text) in files {
        if path != "datapackage.json" {
            disguised.push((path.replace("run-", "zeta-9"), text.clone()));
            continue;
        }
        let mut package: Value = serde_json::from_str(text).expect("a data package");
        package["name"] = "something-else".into();
        package["title"] = "wear force-zero-drift".into();
        package["keywords"] = serde_json::json!(["sensor-lag"]);
        let resources = package["resources"].as_array_mut().expect("resources");
        resources.reverse();
        for resource in resources {
            for key in ["name", "path"] {
                resource[key] = resource[key]
                    .as_str()
                    .expect("text")
                    .replace("run-", "zeta-9")
                    .into();
            }
            resource["remark"] = "taken after lunch".into();
        }
        disguised.push((path.clone(), package.to_string()));
    }
    disguised
}

/// An answer without the names of campaign and runs.
fn nameless(answer: &Value) -> Value {
    let text = answer
        .to_string()
        .replace("something-else", "campaign")
        .replace("zeta-9", "run-");
    let mut answer: Value = serde_json::from_str(&text).expect("still JSON");
    if let Some(place) = answer["unexplained"]["where"].as_object_mut() {
        place.remove("runs");
    }
    answer
}

/// Names, the order of resources and extra metadata change no digit of an answer.
#[test]
fn renaming_and_permuting_change_no_answer() {
    for case in [
        Case::one("wear", 1.0, Protocol::PaperAlternating, SEED + 500),
        Case::nothing(Protocol::PaperBlocked, NoiseKind::Usual, SEED + 501),
    ] {
        let files = case.carry_out().expect("a known cause").files;
        let options = Options {
            quick: true,
            ..Options::default()
        };
        let plain = ask(&files, &options).expect("a campaign").json;
        let other = ask(&disguise(&files), &options).expect("a campaign").json;
        assert_eq!(nameless(&plain), nameless(&other));
    }
}

/// The report marks counts of another diagnosis as stale by the fingerprint that the benchmark writes.
#[test]
fn report_and_benchmark_know_the_diagnosis_by_one_fingerprint() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    assert_eq!(
        reproduction::compose::diagnosis_fingerprint(&root),
        whole_program::identity::of_diagnosis()
    );
}
