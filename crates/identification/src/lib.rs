//! Law, rig and fitting together: the parameters of a campaign and what of them can be identified.
