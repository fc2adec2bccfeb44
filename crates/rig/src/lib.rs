//! The measurement chain: law, stations and a run's protocol to the predicted record, with derivatives.
