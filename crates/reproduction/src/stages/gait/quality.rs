//! How far the numbers of the chapter can be trusted: certificates, starts, and what the mesh does to them.

use biped::gait::catalogue::{CONTACT, Choice, FINE_WEIGHTS, Mount, Name};

use super::strides::Solved;
use super::{Targets, certified, value};
use crate::stage::{StageOutput, StageStatus, TableFile};

/// Steps of the second integration in each interval of the collocation.
const STEPS: usize = 8;
/// Starts by which a number should have been found.
const STARTS: usize = 3;

/// All measures of quality.
pub(super) fn measure(solved: &[Solved], targets: &Targets, output: &mut StageOutput) {
    counts(solved, output);
    search(solved, output);
    integration(solved, output);
    finer(solved, targets, output);
}

/// Certificates and the work behind them.
fn counts(solved: &[Solved], output: &mut StageOutput) {
    let count = certified(solved).count();
    for (id, number) in [("certified", count), ("solved", solved.len())] {
        let id = format!("gait.strides.{id}");
        output.values.push(value(id, number as f64, "1"));
    }
    let steps: usize = solved.iter().map(|s| s.outcome.iterations).sum();
    let subproblems: usize = solved.iter().map(|s| s.outcome.subproblems).sum();
    for (what, number) in [
        ("steps of the solver", steps),
        ("quadratic subproblems", subproblems),
    ] {
        output.work.insert(what.into(), number as u64);
    }
    if count < solved.len() {
        let detail = format!(
            "{} of {} strides lack a certificate",
            solved.len() - count,
            solved.len()
        );
        output.status = StageStatus::NotConverged(detail);
    }
}

/// How often the search that made the starts ended in the strides that it kept.
fn search(solved: &[Solved], output: &mut StageOutput) {
    for (of, count) in [
        ("search", counted(solved, &|_| true)),
        (
            "mesh.search",
            counted(solved, &|name| name.choice == Choice::FineMesh),
        ),
    ] {
        for (what, number) in ["recorded", "thrice"].into_iter().zip(count) {
            let id = format!("gait.{of}.{what}");
            output.values.push(value(id, number as f64, "1"));
        }
    }
}

/// Certified strides of which the search kept a count, and those that enough starts found.
fn counted(solved: &[Solved], wanted: &dyn Fn(&Name) -> bool) -> [usize; 2] {
    let own = certified(solved).filter(|s| wanted(&s.name));
    let found: Vec<usize> = own.filter_map(|s| Some(s.search?.found)).collect();
    let thrice = found.iter().filter(|&&count| count >= STARTS).count();
    [found.len(), thrice]
}

/// Energy over each phase, and each interval integrated again.
fn integration(solved: &[Solved], output: &mut StageOutput) {
    let worst = |of: &dyn Fn(&Solved) -> f64| certified(solved).map(of).fold(0.0, f64::max);
    let energy = worst(&|s| s.outcome.motion.energy_gap(&s.outcome.problem));
    let gap = worst(&|s| {
        let again = s.outcome.motion.reintegration(&s.outcome.problem, STEPS);
        again.gap_m_rad
    });
    for (id, number, unit) in [
        ("worst_energy_gap", energy, "1"),
        // Metres and radians; legs of 0.3 m make a radian the larger of the two.
        ("worst_interval_gap", gap, "rad"),
    ] {
        let id = format!("gait.mesh.{id}");
        output.values.push(value(id, number, unit));
    }
}

/// The same problems with every interval halved: the change is the error of the mesh in speed, cost and gain.
fn finer(solved: &[Solved], targets: &Targets, output: &mut StageOutput) {
    let of = |name: Name| certified(solved).find(|s| s.name == name);
    let mut worst: Option<f64> = None;
    for weight in FINE_WEIGHTS {
        let speeds = [Mount::Symmetric, Mount::Asymmetric].map(|mount| {
            let own = Name::compliant(CONTACT, mount, weight, targets.high);
            let pair = [of(own)?, of(own.with_choice(Choice::FineMesh))?];
            let [own, halved] = pair.map(|s| s.outcome.motion.speed_m_s);
            let change = 100.0 * (halved / own - 1.0);
            let cost = 100.0 * (pair[1].outcome.cost / pair[0].outcome.cost - 1.0);
            for (what, number) in [("speed_change", change), ("cost_change", cost)] {
                let id = format!("gait.mesh.{what}.{}.qv-{weight}", mount.id());
                output.values.push(value(id, number, "percent"));
            }
            worst = Some(worst.map_or(change.abs(), |w| w.max(change.abs())));
            Some([own, halved])
        });
        if let [Some(symmetric), Some(asymmetric)] = speeds {
            for (mesh, of) in ["own", "halved"].into_iter().zip([0, 1]) {
                let gain = 100.0 * (asymmetric[of] / symmetric[of] - 1.0);
                let id = format!("gait.mesh.gain.{mesh}.qv-{weight}");
                output.values.push(value(id, gain, "percent"));
            }
        }
    }
    if let Some(worst) = worst {
        let id = "gait.mesh.worst_speed_change".to_owned();
        output.values.push(value(id, worst, "percent"));
    }
}

/// Every stride with its status.
pub(super) fn table(solved: &[Solved]) -> TableFile {
    let mut csv = String::from(
        "contact,k,c,choice,brush,weight,target_m_s,status,cost,speed_m_s,period_s,effort,found_by,starts\n",
    );
    let number = |count: Option<usize>| count.map_or(String::new(), |n| n.to_string());
    for s in solved {
        let (name, outcome) = (&s.name, &s.outcome);
        csv.push_str(&format!(
            "{:?},{},{},{},{},{},{},{:?},{},{},{},{},{},{}\n",
            name.kind,
            name.k,
            name.c,
            name.choice.id(),
            name.brush.id(),
            name.weight,
            name.aim,
            outcome.status,
            outcome.cost,
            outcome.motion.speed_m_s,
            outcome.motion.period_s(),
            outcome.motion.effort(&outcome.problem),
            number(s.search.map(|search| search.found)),
            number(s.search.map(|search| search.tried)),
        ));
    }
    TableFile {
        name: "gait-strides".into(),
        csv,
    }
}
