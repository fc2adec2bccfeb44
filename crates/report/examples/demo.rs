//! Writes the page of the demonstration document to the path given, to look at.

#[path = "../tests/demo/mod.rs"]
mod demo;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: demo PATH")?;
    std::fs::write(path, report::render(&demo::document())?)?;
    Ok(())
}
