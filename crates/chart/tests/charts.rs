//! Charts: their SVG is well formed and holds all texts, and odd data gives a chart without it.
#![allow(clippy::unwrap_used, reason = "a panic is a failing test")]

use ppnpack_chart::{Bar, Bars, Curve, Interval, Lines, PlotPoint, PointSeries, Scatter};

const SIZE: [u32; 2] = [640, 400];

fn point(label: &str, x: f64, y: f64) -> PlotPoint {
    let y_interval = Some(Interval {
        low: y - 1.0,
        high: y + 1.0,
    });
    PlotPoint {
        label: label.to_owned(),
        x,
        y,
        x_interval: None,
        y_interval,
    }
}

fn scatter() -> Scatter {
    Scatter {
        title: "Compactness & time".to_owned(),
        x_label: "decision time (ms)".to_owned(),
        y_label: "compactness (%)".to_owned(),
        series: vec![
            PointSeries {
                name: "this run".to_owned(),
                reference: false,
                points: vec![point("SDFM", 1.5, 56.8), point("random <1>", 0.02, 39.9)],
            },
            PointSeries {
                name: "published".to_owned(),
                reference: true,
                points: vec![point("PPN-Pack", 430.0, 55.9)],
            },
        ],
    }
}

fn bars() -> Bars {
    let bar = |label: &str, value| Bar {
        label: label.to_owned(),
        value,
    };
    Bars {
        title: "Packed items".to_owned(),
        value_label: "items".to_owned(),
        bars: vec![
            bar("SDFM", 40.77),
            bar("lost", f64::NAN),
            bar("negative", -3.0),
        ],
    }
}

fn lines() -> Lines {
    let odd = vec![
        [0.0, 0.0],
        [1.0, 10.0],
        [2.0, f64::NAN],
        [f64::INFINITY, 4.0],
        [3.0, 30.0],
    ];
    Lines {
        title: "Utilisation".to_owned(),
        x_label: "step".to_owned(),
        y_label: "%".to_owned(),
        curves: vec![
            Curve {
                name: "DBL".to_owned(),
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
fn svg_is_well_formed_and_holds_all_texts() {
    let svg = scatter().to_svg(SIZE).unwrap();
    assert_well_formed(&svg);
    for text in [
        "Compactness &amp; time",
        "decision time (ms)",
        "compactness (%)",
        "\nthis run\n",
        "\npublished\n",
        "\nSDFM\n",
        "\nPPN-Pack\n",
        "random &lt;1&gt;",
        "\n0.1\n",
        "\n100\n",
    ] {
        assert!(svg.contains(text), "{text} is not in {svg}");
    }
    assert_eq!(svg, scatter().to_svg(SIZE).unwrap());
}

#[test]
fn odd_values_are_left_out() {
    let svg = lines().to_svg(SIZE).unwrap();
    assert_well_formed(&svg);
    // One line before the gap, one point after it.
    assert_eq!(svg.matches("stroke-width=\"2\"").count(), 1);
    assert_eq!(svg.matches("<circle").count(), 1);
    let svg = bars().to_svg(SIZE).unwrap();
    assert_well_formed(&svg);
    assert!(svg.contains("\n40.8\n") && svg.contains("\nlost\n"));

    let mut scatter = scatter();
    for (x, y) in [
        (0.0, 1.0),
        (-1.0, 1.0),
        (f64::NAN, 1.0),
        (1.0, f64::INFINITY),
        (1e300, 1.0),
    ] {
        scatter
            .series
            .first_mut()
            .unwrap()
            .points
            .push(point("odd", x, y));
    }
    let svg = scatter.to_svg(SIZE).unwrap();
    assert_well_formed(&svg);
    assert!(!svg.contains("odd"));
}

#[test]
fn charts_without_data_or_room_are_still_charts() {
    for size in [SIZE, [1, 1], [40, 900]] {
        for svg in [
            Scatter::default().to_svg(size),
            Lines::default().to_svg(size),
            Bars::default().to_svg(size),
            scatter().to_svg(size),
            lines().to_svg(size),
            bars().to_svg(size),
        ] {
            assert_well_formed(&svg.unwrap());
        }
    }
}
