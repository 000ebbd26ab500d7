//! Reports: tables and plots as HTML, Markdown and JSON.

pub mod html_report;
pub mod table;
