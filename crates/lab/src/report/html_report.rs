//! A report: one page that holds everything, and the same as files.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::{Value, json};

use super::table::{Table, escape};

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
    /// Pages beside the report, with their names.
    pub pages: Vec<PageLink>,
}

/// A page beside the report.
#[derive(Debug, Clone, PartialEq)]
pub struct PageLink {
    pub name: String,
    /// Its file, below the report's folder.
    pub file: String,
}

/// A plot, and the name of its file.
#[derive(Debug, Clone, PartialEq)]
pub struct Plot {
    pub file: &'static str,
    pub title: &'static str,
    pub note: String,
    pub svg: String,
    /// Whether it repeats another one for other pages, and so is left out of the report's own.
    pub is_extra: bool,
}

/// The colours and letters of the viewer's pages, for reports.
pub const STYLE: &str = include_str!("style.css");

impl Report {
    /// Writes `index.html`, `NAME.md`, `summary.json` and the plots.
    pub fn write(&self, folder: &Path) -> Result<(), String> {
        write(&folder.join("index.html"), &self.to_html())?;
        write(&folder.join(format!("{}.md", self.name)), &self.to_markdown())?;
        let summary = json!({
            "title": self.title,
            "machine": self.machine,
            "tables": self.tables.iter().map(Table::to_json).collect::<Vec<_>>(),
        });
        write(&folder.join("summary.json"), &format!("{summary:#}\n"))?;
        for plot in &self.plots {
            write(&folder.join(plot.file), &plot.svg)?;
        }
        Ok(())
    }

    fn machine_table(&self) -> Table {
        let mut table = Table::new("Machine and settings", "", &["what", "value"]);
        for (name, value) in &self.machine {
            let value = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
            table.rows.push(vec![name.replace('_', " "), value]);
        }
        table
    }

    fn to_html(&self) -> String {
        let figure = |plot: &Plot| {
            format!(
                "<figure>\n<h3>{}</h3>\n{}\n<figcaption>{}</figcaption>\n</figure>\n",
                escape(plot.title),
                plot.svg,
                escape(&plot.note)
            )
        };
        let words: String =
            self.words.iter().map(|words| format!("<p>{}</p>\n", escape(words))).collect();
        let figures: String = self.plots.iter().filter(|plot| !plot.is_extra).map(figure).collect();
        let tables: String = self.tables.iter().map(Table::to_html).collect();
        let pages = self.pages_list();
        format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n\
             {words}{figures}{pages}{tables}{}</body>\n</html>\n",
            self.machine_table().to_html(),
            title = escape(self.title),
        )
    }

    fn pages_list(&self) -> String {
        if self.pages.is_empty() {
            return String::new();
        }
        let item = |page: &PageLink| {
            format!("<li><a href=\"{}\">{}</a></li>\n", escape(&page.file), escape(&page.name))
        };
        let items: String = self.pages.iter().map(item).collect();
        format!("<h3>Each mesh with its hulls, to be turned</h3>\n<ul>\n{items}</ul>\n")
    }

    fn to_markdown(&self) -> String {
        let mut text = format!("# {}\n\n", self.title);
        self.words.iter().for_each(|words| text += &format!("{words}\n\n"));
        for Plot { title, file, note, .. } in self.plots.iter().filter(|plot| !plot.is_extra) {
            text += &format!("## {title}\n\n![{title}]({file})\n\n{note}\n\n");
        }
        text += "## Tables\n\n";
        self.tables.iter().for_each(|table| text += &table.to_markdown());
        text + &self.machine_table().to_markdown()
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
    fn the_page_holds_its_plots_and_loads_nothing() {
        let plot = Plot {
            file: "a.svg",
            title: "A",
            note: "note".into(),
            svg: "<svg><text>inside</text></svg>".into(),
            is_extra: false,
        };
        let report = Report {
            title: "T & T",
            name: "benchmark",
            words: vec!["Word.".into()],
            machine: BTreeMap::from([("processor".to_owned(), json!("fast"))]),
            plots: vec![plot],
            tables: vec![Table::new("Tab", "", &["x"])],
            pages: Vec::new(),
        };
        let page = report.to_html();
        assert!(page.contains("<text>inside</text>") && page.contains("T &amp; T"));
        for loads in ["src=", "href=", "url(", "@import"] {
            assert!(!page.contains(loads), "{loads}");
        }
        let folder = tempfile::tempdir().unwrap();
        report.write(folder.path()).unwrap();
        let link = PageLink { name: "a <b>".into(), file: "pages/a.html".into() };
        let with_pages = Report { pages: vec![link], ..report };
        assert!(with_pages.to_html().contains("<a href=\"pages/a.html\">a &lt;b&gt;</a>"));
        for file in ["index.html", "benchmark.md", "summary.json", "a.svg"] {
            assert!(folder.path().join(file).is_file(), "{file}");
        }
    }
}
