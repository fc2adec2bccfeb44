//! What the gait stage says. Numbers come by their ids.

use biped::gait::catalogue::FINE_WEIGHTS;
use report::{Block, NoticeKind, Section, Value};

fn has(values: &[Value], id: &str) -> bool {
    values
        .iter()
        .any(|value| value.id == id && value.value.is_some())
}

/// Where the printed numbers lie on the map: whether gain and speed are beyond all of it, and whether the contact of the largest
/// gain is slower than the fastest.
pub(super) fn where_printed(gain_beyond: bool, speed_beyond: bool, opposed: bool) -> Block {
    let gain = if gain_beyond {
        "beyond every cell of the map, so the paper's contact must lose more speed in a stance than any of them, or its strides \
         are local minima of other kinds"
    } else {
        "among the cells of the map"
    };
    let speed = if speed_beyond {
        "faster than any cell: that takes less loss, wider limits of reach or rate, or stronger joints than printed"
    } else {
        "within what the cells reach"
    };
    let together = if opposed {
        " What raises the gain lowers the speed, so both printed numbers at once ask for something that neither stiffness nor loss \
         gives: legs that are stronger or reach farther, on ground that loses more; or a stride that need not end as fast as it began."
    } else {
        ""
    };
    Block::notice(
        NoticeKind::Finding,
        "Where the printed numbers lie, and what they would need",
        format!(
            "The largest gain on the map, {{{{ v(\"gait.map.largest\", 3) }}}}, comes with \
             {{{{ v(\"gait.map.largest.speed\", 3) }}}}; the fastest cell reaches {{{{ v(\"gait.map.fastest\", 3) }}}} and gains \
             {{{{ v(\"gait.map.fastest.gain\", 3) }}}}. The printed gain of {{{{ published(\"gait.gain\") }}}} lies {gain}. The \
             printed speed of {{{{ published(\"gait.best_speed.asymmetric\") }}}} is {speed}.{together}"
        ),
    )
}

/// The chapter around the figures.
pub(super) fn section(figures: Vec<Block>, values: &[Value], quick: bool) -> Section {
    let mut blocks = figures;
    blocks.push(Block::heading(
        "gait-why",
        "Why a larger forward limit moves the top speed so little",
    ));
    if has(values, "gait.impulse.asymmetric.forward") {
        blocks.push(Block::prose(
            "Over a periodic stride the forward impulses of the ground cancel. With the asymmetric brush the feet push \
             forward by {{ v(\"gait.impulse.asymmetric.forward\", 3) }} and brake by \
             {{ v(\"gait.impulse.asymmetric.braking\", 3) }}: net {{ v(\"gait.impulse.asymmetric.net\", 2) }}, which is the \
             error of the mesh. Torque, leg swing and reach then set the top speed; friction matters where contact loses \
             speed in every stance.",
        ));
    }
    if has(values, "gait.acceleration.gain") {
        blocks.push(Block::prose(
            "In a stride that may end faster than it began, started at the speed of Fig. 11, the mean acceleration rises by \
             {{ v(\"gait.acceleration.gain\", 3) }}: the paper's argument is one about acceleration.",
        ));
    }
    if has(values, "gait.map.cells") {
        let ordered = values
            .iter()
            .any(|value| value.id == "gait.map.disordered" && value.value == Some(0.0));
        let order = if ordered {
            "every cell with all three strides keeps the order backwards, symmetric, asymmetric."
        } else {
            "in {{ n(\"gait.map.disordered\") }} of them the order backwards, symmetric, asymmetric is broken, which with local minima \
             says that a better stride of one of the three has not been found."
        };
        blocks.push(Block::prose(format!(
            "Over contact stiffness and loss the gain runs from {{{{ v(\"gait.map.smallest\", 3) }}}} to \
             {{{{ v(\"gait.map.largest\", 3) }}}} in {{{{ n(\"gait.map.cells\") }}}} cells in which both strides are certified; {order}"
        )));
    }
    blocks.push(Block::notice(
        NoticeKind::Caution,
        "What is not published",
        "Cost function, contact stiffness and loss, limits of posture and phases: all of them are this project's choices, and \
         the speeds are theirs as much as the machine's. Local minima dominate: a better one than those found may exist. The \
         starts ship with the project (strides of an independent optimiser on the same problems and of the project's own solver, \
         each improved from those of other problems); every problem is solved again from them here.",
    ));
    if has(values, "gait.search.recorded") {
        blocks.push(Block::prose(
            "The search that made the starts ended in {{ n(\"gait.search.thrice\") }} of \
             {{ n(\"gait.search.recorded\") }} recorded strides from at least three starts (strides of other problems, hops from \
             them or from dearer strides); the table of strides names the count of each.",
        ));
    }
    blocks.push(Block::notice(
        NoticeKind::Note,
        "How far the mesh resolves a stride",
        "Two-stage Radau; 28 intervals a compliant stance, a fifth as long as even ones where the foot strikes, and 8 a flight; 8 and 5 \
         where the foot is rigid. Over a stride the work of torques and ground misses the change of energy by up to \
         {{ v(\"gait.mesh.worst_energy_gap\", 2) }} of the kinetic energy. A compliant foot strikes within some 3 ms: between longer \
         intervals the optimiser hides strikes that give more than they take, and runs faster than the same problem allows on finer ones. \
         Therefore a foot sinks in no faster than it may be drawn out, 2/(3c), once the first fifth of its stance has passed: one \
         strike a stance.",
    ));
    if has(values, "gait.mesh.worst_speed_change") {
        blocks.push(Block::prose(finer_mesh(values)));
    }
    let lead = "On the compliant contact the best strides reach {{ v(\"gait.best_speed.symmetric\", 4) }} with the symmetric, \
                {{ v(\"gait.best_speed.asymmetric\", 4) }} with the asymmetric brush and \
                {{ v(\"gait.best_speed.backwards\", 4) }} with the brush mounted backwards: a gain of \
                {{ v(\"gait.gain\", 3) }}, where the paper prints {{ published(\"gait.gain\") }}.";
    let lead = format!("{lead}{}", error_bar(values).unwrap_or_default());
    blocks.push(next());
    Section {
        id: "gait".into(),
        title: "Strides of the biped".into(),
        lead: lead.into(),
        method: Some(
            "One stride: front stance, flight, rear stance, flight, periodic but for the distance. Cost \
             $Q_v (\\bar v - v_{\\mathrm{aim}})^2 + \\overline{\\sum \\tau^2}/\\tau_{\\max}^2$; two-stage Radau collocation with free \
             durations; sequential quadratic programming on Clarabel. {{ n(\"gait.strides.certified\") }} of \
             {{ n(\"gait.strides.solved\") }} strides carry a certificate (first and second order); numbers come from these \
             alone, and the table of strides names the status of each."
                .into(),
        ),
        status: quick.then(|| "quick look: the sweep of one contact only".to_owned()),
        claims: vec!["C10".into(), "C11".into(), "C22".into()],
        blocks,
    }
}

/// What would settle the claims on strides, the cheapest first.
fn next() -> Block {
    Block::notice(
        NoticeKind::Note,
        "What would settle it",
        "The paper's cost function and its model of contact, two lines of text, would decide most: with them the strides here are solved again \
         in a minute (`crates/biped`, `gait::Problem`). Next a drop of one foot on the ground it runs on: the depth of the dent says the \
         stiffness, the speed of the rebound the loss, and with them one cell of the map is the robot's. Last a slide of the brush at the speeds of a \
         stance, metres per second: the friction behind every stride is extrapolated from centimetres per second.",
    )
}

/// By how much the gain moves on the halved mesh at the weight where it moves most.
fn error_bar(values: &[Value]) -> Option<String> {
    let gain = |mesh: &str, weight: f64| {
        let id = format!("gait.mesh.gain.{mesh}.qv-{weight}");
        values.iter().find(|v| v.id == id).and_then(|v| v.value)
    };
    let moves = |weight: f64| Some((gain("halved", weight)? - gain("own", weight)?).abs());
    let most = (FINE_WEIGHTS.into_iter())
        .filter_map(|weight| moves(weight).map(|by| (by, weight)))
        .max_by(|a, b| a.0.total_cmp(&b.0))?;
    let weight = most.1;
    Some(format!(
        " The gain is a small difference of two speeds: with every interval of the mesh halved it goes from \
         {{{{ v(\"gait.mesh.gain.own.qv-{weight}\", 3) }}}} to {{{{ v(\"gait.mesh.gain.halved.qv-{weight}\", 3) }}}} at the weight where it moves \
         most, $Q_v$ = {weight}."
    ))
}

/// What halving every interval does to the speeds, and to the gain at every weight at which it was tried.
fn finer_mesh(values: &[Value]) -> String {
    let gains: Vec<String> = FINE_WEIGHTS
        .into_iter()
        .filter(|weight| has(values, &format!("gait.mesh.gain.halved.qv-{weight}")))
        .map(|weight| {
            let [own, halved] = ["own", "halved"]
                .map(|mesh| format!("{{{{ v(\"gait.mesh.gain.{mesh}.qv-{weight}\", 3) }}}}"));
            format!("from {own} to {halved} at $Q_v$ = {weight}")
        })
        .collect();
    let gains = match gains.as_slice() {
        [] => String::new(),
        some => format!(
            " The gain, a small difference of two speeds, goes {}.",
            some.join(", ")
        ),
    };
    format!(
        "With every interval halved the speeds change by up to {{{{ v(\"gait.mesh.worst_speed_change\", 2) }}}}: that is the error bar of the speeds. It \
         holds the mesh and the search: {{{{ n(\"gait.mesh.search.thrice\") }}}} of {{{{ n(\"gait.mesh.search.recorded\") }}}} strides on the halved mesh \
         were found by at least three starts.{gains}"
    )
}
