//! What the second-order forms of a lagging channel have beside those of first order: y + tau y' + b tau^2 y'' = x.

use friction::ParameterSpec;

/// b: 0 is first order, 1/4 two equal stages, 1/2 a damping ratio of 0.71. At a damping ratio of one half channels ring visibly.
pub(super) const SECOND_ORDER: ParameterSpec = ParameterSpec::new(
    "second_order",
    "1",
    "b in y + tau y' + b tau^2 y'' = x, the damping ratio being 1/(2 sqrt(b))",
    0.0,
    1.0,
    0.25,
);

/// What such a form shares with its plain one: everything but the further parameter and the hook. Asked for on its own it explains too
/// much beside a law that bends it.
macro_rules! second_order_form {
    ($plain:ident) => {
        $crate::causes::marker::refining_form!(
            $plain,
            "second order",
            [TIME_CONSTANT, $crate::causes::second_order::SECOND_ORDER]
        );

        fn parameters_for(&self, experiment: &Experiment) -> Vec<ParameterSpec> {
            let mut specs = $plain.parameters_for(experiment);
            specs.push($crate::causes::second_order::SECOND_ORDER);
            specs
        }

        fn starts(&self, experiment: &Experiment) -> Vec<Vec<f64>> {
            let mut starts = $plain.starts(experiment);
            for start in &mut starts {
                start.push($crate::causes::second_order::SECOND_ORDER.typical);
            }
            starts
        }

        fn lateness_s(&self, p: &[f64]) -> f64 {
            $plain.lateness_s(p)
        }

        fn filters_force(&self) -> bool {
            $plain.filters_force()
        }

        fn steps_a_sample(&self, p: &[f64], run: &rig::RunMotion) -> usize {
            $plain.steps_a_sample(p, run)
        }
    };
}
pub(super) use second_order_form;
