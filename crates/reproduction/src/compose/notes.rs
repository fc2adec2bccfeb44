//! Texts that stand beside the results whatever they are: what is synthetic, what is not published, which choices were
//! made, what could be wrong.

use std::collections::BTreeSet;

use report::{Choice, Prose, Status, Symbol, literal, typeset, typeset_prose};

use super::ledger::told;

/// How this report could be wrong.
pub(super) fn doubts() -> Vec<Prose> {
    [
        "The displayed equations of the paper are missing from the text that we have. E1 to E8 are rebuilt from its words; another reading of E7 (the cosine on the stiffness term alone) is carried along where it matters.",
        "Stand-ins are made from the model that is then fitted. That the fit returns the parameters shows that the procedure works, and nothing about the brush.",
        "The load is assumed to be the stated weight, and the sensor's full scale to be 5 N; the paper states neither.",
        "The order of the columns of Table 3 is our reading; the audit shows that one of its inertias cannot be right as read.",
        "The gait depends on a cost function, bounds and a contact that are not published. Its speeds are those of our problem.",
        "Local minima: the best stride found is a lower bound on the best stride.",
    ]
    .map(Prose::from)
    .to_vec()
}

/// What is synthetic.
pub(super) fn synthetic(campaigns: &[(String, &'static str)]) -> Vec<Prose> {
    campaigns
        .iter()
        .map(|(name, kind)| match *kind {
            "synthetic" => format!(
                "`{}`: a stand-in made from the published numbers and protocol, with a rig's own imperfections (recipe beside the data)",
                literal(name)
            ),
            _ => format!("`{}`: measured, brought with `--data`", literal(name)),
        })
        .map(Prose::from)
        .collect()
}

/// What is not published.
pub(super) fn unpublished() -> Vec<Prose> {
    [
        "raw data and the data of any figure",
        "the displayed equations and the appendix with the terms of E10",
        "theta0, which the paper measured",
        "weights, bounds and settings of the fit",
        "the full scale of the force sensor, the stiffness of the cord, and that the load is the weight",
        "cost function, bounds, contact stiffness and contact loss of the gait",
        "the window over which the steady coefficients were averaged",
        "which symmetric model Figs 11 and 12 use (E8 or the constant coefficient)",
    ]
    .map(|text| typeset_prose(text).into())
    .to_vec()
}

/// What was not reproduced, with reasons.
pub(super) fn out_of_scope() -> Vec<Prose> {
    [
        "Friction and wear against rubber (C14): the paper prints no number.",
        "Photographs and drawings (Figs 1, 3, 4, 7): nothing in them can be computed.",
        "The three-dimensional quadruped that the biped simplifies: not in the paper.",
    ]
    .map(Prose::from)
    .to_vec()
}

/// Every reconstruction choice with its status.
pub(super) fn choices(known: &BTreeSet<&str>) -> Vec<Choice> {
    let choice = |subject: &str, taken: &str, status, sensitivity: &str| Choice {
        subject: typeset(subject).into(),
        taken: typeset_prose(taken).into(),
        status,
        sensitivity: told(sensitivity, known),
    };
    vec![
        choice(
            "E1, geometry and horizontal force",
            "$F_f = (k/h)\\,\\theta\\cos^2(\\theta+\\theta_0)$",
            Status::Derived,
            "none: it follows from the stated equilibrium",
        ),
        choice(
            "E3, rate of the mean rotation",
            "$\\dot\\theta = w - \\sigma|w|\\theta/g(w)$",
            Status::Derived,
            "none: LuGre's form is stated",
        ),
        choice(
            "E4, relative rate",
            "$w = (v/h)\\cos^2(\\theta+\\theta_0)$",
            Status::Derived,
            "none: by analogy with E2, as the text says",
        ),
        choice(
            "E5, exponent of the Stribeck curve",
            "2",
            Status::Inferred,
            "identified parameters; not the steady level",
        ),
        choice(
            "E7, cosine on the damping and viscous terms",
            "on all terms",
            Status::Inferred,
            "theta0 from {{ v(\"audit.lean.all_terms.mean.joint\") }} to {{ v(\"audit.lean.stiffness_only.mean.joint\") }} with the cosine on the stiffness term alone",
        ),
        choice(
            "theta0, the lean",
            "free in the fit; from the printed steady coefficients elsewhere",
            Status::Inferred,
            "direction dependence as a whole: the table of leans",
        ),
        choice(
            "E9, weights",
            "inverse covariance of the noise estimated from the campaign",
            Status::Inferred,
            "intervals more than values",
        ),
        choice(
            "Normal load",
            "the stated weight",
            Status::Inferred,
            "scales k, not the coefficients",
        ),
        choice(
            "Table 3, order of its columns",
            "masses, inertias, centres, lengths, torques",
            Status::Inferred,
            "envelope and gait",
        ),
        choice(
            "Envelope, body",
            "torso and one leg, hip at the torso's centre",
            Status::Inferred,
            "at level pitch the gain runs from {{ v(\"envelope.family.pitch0.lowest\") }} to {{ v(\"envelope.family.pitch0.highest\") }} over all variants",
        ),
        choice(
            "Sign of the pitch",
            "the paper's -5 deg is nose up",
            Status::Inferred,
            "exchanges the gains at -5 and 5 deg",
        ),
        choice(
            "Gait, friction",
            "steady coefficients with a regularised sign",
            Status::Inferred,
            "the law as printed grows without bound with speed",
        ),
    ]
}

/// Symbols with units.
pub(super) fn glossary() -> Vec<Symbol> {
    let symbol = |latex: &str, meaning: &str, unit: &str| Symbol {
        latex: latex.into(),
        meaning: meaning.into(),
        unit: unit.into(),
    };
    vec![
        symbol(
            "\\theta",
            "mean rotation of the bristles about their roots",
            "rad",
        ),
        symbol("\\theta_0", "fixed lean of the bristles", "rad"),
        symbol("w", "relative angular rate", "rad/s"),
        symbol(
            "v",
            "speed of the counterface relative to the brush, forward positive",
            "m/s",
        ),
        symbol("h", "gap between body and substrate", "m"),
        symbol(
            "g(w)",
            "Stribeck curve, in the unit of $\\sigma$",
            "1/m in the paper",
        ),
        symbol(
            "\\sigma",
            "factor of the rate equation; only $\\theta_c/\\sigma$ and $\\theta_s/\\sigma$ matter",
            "1/m in the paper",
        ),
        symbol("\\sigma_0", "stiffness coefficient, $k/(N h)$", "1/rad"),
        symbol("\\sigma_1", "damping coefficient", "s/rad"),
        symbol("\\sigma_2", "viscous coefficient", "s/rad"),
        symbol("\\omega_{sc}", "Stribeck rate", "rad/s"),
        symbol(
            "\\mu",
            "coefficient of friction, force over normal load",
            "1",
        ),
        symbol("N", "normal load", "N"),
        symbol(
            "k",
            "torsion stiffness at the root of the bristles together",
            "N m/rad",
        ),
        symbol(
            "Q_v",
            "weight of the speed error in the cost of a stride",
            "1",
        ),
    ]
}
