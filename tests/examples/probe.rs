//! probe
use planting::{Case, NoiseKind, Protocol, effect::Effect};
use std::collections::BTreeMap;
fn main() {
    for (protocol, gap) in [
        (Protocol::Rich, 1e-4),
        (Protocol::Drive, 1.5e-5),
        (Protocol::Drive, 1e-3),
    ] {
        let plan = protocol.plan();
        for k in [5usize, 0] {
            if plan.runs[k].direction != "both" {
                continue;
            }
            let m = &plan.runs[k].motion;
            let b = m.behind_play(gap);
            // brute play operator
            let (mut y, mut heading) = (0.0f64, 0.0f64);
            let mut off = 0.0; // follower = clamp
            let mut worst = 0.0f64;
            let n = 200000;
            let mut lo = 0.0;
            let mut first = true;
            for i in 0..=n {
                let t = m.duration_s() * i as f64 / n as f64;
                let x = m.position(t);
                let v = m.speed(t);
                if first && v != 0.0 {
                    first = false;
                    heading = v.signum();
                    lo = if heading > 0.0 { 0.0 } else { -gap };
                }
                if !first {
                    // follower y with play: x - y in [lo, lo+gap]... taken up forward: x-y = 0 upper
                    if x - y > lo + 0.0 && heading > 0.0 {}
                    // initial: heading>0 => x - y = 0 is the upper limit, lower limit -gap
                    let (a, c) = if heading > 0.0 {
                        (-gap, 0.0)
                    } else {
                        (0.0, gap)
                    };
                    if x - y > c {
                        y = x - c
                    } else if x - y < a {
                        y = x - a
                    }
                }
                let e = (b.position(t) - y).abs();
                if e > worst {
                    worst = e;
                    off = t;
                }
            }
            println!("{protocol:?} run {k} gap {gap}: worst {worst:.3e} at {off}");
        }
    }
    let healthy = Case::nothing(Protocol::Drive, NoiseKind::None, 21);
    let day = healthy
        .clone()
        .with("backlash", 0.5, false)
        .carry_out()
        .unwrap();
    let Effect::Backlash { gap_m } = day.key.effects[0] else {
        panic!()
    };
    let c = whole_program::measured::campaign(&day.plan, &day.recordings);
    let e = rig::Experiment::new(&c).unwrap();
    let cause = diagnosis::causes::find("backlash").unwrap();
    let mut r = BTreeMap::new();
    r.insert("gap_m".to_string(), gap_m);
    let p = cause.from_reported(&r).unwrap();
    let m = rig::Model::new(friction::LawKind::Lugre, vec![cause], &e).unwrap();
    let planting::law::Law::Lugre(d) = day.key.law else {
        panic!()
    };
    let mut v = vec![
        d.coulomb,
        d.breakaway,
        d.stribeck_speed,
        d.stiffness,
        d.damping,
        d.viscous,
    ];
    v.extend(p);
    let f = m.predict(&e, &v);
    let w = healthy.carry_out().unwrap();
    println!("gap {gap_m} buildup {}", d.coulomb / d.stiffness);
    for i in 380..460 {
        println!(
            "{i} v {:.5} planted {:.4} pred {:.4} clean {:.4}",
            day.recordings[0].velocity_m_s[i],
            day.recordings[0].force_n[i],
            f[i],
            w.recordings[0].force_n[i]
        );
    }
}
