//! The chapter that says whether two runs gave the same bytes.

use report::figure::Provenance;
use report::{Block, Cell, Column, Evidence, NoticeKind, Section, Table, literal};

/// What a run left, as hashes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Prints {
    /// How many threads computed it, in words.
    pub threads: String,
    /// Identity of the results: SHA-256 of `results.json` without `run`.
    pub results: String,
    /// SHA-256 of all tables and figures and of the page outside its volatile facts, with their names.
    pub files: String,
}

/// Two runs in processes of their own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Twice {
    /// The prints of either.
    pub prints: [Prints; 2],
    /// Values and files that are not equal byte for byte.
    pub different: Vec<String>,
}

impl Twice {
    /// Whether both left the same bytes.
    #[must_use]
    pub fn same(&self) -> bool {
        let [one, other] = &self.prints;
        one.results == other.results && one.files == other.files
    }

    /// The outcome in a sentence.
    #[must_use]
    pub fn words(&self) -> String {
        if self.same() {
            return "results, tables, figures and page are equal byte for byte".to_owned();
        }
        const SHOWN: usize = 8;
        let more = self.different.len().saturating_sub(SHOWN);
        let rest = if more > 0 {
            format!(" and {more} more")
        } else {
            String::new()
        };
        let named: Vec<&str> = self
            .different
            .iter()
            .take(SHOWN)
            .map(String::as_str)
            .collect();
        format!("not equal: {}{rest}", named.join(", "))
    }
}

/// The outcome in a few words, for the header.
pub(super) fn fact(twice: Option<&Twice>) -> String {
    match twice.map(Twice::same) {
        None => "not tried in this run; reproduce --twice does".to_owned(),
        Some(true) => "yes: one thread and all, two processes".to_owned(),
        Some(false) => "no".to_owned(),
    }
}

/// The chapter.
pub(super) fn section(twice: Option<&Twice>) -> Section {
    let (lead, blocks) = match twice {
        None => (
            "Not run.".to_owned(),
            vec![Block::notice(
                NoticeKind::Note,
                "Not run",
                "This report was made in one process. `cargo xtask reproduce --twice` computes everything in two, one with a single thread, and compares what they leave byte for byte.",
            )],
        ),
        Some(twice) => (
            literal(&format!("Two processes: {}.", twice.words())),
            vec![table(twice).into()],
        ),
    };
    Section {
        id: "bit-identity".into(),
        title: "Same bytes twice?".into(),
        lead: lead.into(),
        method: Some(
            "A tolerance cannot find a result that depends on the order in which threads finish, or on the seed of a hash; two processes that start from nothing can.".into(),
        ),
        blocks,
        ..Section::default()
    }
}

fn table(twice: &Twice) -> Table {
    let rows = twice
        .prints
        .iter()
        .map(|prints| {
            vec![
                Cell::Text(prints.threads.clone()),
                Cell::Text(prints.results.clone()),
                Cell::Text(prints.files.clone()),
            ]
        })
        .collect();
    Table {
        id: "bit-identity-hashes".into(),
        title: "What either process left".into(),
        caption: "SHA-256 of the results without their volatile part, and of all tables, figures and the page (without the facts of its run) with their names.".into(),
        columns: ["threads", "results.json", "tables, figures, page"]
            .map(Column::text)
            .to_vec(),
        rows,
        evidence: Some(Evidence::Computed),
        provenance: Some(Provenance::here("reproduce", "cli::twice::compare")),
        ..Table::default()
    }
}
