//! The equations that the results rest on, as rebuilt: the paper's displayed ones have not reached us.

use report::{Block, Equation, Section, Status, typeset_prose};

/// The chapter.
pub(super) fn section() -> Section {
    let blocks = LIST
        .iter()
        .map(|(id, latex, status, words)| {
            Block::Equation(Equation {
                id: (*id).to_owned(),
                latex: (*latex).to_owned(),
                status: *status,
                caption: typeset_prose(words).into(),
            })
        })
        .collect();
    Section {
        id: "equations".into(),
        title: "Equations".into(),
        lead: "The displayed equations of the paper are missing from the text that we have; these stand in their place, under the paper's numbers. *Stated*: in the paper's words. *Derived*: follows from what is stated. *Inferred*: chosen here; the reconstruction choices say what depends on it.".into(),
        claims: ["C08", "C17", "C18", "C20"].map(String::from).to_vec(),
        blocks,
        ..Section::default()
    }
}

/// Number, form, where it comes from, what it says.
const LIST: [(&str, &str, Status, &str); 12] = [
    (
        "E1",
        r"F_f = \frac{k}{h}\,\theta\cos^2(\theta+\theta_0)",
        Status::Derived,
        "Friction force of bristles that are rigid and turn about their roots against a torsion spring: the horizontal part of the contact force.",
    ),
    (
        "E2",
        r"v = \frac{h\,\dot\theta}{\cos^2(\theta+\theta_0)}",
        Status::Derived,
        "Speed of the contact point of a bristle that sticks.",
    ),
    (
        "E3",
        r"\dot\theta = w - \frac{\sigma |w|}{g(w)}\,\theta",
        Status::Derived,
        "Rate of the mean rotation, in the form of LuGre. It holds sigma, theta_c and theta_s in their ratios only.",
    ),
    (
        "E4",
        r"w = \frac{v}{h}\cos^2(\theta+\theta_0)",
        Status::Derived,
        "Relative angular rate of the substrate, by analogy with E2.",
    ),
    (
        "E5",
        r"g(w) = \theta_c + (\theta_s-\theta_c)\,e^{-(w/\omega_{sc})^2}",
        Status::Inferred,
        "Stribeck curve. The exponent is not stated.",
    ),
    (
        "E6",
        r"\mu = \frac{k}{N h}\,\theta\cos^2(\theta+\theta_0)",
        Status::Derived,
        "E1 over the normal load: the coefficient of friction.",
    ),
    (
        "E7",
        r"\mu = (\sigma_0\theta + \sigma_1\dot\theta + \sigma_2 w)\cos^2(\theta+\theta_0)",
        Status::Inferred,
        "With damping and a viscous term. Whether the cosine stands on these two terms as well is not stated; the other reading has it on the stiffness term alone.",
    ),
    (
        "E8",
        r"\theta_0 = 0: \quad \mu = (\sigma_0\theta + \sigma_1\dot\theta + \sigma_2 w)\cos^2\theta",
        Status::Stated,
        "Upright bristles: the symmetric law. For small theta it is LuGre with a deflection of h theta.",
    ),
    (
        "E9",
        r"\hat p = \arg\min_p \; r(p)^{T} C^{-1} r(p)",
        Status::Inferred,
        "Weighted least squares over all samples; the paper does not state its weights. C is the covariance of the noise, estimated from the campaign.",
    ),
    (
        "E10",
        r"M(q)\,\ddot q + c(q,\dot q) + G(q) = S\tau + J^{T} F",
        Status::Derived,
        "Motion of the biped. The paper's own terms stand in an appendix that we do not have; ours follow from virtual work, body by body.",
    ),
    (
        "E11",
        r"F(\tau) = -(J M^{-1} J^{T})^{-1} J M^{-1} (S\tau - G), \quad |\tau| \le \tau_{max}, \quad -\mu_{rev} F_y \le F_x \le \mu_{fwd} F_y",
        Status::Inferred,
        "Force envelope: what a foot at rest can press with, within the torques and the friction of either direction.",
    ),
    (
        "F6",
        r"F_n = k_n\,\delta^{3/2}\left(1 + \frac{3}{2}\,c\,\dot\delta\right), \quad F_n \ge 0",
        Status::Inferred,
        "Not in the paper: the compliant contact of the gait (Hertz; Hunt and Crossley 1975), with depth delta, stiffness and loss. The paper publishes none.",
    ),
];
