//! Tables that can be shown as HTML, Markdown and JSON.

use serde_json::{Map, Value, json};

/// A table with a heading, and words about it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    pub title: String,
    pub note: String,
    pub header: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

/// Stands where there is no number.
pub const NOTHING: &str = "–";

impl Table {
    pub fn new(title: &str, note: &str, header: &[&str]) -> Self {
        Self {
            title: title.into(),
            note: note.into(),
            header: header.iter().map(|&cell| cell.into()).collect(),
            rows: Vec::new(),
        }
    }

    pub fn to_markdown(&self) -> String {
        let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
        let mut text = format!("### {}\n\n", self.title);
        if !self.note.is_empty() {
            text += &format!("{}\n\n", self.note);
        }
        text += &line(&self.header);
        text += &format!("|{}\n", "---|".repeat(self.header.len()));
        self.rows.iter().for_each(|row| text += &line(row));
        text + "\n"
    }

    pub fn to_html(&self) -> String {
        let line = |cells: &[String], tag: &str| {
            let cells: String =
                cells.iter().map(|cell| format!("<{tag}>{}</{tag}>", escape(cell))).collect();
            format!("<tr>{cells}</tr>\n")
        };
        let rows: String = self.rows.iter().map(|row| line(row, "td")).collect();
        format!(
            "<h3>{}</h3>\n<p>{}</p>\n<table>\n<thead>{}</thead>\n<tbody>\n{rows}</tbody>\n</table>\n",
            escape(&self.title),
            escape(&self.note),
            line(&self.header, "th"),
        )
    }

    pub fn to_json(&self) -> Value {
        let row = |row: &Vec<String>| -> Value {
            let cells = self.header.iter().cloned().zip(row);
            Value::Object(cells.map(|(name, cell)| (name, value(cell))).collect::<Map<_, _>>())
        };
        let rows: Vec<Value> = self.rows.iter().map(row).collect();
        json!({ "title": self.title, "note": self.note, "rows": rows })
    }
}

fn value(cell: &str) -> Value {
    match cell.parse::<f64>() {
        Ok(number) if number.is_finite() => json!(number),
        _ if cell == NOTHING => Value::Null,
        _ => json!(cell),
    }
}

pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A number in about three digits.
pub fn number(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        size if size >= 100.0 => format!("{value:.0}"),
        size if size >= 10.0 => format!("{value:.1}"),
        size if size >= 1.0 => format!("{value:.2}"),
        size if size >= 0.1 => format!("{value:.3}"),
        size if size >= 0.01 => format!("{value:.4}"),
        size if size >= 1e-4 => format!("{value:.5}"),
        _ => format!("{value:.1e}"),
    }
}

pub fn number_or_nothing(value: Option<f64>) -> String {
    value.map_or_else(|| NOTHING.into(), number)
}

pub fn count(value: Option<usize>) -> String {
    value.map_or_else(|| NOTHING.into(), |count| count.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_says_the_same_in_every_format() {
        let mut table = Table::new("T", "about <it>", &["method", "hulls"]);
        table.rows.push(vec!["surface".into(), number(12.345)]);
        table.rows.push(vec!["other".into(), NOTHING.into()]);
        assert!(table.to_markdown().contains("| surface | 12.3 |"));
        assert!(table.to_html().contains("<td>12.3</td>"));
        assert!(table.to_html().contains("about &lt;it&gt;"));
        assert_eq!(table.to_json()["rows"][0]["hulls"], 12.3);
        assert_eq!(table.to_json()["rows"][1]["hulls"], Value::Null);
    }
}
