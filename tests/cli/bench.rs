//! `sunfleck bench` on a tiny picture.

use crate::program::Studio;
use std::collections::BTreeMap;

type Row = BTreeMap<String, String>;

fn rows(studio: &Studio, name: &str) -> Vec<Row> {
    let mut reader = csv::Reader::from_path(studio.path(name)).unwrap();
    reader.deserialize().map(Result::unwrap).collect()
}

fn number(row: &Row, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column} of {row:?}"))
}

/// Slow in no sense: 8 x 6 pixels.
const TINY: &str = "bench scene.ron --bounces 0 --size 8x6 --rounds 2 --longest 0.3 --reference-samples 256";

#[test]
fn all_methods_come_to_the_same_picture() {
    let studio = Studio::new();
    // This is no race: the effort is bounded, and no machine is as slow as the clock allows.
    let unhurried = "bench scene.ron --bounces 0 --size 8x6 --rounds 2 --longest 3600 --most-samples 256 --reference-samples 512";
    let outcome = studio.succeed(&format!("{unhurried} --csv a/b.csv --svg a/b.svg"));
    let rows = rows(&studio, "a/b.csv");
    for method in ["march", "march-jittered", "equiangular", "segments", "slices", "slices-until"] {
        assert!(outcome.out.contains(method), "{}", outcome.out);
        let own: Vec<_> = rows.iter().filter(|row| row["method"] == method).collect();
        assert!(own.len() >= 3, "{method}: {} points", own.len());
        let noisy = |row: &Row| number(row, "rmse_with_reference_noise");
        let best = own.iter().map(|row| noisy(row)).fold(f64::INFINITY, f64::min);
        // With the reference's noise in it, about 0.001 here.
        assert!(best < 0.004, "{method} comes no nearer than {best}");
        assert!(own.iter().map(|row| noisy(row)).fold(0.0, f64::max) > 2.0 * best, "{method}: effort helps");
        for row in own {
            assert!(number(row, "samples") <= 256.0, "{row:?}");
            assert!(number(row, "cpu_s") > 0.0 && number(row, "cpu_spread") >= 0.0);
            assert!(number(row, "mean_abs") <= noisy(row) && noisy(row) <= number(row, "max"));
            assert!(number(row, "p99") <= number(row, "max"));
        }
    }
}

/// The reference is by random walks, which come to it with more samples; the field comes near at once.
#[test]
fn all_light_is_measured_where_nobody_says_otherwise() {
    let studio = Studio::new();
    let flags = "--size 8x6 --rounds 1 --longest 3600 --most-samples 64 --reference-samples 1024";
    let outcome = studio.succeed(&format!(
        "bench scene.ron {flags} --methods slices,slices-until,paths --csv e.csv --svg e.svg"
    ));
    assert!(outcome.out.contains("1024 samples a pixel, by random walks"), "{}", outcome.out);
    let rows = rows(&studio, "e.csv");
    let errors = |method: &str| {
        let own = rows.iter().filter(|row| row["method"] == method);
        own.map(|row| number(row, "rmse_with_reference_noise")).collect::<Vec<_>>()
    };
    let (walks, field) = (errors("paths"), errors("slices-until"));
    assert!(walks.first() > walks.last().map(|last| 2.0 * last).as_ref(), "{walks:?}");
    let best = field.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(best < 0.03, "{field:?}");
    studio.fail("bench scene.ron --methods literal", 2);
    studio.fail("bench scene.ron --methods paths --bounces 0", 2);
}

#[test]
fn the_literal_method_is_extrapolated_and_says_so_everywhere() {
    let studio = Studio::new();
    let outcome = studio.succeed(&format!("{TINY} --methods literal --csv b.csv --svg b.svg"));
    let rows = rows(&studio, "b.csv");
    assert_eq!(rows.len(), 1);
    assert_eq!((rows[0]["method"].as_str(), rows[0]["extrapolated"].as_str()), ("literal", "true"));
    // It sees what the march through the tree sees.
    let (_, deviation) = rows[0]["note"].split_once("differ by ").unwrap();
    let deviation: f64 = deviation.split_whitespace().next().unwrap().parse().unwrap();
    assert!(deviation < 1e-6, "{deviation}");
    assert!(outcome.out.contains("extrapolated from"), "{}", outcome.out);
    assert!(String::from_utf8(studio.bytes("b.svg")).unwrap().contains("(extrapolated)"));
}

#[test]
fn the_plot_is_whole_xml_and_has_the_peers() {
    let studio = Studio::new();
    let peers = "checkout:benches/peers/leaves500.csv";
    let line = format!("{TINY} --methods slices --peers {peers} --csv c.csv --svg c.svg");
    studio.succeed(&line);
    let svg = String::from_utf8(studio.bytes("c.svg")).unwrap();
    let mut open: Vec<&str> = Vec::new();
    for tag in svg.split('<').skip(1) {
        let (tag, _) = tag.split_once('>').unwrap();
        assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
        match tag.strip_prefix('/') {
            Some(name) => assert_eq!(open.pop(), Some(name)),
            None if tag.ends_with('/') => {}
            None => open.push(tag.split_whitespace().next().unwrap()),
        }
    }
    assert!(open.is_empty(), "{open:?} are not closed");
    for part in ["Cycles 5.0.1", "Mitsuba scalar 3.9.1", "slices"] {
        assert!(svg.contains(part), "{part}");
    }
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
    assert!(rows(&studio, "c.csv").iter().any(|row| row["note"] == "measured elsewhere"));
}

#[test]
fn a_picture_from_elsewhere_can_be_the_reference() {
    let studio = Studio::new();
    studio.succeed("render scene.ron --bounces 0 --size 8x6 --samples 512 --seed 3 --out reference.exr");
    let with = |more: &str| {
        format!(
            "bench scene.ron --bounces 0 --size 8x6 --quick --methods slices --csv d.csv --svg d.svg {more}"
        )
    };
    let outcome = studio.succeed(&with("--reference reference.exr --reference-noise 0.001"));
    assert!(outcome.out.contains("reference: from a file"), "{}", outcome.out);
    let refusal = studio.fail(&with("--reference reference.exr --size 9x6").replace("--size 8x6 ", ""), 2);
    assert!(refusal.contains("reference.exr") && refusal.contains("--size 8x6"), "{refusal}");
    studio.succeed("render tiny.ron --frames 3 --size 8x6 --samples 1 --out third.exr");
    let refusal = studio.fail(&with("--reference third.exr"), 2);
    assert!(refusal.contains("third.exr") && refusal.contains("--frame 3"), "{refusal}");
    studio.fail(&with("--reference nowhere.exr"), 4);
    studio.fail(&with("--reference-noise 0.001"), 2);
}

#[test]
fn what_cannot_be_measured_is_refused_with_a_remedy() {
    let studio = Studio::new();
    for (flags, code, told) in [
        ("--frame 99", 2, "there is no frame 99"),
        ("--size 0x6", 2, "--size"),
        ("--rounds 0", 2, "--rounds"),
        ("--longest -1", 2, "--longest"),
        ("--methods magic", 2, "--methods"),
        ("--peers nowhere.csv", 4, "nowhere.csv"),
        ("--peers tiny.ron", 3, "tiny.ron:1:1: error: the column `renderer` is missing"),
        ("--csv /proc/nothing/b.csv", 4, "/proc/nothing/b.csv"),
    ] {
        let refusal = studio.fail(&format!("bench tiny.ron {flags}"), code);
        assert!(refusal.contains(told), "{flags}: {refusal}");
    }
}
