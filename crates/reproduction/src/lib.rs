//! The paper: published numbers, stages, claims, cache and provenance; the program behind cargo xtask.
