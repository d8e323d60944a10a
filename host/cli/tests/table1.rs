//! `fre table1`: the twenty cases of *Geometrico-Static Modelling of a FRE Finger*.

mod said;

use std::process::Command;

use fre::files::Files;
use fre::study::model::physics_word;
use fre::study::run::{self, Run};
use fre::study::table1::{
    self, APPROACH_DEG, Agreement, CASES, COMPARED, EXTENDED_FULL, EXTENDED_REDUCED, SERIES, variants,
};
use model_core::status::Status;

#[test]
fn first_contact_is_where_it_is_said_to_be() {
    for series in SERIES {
        let mut case = series.case().unwrap();
        let touch = series.angles_deg[0] - APPROACH_DEG;
        case.path.places = vec![touch - 1.0, touch - 0.001, touch + 0.05];
        let solved = run::solve(&case, &Default::default()).unwrap();
        let statuses: Vec<Status> = solved.places.iter().map(|place| place.status).collect();
        assert_eq!(statuses, [Status::NoContact, Status::NoContact, Status::Converged], "{}", series.name(0));
        // Samples stand on the beam at distances of a few millimetres.
        let arc = solved.places[2].state.as_ref().unwrap().shape.contacts[0].arc;
        assert!((arc - series.height_mm).abs() < 2.5, "{arc} is not {}", series.height_mm);
    }
}

#[test]
fn every_model_has_twenty_rows_with_their_statuses() {
    let rows = table1::solve().unwrap();
    assert_eq!(rows.len(), CASES);
    let angles: Vec<f64> = rows.iter().map(|row| row.series.angles_deg[row.angle]).collect();
    let paper = [11, 13, 15, 17, 12, 15, 17, 19, 13, 15, 17, 19, 18, 20, 22, 24, 22, 24, 26, 28];
    assert_eq!(angles, paper.map(f64::from));
    for row in &rows {
        assert_eq!((row.runs.len(), row.snapped.len()), (4, 4));
        for (run, model) in row.runs.iter().zip(variants()) {
            let place = &run.places[0];
            assert_eq!(place.at.value(), row.series.angles_deg[row.angle]);
            assert_eq!(place.state.is_some(), place.status.is_trustworthy());
            let full = model.name.ends_with("170/20");
            assert_eq!(run.model.elements_per_beam == 170, full, "{}", model.name);
            assert!(model.name.starts_with(physics_word(run.model.physics)), "{}", model.name);
        }
    }
    let csv = table1::csv(&rows);
    for model in variants() {
        assert_eq!(csv.lines().filter(|line| line.split(',').nth(4) == Some(model.name)).count(), CASES);
    }
    assert_eq!(csv.lines().count(), 1 + 4 * CASES);
    // The reduced model is judged by the accurate one of its physics: the design allows 1.5 %.
    let mut compared = 0;
    for row in &rows {
        if let Agreement::Same { shape, force_percent } = row.compare(EXTENDED_REDUCED, EXTENDED_FULL) {
            compared += 1;
            assert!(force_percent.abs() < 1.5 && shape.max < 0.3 && shape.mean <= shape.max, "{}", row.name());
        }
    }
    assert!(compared >= 15, "{compared}");
}

#[test]
fn what_cannot_be_trusted_is_named_and_not_compared() {
    let mut rows = table1::solve().unwrap();
    let lost = &mut rows[3].runs[EXTENDED_FULL].places[0];
    (lost.status, lost.state) = (Status::Folded, None);
    rows[7].snapped[EXTENDED_REDUCED] = !rows[7].snapped[EXTENDED_FULL];
    assert_eq!(rows[3].compare(EXTENDED_REDUCED, EXTENDED_FULL), Agreement::None);
    assert_eq!(rows[7].compare(EXTENDED_REDUCED, EXTENDED_FULL), Agreement::OtherBranch);
    let text = table1::markdown(&rows);
    let line = |table: &str, case: &str| {
        let rest = &text[text.find(table).unwrap()..];
        rest.lines().find(|line| line.starts_with(&format!("| {case} "))).unwrap().to_owned()
    };
    let forces: Vec<String> =
        line("## Net force", "Ø80 High α4").split('|').map(|cell| cell.trim().to_owned()).collect();
    assert_eq!(forces[5], "folded", "{forces:?}");
    let deviations = ["Ø80 High α4", "Ø80 Mid α4"].map(|case| line("## Deviation", case));
    snapbox::assert_data_eq!(
        said::words(&deviations.join("\n")),
        snapbox::str![[r#"
| Ø# High α# | # | # | # | folded | – | – | folded | – | – |
| Ø# Mid α# | # | # | # | other branch | – | – | # | # | # |
"#]]
    );
    assert_page(&text);
    assert!(text.contains("18 of 20") && !text.contains("NaN"), "{text}");
    // All lines of a Markdown table have as many cells.
    for table in text.split("\n## ").skip(1) {
        let cells: Vec<usize> =
            table.lines().filter(|line| line.starts_with('|')).map(|l| l.matches('|').count()).collect();
        assert!(cells.len() > 4 && cells.iter().all(|count| *count == cells[0]), "{table}");
    }
    let own = tempfile::tempdir().unwrap();
    let folder = own.path();
    let mut outputs = Files::new(false).folder(folder, &table1::FILES, "the report").unwrap();
    let files = table1::write(&mut outputs, &rows).unwrap();
    let page = std::fs::read_to_string(&files[0]).unwrap();
    assert!(page.contains("<b>Ø80 High α4</b>, 17°: folded"));
    // One cross for every measure of every pair that is not compared.
    let bars = std::fs::read_to_string(folder.join("errors.svg")).unwrap();
    assert_eq!(strokes_of_crosses(&bars), 2 * 3 * 3);
}

/// docs/accuracy.md has the summary's figures.
#[test]
fn the_summary_is_the_one_that_the_documentation_quotes() {
    let text = table1::markdown(&table1::solve().unwrap());
    let summary = text.split("## Summary").nth(1).and_then(|rest| rest.split("\n## ").next()).unwrap();
    let quoted = include_str!("../../../docs/accuracy.md");
    let rows: Vec<_> = summary.lines().filter(|line| line.contains(" of 20 ")).collect();
    assert_eq!(rows.len(), 3);
    for row in rows {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let [_, pair, compared, mean, max, mean_force, max_force, ..] = cells[..] else { panic!("{row}") };
        let quote = format!("| {pair} | {compared} | {mean}, {max} | {mean_force}, {max_force} |");
        assert!(quoted.contains(&quote), "{quote}");
    }
}

/// That these are the page's words.
#[track_caller]
fn assert_page(text: &str) {
    snapbox::assert_data_eq!(
        words_of(text),
        snapbox::str![[r##"
# The paper's twenty cases

Motor angles are those of Table 1 in "Geometrico-Static Modelling of a FRE Finger", the paper. It prints neither the objects' positions nor the finger's dimensions: here first contact is 6° before α1, at High 60 mm, Mid 45 mm, Low 25 mm above the front beam's base, and the finger is the preset dhas-80, an approximation. The forces are therefore not the paper's and cannot be held against its measurements; what is compared is one model with another.

paper: inextensible beams, hinges from the centrelines, no rigid tip, plane stress; 170/20 by the scheme the paper defines. extended: stretch and shear of beams and hinges, hinges from the beams' faces, rigid tip, plates; 170/20 by the trapezoid scheme. reduced: the microcontroller's resolution. Each case is reached from the angle before it (α1 from 1° before contact); its time is that of this way, on one core, the fastest of three.

Deviation: nearest distance of a model's front nodes from the reference's front centreline; the mean is along x_f, the place on the beam. Force error: of the net force's magnitude. A case counts only where both models have a trustworthy solution and both have, or neither has, snapped through; all others are named by their status.

## Summary


## Net force and time


## Deviation along x_f and force error


"##]]
    );
}

/// The text without the rows of its tables, whose figures are the model's.
fn words_of(markdown: &str) -> String {
    markdown.lines().filter(|line| !line.starts_with('|')).fold(String::new(), |words, line| words + line + "\n")
}

/// Lines in a series' colour are those of crosses; the legend's are wider.
fn strokes_of_crosses(svg: &str) -> usize {
    svg.matches("class=\"s-series").count() - svg.matches("stroke-width=\"12\"").count()
}

#[test]
fn the_command_writes_a_page_that_needs_nothing_else() {
    let own = tempfile::tempdir().unwrap();
    // The command makes it.
    let folder = own.path().join("report");
    let output = Command::new(env!("CARGO_BIN_EXE_fre")).arg("table1").arg("--out").arg(&folder).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let lost = !table1::solve().unwrap().iter().flat_map(|row| &row.runs).all(Run::is_trustworthy);
    assert_eq!(output.status.code(), Some(if lost { 2 } else { 0 }), "{}", String::from_utf8_lossy(&output.stderr));
    assert_page(&text);
    let page = std::fs::read_to_string(folder.join("report.html")).unwrap();
    for reference in ["src=", "href=", "@import", "url(http", "<script"] {
        assert!(!page.contains(reference), "{reference}");
    }
    assert_eq!(page.matches("<svg").count() + page.matches("class=\"bad\"><b>").count(), CASES + 1);
    assert!(!page.contains("NaN"));
    // A comparison is named once, over its three measures.
    assert_eq!(page.matches("<th colspan=\"3\">paper reduced against paper 170/20</th>").count(), 1);
    assert!(!page.contains("x_f") && page.contains("<i>x</i><sub>f</sub>"));
    for row in page.split("<tr").skip(1).filter_map(|rest| rest.split("</tr>").next()) {
        let spans = row.matches("colspan=\"").count();
        let cells = row.matches("</td>").count() + row.matches("</th>").count();
        assert!(spans > 0 || [7, 10].contains(&cells), "{row}");
    }
    // Identifiers are the page's own, each once.
    let ids: Vec<&str> = page.match_indices(" id=\"").filter_map(|(at, _)| page[at + 5..].split('"').next()).collect();
    let different: std::collections::HashSet<&&str> = ids.iter().collect();
    assert!(ids.len() >= 15 && ids.len() == different.len(), "{ids:?}");
    let bars = std::fs::read_to_string(folder.join("errors.svg")).unwrap();
    let tree = roxmltree::Document::parse(&bars).unwrap();
    let rects = tree.descendants().filter(|n| n.attribute("class").is_some_and(|class| class.starts_with("f-series")));
    assert_eq!(rects.count() + strokes_of_crosses(&bars) / 2, 3 * COMPARED.len() * CASES);
    for name in ["table1.md", "table1.csv", "errors.png"] {
        assert!(std::fs::metadata(folder.join(name)).unwrap().len() > 1000, "{name}");
    }
}
