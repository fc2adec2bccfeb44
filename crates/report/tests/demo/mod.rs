//! A small document with one of everything and with hostile strings wherever a reader's data could bring them. Its
//! numbers are made up and mean nothing.
#![allow(missing_docs, unreachable_pub)]

mod claims;
mod figures;
mod sections;

use report::{
    Answer, AuditItem, AuditOutcome, CauseClass, CheckItem, Choice, Deviation, Document, Drift,
    DriftClass, DriftRow, Evidence, Header, Input, NegativeControl, Prose, Run, Status, Subject,
    Symbol, Value,
};

use self::claims::claims;
use self::sections::sections;

/// What metadata could hold.
pub const HOSTILE: &str = "</script><script>alert('x')</script> <img src=https://example.org/x.png onerror=alert(1)> {{ v(\"no.such\") }} *b* $\\frac$ [a](javascript:alert(1)) `";

/// The document.
pub fn document() -> Document {
    let values = vec![
        Value::new(
            "demo.sigma0",
            1.640_123,
            "1/rad",
            "validation",
            Evidence::Synthetic,
        )
        .with_ci95(1.622, 1.658)
        .with_published("1.64"),
        Value::new("demo.rmse", 0.0123, "1", "validation", Evidence::Synthetic),
        Value::new(
            "demo.steady_forward",
            0.904_93,
            "1",
            "validation",
            Evidence::Published,
        )
        .with_ci95(0.90485, 0.90495)
        .with_published("0.9049"),
        Value::new(
            "demo.gain",
            18.604,
            "percent",
            "envelope",
            Evidence::Computed,
        )
        .with_published("18.79"),
    ];
    let results =
        serde_json::json!({ "schema": "bristle/results/1", "hostile": HOSTILE, "values": values });
    Document {
        title: "Asymmetric bristle: a demonstration".into(),
        lead: "A made-up document with one of everything. Its numbers mean nothing.".into(),
        subject: Subject {
            reference: format!("Nobody N. “{HOSTILE}” Journal of Nothing 1(1), 2024."),
            doi: Some("10.1000/xyz123".into()),
        },
        header: Header {
            program: "Bristle 0.1.0".into(),
            command: "cargo xtask reproduce".into(),
            inputs: vec![Input {
                path: HOSTILE.into(),
                hash: "blake3:0123".into(),
                kind: "synthetic".into(),
            }],
            facts: vec![
                ("Claims".into(), "6".into()),
                ("Seeds".into(), HOSTILE.into()),
            ],
            stages: vec![("validation".into(), "done".into())],
            repository: Some("https://example.org/bristle".into()),
        },
        run: Run {
            commit: "0123456789abcdef".into(),
            dirty: true,
            rustc: "rustc 1.95.0".into(),
            target: "x86_64-unknown-linux-gnu".into(),
            started: "2024-01-01T00:00:00Z".into(),
            finished: "2024-01-01T00:01:00Z".into(),
            seconds: [("C02".to_string(), 0.8), ("validation".to_string(), 3.2)].into(),
            link: None,
        },
        values,
        claims: claims(),
        deviations: vec![Deviation {
            claim: "C12".into(),
            cause: CauseClass::UnderSpecified,
            account: "The hip’s place is not stated.".into(),
            settles: "The appendix with the dynamics, or the authors’ code.".into(),
        }],
        audit: vec![
            AuditItem {
                id: "A01".into(),
                subject: "Mean of the steady coefficients".into(),
                locator: "section 2.4".into(),
                sum: "$(0.9049 + 0.4314)/2 = 0.66815$, printed 0.6682".into(),
                outcome: AuditOutcome::Holds,
                consequence: "Within rounding.".into(),
                claims: vec!["C09".into()],
            },
            AuditItem {
                id: "A02".into(),
                subject: "Number of brushes".into(),
                locator: "section 2.2".into(),
                sum: "$3 \\times 3 = 9 \\ne 6$".into(),
                outcome: AuditOutcome::Fails,
                consequence: "See [the claim](#C16).".into(),
                claims: vec!["C16".into()],
            },
            AuditItem {
                id: "A03".into(),
                subject: "Full scale of the sensor".into(),
                locator: String::new(),
                sum: "not stated".into(),
                outcome: AuditOutcome::Open,
                consequence: Prose::default(),
                claims: vec![],
            },
        ],
        sections: sections(),
        drift: Some(Drift {
            against: HOSTILE.into(),
            old_identity: "00".into(),
            unchanged: 3,
            rows: vec![DriftRow {
                id: "demo.gain".into(),
                old: Some(18.5),
                new: Some(18.604),
                unit: "percent".into(),
                tolerance_used_percent: Some(41.0),
                class: DriftClass::Algorithm,
                flips: vec!["C12".into()],
            }],
            verdicts: vec![("C12".into(), "reproduced".into(), "differs".into())],
            by_values: vec![("C09".into(), "differs".into(), "consistent".into())],
            platforms: Some(["aarch64, rustc 1".into(), HOSTILE.into()]),
        }),
        doubts: vec!["The load may not be the weight.".into()],
        controls: vec![
            NegativeControl {
                id: "N1".into(),
                mutation: "one published number altered".into(),
                expected: vec!["C09".into()],
                turned: vec!["C09".into()],
            },
            NegativeControl {
                id: "N2".into(),
                mutation: "columns swapped".into(),
                expected: vec!["C02".into()],
                turned: vec![],
            },
        ],
        synthetic: vec!["All campaigns.".into()],
        unpublished: vec!["Raw data.".into()],
        out_of_scope: vec!["Rubber (C14): no numbers.".into()],
        checklist: vec![CheckItem {
            id: "R01".into(),
            source: "ACM".into(),
            question: HOSTILE.into(),
            answer: Answer::Partly,
            evidence: "See the [ledger](#ledger).".into(),
        }],
        choices: vec![Choice {
            subject: "Stribeck exponent".into(),
            taken: "2".into(),
            status: Status::Inferred,
            sensitivity: "Moves $\\omega_{sc}$ only.".into(),
        }],
        glossary: vec![Symbol {
            latex: r"\theta_0".into(),
            meaning: "lean of a bristle at rest".into(),
            unit: "rad".into(),
        }],
        results,
    }
}
