//! The report as one HTML page that needs nothing else.

mod facts;
mod modes;
mod queries;
mod refit;
mod tightness;

use super::content::Content;
use super::text::escaped;
use crate::plot::{self, Line, Plot};

/// A picture of the asset.
pub struct Picture {
    /// What it shows.
    pub caption: String,
    /// Its file.
    pub png: Vec<u8>,
}

/// The page; `pictures` are of the asset.
pub fn page(content: &Content, pictures: &[Picture]) -> String {
    let mut page = Page::default();
    page.head(content);
    page.pictures(pictures);
    page.verdict(content);
    page.made(content);
    page.advice(content);
    page.samples(content);
    page.modes(content);
    page.refit(content);
    page.tightness(content);
    page.depth(content);
    page.bytes(content);
    page.margin(content);
    page.foot(content);
    let title = escaped(&content.file);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\
         <title>{title}: report</title>\n<style>\n{}{}</style></head>\n<body>\n{}</body></html>\n",
        include_str!("../style.css"),
        plot::style(),
        page.body
    )
}

#[derive(Default)]
struct Page {
    body: String,
}

impl Page {
    fn line(&mut self, text: &str) {
        self.body += text;
        self.body.push('\n');
    }

    fn heading(&mut self, text: &str) {
        self.line(&format!("<h2>{}</h2>", escaped(text)));
    }

    fn text(&mut self, text: &str) {
        self.line(&format!("<p>{}</p>", prose(text)));
    }

    fn soft(&mut self, text: &str) {
        self.line(&format!("<p class=\"soft\">{}</p>", prose(text)));
    }

    fn open(&mut self) {
        self.line("<div class=\"row\">");
    }

    fn close(&mut self) {
        self.line("</div>");
    }

    fn plot(&mut self, plot: &Plot) {
        if let Some(svg) = plot.svg() {
            let title = escaped(&plot.title);
            let key = |(k, name): (usize, &str)| {
                format!(
                    "<span class=\"key\"><i style=\"background:{}\"></i>{}</span>",
                    plot::key_background(k),
                    escaped(name)
                )
            };
            let mut keys: String = plot.keys().map(key).collect();
            if let Some(mark) = &plot.mark {
                let name = escaped(&mark.name);
                keys += &format!("<span class=\"key\"><i class=\"stretch\"></i>{name}</span>");
            }
            self.line(&format!(
                "<figure role=\"img\" aria-label=\"{title}\"><figcaption>{title}</figcaption>{keys}{svg}</figure>"
            ));
        }
    }

    /// A row for each of `rows`, a column for each head and what stands below it; the first `texts` columns are
    /// text, the others numbers. Tables of few numbers lie side by side, as plots do.
    fn table<R>(&mut self, rows: &[R], texts: usize, columns: &[Column<'_, R>]) {
        let line = |tag: &str, text: &dyn Fn(&Column<'_, R>) -> String| -> String {
            let cell = |(k, column): (usize, &Column<'_, R>)| {
                let class = if k < texts { " class=\"text\"" } else { "" };
                let mut text = text(column);
                if tag == "td" && k >= texts {
                    text = unbroken(&text);
                }
                format!("<{tag}{class}>{}</{tag}>", escaped(&text))
            };
            columns.iter().enumerate().map(cell).collect()
        };
        let head = line("th", &|(head, _)| head.to_string());
        let class = match texts == 0 && columns.len() <= SMALL {
            true => "small table",
            false => "table",
        };
        let mut text = format!(
            "<div class=\"{class}\" tabindex=\"0\"><table><thead><tr>{head}</tr></thead><tbody>"
        );
        for row in rows {
            text += &format!("<tr>{}</tr>", line("td", &|(_, cell)| cell(row)));
        }
        self.line(&(text + "</tbody></table></div>"));
    }
}

/// The most columns of numbers that fit below a plot, and on a phone.
const SMALL: usize = 5;

/// A number whose line does not end before its unit.
fn unbroken(number: &str) -> String {
    number.replace(" %", "\u{202f}%")
}

/// Sentences: what stands between backticks as code, and lines that do not end within the name of an option, as they
/// would behind its hyphens.
fn prose(text: &str) -> String {
    let mut parts = text.split('`');
    let mut html = words(parts.next().unwrap_or_default());
    while let Some(code) = parts.next() {
        match parts.next() {
            Some(after) => html += &format!("<code>{}</code>{}", words(code), words(after)),
            // A backtick of its own.
            None => html += &format!("`{}", words(code)),
        }
    }
    html
}

/// Words of a sentence.
fn words(text: &str) -> String {
    let word = |word: &str| match word.trim_start_matches('(').starts_with("--") {
        true => format!("<span class=\"option\">{}</span>", escaped(word)),
        false => escaped(word),
    };
    text.split(' ').map(word).collect::<Vec<_>>().join(" ")
}

/// The head of a column, and what a row has there.
type Column<'a, R> = (&'a str, &'a dyn Fn(&R) -> String);

/// A line through a point of each row.
fn line<R>(name: &str, rows: &[R], point: impl Fn(&R) -> (f64, f64)) -> Line {
    Line {
        name: name.to_string(),
        points: rows.iter().map(point).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::prose;

    #[test]
    fn commands_in_sentences_are_code() {
        for (text, html) in [
            (
                "`bdtree-build … --advise` measures <both> & finds (--modes 3).",
                "<code>bdtree-build … <span class=\"option\">--advise</span></code> measures &lt;both&gt; &amp; finds \
                 <span class=\"option\">(--modes</span> 3).",
            ),
            (
                "Run `a<b>`, then `c`.",
                "Run <code>a&lt;b&gt;</code>, then <code>c</code>.",
            ),
            ("Mode 3 \"a`b\" moves.", "Mode 3 &quot;a`b&quot; moves."),
            ("", ""),
        ] {
            assert_eq!(prose(text), html);
        }
    }
}
