//! The report as one page that needs nothing else.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::bars;
use super::row::Row;
use super::table::{self, Table};
use super::variant::{EXTENDED_FULL, variants};
use crate::draw::{self, FingerPicture};

const TITLE: &str = "The paper's twenty cases";

/// The page.
pub(super) fn html(rows: &[Row]) -> String {
    let mut tables = table::tables(rows).into_iter();
    let summary = tables.next();
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (TITLE) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                main {
                    h1 { (TITLE) }
                    @for note in table::notes() {
                        p { (with_symbols(&note)) }
                    }
                    @if let Some(summary) = &summary { (table_markup(summary)) }
                    figure.wide {
                        (PreEscaped(draw::svg_in_page(&bars::scene(rows), "bars-")))
                        figcaption {
                            "Deviation of the front beams and error of the net force, per case, on a logarithmic scale. A cross: not \
                             compared, because one of the two has no trustworthy solution or is on another branch (the tables say \
                             which)."
                        }
                    }
                    h2 { "Deformed fingers" }
                    p {
                        "By " (variants()[EXTENDED_FULL].name) ". Arrows are forces on the object, to the scale in each picture: a \
                         thin one belongs to one contact sample, the thick one is their sum."
                    }
                    div.fingers {
                        @for (index, row) in rows.iter().enumerate() {
                            figure { (finger(row, index)) }
                        }
                    }
                    @for table in tables { (table_markup(&table)) }
                }
            }
        }
    };
    page.into_string()
}

/// The deformed finger of a case; its status where there is no trustworthy solution.
fn finger(row: &Row, index: usize) -> Markup {
    let name = row.name();
    let Some(place) = row.place(EXTENDED_FULL) else { return Markup::default() };
    let Some(state) = &place.state else {
        return html! {
            p.bad { b { (name) } ", " (place.at) ": " (place.status) " – there is no trustworthy solution to draw." }
        };
    };
    let scene = FingerPicture {
        title: name,
        subtitle: format!("{}, {}", variants()[EXTENDED_FULL].name, place.status),
        design: &row.case.finger.design,
        motion: row.case.path.motion,
        coordinate: row.case.path.coordinate(place.at.value()),
        object: row.case.object,
        friction: 0.0,
        shape: &state.shape,
        force: Some(state.force_n),
    }
    .scene();
    PreEscaped(draw::svg_in_page(&scene, &format!("f{index}-")))
}

fn table_markup(Table { title, groups, columns, rows }: &Table) -> Markup {
    // Where a group begins, a wider gap sets it apart.
    let begins: Vec<usize> = groups.iter().scan(0, |at, (_, count)| Some(std::mem::replace(at, *at + count))).collect();
    let class = |column: usize| (column > 0 && begins.contains(&column)).then_some("first");
    html! {
        h2 { (with_symbols(title)) }
        div.wide {
            table {
                thead {
                    @if !groups.is_empty() {
                        tr.groups {
                            @for (name, count) in groups {
                                // Columns without a common name have an empty cell above them, which is not a heading.
                                @if name.is_empty() { td colspan=(count) {} } @else { th colspan=(count) { (name) } }
                            }
                        }
                    }
                    tr {
                        @for (index, column) in columns.iter().enumerate() {
                            th class=[class(index)] { (column) }
                        }
                    }
                }
                tbody {
                    @for cells in rows {
                        tr {
                            @for (index, cell) in cells.iter().enumerate() {
                                td class=[class(index)] { (cell) }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// A text with the paper's symbol as it is printed.
fn with_symbols(text: &str) -> Markup {
    html! {
        @for (index, part) in text.split("x_f").enumerate() {
            @if index > 0 { i { "x" } sub { "f" } }
            (part)
        }
    }
}

/// The look of a report, light and dark, on screen and on paper.
pub const STYLE: &str = "\
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
