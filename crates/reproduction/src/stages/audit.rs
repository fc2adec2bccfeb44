//! The audit of the paper's own arithmetic, as a stage.

use crate::audit::{examine, worlds};
use crate::stage::{Needs, Stage, StageContext, StageError, StageOutput};

/// The paper's own arithmetic.
pub(super) struct Audit;

impl Stage for Audit {
    fn id(&self) -> &'static str {
        "audit"
    }

    fn title(&self) -> &'static str {
        "the paper's own arithmetic"
    }

    fn needs(&self) -> Needs {
        Needs::default()
    }

    fn run(&self, context: &StageContext<'_>) -> Result<StageOutput, StageError> {
        let audit = examine(context.published)?;
        let mut output = StageOutput::done();
        let items = serde_json::to_value(&audit.items)
            .map_err(|error| StageError::Failed(error.to_string()))?;
        output.artefacts.insert("items".to_owned(), items);
        output
            .work
            .insert("sums".to_owned(), audit.items.len() as u64);
        for (claim, worlds) in worlds(context.published)? {
            let artefact = worlds
                .artefact(claim)
                .map_err(|error| StageError::Failed(error.to_string()))?;
            output.artefacts.extend([artefact]);
        }
        output.values = audit.values;
        output.sections = audit.sections;
        Ok(output)
    }
}
