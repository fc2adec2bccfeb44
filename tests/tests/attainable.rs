//! Are the intervals as narrow as the records allow? Only a test may know the recipe: the bound takes the parameters and
//! the noise from it, the intervals come from the program.

use std::path::Path;

use fitting::noise::Sizes;
use friction::LawKind;
use identification::{Question, identify, least_sd};
use planting::stand_ins::Recipe;
use whole_program::measured::parameters;

/// Half width of a normal 95 % interval, standard deviations.
const NORMAL: f64 = 1.959_964;

struct Row {
    name: String,
    truth: f64,
    bound: f64,
    sd: Option<f64>,
    half_width: f64,
    error: f64,
    quantile: f64,
}

fn rows(material: &str) -> Vec<Row> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/campaigns");
    let recipe = Recipe::read(&folder).unwrap();
    let (law, truth) = parameters(&recipe.law(material, recipe.lean_rad().unwrap()).unwrap());
    assert_eq!(
        law,
        LawKind::AsymmetricBristle,
        "the stand-ins are of bristles"
    );
    let noise = recipe.noise().unwrap();
    let sizes = Sizes {
        sensor: noise.sensor_n,
        private: noise.roughness * (1.0 - noise.plate_share).sqrt(),
        plate: noise.roughness * noise.plate_share.sqrt(),
        length: noise.correlation_m,
        scatter: noise.scatter,
        ..Sizes::NONE
    };
    let campaign = campaign::open(&folder.join(format!("brush-2x2-{material}"))).unwrap();
    let bound = least_sd(&campaign, law, &truth, &sizes).unwrap().unwrap();
    let found = identify(&campaign, &Question::of(law)).unwrap();
    found
        .estimates
        .iter()
        .zip(truth)
        .zip(bound)
        .map(|((e, truth), bound)| {
            let interval = e.interval.as_ref().unwrap();
            Row {
                name: e.name.clone(),
                truth,
                bound,
                sd: e.sd,
                half_width: (interval.high() - e.value).max(e.value - interval.low()),
                error: e.value - truth,
                quantile: e.drivers.unwrap().quantile,
            }
        })
        .collect()
}

/// The standard deviations by which the intervals are made lie about the bound: more would waste the records, less would
/// be a claim that they do not bear. They differ from it because the noise is estimated from six runs.
#[test]
fn intervals_are_about_as_narrow_as_the_records_allow() {
    for material in ["aluminium", "nylon", "ceramic"] {
        println!("{material:20} bound(95%)  half width  error   sd/bound  quantile");
        for row in rows(material) {
            let percent = |x: f64| 100.0 * x / row.truth.abs();
            let ratio = row.sd.map_or(f64::NAN, |sd| sd / row.bound);
            println!(
                "{:20} {:>9.2}% {:>10.2}% {:>+7.2}% {ratio:>9.3} {:>9.3}",
                row.name,
                percent(NORMAL * row.bound),
                percent(row.half_width),
                percent(row.error),
                row.quantile
            );
            // On its bound (nylon's sigma2) a parameter has no standard deviation.
            if row.sd.is_some() {
                assert!(
                    (0.6..1.5).contains(&ratio),
                    "{material} {}: {ratio}",
                    row.name
                );
            }
        }
    }
}
