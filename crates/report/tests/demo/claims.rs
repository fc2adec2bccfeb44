//! Claims with every verdict, from the fullest row to the barest.

use report::{ClaimRow, Evidence, Multiverse, Verdict};

use super::HOSTILE;

pub fn claims() -> Vec<ClaimRow> {
    let mut curves = ClaimRow::new(
        "C02",
        "with Table 1 the model matches the measurement in both directions",
        Verdict::Consistent,
        Evidence::Synthetic,
    );
    curves.locator = "section 2.3, Fig. 6".into();
    curves.quote = Some(HOSTILE.into());
    curves.published = "“matches”, no number".into();
    curves.ours = "rmse {{ v(\"demo.rmse\") }}".into();
    curves.tolerance = "rmse below the floor of the repeats".into();
    curves.reason = "a model cannot do better than the runs repeat".into();
    curves.account = "Checked on stand-in data, so the verdict can be *consistent* at best. See [Fig. 6](#fig-curves).\n\nA second paragraph.".into();
    curves.values = vec!["demo.rmse".into()];
    curves.figures = vec!["fig-curves".into(), "fig-absent".into()];
    let mut steady = ClaimRow::new(
        "C09",
        "steady coefficients $\\mu_f$ and $\\mu_r$",
        Verdict::Reproduced,
        Evidence::Published,
    );
    steady.published = "0.9049 [0.90485, 0.90495]".into();
    steady.ours = "{{ ci(\"demo.steady_forward\") }}".into();
    steady.deviation = Some("−0.03 of the last printed digit".into());
    steady.tolerance = "half a unit in the last printed digit".into();
    steady.reason = "printed numbers are intervals".into();
    steady.flips_at = Some("0.00003".into());
    let mut force = ClaimRow::new(
        "C12",
        "forward contact force rises by 12.61, 18.79, 17.52 % at pitch −5, 0, 5°",
        Verdict::Differs,
        Evidence::Computed,
    );
    force.published = "{{ published(\"demo.gain\") }}".into();
    force.ours = "{{ v(\"demo.gain\") }}".into();
    force.multiverse = Some(Multiverse {
        holds: 10,
        of: 12,
        axes: vec![
            ("hip".into(), vec!["centre".into(), "end".into()]),
            ("torso".into(), vec!["free".into(), "fixed".into()]),
        ],
        verdicts: [Verdict::Differs; 10]
            .into_iter()
            .chain([Verdict::Reproduced, Verdict::NotRun])
            .collect(),
        account: "the place of the hip decides".into(),
    });
    vec![
        curves,
        ClaimRow::new(
            "C04",
            "the measurement is highly repeatable",
            Verdict::NotTestable,
            Evidence::Synthetic,
        ),
        steady,
        ClaimRow::new(
            "C16",
            "the 3x3 brush has “six” brushes",
            Verdict::Contradicted,
            Evidence::Published,
        ),
        force,
        ClaimRow::new(
            "C22",
            "the larger force explains the higher speed",
            Verdict::NotRun,
            Evidence::Computed,
        ),
    ]
}
