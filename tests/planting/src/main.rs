//! Writes the stand-in campaigns.
fn main() {}
