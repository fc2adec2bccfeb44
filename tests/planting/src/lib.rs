//! An independent simulator of the rig that hides effects in synthetic campaigns.
