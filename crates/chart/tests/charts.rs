//! Charts: their SVG is well formed and holds all texts, and odd data gives a chart without it.
#![allow(clippy::unwrap_used, reason = "a panic is a failing test")]

use ppnpack_chart::{Curve, Lines};

const SIZE: [u32; 2] = [640, 400];

fn lines() -> Lines {
    let odd = vec![
        [0.0, 0.0],
        [1.0, 10.0],
        [2.0, f64::NAN],
        [f64::INFINITY, 4.0],
        [3.0, 30.0],
        [1e300, 1.0],
    ];
    Lines {
        title: "Utilisation & time".to_owned(),
        x_label: "step".to_owned(),
        y_label: "%".to_owned(),
        curves: vec![
            Curve {
                name: "DBL <1>".to_owned(),
                points: odd,
            },
            Curve::default(),
        ],
    }
}

/// Every element is closed in order, and no attribute holds something that is not a number where one belongs.
fn assert_well_formed(svg: &str) {
    let mut open = Vec::new();
    for tag in svg.split('<').skip(1) {
        let (inside, text) = tag.split_once('>').unwrap();
        assert!(!text.contains('>'), "{tag}");
        if let Some(name) = inside.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name));
        } else if !inside.ends_with('/') {
            open.push(inside.split(' ').next().unwrap());
        }
        assert_eq!(inside.matches('"').count() % 2, 0, "{inside}");
        assert!(
            !inside.contains("NaN") && !inside.contains("inf"),
            "{inside}"
        );
    }
    assert!(open.is_empty(), "{open:?}");
}

#[test]
fn svg_is_well_formed_holds_all_texts_and_leaves_odd_values_out() {
    let svg = lines().to_svg(SIZE).unwrap();
    assert_well_formed(&svg);
    for text in [
        "Utilisation &amp; time",
        "DBL &lt;1&gt;",
        "\nstep\n",
        "\n%\n",
        "\n30\n",
    ] {
        assert!(svg.contains(text), "{text} is not in {svg}");
    }
    // One line before the gap, one point after it.
    assert_eq!(svg.matches("<circle").count(), 1);
    assert_eq!(svg, lines().to_svg(SIZE).unwrap());
}

#[test]
fn charts_without_data_or_room_are_still_charts() {
    for size in [SIZE, [1, 1], [40, 900]] {
        for chart in [Lines::default(), lines()] {
            assert_well_formed(&chart.to_svg(size).unwrap());
        }
    }
}
