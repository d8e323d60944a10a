//! The report as one page that needs nothing else.

use std::fmt::Write as _;

use super::table::{self, Table};
use super::{EXTENDED_FULL, Row, bars, variants};
use crate::draw::{self, FingerPicture};

const TITLE: &str = "The paper's twenty cases";

/// The page.
pub(super) fn html(rows: &[Row]) -> String {
    let mut out = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>{TITLE}</title>\n<style>{STYLE}</style>\n</head>\n\
         <body>\n<main>\n<h1>{TITLE}</h1>\n"
    );
    for note in table::notes() {
        let _ = writeln!(out, "<p>{}</p>", with_symbols(&note));
    }
    let mut tables = table::tables(rows).into_iter();
    if let Some(summary) = tables.next() {
        write_table(&mut out, &summary);
    }
    let _ = writeln!(
        out,
        "<figure class=\"wide\">\n{}<figcaption>Deviation of the front beams and error of the net force, per case, on a \
         logarithmic scale. A cross: not compared, because one of the two has no trustworthy solution or stands on another \
         branch (the tables say which).</figcaption>\n</figure>",
        draw::svg_in_page(&bars::scene(rows), "bars-")
    );
    let _ = writeln!(
        out,
        "<h2>Deformed fingers</h2>\n<p>By {}. Arrows are forces on the object, to the scale in each picture: thin ones belong \
         to a contact sample each, the thick one is their sum.</p>\n<div class=\"fingers\">",
        variants()[EXTENDED_FULL].name
    );
    for (index, row) in rows.iter().enumerate() {
        let _ = writeln!(out, "<figure>\n{}</figure>", finger(row, index));
    }
    out += "</div>\n";
    for table in tables {
        write_table(&mut out, &table);
    }
    out += "</main>\n</body>\n</html>\n";
    out
}

/// The deformed finger of a case; its status where there is no trustworthy solution.
fn finger(row: &Row, index: usize) -> String {
    let name = row.name();
    let Some(place) = row.place(EXTENDED_FULL) else { return String::new() };
    let Some(state) = &place.state else {
        return format!(
            "<p class=\"bad\"><b>{name}</b>, {}°: {} – there is no trustworthy solution to draw.</p>",
            place.at.value(),
            place.status
        );
    };
    let scene = FingerPicture {
        title: name,
        subtitle: format!("{}, {}", variants()[EXTENDED_FULL].name, place.status),
        design: &row.case.finger.design,
        motion: row.case.path.motion,
        coordinate: row.case.path.coordinate(place.at.value()),
        object: row.case.object,
        shape: &state.shape,
        force: Some(state.force_n),
    }
    .scene();
    draw::svg_in_page(&scene, &format!("f{index}-"))
}

fn write_table(out: &mut String, Table { title, groups, columns, rows }: &Table) {
    let _ = write!(out, "<h2>{}</h2>\n<div class=\"wide\"><table>\n<thead>", with_symbols(title));
    if !groups.is_empty() {
        *out += "<tr class=\"groups\">";
        for (name, count) in groups {
            // Over columns without a common name stands an empty cell, which is no head.
            let tag = if name.is_empty() { "td" } else { "th" };
            let _ = write!(out, "<{tag} colspan=\"{count}\">{}</{tag}>", escaped(name));
        }
        *out += "</tr>\n";
    }
    // Where a group begins, a wider gap sets it apart.
    let begins: Vec<usize> = groups.iter().scan(0, |at, (_, count)| Some(std::mem::replace(at, *at + count))).collect();
    let class = |column: usize| if column > 0 && begins.contains(&column) { " class=\"first\"" } else { "" };
    *out += "<tr>";
    for (index, column) in columns.iter().enumerate() {
        let _ = write!(out, "<th{}>{}</th>", class(index), escaped(column));
    }
    *out += "</tr></thead>\n<tbody>\n";
    for cells in rows {
        let cell = |(index, cell): (usize, &String)| format!("<td{}>{}</td>", class(index), escaped(cell));
        let cells: String = cells.iter().enumerate().map(cell).collect();
        let _ = writeln!(out, "<tr>{cells}</tr>");
    }
    *out += "</tbody>\n</table></div>\n";
}

/// Escaped, with the paper's symbol as it is printed.
fn with_symbols(text: &str) -> String {
    escaped(text).replace("x_f", "<i>x</i><sub>f</sub>")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

const STYLE: &str = "\
:root{--paper:#fff;--ink:#1b1f24;--muted:#5b636c;--rule:#e3e6e9;--bad:#b3261e}\
@media screen and (prefers-color-scheme:dark){:root{--paper:#0f1419;--ink:#e6eaee;--muted:#9aa4ae;--rule:#2a3138;--bad:#ff8a80}}\
body{margin:0;background:var(--paper);color:var(--ink);font:16px/1.5 'Noto Sans','Helvetica Neue',Helvetica,Arial,sans-serif}\
main{max-width:1100px;margin:0 auto;padding:1.5rem 1rem 4rem}\
h1{font-size:1.5rem;line-height:1.25;margin:0 0 .75rem}h2{font-size:1.15rem;margin:2rem 0 .5rem}\
p{max-width:85ch}figcaption{color:var(--muted);font-size:.9rem;max-width:85ch}.bad{color:var(--bad)}\
.wide{overflow-x:auto}table{border-collapse:collapse;font-size:.875rem;font-variant-numeric:tabular-nums}\
th,td{padding:.25rem 0 .25rem .9rem;text-align:right;vertical-align:bottom;border-bottom:1px solid var(--rule)}\
th:first-child,td:first-child{text-align:left;padding-left:0;white-space:nowrap}th{font-weight:600;line-height:1.25}\
.groups th,.groups td{border-bottom:0;padding-bottom:.1rem;text-align:left}.groups th{padding-left:2rem}.first{padding-left:2rem}\
sub{line-height:0}\
figure{margin:1.5rem 0}figure svg{max-width:100%;height:auto;display:block}figure.wide svg{min-width:760px}\
.fingers{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,500px),1fr));gap:0 1rem}\
.fingers figure{margin:.5rem 0}\
@media print{main{max-width:none;padding:0}.wide{overflow:visible}figure.wide svg{min-width:0}table{font-size:8pt}\
th,td{padding-left:.5rem}.groups th,.first{padding-left:.9rem}figure,tr{break-inside:avoid}h2{break-after:avoid}\
.fingers{grid-template-columns:1fr 1fr}}";
