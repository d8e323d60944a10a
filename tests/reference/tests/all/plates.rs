//! The plate factor against finite elements in three dimensions (`plates.csv`; `cargo xtask bench plates` makes them again).

use reference_tests::plates::{Span, spans};

/// Within 1 %, whether the constants were chosen with it or not, from beams as wide as thick to plates.
#[test]
fn the_plate_factor_is_that_of_finite_elements() {
    let mut worst = [0.0_f64; 2];
    let mut rows = [0; 2];
    for (span, factor, fitted) in spans().filter(|(span, ..)| span.curvature == 0.0) {
        let error = span.formula() / factor - 1.0;
        let kind = usize::from(fitted);
        (worst[kind], rows[kind]) = (worst[kind].max(error.abs()), rows[kind] + 1);
        assert!(error.abs() < 0.01, "{span:?}: {} for {factor}", span.formula());
    }
    println!(
        "not fitted {} rows within {:.2} %, fitted {} within {:.2} %",
        rows[0],
        100.0 * worst[0],
        rows[1],
        100.0 * worst[1]
    );
    assert!(rows[0] > 2 * rows[1] && rows[1] > 20, "{rows:?}");
}

/// Curvature keeps a wall from curling, which the model does not have: little between ribs, much in a long wall without any.
#[test]
fn curvature_stiffens_spans_between_ribs_little() {
    let straight: Vec<(Span, f64)> = spans().filter(|row| row.0.curvature == 0.0).map(|row| (row.0, row.1)).collect();
    let rise = |bent: &Span| {
        let same = |(span, _): &&(Span, f64)| *span == Span { curvature: 0.0, ..*bent };
        let factor = straight.iter().find(same).expect("the same span, hardly bent").1;
        move |bent: f64| bent / factor - 1.0
    };
    let mut rows = 0;
    for (span, factor, _) in spans().filter(|(span, ..)| span.curvature > 0.0) {
        let rise = rise(&span)(factor);
        println!("{span:?}: {:+.2} %", 100.0 * rise);
        assert!(rise > 0.0 && (span.clear > 8.0 || rise < 0.015), "{span:?}: {rise}");
        rows += 1;
    }
    assert!(rows > 9, "{rows}");
}
