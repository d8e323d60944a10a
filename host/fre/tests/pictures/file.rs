//! What every picture has: letters, titles, descriptions, themes and files.

use fre::draw::{self, Chart, Ink, Panel, Scene, Theme};

use crate::reading::{TURNING, chart, finger, share, texts};

#[test]
fn a_picture_needs_no_font_of_the_system() {
    let scene = finger("title", TURNING, 0.0, 0.0);
    let mut blank = scene.clone();
    blank.items.clear();
    let dark = |scene: &Scene| share(&draw::png(scene, 1.0, Theme::Light).unwrap(), Ink::Main);
    assert_eq!(dark(&blank), 0.0);
    assert!(dark(&scene) > 0.001, "letters are missing");
}

#[test]
fn both_themes_are_in_the_svg_and_on_request_in_the_png() {
    let scene = finger("title", TURNING, 0.0, 1.0);
    let svg = draw::svg(&scene);
    assert!(svg.contains("prefers-color-scheme:dark") && svg.contains(".f-front{fill:#0072b2}"));
    let [light, dark] = [Theme::Light, Theme::Dark].map(|theme| draw::png(&scene, 1.0, theme).unwrap());
    assert!(share(&light, Ink::Paper) > 0.4 && share(&dark, Ink::Paper) < 0.01);
}

#[test]
fn a_picture_file_has_the_format_of_its_ending() {
    let own = tempfile::tempdir().unwrap();
    let folder = own.path();
    let scene = chart(vec![[0.0, 0.0], [1.0, 1.0]]);
    draw::write(&scene, &folder.join("a.svg")).unwrap();
    draw::write(&scene, &folder.join("a.PNG")).unwrap();
    assert!(std::fs::read(folder.join("a.svg")).unwrap().starts_with(b"<svg"));
    assert!(std::fs::read(folder.join("a.PNG")).unwrap().starts_with(b"\x89PNG"));
    for (file, words) in [("a.pdf", ".svg or .png"), ("a", ".svg or .png"), ("no/such/a.svg", "cannot be written")] {
        let message = draw::write(&scene, &folder.join(file)).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
    assert!(draw::png(&scene, 1e6, Theme::Light).is_err() && draw::png(&scene, 0.0, Theme::Light).is_err());
}

#[test]
fn long_titles_are_broken_into_lines() {
    let title =
        "a finger with a name that is far longer than a picture of it is wide, and then some more of it to be sure";
    let words = texts(&finger(title, TURNING, 0.1, 1.0));
    assert!(words.iter().any(|word| word.starts_with("a finger with")) && !words.iter().any(|word| word == title));
    let mut chart = Chart::new(title, title, "x");
    chart.panels = vec![Panel::default()];
    assert!(texts(&chart.scene()).join(" ").contains(&format!("{title} {title}")));
}

#[test]
fn names_are_shown_as_they_are() {
    for name in ["finger*2", "*bold* _{sub}", "a_{b", r"back\*slash\\", "} *", "***"] {
        let words = texts(&finger(name, TURNING, 0.1, 1.0));
        assert!(words.iter().any(|word| word == name), "{name}: {words:?}");
        let mut chart = Chart::new(name, format!("{} at *α*", draw::literal(name)), "x");
        chart.panels = vec![Panel::default()];
        let words = texts(&chart.scene());
        let subtitle = format!("{name} at α");
        assert!(words.iter().any(|word| word == name) && words.contains(&subtitle), "{name}: {words:?}");
    }
    let words = texts(&finger("two\nlines\tand a tab", TURNING, 0.1, 1.0));
    assert!(words.iter().any(|word| word == "two lines and a tab"), "{words:?}");
}

#[test]
fn any_letters_make_a_well_formed_picture() {
    let name: String =
        ('\0'..='\u{ff}').chain(['\u{d7ff}', '\u{e000}', '\u{fffd}', '\u{fffe}', '\u{ffff}', '\u{1f600}']).collect();
    let scene = finger(&name, TURNING, 0.1, 1.0);
    // Parses the picture.
    texts(&scene);
    let svg = draw::svg(&scene);
    assert!(!svg.contains('\u{fffe}') && !svg.contains('\u{ffff}') && svg.contains('\u{fffd}'));
}

#[test]
fn descriptions_are_words_without_marks() {
    let chart = |title: &str, subtitle: &str| Chart::new(title, subtitle, "x").scene();
    let both = chart("Strain of finger*2", "*α* = 8°: *F*_{x} = 6.03 N").above(&chart("Force", ""));
    assert_eq!(both.description, "Strain of finger*2. α = 8°: Fx = 6.03 N. Force");
    assert!(draw::svg(&both).contains("<title>Strain of finger*2. α = 8°: Fx = 6.03 N. Force</title>"));
}
