//! Tables as Markdown and JSON, and reports of them.

use std::collections::BTreeMap;
use std::path::Path;

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

/// What a report says, whatever it is about.
#[derive(Default)]
pub struct Report {
    pub title: &'static str,
    /// Of its Markdown file, without the suffix.
    pub name: &'static str,
    /// Paragraphs before everything else.
    pub words: Vec<String>,
    pub machine: BTreeMap<String, Value>,
    pub plots: Vec<Plot>,
    pub tables: Vec<Table>,
}

/// A plot, and the name of its file.
#[derive(Debug, Clone, PartialEq)]
pub struct Plot {
    pub file: &'static str,
    pub title: &'static str,
    pub note: String,
    pub svg: String,
}

impl Report {
    /// Writes `NAME.md`, `summary.json` and the plots.
    pub fn write(&self, folder: &Path) -> Result<(), String> {
        write(&folder.join(format!("{}.md", self.name)), &self.to_markdown())?;
        let summary = json!({
            "title": self.title,
            "machine": self.machine,
            "tables": self.tables.iter().map(Table::to_json).collect::<Vec<_>>(),
        });
        write(&folder.join("summary.json"), &format!("{summary:#}\n"))?;
        self.plots.iter().try_for_each(|plot| write(&folder.join(plot.file), &plot.svg))
    }

    fn to_markdown(&self) -> String {
        let mut text = format!("# {}\n\n", self.title);
        self.words.iter().for_each(|words| text += &format!("{words}\n\n"));
        for Plot { title, file, note, .. } in &self.plots {
            text += &format!("![{title}]({file})\n\n{note}\n\n");
        }
        self.tables.iter().for_each(|table| text += &table.to_markdown());
        let mut machine = Table::new("Machine and settings", "", &["what", "value"]);
        for (name, value) in &self.machine {
            let value = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
            machine.rows.push(vec![name.replace('_', " "), value]);
        }
        text + &machine.to_markdown()
    }
}

/// Makes the folder of a report, if it is not there.
pub fn create_folder(path: &Path) -> Result<(), String> {
    std::fs::create_dir_all(path).map_err(|error| format!("{}: {error}", path.display()))
}

/// Writes a text file.
pub fn write(path: &Path, text: &str) -> Result<(), String> {
    std::fs::write(path, text).map_err(|error| format!("{}: {error}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_says_the_same_in_both_formats() {
        let mut table = Table::new("T", "about <it>", &["method", "hulls"]);
        table.rows.push(vec!["surface".into(), number(12.345)]);
        table.rows.push(vec!["other".into(), NOTHING.into()]);
        assert!(table.to_markdown().contains("| surface | 12.3 |"));
        assert_eq!(table.to_json()["rows"][0]["hulls"], 12.3);
        assert_eq!(table.to_json()["rows"][1]["hulls"], Value::Null);
    }
}
