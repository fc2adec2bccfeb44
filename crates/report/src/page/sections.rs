//! The chapters of the page, its contents, and the lists at its end.

use minijinja::{Value, context};

use super::cards::Cards;
use super::claim_links;
use super::engine::safe;
use super::ledger::each;
use crate::escape::html;
use crate::{Answer, Block, Document, Error, Notice, NoticeKind, Prose, Section, mathml, number};

/// Everything else that the page template needs.
pub(super) fn context(document: &Document, cards: &Cards<'_>) -> Result<Value, Error> {
    let lookup = cards.lookup;
    let lines =
        |items: &[Prose], place: &str| each(items, |item| lookup.inline(item, place).map(safe));
    let mut limits = Vec::new();
    for (id, title, items) in [
        ("synthetic", "What is synthetic", &document.synthetic),
        (
            "unpublished",
            "What is not published",
            &document.unpublished,
        ),
        (
            "out-of-scope",
            "What was not reproduced",
            &document.out_of_scope,
        ),
    ] {
        if !items.is_empty() {
            limits.push(context! { id, title, items => lines(items, title)? });
        }
    }
    let checklist = each(&document.checklist, |item| {
        Ok(context! {
            id => &item.id,
            source => &item.source,
            question => &item.question,
            answer => item.answer.word(),
            symbol => item.answer.symbol(),
            class => item.answer.class(),
            evidence => safe(lookup.inline(&item.evidence, &item.id)?),
        })
    })?;
    let answered = [Answer::Yes, Answer::Partly, Answer::No, Answer::Yours].map(|answer| {
        let items = document.checklist.iter();
        let count = items.filter(|item| item.answer == answer).count();
        context! { count, word => answer.word() }
    });
    let choices = each(&document.choices, |choice| {
        Ok(context! {
            subject => safe(lookup.inline(&choice.subject, "choices")?),
            taken => safe(lookup.inline(&choice.taken, "choices")?),
            status => choice.status.word(),
            sensitivity => safe(lookup.inline(&choice.sensitivity, "choices")?),
        })
    })?;
    let glossary = each(&document.glossary, |symbol| {
        Ok(context! {
            symbol => safe(mathml::render(&symbol.latex, false, "glossary")?),
            meaning => safe(lookup.inline(&symbol.meaning, "glossary")?),
            unit => number::unit(&symbol.unit),
        })
    })?;
    let sections = each(&document.sections, |section| section_view(section, cards))?;
    Ok(context! {
        contents => contents(document, !limits.is_empty()),
        sections,
        doubts => lines(&document.doubts, "doubts")?,
        limits,
        checklist,
        answered => answered.to_vec(),
        choices,
        glossary,
    })
}

/// The contents of the page, in its order.
fn contents(document: &Document, limits: bool) -> Vec<Value> {
    let entry = |id: &str, title: &str| context! { id, title };
    let mut out = Vec::new();
    let mut add = |there: bool, id: &str, title: &str| out.extend(there.then(|| entry(id, title)));
    add(!document.claims.is_empty(), "ledger", "Claims ledger");
    add(!document.deviations.is_empty(), "deviations", "Deviations");
    add(document.drift.is_some(), "changes", "What changed");
    add(
        !document.audit.is_empty(),
        "audit",
        "The paper’s own arithmetic",
    );
    for section in &document.sections {
        add(true, &section.id, &section.title);
    }
    add(
        !(document.doubts.is_empty() && document.controls.is_empty()),
        "doubts",
        "How this report could be wrong",
    );
    add(
        limits,
        "limits",
        "What is synthetic, unpublished or left out",
    );
    add(
        !document.checklist.is_empty(),
        "checklist",
        "Reviewer’s checklist",
    );
    add(
        !document.choices.is_empty(),
        "choices",
        "Reconstruction choices",
    );
    add(
        !document.glossary.is_empty(),
        "glossary",
        "Symbols and words",
    );
    add(true, "provenance", "Provenance");
    out
}

fn section_view(section: &Section, cards: &Cards<'_>) -> Result<Value, Error> {
    let place = format!("section {}", section.id);
    let mut body = String::new();
    for block in &section.blocks {
        body.push_str(&block_html(block, cards, &place)?);
        body.push('\n');
    }
    let method = section
        .method
        .as_ref()
        .map(|method| cards.lookup.paragraphs(method, &place).map(safe))
        .transpose()?;
    Ok(context! {
        id => &section.id,
        title => &section.title,
        status => &section.status,
        lead => safe(cards.lookup.paragraphs(&section.lead, &place)?),
        claims => claim_links(&section.claims, cards.lookup),
        method,
        body => safe(body),
    })
}

fn block_html(block: &Block, cards: &Cards<'_>, place: &str) -> Result<String, Error> {
    let lookup = cards.lookup;
    match block {
        Block::Heading(id, text) => Ok(format!("<h3 id=\"{}\">{}</h3>", html(id), html(text))),
        Block::Prose(prose) => lookup.paragraphs(prose, place),
        Block::List(items) => {
            let mut out = String::from("<ul class=\"points\">");
            for item in items {
                out.push_str(&format!("<li>{}</li>", lookup.inline(item, place)?));
            }
            out.push_str("</ul>");
            Ok(out)
        }
        Block::Figure(figure) => cards.figure(figure),
        Block::Table(table) => cards.table(table),
        Block::Equation(equation) => {
            let place = format!("equation {}", equation.id);
            Ok(format!(
                "<div class=\"equation\" id=\"{id}\"><div class=\"scroll\" role=\"group\" tabindex=\"0\" \
                 aria-label=\"Equation {id}\">{math}</div><p class=\"about\"><span class=\"id\">{id}</span> \
                 <span class=\"tag t-{status}\">{status}</span> {caption}</p></div>",
                id = html(&equation.id),
                math = mathml::render(&equation.latex, true, &place)?,
                status = equation.status.word(),
                caption = lookup.inline(&equation.caption, &place)?,
            ))
        }
        Block::Notice(notice) => notice_html(notice, cards, place),
        Block::Chain(chain) => cards.chain(chain),
    }
}

fn notice_html(notice: &Notice, cards: &Cards<'_>, place: &str) -> Result<String, Error> {
    let (kind, symbol) = match notice.kind {
        NoticeKind::Synthetic => ("synthetic", "◇"),
        NoticeKind::Finding => ("finding", "●"),
        NoticeKind::Caution => ("caution", "△"),
        NoticeKind::Refusal => ("refusal", "✕"),
        NoticeKind::Note => ("note", "i"),
    };
    Ok(format!(
        "<div class=\"notice {kind}\" role=\"note\"><p class=\"notice-title\"><span aria-hidden=\"true\">{symbol}</span> \
         {}</p>{}</div>",
        html(&notice.title),
        cards.lookup.paragraphs(&notice.body, place)?
    ))
}
