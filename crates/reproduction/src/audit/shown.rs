//! The paper's printed geometry and machine, shown: the bristle to scale, Table 3 as read.

use report::figure::{Figure, Ink, Provenance, bristle};
use report::{Cell, Column, Evidence, Section, Table};

use super::{Book, shown};
use crate::published::PublishedError;

/// Counterpart of Fig. 2: the bristle at rest and sliding either way, drawn from the printed numbers and the lean.
pub(super) fn bristle_to_scale(book: &Book<'_>, lean: f64) -> Result<Figure, PublishedError> {
    let theta = book.value("table1.theta_c")? / book.value("table1.sigma")?;
    let states = [
        ("sliding forward", Ink::FORWARD, lean + theta),
        ("sliding in reverse", Ink::REVERSE, lean - theta),
    ];
    let drawing = bristle(
        book.value("brush.bristle_length")?,
        book.value("brush.bristle_diameter")?,
        book.value("brush.contact_height")?,
        lean,
        &states,
    );
    Ok(Figure::new(
        "fig-2",
        "The bristle, to scale",
        "From the printed length, gap and Table 1, with the lean that both printed coefficients ask for \
         ({{ v(\"audit.lean.all_terms.mean.joint\") }}) and the steady rotation {{ v(\"audit.steady_theta\") }}. Dots: where the \
         bristle's line meets the substrate, at {{ v(\"audit.reach.rest\") }} from the root at rest, \
         {{ v(\"audit.reach.forward\") }} forward and {{ v(\"audit.reach.reverse\") }} in reverse: beyond the tip every time.",
        Evidence::Computed,
        drawing,
        Provenance::here("audit", "shown::bristle_to_scale"),
    )
    .with_paper("Fig. 2")
    .with_claims(&["C08", "C21"]))
}

/// Counterpart of Table 3, in the order of columns in which it is read here.
pub(super) fn robot() -> Section {
    let row = |link: &str, joint: Option<&str>| {
        let cell = |part: &str| Cell::Prose(shown(&format!("table3.{link}_{part}")).into());
        let from_joint = |cell: Cell| match joint {
            Some(_) => cell,
            None => {
                Cell::Missing("the torso hangs on no joint; its mass centre is its middle".into())
            }
        };
        vec![
            Cell::from(link),
            cell("mass"),
            cell("inertia"),
            from_joint(cell("centre")),
            cell("length"),
            match joint {
                Some(joint) => Cell::Prose(shown(&format!("table3.{joint}_torque")).into()),
                None => from_joint(Cell::from("")),
            },
        ]
    };
    let table = Table {
        id: "table-3".into(),
        title: "The biped’s parameters, as read".into(),
        caption: "The headers of the printed columns are lost; the order is read from magnitudes and units. The inertia of the \
                  shank is more than a body of its mass and length with its centre there can have ({{ v(\"audit.shank_inertia_bound_at_centre\") }})."
            .into(),
        columns: vec![
            Column::text("link"),
            Column::number("mass", ""),
            Column::number("inertia about the mass centre", ""),
            Column::number("mass centre from the upper joint", ""),
            Column::number("length", ""),
            Column::number("largest torque of the upper joint", ""),
        ],
        rows: vec![
            row("torso", None),
            row("thigh", Some("hip")),
            row("shank", Some("knee")),
        ],
        evidence: Some(Evidence::Published),
        paper: Some("Table 3".into()),
        provenance: Some(Provenance::here("audit", "shown::robot")),
        claims: ["C11", "C12"].map(String::from).to_vec(),
    };
    Section {
        id: "audit-robot".into(),
        title: "The biped’s parameters".into(),
        lead: "Envelope and gait are computed from these numbers; with one of them the paper’s machine cannot be built.".into(),
        claims: ["C11", "C12"].map(String::from).to_vec(),
        blocks: vec![table.into()],
        ..Section::default()
    }
}
