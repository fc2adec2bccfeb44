//! probe
use planting::species::CAUSES;
use planting::{Planted, Protocol};
use whole_program::hidden::oracle::{Oracle, viewpoint};
fn main() {
    for protocol in [Protocol::PaperBlocked, Protocol::Drive] {
        let o = Oracle::new(&viewpoint(protocol, 1_500_000)).unwrap();
        for c in CAUSES {
            let t = std::time::Instant::now();
            let p = |size: f64| {
                o.parts(&[Planted {
                    id: c.into(),
                    size,
                    second_shape: false,
                }])
                .unwrap()
            };
            let s = o.threshold(c, false, 10.0).unwrap();
            println!(
                "{c:24} {:?} {:?} {:?} thr={s:?} {:?}",
                p(0.01),
                p(0.1),
                p(1.0),
                t.elapsed()
            );
        }
        for s in [1e-4, 1e-3, 2e-3, 3e-3, 4e-3, 5e-3, 6e-3, 8e-3] {
            println!(
                "{s} {:?}",
                o.parts(&[Planted {
                    id: "backlash".into(),
                    size: s,
                    second_shape: false
                }])
            );
        }
    }
}
