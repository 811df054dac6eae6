//! README.md and docs/command-line.md say what is so.

use crate::checkout;
use crate::program::Studio;
use std::collections::BTreeSet;
use sunfleck::diagnostic::Loss;

fn page(name: &str) -> String {
    std::fs::read_to_string(checkout::file(name)).unwrap()
}

/// The long flags in a text.
fn flags(text: &str) -> BTreeSet<&str> {
    let is_part = |character: char| character.is_ascii_lowercase() || character == '-';
    text.split(|character| !is_part(character))
        .filter(|word| word.starts_with("--") && word.len() > 2 && !word.starts_with("---"))
        .collect()
}

#[test]
fn the_page_on_the_command_line_has_every_flag() {
    let page = page("docs/command-line.md");
    let described = flags(&page);
    let studio = Studio::new();
    for command in ["render", "preview", "inspect", "bench", "export", "diff", "farm", "serve"] {
        let help = studio.succeed(&format!("{command} --help")).out;
        let missing: Vec<_> = flags(&help).difference(&described).copied().collect();
        assert!(missing.is_empty(), "{command}: {missing:?} are not described");
    }
}

/// The table of docs/losses.md is the program's own, sentence by sentence.
#[test]
fn every_loss_stands_in_the_documentation() {
    let page = page("docs/losses.md");
    let rows: BTreeSet<&str> = page.lines().filter(|line| line.starts_with("| `")).collect();
    let known: Vec<String> = (Loss::ALL.iter().map(|loss| (loss.id(), loss.sentence())))
        .map(|(id, sentence)| format!("| `{id}` | {sentence} |"))
        .collect();
    assert_eq!(rows, known.iter().map(String::as_str).collect());
}

#[test]
fn the_scene_in_the_readme_can_be_rendered() {
    let page = page("README.md");
    let (_, rest) = page.split_once("```ron\n").unwrap();
    let (scene, _) = rest.split_once("```").unwrap();
    let studio = Studio::new();
    std::fs::write(studio.path("leaf.ron"), scene).unwrap();
    let outcome = studio.succeed("render leaf.ron --size 8x4 --samples 1 --frames 1 --out a/");
    assert_eq!(studio.names("a"), ["leaf.0001.exr"]);
    assert!(!outcome.err.contains("warning"), "{}", outcome.err);
}

#[test]
fn files_that_the_readme_and_the_figures_name_are_there() {
    for word in (page("README.md") + &page("docs/figures.md")).split(['`', '(', ')', ' ', '\n', '|']) {
        let is_ours = ["docs/", "scenes/", "sequences/", "src/", "tests/", "tools/", "benches/"]
            .iter()
            .any(|folder| word.starts_with(folder));
        if is_ours && !word.ends_with(".png") && !word.contains(['<', '#', '*']) {
            assert!(
                checkout::file(word.trim_end_matches(['.', ',', ';', ':'])).exists(),
                "{word} is not there"
            );
        }
    }
}
