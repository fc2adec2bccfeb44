//! The gait (Figs 10 to 12, claims C10, C11 and C22).

mod drawings;
mod extrapolation;
mod figures;
mod quality;
mod strides;
mod words;
mod worlds;

use biped::gait::STANDING;
use biped::gait::catalogue::{
    CONTACT, Choice, Kind, LOSSES, MAP_WEIGHT, Mount, Name, STIFFNESSES, WEIGHTS,
};
use biped::gait::motion::Motion;
use biped::kinematics::foot_velocity;
use report::figure::Figure;
use report::{Block, Evidence, NoticeKind, Value};

use self::strides::{Solved, of_sweep};
use super::machine;
use crate::stage::{Needs, Stage, StageContext, StageError, StageOutput};

/// The gait.
pub(super) struct Gait;

/// Targets of Figs 11 and 12 as ids in the starts.
struct Targets {
    low: f64,
    high: f64,
}

impl Stage for Gait {
    fn id(&self) -> &'static str {
        "gait"
    }

    fn title(&self) -> &'static str {
        "strides of the biped"
    }

    fn needs(&self) -> Needs {
        Needs::default()
    }

    fn run(&self, context: &StageContext<'_>) -> Result<StageOutput, StageError> {
        let published = context.published;
        let biped = machine::biped(published)?;
        let brush = machine::brush(published)?;
        let targets = Targets {
            low: published.value("gait.target_speed_fig11")?,
            high: published.value("gait.target_speed_fig12")?,
        };
        let quick = context.quick;
        let solved = strides::solve(&biped, brush, |name| {
            let base = name.kind == Kind::Compliant && (name.k, name.c) == CONTACT;
            !quick || (base && name.choice == Choice::Own)
        })?;
        context.say(&format!("{} strides solved", solved.len()));

        let mut output = StageOutput::done();
        let mut blocks = vec![Block::from(drawings::machine(&biped))];
        let compliant = best_speeds(
            &solved,
            Kind::Compliant,
            &targets,
            "gait",
            context,
            &mut output,
        )?;
        blocks.push(compliant.into());
        if !quick {
            let rigid = best_speeds(
                &solved,
                Kind::Rigid,
                &targets,
                "gait.rigid",
                context,
                &mut output,
            )?;
            blocks.push(rigid.into());
        }
        let at_low = |mount: Mount| {
            let name = Name::compliant(CONTACT, mount, MAP_WEIGHT, targets.low);
            certified(&solved).find(|s| s.name == name)
        };
        if let (Some(symmetric), Some(asymmetric)) =
            (at_low(Mount::Symmetric), at_low(Mount::Asymmetric))
        {
            let motions = [
                (Mount::Symmetric, &symmetric.outcome.motion),
                (Mount::Asymmetric, &asymmetric.outcome.motion),
            ];
            direction_values(&motions, &mut output);
            let mean = brush.symmetric().forward;
            blocks.push(figures::directions(&motions, [brush.forward, brush.reverse, mean]).into());
            let motion = &asymmetric.outcome.motion;
            blocks.push(figures::paths(motion, &biped).into());
            let cone = [brush.forward, brush.reverse];
            blocks.push(
                drawings::animation(
                    "gait-animation",
                    "One stride, asymmetric brush",
                    motion,
                    &biped,
                    cone,
                )
                .into(),
            );
        }
        let printed = Printed {
            gain_percent: published.value("gait.gain")?,
            speed_m_s: published.value("gait.best_speed.asymmetric")?,
        };
        blocks.extend(map(&solved, &targets, &printed, &mut output));
        impulses(&solved, &targets, &mut output);
        if !quick {
            blocks.extend(choices(&solved, &targets, &mut output));
            let strides = strides::accelerate(&biped, brush, targets.low)?;
            accelerating(&strides, &mut output);
        }
        let slip = largest_slip(&solved);
        let (figure, values) =
            extrapolation::figure(published, [brush.forward, brush.reverse], slip)?;
        blocks.push(figure.into());
        output.values.extend(values);
        for (claim, worlds) in worlds::all(&solved, &targets, &output.values) {
            let artefact = worlds.artefact(claim);
            output
                .artefacts
                .extend([artefact.map_err(|error| StageError::Failed(error.to_string()))?]);
        }
        quality::measure(&solved, &targets, &mut output);
        output.tables.push(quality::table(&solved));
        output
            .sections
            .push(words::section(blocks, &output.values, quick));
        Ok(output)
    }
}

fn value(id: String, number: f64, unit: &str) -> Value {
    Value::new(id, number, unit, "gait", Evidence::Computed)
}

/// The strides that a number may come from.
fn certified(solved: &[Solved]) -> impl Iterator<Item = &Solved> {
    solved.iter().filter(|s| s.outcome.is_certified())
}

/// Values and figure of the sweep over the speed weights with one contact. A mean needs a certificate at every
/// weight: over fewer weights it would be another quantity than the printed one.
fn best_speeds(
    solved: &[Solved],
    kind: Kind,
    targets: &Targets,
    prefix: &str,
    context: &StageContext<'_>,
    output: &mut StageOutput,
) -> Result<Figure, StageError> {
    let mut rows = Vec::new();
    let mut means = Vec::new();
    for mount in Mount::ALL {
        let strides: Vec<Option<&Solved>> = WEIGHTS
            .iter()
            .map(|&weight| {
                let name = of_sweep(kind, mount, weight, targets.high);
                solved.iter().find(|s| s.name == name)
            })
            .collect();
        let speeds: Vec<Option<f64>> = strides
            .iter()
            .map(|s| {
                s.filter(|s| s.outcome.is_certified())
                    .map(|s| s.outcome.motion.speed_m_s)
            })
            .collect();
        for (weight, speed) in WEIGHTS.iter().zip(&speeds) {
            let id = format!("{prefix}.speed.{}.qv-{weight}", mount.id());
            output
                .values
                .push(value(id, speed.unwrap_or(f64::NAN), "m/s"));
        }
        output.values.push(value(
            format!("{prefix}.certified.{}", mount.id()),
            speeds.iter().flatten().count() as f64,
            "1",
        ));
        let mean = speeds.iter().map(|s| s.unwrap_or(f64::NAN)).sum::<f64>() / WEIGHTS.len() as f64;
        let id = format!("{prefix}.best_speed.{}", mount.id());
        let mut mean_value = value(id.clone(), mean, "m/s");
        if let Some(printed) = context.published.get(&id) {
            mean_value = mean_value.with_published(&printed.printed);
        }
        output.values.push(mean_value);
        means.push(mean);
        let open = strides
            .iter()
            .map(|s| {
                s.filter(|s| !s.outcome.is_certified())
                    .map(|s| s.outcome.motion.speed_m_s)
            })
            .collect();
        rows.push(figures::Speeds {
            mount,
            certified: speeds,
            open,
        });
    }
    let gain = gain_percent([means[0], means[1]]);
    let mut gain_value = value(format!("{prefix}.gain"), gain, "percent");
    if let Some(printed) = context.published.get(&format!("{prefix}.gain")) {
        gain_value = gain_value.with_published(&printed.printed);
    }
    output.values.push(gain_value);
    let (id, title) = match kind {
        Kind::Compliant => ("fig-12", "Best speeds, compliant contact"),
        Kind::Rigid => ("fig-12-rigid", "Best speeds, rigid contact with impact"),
    };
    figures::speeds(id, title, &rows, context.published)
}

/// Range of force directions at the lower target.
fn direction_values(motions: &[(Mount, &Motion)], output: &mut StageOutput) {
    for (mount, motion) in motions {
        let [low, high] = motion.directions();
        for (end, number) in [("smallest", low), ("largest", high)] {
            output.values.push(value(
                format!("gait.force_direction.{}.{end}", mount.id()),
                number,
                "1",
            ));
        }
    }
}

/// The certified strides of a problem with the symmetric and the asymmetric brush, whatever brush `name` has.
fn pair(solved: &[Solved], name: Name) -> Option<[&Solved; 2]> {
    let of = |brush: Mount| {
        let name = Name { brush, ..name };
        certified(solved).find(|s| s.name == name)
    };
    Some([of(Mount::Symmetric)?, of(Mount::Asymmetric)?])
}

/// Gain of the second of two values over the first, percent.
fn gain_percent([symmetric, asymmetric]: [f64; 2]) -> f64 {
    100.0 * (asymmetric / symmetric - 1.0)
}

/// Gain of the asymmetric over the symmetric brush where both strides are certified, percent.
fn gain(solved: &[Solved], name: Name) -> Option<f64> {
    Some(gain_percent(
        pair(solved, name)?.map(|s| s.outcome.motion.speed_m_s),
    ))
}

/// What the paper prints of the sweep, to be looked for on the map.
struct Printed {
    gain_percent: f64,
    speed_m_s: f64,
}

/// Gain over contact stiffness and loss at one weight, the cells that break the order of the brushes, and where the printed
/// numbers would lie.
fn map(
    solved: &[Solved],
    targets: &Targets,
    printed: &Printed,
    output: &mut StageOutput,
) -> Vec<Block> {
    let name = |k, c| move |mount: Mount| Name::compliant((k, c), mount, MAP_WEIGHT, targets.high);
    let mut cells = Vec::new();
    // Gain and speed with the asymmetric brush where both strides are certified.
    let mut found: Vec<(f64, f64)> = Vec::new();
    let mut disordered = 0;
    for k in STIFFNESSES {
        let mut row = Vec::new();
        for c in LOSSES {
            let speed = |mount: Mount| {
                let name = name(k, c)(mount);
                let stride = certified(solved).find(|s| s.name == name)?;
                Some(stride.outcome.motion.speed_m_s)
            };
            let gain = gain(solved, name(k, c)(Mount::Symmetric));
            if let (Some(gain), Some(speed)) = (gain, speed(Mount::Asymmetric)) {
                let id = format!("gait.map.k-{k}.c-{c}");
                output.values.push(value(id.clone(), gain, "percent"));
                output
                    .values
                    .push(value(format!("{id}.speed"), speed, "m/s"));
                found.push((gain, speed));
            }
            let speeds: Option<Vec<f64>> = [Mount::Backwards, Mount::Symmetric, Mount::Asymmetric]
                .into_iter()
                .map(speed)
                .collect();
            disordered += usize::from(speeds.is_some_and(|s| s.windows(2).any(|w| w[0] >= w[1])));
            row.push(gain);
        }
        cells.push(row);
    }
    let smallest = found.iter().map(|f| f.0).fold(f64::INFINITY, f64::min);
    let Some(largest) = found.iter().max_by(|a, b| a.0.total_cmp(&b.0)).copied() else {
        return vec![Block::notice(
            NoticeKind::Refusal,
            "No map of the gain",
            "In no cell of contact stiffness and loss do both strides carry a certificate, so no gain is claimed.",
        )];
    };
    let fastest = found.iter().max_by(|a, b| a.1.total_cmp(&b.1)).copied();
    let fastest = fastest.unwrap_or(largest);
    for (id, number, unit) in [
        ("cells", found.len() as f64, "1"),
        ("disordered", disordered as f64, "1"),
        ("smallest", smallest, "percent"),
        ("largest", largest.0, "percent"),
        ("largest.speed", largest.1, "m/s"),
        ("fastest", fastest.1, "m/s"),
        ("fastest.gain", fastest.0, "percent"),
    ] {
        output
            .values
            .push(value(format!("gait.map.{id}"), number, unit));
    }
    vec![
        figures::map(&STIFFNESSES, &LOSSES, &cells, printed.gain_percent).into(),
        words::where_printed(
            printed.gain_percent > largest.0,
            printed.speed_m_s > fastest.1,
            largest.1 < fastest.1,
        ),
    ]
}

/// Gain under each of the other choices that the paper leaves open.
fn choices(solved: &[Solved], targets: &Targets, output: &mut StageOutput) -> Option<Block> {
    let mut rows = Vec::new();
    for choice in std::iter::once(Choice::Own).chain(Choice::ALL) {
        let name = |mount: Mount| {
            Name::compliant(CONTACT, mount, MAP_WEIGHT, targets.high).with_choice(choice)
        };
        for mount in [Mount::Symmetric, Mount::Asymmetric] {
            let name = name(mount);
            let speed = certified(solved)
                .find(|s| s.name == name)
                .map_or(f64::NAN, |s| s.outcome.motion.speed_m_s);
            let id = format!("gait.choice.{}.{}", choice.id(), mount.id());
            output.values.push(value(id, speed, "m/s"));
        }
        let number = gain(solved, name(Mount::Symmetric));
        let id = format!("gait.choice.{}.gain", choice.id());
        output
            .values
            .push(value(id, number.unwrap_or(f64::NAN), "percent"));
        if number.is_some() {
            rows.push(choice);
        }
    }
    (rows.len() > 1).then(|| figures::choices(&rows).into())
}

/// Forward and braking impulses of the fastest strides: over a period they cancel.
fn impulses(solved: &[Solved], targets: &Targets, output: &mut StageOutput) {
    for mount in Mount::ALL {
        let name = Name::compliant(CONTACT, mount, MAP_WEIGHT, targets.high);
        let found = certified(solved).find(|s| s.name == name);
        let Some(solved) = found else { continue };
        let motion = &solved.outcome.motion;
        let [forward, braking] = motion.forward_and_braking_n_s();
        let net = motion.ground_impulse_n_s()[0];
        for (name, number) in [("forward", forward), ("braking", braking), ("net", net)] {
            output.values.push(value(
                format!("gait.impulse.{}.{name}", mount.id()),
                number,
                "N s",
            ));
        }
    }
}

/// Mean acceleration of strides that may end faster than they began.
fn accelerating(strides: &[Solved], output: &mut StageOutput) {
    let mut found = Vec::new();
    for stride in strides {
        let name = stride.name.brush.id();
        let acceleration = stride.outcome.motion.acceleration_m_s2;
        if stride.outcome.is_certified() {
            output.values.push(value(
                format!("gait.acceleration.{name}"),
                acceleration,
                "m/s^2",
            ));
            found.push((stride.name.brush, acceleration));
        }
        output.work.insert(
            format!("accelerating stride, {name}: steps"),
            stride.outcome.iterations as u64,
        );
    }
    let of = |mount: Mount| found.iter().find(|(m, _)| *m == mount).map(|(_, a)| *a);
    if let (Some(symmetric), Some(asymmetric)) = (of(Mount::Symmetric), of(Mount::Asymmetric)) {
        output.values.push(value(
            "gait.acceleration.gain".into(),
            gain_percent([symmetric, asymmetric]),
            "percent",
        ));
    }
}

/// Largest slip of a loaded foot over all certified strides, m/s.
fn largest_slip(solved: &[Solved]) -> f64 {
    certified(solved)
        .flat_map(|s| {
            s.outcome
                .motion
                .samples
                .iter()
                .map(move |sample| (s, sample))
        })
        .filter(|(_, sample)| sample.force_n[1] > 1.0)
        .filter_map(|(s, sample)| {
            let leg = STANDING[sample.phase]?;
            Some(foot_velocity(&s.outcome.problem.biped, &sample.q, &sample.v, leg)[0].abs())
        })
        .fold(0.0, f64::max)
}
