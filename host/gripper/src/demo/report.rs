//! The report: a page that needs nothing else, the same as Markdown, the pictures and the data.

use std::fmt::Write as _;
use std::path::PathBuf;

use maud::{DOCTYPE, PreEscaped, html};

use super::error::DemoError;
use super::lead::{CLOSED_DEG, OPEN_DEG};
use super::pictures;
use super::sample::Sample;
use super::seen::Seen;
use super::summary::Summary;
use super::task::{LOG, PRESET};
use fre::delimited::line;
use fre::draw::{self, Scene};
use fre::files::Folder;
use fre::study::model::physics_word;

/// A picture with its name and what to see in it.
struct Picture {
    name: &'static str,
    scene: Scene,
    caption: String,
}

/// Names of the files that a demonstration makes: its log and its report.
pub const FILES: [&str; 10] = [
    LOG,
    "report.html",
    "report.md",
    "estimates.csv",
    "finger.svg",
    "finger.png",
    "force.svg",
    "force.png",
    "time.svg",
    "time.png",
];

/// Writes everything but the log ([`FILES`]) into a folder; gives the files in the order in which a reader wants them.
///
/// # Errors
/// A file cannot be written or a picture not be drawn.
pub fn write(folder: &mut Folder, seen: &Seen, summary: &Summary) -> Result<Vec<String>, DemoError> {
    let pictures = pictures_of(seen, summary);
    let mut files: Vec<PathBuf> = Vec::new();
    let mut put = |name: &str, text: &str| {
        files.push(folder.write(name, text.as_bytes())?);
        Ok::<(), DemoError>(())
    };
    put("report.html", &html(&pictures, seen, summary))?;
    put("report.md", &markdown(&pictures, seen, summary))?;
    put("estimates.csv", &csv(seen))?;
    for Picture { name, scene, .. } in &pictures {
        let file = |format| draw::encode(scene, format, draw::Theme::Light);
        folder.write(&format!("{name}.svg"), &file(draw::Format::Svg)?)?;
        files.push(folder.write(&format!("{name}.png"), &file(draw::Format::Png)?)?);
    }
    Ok(files.iter().map(|path| path.display().to_string()).collect())
}

fn pictures_of(seen: &Seen, summary: &Summary) -> Vec<Picture> {
    let mut pictures = Vec::new();
    if let Some(scene) = pictures::finger(seen) {
        let off = summary.shape_off.map_or_else(String::new, |[off, angle]| {
            format!(" The front beams at {angle:.2}° lie within {off:.3} mm of each other.")
        });
        let caption = format!(
            "The deformed finger at the greatest force that the target has shown, and the reference at the same angle. \
             Arrows are forces on the object; a thin one belongs to one contact sample, and the two models have samples at \
             different places.{off}"
        );
        pictures.push(Picture { name: "finger", scene, caption });
    }
    pictures.push(Picture {
        name: "force",
        scene: pictures::force(seen),
        caption: format!(
            "Force over motor angle, and the target's force minus the references'. {} The band is what the target is \
             allowed.",
            "Percentages as in the table."
        ),
    });
    pictures.push(Picture {
        name: "time",
        scene: pictures::time(seen),
        caption: "Motor angle by the servo's position, force and cost of every tick on the target.".to_owned(),
    });
    pictures
}

const TITLE: &str = "Contact force from motor angle, on a Cortex-M7 in QEMU";

fn introduction(seen: &Seen, summary: &Summary) -> String {
    let cycles = match summary.cycles {
        1 => "once".to_owned(),
        more => format!("{more} times"),
    };
    format!(
        "The gripper's firmware {} ({}) read the position of a simulated XM430-W350-T over Dynamixel Protocol 2.0, moved it \
         {cycles} from {}° to {}° and back, and estimated the force of the finger {} on a cylinder from every position \
         (0.088° per count). The references follow the same positions on the PC at full resolution. Physics: {}. Greatest \
         force: {:.2} N.",
        seen.version.firmware,
        seen.version.board,
        OPEN_DEG.to_string().replace('-', "−"),
        CLOSED_DEG,
        PRESET,
        physics_word(seen.physics),
        summary.greatest_force
    )
}

fn markdown(pictures: &[Picture], seen: &Seen, summary: &Summary) -> String {
    let mut out = format!("# {TITLE}\n\n{}\n\n**{}**\n\n", introduction(seen, summary), summary.verdict());
    let row = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    out += &row(&Summary::COLUMNS.map(
        |[name, unit]| {
            if unit.is_empty() { name.to_owned() } else { format!("{name} ({unit})") }
        },
    ));
    out += "|---|---|---:|---:|---:|---:|---:|---:|\n";
    for cells in summary.rows() {
        out += &row(&cells);
    }
    let _ = writeln!(out, "\n{}\n", Summary::note());
    out += "| | |\n|---|---|\n";
    for (name, words) in summary.facts() {
        out += &row(&[name.trim().to_owned(), words]);
    }
    for Picture { name, caption, .. } in pictures {
        let _ = write!(out, "\n![{caption}]({name}.svg)\n\n{caption}\n");
    }
    out += "\nEvery report of the target is a line of [estimates.csv](estimates.csv).\n";
    out
}

fn html(pictures: &[Picture], seen: &Seen, summary: &Summary) -> String {
    let verdict = if summary.faults.is_empty() { "verdict good" } else { "verdict bad" };
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
                    p { (introduction(seen, summary)) }
                    p class=(verdict) { (summary.verdict()) }
                    div.wide {
                        table.numbers {
                            thead {
                                tr {
                                    @for [name, unit] in Summary::COLUMNS {
                                        th { (name) br; small { (unit) } }
                                    }
                                }
                            }
                            tbody {
                                @for cells in summary.rows() {
                                    tr {
                                        @for cell in cells { td { (cell) } }
                                    }
                                }
                            }
                        }
                    }
                    p.note { (Summary::note()) }
                    @for Picture { name, scene, caption } in pictures {
                        figure {
                            (PreEscaped(draw::svg_in_page(scene, &format!("{name}-"))))
                            figcaption { (caption) }
                        }
                    }
                    h2 { "The run" }
                    div.wide {
                        table.facts {
                            @for (name, words) in summary.facts() {
                                tr { th { (name.trim()) } td { (words) } }
                            }
                        }
                    }
                    p { "Every report of the target is a line of " a href="estimates.csv" { "estimates.csv" } "." }
                }
            }
        }
    };
    page.into_string()
}

const STYLE: &str = "\
:root{--paper:#fff;--ink:#1b1f24;--muted:#5b636c;--rule:#e3e6e9;--good:#0a7a4b;--bad:#b3261e}\
@media (prefers-color-scheme:dark){:root{--paper:#0f1419;--ink:#e6eaee;--muted:#9aa4ae;--rule:#2a3138;--good:#3fcfa5;--bad:#ff8a80}}\
body{margin:0;background:var(--paper);color:var(--ink);font:16px/1.5 'Noto Sans','Helvetica Neue',Helvetica,Arial,sans-serif}\
main{max-width:1100px;margin:0 auto;padding:1.5rem 1rem 4rem}\
h1{font-size:1.5rem;line-height:1.25;margin:0 0 .75rem}h2{font-size:1.15rem;margin:2rem 0 .5rem}\
p{max-width:75ch}.note,figcaption{color:var(--muted);font-size:.9rem;max-width:85ch}\
.verdict{font-weight:600}.good{color:var(--good)}.bad{color:var(--bad)}\
.wide{overflow-x:auto}table{border-collapse:collapse;font-variant-numeric:tabular-nums}\
th,td{padding:.25rem .9rem .25rem 0;text-align:left;vertical-align:top;border-bottom:1px solid var(--rule)}\
th{font-weight:600}thead th{vertical-align:bottom;line-height:1.25}small{color:var(--muted);font-weight:400}\
.numbers th:nth-child(n+3),.numbers td:nth-child(n+3){text-align:right;padding:.25rem 0 .25rem 1.2rem}\
.facts th{white-space:nowrap}\
figure{margin:1.75rem 0}figure svg{max-width:100%;height:auto;display:block}a{color:inherit}";

/// One line per report. Numbers that are not known are empty.
fn csv(seen: &Seen) -> String {
    let each = seen.pace.instructions_per_tick(seen.version.cost_hz);
    let columns = [
        "time_s",
        "sequence",
        "position_counts",
        "motor_angle_deg",
        "direction",
        "cycle",
        "status",
        "force_x_n",
        "force_y_n",
        "force_n",
        "trapezoid_force_x_n",
        "trapezoid_force_y_n",
        "trapezoid_force_n",
        "paper_force_x_n",
        "paper_force_y_n",
        "paper_force_n",
        "motor_torque_nmm",
        "present_current_ma",
        "iterations",
        "age_ticks",
        "cost_ticks",
        "cost_instructions",
        "force_x_per_deg_n",
        "force_y_per_deg_n",
        "standard_deviation_n",
    ];
    let mut out = line(columns);
    let pair = |force: Option<[f64; 2]>| {
        force.map_or_else(Default::default, |[x, y]| [x, y, x.hypot(y)].map(|component| format!("{component:.6}")))
    };
    for sample in &seen.samples {
        let Sample { report, time_s, angle_deg, way, cycle, references } = sample;
        let estimate = &report.estimate;
        let [force, trapezoid, paper] = [Some(sample.force()), references[0], references[1]].map(pair);
        let head = [
            format!("{time_s:.6}"),
            report.sequence.to_string(),
            report.position.to_string(),
            format!("{angle_deg:.6}"),
            way.word().to_owned(),
            cycle.to_string(),
            estimate.status.to_string(),
        ];
        let tail = [
            format!("{:.4}", estimate.torque),
            format!("{:.2}", report.current),
            estimate.iterations.to_string(),
            estimate.age.to_string(),
            report.cost.to_string(),
            each.map_or_else(String::new, |each| format!("{:.0}", each * f64::from(report.cost))),
            format!("{:.6}", estimate.force_per_angle[0].to_radians()),
            format!("{:.6}", estimate.force_per_angle[1].to_radians()),
            format!("{:.6}", estimate.standard_deviation),
        ];
        out += &line(head.into_iter().chain(force).chain(trapezoid).chain(paper).chain(tail));
    }
    out
}
