//! Cards: a figure, a table, a chain, each with what a reader needs to check it.

use minijinja::{Value, context};

use super::claim_links;
use super::engine::{Engine, safe};
use crate::escape::{data_uri, html};
use crate::figure::data::{self, Data, Datum};
use crate::figure::describe::describe;
use crate::figure::draw::{self, View, thin::evenly};
use crate::figure::{Figure, Plot, Provenance};
use crate::prose::{Lookup, letters};
use crate::{Align, Cell, Chain, Error, Table, number, palette};

/// Rows of the data shown on the page; all are in the file.
const PREVIEW: usize = 24;
/// Rows of the data inside the page's CSV; all are in the file beside the report.
const EMBEDDED: usize = 1200;
/// Digits of the data inside the page's CSV.
const DIGITS: u8 = 6;

/// What cards need beside their own content.
pub(super) struct Cards<'a> {
    pub(super) engine: &'a Engine,
    pub(super) lookup: &'a Lookup<'a>,
    pub(super) repository: Option<&'a str>,
    pub(super) commit: &'a str,
}

impl Cards<'_> {
    /// A figure card.
    pub(super) fn figure(&self, figure: &Figure) -> Result<String, Error> {
        let place = format!("figure {}", figure.id);
        let description = describe(figure);
        let mut views = Vec::new();
        if figure.paper_limits.is_some() {
            let svg = draw::svg(figure, View::Paper, &description)?;
            views.push(context! { key => "paper", label => "the paper’s axes", svg => safe(svg) });
        }
        let full = draw::svg(figure, View::Full, &description)?;
        let maps = matches!(figure.plot, Plot::Heat(_));
        let style = format!(
            "{}{}",
            palette::for_file(maps),
            crate::figure::STYLE.replace('\n', "")
        );
        let file = data_uri("image/svg+xml", &draw::standalone(&full, &style));
        views.push(context! { key => "full", label => "full data", svg => safe(full) });
        let data = data::of(figure);
        let csv = (!data.rows.is_empty())
            .then(|| data_uri("text/csv;charset=utf-8", &embedded(&data).csv(Some(DIGITS))));
        self.engine.render(
            "figure.html",
            context! {
                id => &figure.id,
                title => &figure.title,
                paper => &figure.paper,
                evidence => figure.evidence.word(),
                caption => safe(self.lookup.paragraphs(&figure.caption, &place)?),
                limits_source => figure.paper_limits.as_ref().map(|limits| limits.source.clone()),
                views,
                moves => matches!(figure.plot, Plot::Animation(_)),
                preview => preview(&data),
                description,
                csv,
                svg => file,
                origin => self.origin(&figure.provenance),
                claims => claim_links(&figure.claims, self.lookup),
            },
        )
    }

    /// A table card.
    pub(super) fn table(&self, table: &Table) -> Result<String, Error> {
        let place = format!("table {}", table.id);
        check_width(table)?;
        let columns: Vec<Value> = table
            .columns
            .iter()
            .map(|column| {
                Ok(context! {
                    name => safe(self.lookup.inline(&column.name, &place)?),
                    unit => number::unit(&column.unit),
                    align => align(column.align),
                })
            })
            .collect::<Result<_, Error>>()?;
        let rows: Vec<Vec<Value>> = table
            .rows
            .iter()
            .map(|row| {
                row.iter()
                    .zip(&table.columns)
                    .enumerate()
                    .map(|(index, (cell, column))| {
                        let html = self.cell(cell, &column.unit, &place)?;
                        Ok(context! {
                            // A heading of mathematics alone counts as empty for assistive technology.
                            heads => index == 0 && !(html.starts_with("<math") && html.ends_with("</math>")),
                            html => safe(html),
                            align => align(column.align),
                        })
                    })
                    .collect()
            })
            .collect::<Result<_, Error>>()?;
        self.engine.render(
            "table.html",
            context! {
                id => &table.id,
                title => &table.title,
                paper => &table.paper,
                evidence => table.evidence.map(crate::Evidence::word),
                caption => safe(self.lookup.paragraphs(&table.caption, &place)?),
                columns,
                rows,
                csv => data_uri("text/csv;charset=utf-8", &table_csv(table, self.lookup)?),
                origin => table.provenance.as_ref().map(|origin| self.origin(origin)),
                claims => claim_links(&table.claims, self.lookup),
            },
        )
    }

    /// The chain diagram.
    pub(super) fn chain(&self, chain: &Chain) -> Result<String, Error> {
        let stations: Vec<Value> = chain
            .stations
            .iter()
            .map(|station| {
                let suspects: Vec<Value> = station
                    .suspects
                    .iter()
                    .map(|suspect| {
                        context! {
                            label => &suspect.label,
                            state => suspect.state.words().replace(' ', "-"),
                            words => suspect.state.words(),
                            symbol => suspect.state.symbol(),
                            note => &suspect.note,
                        }
                    })
                    .collect();
                context! { name => &station.name, role => &station.role, suspects }
            })
            .collect();
        self.engine.render(
            "chain.html",
            context! {
                id => &chain.id,
                caption => safe(self.lookup.paragraphs(&chain.caption, &format!("chain {}", chain.id))?),
                stations,
            },
        )
    }

    /// Who made it, from what; linked to the line at the commit where the repository has a public address.
    fn origin(&self, origin: &Provenance) -> Value {
        let address = self
            .repository
            .filter(|repository| repository.starts_with("https://") && !self.commit.is_empty())
            .map(|repository| {
                format!(
                    "{}/blob/{}/{}#L{}",
                    repository.trim_end_matches('/'),
                    self.commit,
                    origin.file,
                    origin.line
                )
            });
        context! {
            stage => &origin.stage,
            function => &origin.function,
            place => format!("{}:{}", origin.file, origin.line),
            address,
            seed => origin.seed.map(|seed| seed.to_string()),
            parameters => origin.parameters.iter().map(|(k, v)| vec![k.clone(), v.clone()]).collect::<Vec<_>>(),
            inputs => origin.inputs.iter().map(|(k, v)| vec![k.clone(), v.clone()]).collect::<Vec<_>>(),
        }
    }

    fn cell(&self, cell: &Cell, column_unit: &str, place: &str) -> Result<String, Error> {
        Ok(match cell {
            Cell::Text(text) => html(text),
            Cell::Prose(prose) => self.lookup.inline(prose, place)?,
            Cell::Number(number) => html(&number::plain(*number)),
            Cell::Digits(number, digits) => html(&number::significant(*number, *digits)),
            Cell::Interval(number, interval) => html(&number::with_interval(*number, *interval)),
            Cell::Value(id) => {
                // The heading of the column has the unit already.
                let bare =
                    number::unit(&self.lookup.value(id, place)?.unit) == number::unit(column_unit);
                let call = if bare { "ni" } else { "ci" };
                self.lookup
                    .inline(&format!("{{{{ {call}(\"{id}\") }}}}").into(), place)?
            }
            Cell::Verdict(verdict) => format!(
                "<span class=\"chip v-{}\"><span aria-hidden=\"true\">{}</span> {}</span>",
                verdict.class(),
                verdict.symbol(),
                verdict.word()
            ),
            Cell::Missing(why) => format!(
                "<span class=\"absent\">– <span class=\"why\">{}</span></span>",
                html(why)
            ),
        })
    }
}

fn align(align: Align) -> &'static str {
    match align {
        Align::Left => "left",
        Align::Right => "num",
        Align::Centre => "centre",
    }
}

/// Every row is as wide as the heading.
pub(super) fn check_width(table: &Table) -> Result<(), Error> {
    match table
        .rows
        .iter()
        .position(|row| row.len() != table.columns.len())
    {
        None => Ok(()),
        Some(row) => Err(Error::Table {
            id: table.id.clone(),
            why: format!(
                "row {} has {} cells for {} columns",
                row + 1,
                table.rows[row].len(),
                table.columns.len()
            ),
        }),
    }
}

/// The table as CSV: numbers with every digit; an interval stays in one cell, `value [low; high]`.
pub(super) fn table_csv(table: &Table, lookup: &Lookup<'_>) -> Result<String, Error> {
    let place = format!("table {}", table.id);
    let mut out = String::new();
    let mut heading = Vec::new();
    for column in &table.columns {
        let name = lookup.plain(&column.name, &place)?;
        heading.push(crate::escape::csv(
            &match number::unit(&column.unit).as_str() {
                "" => name,
                unit => format!("{name} ({unit})"),
            },
        ));
    }
    out.push_str(&heading.join(","));
    out.push('\n');
    for row in &table.rows {
        let mut cells = Vec::new();
        for cell in row {
            let text = match cell {
                Cell::Text(text) => text.clone(),
                Cell::Prose(prose) => lookup.plain(prose, &place)?,
                Cell::Number(number) | Cell::Digits(number, _) => number::exact(*number),
                Cell::Interval(number, [low, high]) => {
                    format!(
                        "{} [{}; {}]",
                        number::exact(*number),
                        number::exact(*low),
                        number::exact(*high)
                    )
                }
                Cell::Value(id) => {
                    let value = lookup.value(id, &place)?;
                    value.value.map(number::exact).unwrap_or_default()
                }
                Cell::Verdict(verdict) => verdict.word().to_string(),
                Cell::Missing(_) => String::new(),
            };
            cells.push(crate::escape::csv(&text));
        }
        out.push_str(&cells.join(","));
        out.push('\n');
    }
    Ok(out)
}

/// The rows that the page's CSV holds.
fn embedded(data: &Data) -> Data {
    let chosen: Vec<usize> = evenly(&(0..data.rows.len()).collect::<Vec<_>>(), EMBEDDED);
    Data {
        heading: data.heading.clone(),
        rows: chosen
            .into_iter()
            .map(|index| data.rows[index].clone())
            .collect(),
    }
}

/// The rows that the page shows.
fn preview(data: &Data) -> Value {
    let chosen = evenly(&(0..data.rows.len()).collect::<Vec<_>>(), PREVIEW);
    let all = data.rows.len();
    let mut note = if chosen.len() < all {
        format!("{} of {all} rows, evenly chosen.", chosen.len())
    } else {
        format!("{all} rows.")
    };
    if all > EMBEDDED {
        note.push_str(&format!(
            " The CSV below holds {EMBEDDED} of them to {DIGITS} digits; all rows with all digits are in the folder `tables` beside the report."
        ));
    } else {
        note.push_str(&format!(
            " The CSV below holds all of them to {DIGITS} digits."
        ));
    }
    let rows: Vec<Vec<Value>> = chosen
        .into_iter()
        .map(|index| {
            data.rows[index]
                .iter()
                .map(|datum| match datum {
                    Datum::Word(word) => context! { number => false, text => letters(word) },
                    Datum::Number(number) => {
                        context! { number => true, text => number::significant(*number, 5) }
                    }
                    Datum::Nothing => context! { number => true, text => "" },
                })
                .collect()
        })
        .collect();
    // Symbols as the figure has them; the files keep the ids that programs read.
    let heading: Vec<String> = data.heading.iter().map(|name| letters(name)).collect();
    context! { note, heading, rows }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_preview_has_the_symbols_of_the_figure_and_the_file_has_the_ids() {
        let data = Data {
            heading: vec!["series".into(), "theta0 (rad)".into()],
            rows: vec![vec![
                Datum::Word("theta_c_over_sigma".into()),
                Datum::Number(0.5),
            ]],
        };
        let shown = preview(&data).to_string();
        let (series, heading) = (letters("theta_c_over_sigma"), letters("theta0 (rad)"));
        assert!(
            shown.contains(&series) && shown.contains(&heading),
            "{shown}"
        );
        assert!(!shown.contains("theta"), "{shown}");
        assert!(data.csv(None).contains("theta_c_over_sigma"));
    }
}
