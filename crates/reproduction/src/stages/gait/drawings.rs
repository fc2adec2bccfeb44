//! The biped drawn to scale (Fig. 10), and its stride as a moving picture.

use biped::gait::STANDING;
use biped::gait::motion::{Motion, Sample};
use biped::kinematics::{COORDINATES, Leg, leg_points};
use biped::parameters::{Biped, Link};
use report::Evidence;
use report::figure::{Animation, Drawing, Figure, Frame, Ink, Provenance, Shape};

/// Metres of arrow for one newton of ground force.
const METRES_PER_NEWTON: f64 = 1.0 / 1500.0;

fn line(points: Vec<[f64; 2]>, ink: Ink, width: f64) -> Shape {
    Shape::Line {
        points,
        ink,
        width,
        dashed: false,
    }
}

fn leg_ink(leg: Leg) -> Ink {
    match leg {
        Leg::Front => Ink::Slot(4),
        Leg::Rear => Ink::Slot(5),
    }
}

/// Torso and legs as lines.
fn body(biped: &Biped, q: &[f64; COORDINATES], shapes: &mut Vec<Shape>) {
    let legs = Leg::BOTH.map(|leg| leg_points(biped, q, leg));
    shapes.push(line(vec![legs[0].hip, legs[1].hip], Ink::Muted, 6.0));
    for (leg, points) in Leg::BOTH.into_iter().zip(legs) {
        shapes.push(line(
            vec![points.hip, points.knee, points.foot],
            leg_ink(leg),
            3.0,
        ));
    }
}

/// Fig. 10: the machine from its parameters.
pub(super) fn machine(biped: &Biped) -> Figure {
    let bent = [-45.0_f64, 90.0].map(f64::to_radians);
    let mut q = [0.0, 0.0, 0.0, bent[0], bent[1], bent[0], bent[1]];
    let foot = leg_points(biped, &q, Leg::Front).foot;
    q[1] = -foot[1];
    let mut shapes = vec![line(vec![[-0.6, 0.0], [0.6, 0.0]], Ink::Muted, 1.5)];
    body(biped, &q, &mut shapes);
    let front = leg_points(biped, &q, Leg::Front);
    let rear = leg_points(biped, &q, Leg::Rear);
    // Where a link's mass centre lies between its ends.
    let along = |link: &Link, a: [f64; 2], b: [f64; 2]| {
        let part = link.centre_m / link.length_m;
        [a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1])]
    };
    let masses = [
        ([q[0], q[1]], biped.torso_mass_kg),
        (
            along(&biped.thigh, front.hip, front.knee),
            biped.thigh.mass_kg,
        ),
        (
            along(&biped.shank, front.knee, front.foot),
            biped.shank.mass_kg,
        ),
        (
            along(&biped.thigh, rear.hip, rear.knee),
            biped.thigh.mass_kg,
        ),
        (
            along(&biped.shank, rear.knee, rear.foot),
            biped.shank.mass_kg,
        ),
    ];
    for (centre, mass) in masses {
        // Area in proportion to mass.
        shapes.push(Shape::Circle {
            centre,
            radius: 0.02 * mass.sqrt(),
            ink: Ink::Slot(3),
            filled: true,
        });
    }
    let above = |p: [f64; 2]| [p[0], p[1] + 0.08];
    shapes.push(Shape::Dimension {
        from: above(rear.hip),
        to: above(front.hip),
        label: format!("{:.2} m", biped.torso_length_m),
    });
    shapes.push(Shape::Dimension {
        from: [front.hip[0] + 0.1, front.hip[1]],
        to: [front.hip[0] + 0.1, 0.0],
        label: format!("{:.3} m", front.hip[1]),
    });
    let drawing = Drawing {
        unit: "m".into(),
        shapes,
        legend: vec![
            (Ink::Slot(4), "front leg".into()),
            (Ink::Slot(5), "rear leg".into()),
            (Ink::Slot(3), "mass centres, area in proportion to mass".into()),
        ],
        description: "The planar biped in the posture of the force envelope: a horizontal torso with a hip at either end, \
                      each thigh 45 degrees backwards, each shank forwards so that the foot stands below its hip."
            .into(),
    };
    Figure::new(
        "fig-10",
        "The biped, to scale",
        "Drawn from the parameters of the paper's Table 3 in the project's reading: thighs back, shanks forward.",
        Evidence::Computed,
        drawing,
        Provenance::here("gait", "biped::kinematics::leg_points"),
    )
    .with_paper("Fig. 10")
}

/// One stride as an animation: legs, ground force, friction cone under the standing foot.
pub(super) fn animation(
    id: &str,
    title: &str,
    motion: &Motion,
    biped: &Biped,
    cone: [f64; 2],
) -> Figure {
    let period = motion.period_s();
    let wanted = 24;
    let frames: Vec<Frame> = (0..wanted)
        .filter_map(|k| {
            let time = period * (k as f64 + 0.5) / f64::from(wanted);
            let nearest = motion
                .samples
                .iter()
                .min_by(|a, b| (a.time_s - time).abs().total_cmp(&(b.time_s - time).abs()))?;
            Some(frame(nearest, biped, motion.speed_m_s, cone))
        })
        .collect();
    let ground = line(vec![[-0.8, 0.0], [0.8, 0.0]], Ink::Muted, 1.5);
    let animation = Animation {
        unit: "m".into(),
        backdrop: vec![ground],
        still: vec![2, 8, 14, 20],
        frames,
        cycle_s: 2.4,
        legend: vec![
            (Ink::Slot(4), "front leg".into()),
            (Ink::Slot(5), "rear leg".into()),
            (Ink::FORWARD, "ground force".into()),
            (Ink::Muted, "friction cone".into()),
        ],
        description: "One stride seen from a camera that moves with the mean speed: front stance, flight, rear stance, \
                      flight; the arrow is the ground's force on the standing foot, the two thin lines its friction cone."
            .into(),
    };
    Figure::new(
        id,
        title,
        "The stride in slow motion, camera at the mean speed. One metre of arrow is 1500 N.",
        Evidence::Computed,
        animation,
        Provenance::here("gait", "biped::gait::motion"),
    )
    .with_paper("Fig. 11")
    .with_claims(&["C10"])
}

fn frame(sample: &Sample, biped: &Biped, speed: f64, cone: [f64; 2]) -> Frame {
    let mut q = sample.q;
    q[0] -= speed * sample.time_s;
    let mut shapes = Vec::new();
    body(biped, &q, &mut shapes);
    if let Some(leg) = STANDING[sample.phase] {
        let foot = leg_points(biped, &q, leg).foot;
        let reach = 0.2;
        for slope in [cone[0], -cone[1]] {
            shapes.push(line(
                vec![foot, [foot[0] + slope * reach, foot[1] + reach]],
                Ink::Muted,
                1.0,
            ));
        }
        let force = sample.force_n.map(|f| f * METRES_PER_NEWTON);
        shapes.push(Shape::Arrow {
            from: foot,
            to: [foot[0] + force[0], foot[1] + force[1]],
            ink: Ink::FORWARD,
        });
    }
    Frame {
        time_s: sample.time_s,
        shapes,
    }
}
