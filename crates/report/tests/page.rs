//! The structure of the page, on a document with one of everything and hostile strings in its metadata.

mod demo;

use std::collections::BTreeSet;

use report::figure::{Axis, Figure, Ink, LinePlot, Provenance, Series};
use report::{
    Block, Cell, ClaimRow, Column, Document, Error, Evidence, Section, Table, Verdict, render,
};

fn page() -> String {
    render(&demo::document()).expect("the demonstration renders")
}

/// Values of an attribute of all elements, or of elements with this name.
fn attributes(page: &str, element: Option<&str>, name: &str) -> Vec<String> {
    let mut out = Vec::new();
    for tag in tags(page) {
        let inside = tag.trim_start_matches('<');
        if element.is_some_and(|element| inside.split_whitespace().next() != Some(element)) {
            continue;
        }
        if let Some((_, rest)) = tag.split_once(&format!(" {name}=\"")) {
            out.extend(rest.split_once('"').map(|(value, _)| value.to_string()));
        }
    }
    out
}

/// Opening tags outside scripts and styles.
fn tags(page: &str) -> Vec<String> {
    let mut out = Vec::new();
    let mut rest = page;
    while let Some(at) = rest.find('<') {
        rest = &rest[at..];
        let end = rest.find('>').map_or(rest.len(), |end| end + 1);
        let tag = &rest[..end];
        let name: String = tag[1..]
            .chars()
            .take_while(char::is_ascii_alphanumeric)
            .collect();
        if !name.is_empty() {
            out.push(tag.trim_end_matches(['>', '/']).to_string());
        }
        rest = &rest[end..];
        if matches!(name.as_str(), "script" | "style") {
            rest = rest.find("</").map_or("", |at| &rest[at..]);
        }
    }
    out
}

/// A reviewer finds the checklist, and how much of it the run answers, without scrolling through the page.
#[test]
fn the_masthead_counts_the_answers_of_the_checklist() {
    let page = page();
    let (masthead, _) = page.split_once("</header>").expect("a masthead");
    let counted = "<a href=\"#checklist\">Reviewer’s checklist</a>: 1 partly.";
    assert!(masthead.contains(counted), "{masthead}");
}

#[test]
fn hostile_metadata_stays_text() {
    let page = page();
    let scripts = tags(&page)
        .iter()
        .filter(|tag| tag.starts_with("<script"))
        .count();
    assert_eq!(
        scripts, 3,
        "facts of the run, results, and the page's own script"
    );
    assert!(attributes(&page, None, "onerror").is_empty());
    assert!(attributes(&page, Some("img"), "src").is_empty());
    assert!(!page.contains("href=\"javascript"));
    assert!(page.contains("&lt;script&gt;") || page.contains("&lt;&#x2f;script&gt;"));
}

#[test]
fn nothing_is_loaded() {
    let page = page();
    for name in ["src", "srcset", "data", "poster", "xlink:href", "action"] {
        assert_eq!(
            attributes(&page, None, name),
            Vec::<String>::new(),
            "{name}"
        );
    }
    for address in attributes(&page, Some("link"), "href") {
        assert!(address.starts_with("data:"), "{address}");
    }
    assert!(!page.contains("@import") && !page.contains("url("));
    assert!(page.contains("default-src 'none'"));
}

#[test]
fn ids_are_unique_and_links_arrive() {
    let page = page();
    let ids = attributes(&page, None, "id");
    let unique: BTreeSet<&String> = ids.iter().collect();
    assert_eq!(ids.len(), unique.len());
    for link in attributes(&page, Some("a"), "href") {
        if let Some(id) = link.strip_prefix('#') {
            assert!(unique.contains(&id.to_string()), "nothing has the id {id}");
        }
    }
    for name in [
        "aria-labelledby",
        "aria-describedby",
        "for",
        "aria-controls",
    ] {
        for value in attributes(&page, None, name) {
            for id in value.split_whitespace() {
                assert!(unique.contains(&id.to_string()), "{name} names {id}");
            }
        }
    }
}

#[test]
fn headings_do_not_skip() {
    let page = page();
    let levels: Vec<u8> = tags(&page)
        .iter()
        .filter_map(|tag| {
            tag.strip_prefix("<h")
                .and_then(|rest| rest.chars().next()?.to_digit(10))
        })
        .map(|level| u8::try_from(level).unwrap_or(9))
        .collect();
    assert_eq!(levels.first(), Some(&1));
    assert_eq!(levels.iter().filter(|level| **level == 1).count(), 1);
    assert!(
        levels.windows(2).all(|pair| pair[1] <= pair[0] + 1),
        "{levels:?}"
    );
}

#[test]
fn every_drawing_has_words() {
    let page = page();
    let drawings = tags(&page)
        .iter()
        .filter(|tag| tag.starts_with("<svg"))
        .count();
    assert_eq!(drawings, 8, "seven figures, one of them on two axes");
    assert_eq!(page.matches("<title id=").count(), drawings);
    assert_eq!(page.matches("<desc id=").count(), drawings);
    assert!(page.contains("Line plot of coefficient of friction over speed."));
    assert!(page.contains("1800 points, lowest"));
    assert!(page.contains("Bar chart of gain for 3 categories"));
    assert!(page.contains("1 cells without a value") || page.contains("1 cell without a value"));
}

#[test]
fn all_six_verdicts_are_counted() {
    let mut document = demo::document();
    document
        .claims
        .retain(|claim| claim.verdict == Verdict::Reproduced);
    document.deviations.clear();
    document.drift = None;
    let page = render(&document).expect("renders");
    let board = page
        .split("class=\"board\"")
        .nth(1)
        .and_then(|rest| rest.split("</ul>").next())
        .expect("a board");
    for verdict in Verdict::ALL {
        assert!(board.contains(verdict.word()), "{}", verdict.word());
        assert!(board.contains(verdict.symbol()), "{}", verdict.word());
    }
    assert_eq!(board.matches(">0<").count(), 5);
    assert_eq!(board.matches(">1<").count(), 1);
}

#[test]
fn synthetic_data_says_so() {
    let page = page();
    let card = page.split("id=\"fig-curves\"").nth(1).expect("the card");
    let card = card.split("</figure>").next().expect("its end");
    assert_eq!(card.matches(">SYNTHETIC DATA<").count(), 2, "on both views");
    assert!(card.contains("Made from synthetic data."));
    let other = page.split("id=\"fig-gains\"").nth(1).expect("the card");
    let other = other.split("</figure>").next().expect("its end");
    assert!(!other.contains("SYNTHETIC"));
}

#[test]
fn only_the_marked_block_is_volatile() {
    let mut document = demo::document();
    let one = render(&document).expect("renders");
    document.run.started = "2025-05-05T05:05:05Z".into();
    document.run.seconds.insert("validation".into(), 99.0);
    let two = render(&document).expect("renders");
    assert_ne!(one, two);
    let stable = |page: &str| {
        let (before, rest) = page.split_once("<!-- volatile:begin -->").expect("begin");
        let (_, after) = rest.split_once("<!-- volatile:end -->").expect("end");
        format!("{before}{after}")
    };
    assert_eq!(stable(&one), stable(&two));
}

#[test]
fn the_embedded_results_read_back() {
    let document = demo::document();
    let page = render(&document).expect("renders");
    let embedded = page
        .split("id=\"results\">")
        .nth(1)
        .and_then(|rest| rest.split("</script>").next())
        .expect("results");
    let read: serde_json::Value = serde_json::from_str(embedded).expect("JSON");
    assert_eq!(read, document.results);
    assert!(page.contains(&format!("sha256:{}", report::identity(&document.results))));
}

#[test]
fn a_campaign_without_ledger_has_no_ledger_parts() {
    let document = Document {
        title: "One campaign".into(),
        sections: vec![Section {
            id: "answer".into(),
            title: "Answer".into(),
            blocks: vec![Block::prose("Nothing was found.")],
            ..Section::default()
        }],
        ..Document::default()
    };
    let page = render(&document).expect("renders");
    for absent in [
        "id=\"ledger\"",
        "class=\"board\"",
        "id=\"deviations\"",
        "id=\"audit\"",
        "id=\"glossary\"",
    ] {
        assert!(!page.contains(absent), "{absent}");
    }
}

#[test]
fn mistakes_of_an_author_are_named() {
    let with = |block: Block| Document {
        sections: vec![Section {
            id: "s".into(),
            blocks: vec![block],
            ..Section::default()
        }],
        ..Document::default()
    };
    let error = render(&with(Block::prose("{{ v(\"no.such\") }}"))).expect_err("unknown value");
    assert_eq!(
        error.to_string(),
        "section s: no value has the id `no.such`"
    );
    let error =
        render(&with(Block::prose("$\\frac{1$"))).expect_err("an equation that does not close");
    assert!(matches!(error, Error::Equation { .. }), "{error}");
    let error = render(&with(Block::heading("s", "Twice"))).expect_err("doubled id");
    assert_eq!(
        error.to_string(),
        "the id `s` stands on two parts of the page"
    );
    let table = Table {
        id: "t".into(),
        columns: vec![Column::text("a"), Column::text("b")],
        rows: vec![vec![Cell::from("only one")]],
        ..Table::default()
    };
    let error = render(&with(table.into())).expect_err("a short row");
    assert_eq!(
        error.to_string(),
        "table `t`: row 1 has 1 cells for 2 columns"
    );
    let empty = LinePlot::new(
        Axis::new("x", "1"),
        Axis::new("y", "1"),
        vec![Series::line("nothing", Ink::Muted, vec![])],
    );
    let figure = Figure::new(
        "f",
        "Empty",
        "",
        Evidence::Computed,
        empty,
        Provenance::here("s", "f"),
    );
    let error = render(&with(figure.into())).expect_err("nothing to draw");
    assert_eq!(error.to_string(), "figure `f`: no finite number to draw");
}

#[test]
fn a_figure_with_strange_numbers_is_still_drawn() {
    let points = vec![
        [0.0, f64::NAN],
        [1.0, 1.0],
        [2.0, f64::INFINITY],
        [3.0, -1e300],
        [4.0, 2.0],
    ];
    let plot = LinePlot::new(
        Axis::new("x", "1"),
        Axis::new("y", "1"),
        vec![Series::line("odd", Ink::Slot(9), points)],
    );
    let figure = Figure::new(
        "odd",
        "Odd",
        "",
        Evidence::Computed,
        plot,
        Provenance::here("s", "f"),
    );
    let svg = report::figure::svg_file(&figure).expect("draws");
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
    let csv = report::figure::csv_file(&figure).expect("data");
    assert_eq!(csv.lines().count(), 6);
}

#[test]
fn files_beside_the_report_are_complete() {
    let document = demo::document();
    for block in document.sections.iter().flat_map(|section| &section.blocks) {
        if let Block::Figure(figure) = block {
            let svg = report::figure::svg_file(figure).expect("draws");
            assert!(
                svg.starts_with("<svg") && svg.ends_with("</svg>") && svg.contains("<style>"),
                "{}",
                figure.id
            );
            assert_eq!(
                svg,
                report::figure::svg_file(figure).expect("draws"),
                "the same bytes again"
            );
        }
    }
}

#[test]
fn tables_come_from_frames() {
    use polars::prelude::{Column as Series, DataFrame};
    let frame = DataFrame::new(
        2,
        vec![
            Series::new("material".into(), ["aluminium", "<nylon>"]),
            Series::new("steady".into(), [Some(0.9), None]),
        ],
    )
    .expect("a frame");
    let table = Table::from_frame("t", "Steady", &frame, &["", "1"]).expect("a table");
    assert_eq!(
        table.rows[0],
        [Cell::Text("aluminium".into()), Cell::Number(0.9)]
    );
    assert!(matches!(table.rows[1][1], Cell::Missing(_)));
    assert!(Table::from_frame("t", "Steady", &frame, &["1"]).is_err());
}

#[test]
fn documents_can_be_cached() {
    let document = demo::document();
    let text = serde_json::to_string(&document).expect("written");
    let read: Document = serde_json::from_str(&text).expect("read");
    assert_eq!(
        render(&read).expect("renders"),
        render(&document).expect("renders")
    );
}

#[test]
fn a_claim_without_numbers_still_renders() {
    let document = Document {
        claims: vec![ClaimRow::new(
            "C14",
            "steel beats rubber",
            Verdict::NotTestable,
            Evidence::Published,
        )],
        ..Document::default()
    };
    assert!(
        render(&document)
            .expect("renders")
            .contains("steel beats rubber")
    );
}
