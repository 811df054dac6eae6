//! The directions of import, the place of `unsafe` and the width of comments, held by reading the source.

mod checkout;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Modules from the first to the last: each may import only those before it.
const ORDER: [&str; 24] = [
    "color",
    "diagnostic",
    "math",
    "passes",
    "description",
    "scene",
    "export",
    "accel",
    "ordinates",
    "scattering",
    "light",
    "fog",
    "snapshot",
    "canopy",
    "indirect",
    "transport",
    "film",
    "scanline",
    "render",
    "frame_file",
    "api",
    "sequence",
    "bench",
    "cli",
];

/// As `max_width` in rustfmt.toml, which does not hold for comments.
const MOST_COLUMNS: usize = 110;

/// Lines a file may have, tests aside; beyond that it holds more than one concept.
const MOST_LINES: usize = 400;
const MOST_LINES_OF_TESTS: usize = 600;

/// Lines of code a function may have.
const MOST_LINES_OF_A_FUNCTION: usize = 60;

/// Arguments a function may have beside `self`, tuples by their members; beyond that some are one thing.
const MOST_ARGUMENTS: usize = 5;

fn source_files(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("the source is there") {
        let path = entry.expect("readable").path();
        if path.is_dir() {
            source_files(&path, out);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            out.push(path);
        }
    }
}

/// (file relative to src, its top-level module, its text without tests and comments)
fn sources() -> Vec<(String, String, String)> {
    let root = checkout::file("src");
    let mut files = Vec::new();
    source_files(&root, &mut files);
    files.sort();
    files
        .into_iter()
        .map(|path| {
            let relative = path.strip_prefix(&root).expect("below src").to_string_lossy().into_owned();
            let module = relative.split(['/', '.']).next().expect("a name").to_owned();
            let text = fs::read_to_string(&path).expect("readable");
            (relative, module, shipped(&text))
        })
        .collect()
}

/// The text without what is compiled for tests alone, wherever it stands.
fn shipped(text: &str) -> String {
    let (mut shipped, mut rest) = (String::new(), text);
    while let Some((before, after)) = rest.split_once("#[cfg(test)]") {
        shipped.push_str(before);
        rest = after_item(after);
    }
    shipped + rest
}

/// What follows the item that a text begins with: a statement, or a block in braces.
fn after_item(text: &str) -> &str {
    let mut depth = 0;
    for (at, character) in text.char_indices() {
        match character {
            '{' => depth += 1,
            '}' => depth -= 1,
            ';' if depth == 0 => return &text[at + 1..],
            _ => continue,
        }
        if depth == 0 {
            return &text[at + 1..];
        }
    }
    ""
}

fn rank(module: &str) -> Option<usize> {
    ORDER.iter().position(|name| *name == module)
}

/// Lines of code, comments aside.
fn code(text: &str) -> String {
    let lines = text.lines().filter(|line| !line.trim_start().starts_with("//"));
    lines.collect::<Vec<_>>().join("\n")
}

/// The paths that a file names: those that begin with `crate`, `super` or the library's name, made absolute,
/// as lists of segments.
fn paths(file: &str, text: &str) -> Vec<Vec<String>> {
    let own = module_of(file);
    let code = code(text);
    let mut found = Vec::new();
    let begins = ["crate::", "super::", "sunfleck::"].map(|begin| code.match_indices(begin));
    for (at, begin) in begins.into_iter().flatten() {
        let follows_path =
            code[..at].ends_with("::") || code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_');
        if follows_path {
            continue;
        }
        let is_absolute = begin != "super::";
        let mut base = if is_absolute { Vec::new() } else { own.clone() };
        let mut rest = &code[if is_absolute { at + begin.len() } else { at }..];
        // All modules of the library are in this one, which has no file.
        rest = rest.strip_prefix("inside::").unwrap_or(rest);
        while let Some(above) = rest.strip_prefix("super::") {
            base.pop();
            rest = above;
        }
        expand(&base, rest, &mut found);
    }
    found
}

/// Appends the paths that a text begins with: one, or all of a list in braces.
fn expand(base: &[String], text: &str, found: &mut Vec<Vec<String>>) {
    let mut path = base.to_vec();
    let mut rest = text;
    loop {
        if let Some(list) = rest.strip_prefix('{') {
            let inner = &list[..rest.len() - after_item(rest).len() - 2];
            split_list(inner).into_iter().for_each(|item| expand(&path, item.trim(), found));
            return;
        }
        let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        if end > 0 {
            path.push(rest[..end].to_owned());
        }
        let Some(after) = rest[end..].strip_prefix("::") else { break };
        rest = after;
    }
    found.push(path);
}

/// The parts of a list between commas that are in no brackets.
fn split_list(list: &str) -> Vec<&str> {
    let (mut parts, mut start, mut depth) = (Vec::new(), 0, 0);
    for (at, character) in list.char_indices() {
        match character {
            '{' | '(' | '[' | '<' => depth += 1,
            '>' if list[..at].ends_with(['-', '=']) => {}
            '}' | ')' | ']' | '>' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&list[start..at]);
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&list[start..]);
    parts.into_iter().filter(|part| !part.trim().is_empty()).collect()
}

/// `a/b.rs` and `a/b/mod.rs` are `a::b`.
fn module_of(file: &str) -> Vec<String> {
    let path = file.trim_end_matches(".rs").trim_end_matches("/mod");
    path.split('/').map(str::to_owned).collect()
}

/// The top-level modules that a file imports.
fn imports(file: &str, text: &str) -> Vec<String> {
    paths(file, text).into_iter().filter_map(|path| path.into_iter().next()).collect()
}

#[test]
fn every_module_has_its_place() {
    for (file, module, _) in sources() {
        if module != "lib" && module != "main" {
            assert!(rank(&module).is_some(), "{file}: `{module}` is not in the order of modules");
        }
    }
}

#[test]
fn imports_point_only_upward() {
    for (file, module, text) in sources() {
        let Some(own) = rank(&module) else { continue };
        for import in imports(&file, &text) {
            let Some(other) = rank(&import) else { panic!("{file}: crate::{import} is not a module") };
            assert!(other <= own, "{file}: `{module}` imports `{import}`, which comes after it");
        }
    }
}

#[test]
fn the_solver_knows_no_leaf_no_camera_and_no_scene() {
    for (file, _, text) in sources().into_iter().filter(|(_, module, _)| module == "ordinates") {
        for import in imports(&file, &text) {
            let known = ["accel", "color", "math", "ordinates"];
            assert!(known.contains(&import.as_str()), "{file}: the solver imports `{import}`");
        }
    }
}

#[test]
fn unsafe_lives_in_the_simd_kernels_alone() {
    for (file, module, text) in sources() {
        let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
        let uses =
            code.filter(|line| line.split(|c: char| !c.is_alphanumeric() && c != '_').any(|w| w == "unsafe"));
        if uses.count() > 0 {
            assert_eq!(module, "accel", "{file} has `unsafe`");
        }
    }
}

#[test]
fn examples_show_the_face_alone() {
    let mut files = Vec::new();
    source_files(&checkout::file("examples"), &mut files);
    // The face's own test is one more program that uses it.
    files.push(checkout::file("tests/library/face.rs"));
    assert!(files.len() > 3, "examples are found");
    for file in files {
        let text = code(&fs::read_to_string(&file).expect("readable"));
        let mut named = Vec::new();
        text.match_indices("sunfleck::")
            .for_each(|(at, path)| expand(&[], &text[at + path.len()..], &mut named));
        assert!(!named.is_empty(), "{}: uses are found", file.display());
        for path in named {
            let is_module = path.first().is_some_and(|name| name.starts_with(char::is_lowercase));
            assert!(!is_module, "{}: `{}` is inside the library", file.display(), path.join("::"));
        }
    }
}

#[test]
fn input_files_are_read_in_one_place() {
    let readers = ["std::fs::read", "fs::read(", "File::open", "read_to_string("];
    for (file, module, text) in sources() {
        if readers.iter().any(|reader| text.contains(reader)) {
            // What the system says of this process is no input, nor is what an earlier run has kept.
            let allowed = ["description/files.rs", "cli/process.rs", "cli/loading.rs"]
                .contains(&file.as_str())
                || module == "frame_file";
            assert!(allowed, "{file} opens files");
        }
    }
}

#[test]
fn comments_keep_to_the_columns_of_code() {
    let mut files = Vec::new();
    for folder in ["src", "tests", "benches", "examples"] {
        source_files(&checkout::file(folder), &mut files);
    }
    let mut comments = 0;
    for file in files {
        let text = fs::read_to_string(&file).expect("readable");
        for (number, line) in (1..).zip(text.lines()) {
            let is_comment = line.trim_start().starts_with("//");
            let columns = line.chars().count();
            comments += usize::from(is_comment);
            assert!(!is_comment || columns <= MOST_COLUMNS, "{}:{number}: {columns} columns", file.display());
        }
    }
    assert!(comments > 5_000, "comments are found: {comments}");
}

#[test]
fn every_file_tells_its_invariant_and_holds_one_concept() {
    for (file, _, text) in sources() {
        assert!(text.starts_with("//! "), "{file} does not say what it is");
        let most = if file.ends_with("/tests.rs") { MOST_LINES_OF_TESTS } else { MOST_LINES };
        assert!(text.lines().count() <= most, "{file} is too long");
    }
}

/// A function as it is written.
#[derive(Debug, PartialEq)]
struct Function {
    name: String,
    /// Beside `self`; of tuples each member.
    arguments: usize,
    /// Of code; 0 if it is only declared.
    lines: usize,
}

/// The functions that stand in a text as rustfmt leaves it.
fn functions(text: &str) -> Vec<Function> {
    let code = code(text);
    let mut found = Vec::new();
    for (at, _) in code.match_indices("fn ") {
        let before = code[..at].rsplit('\n').next().expect("a line");
        if before.contains(|c: char| !c.is_alphabetic() && !" ():".contains(c)) || before.contains("fn ") {
            continue;
        }
        let rest = &code[at + 3..];
        let name_ends = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(0);
        let (name, signature) = rest.split_at(name_ends);
        if name.is_empty() {
            continue;
        }
        let arguments_begin = if signature.starts_with('<') { bracketed(signature) } else { 0 };
        let arguments = &signature[arguments_begin..];
        let (arguments, after) = arguments.split_at(bracketed(arguments));
        let listed = split_list(&arguments[1..arguments.len() - 1]);
        let end = format!("\n{}}}", " ".repeat(before.len() - before.trim_start().len()));
        let first = |sign: &str| after.find(sign).unwrap_or(usize::MAX);
        let is_declared = first(";\n") < first("{");
        let is_one_line = rest.lines().next().is_some_and(|line| line.ends_with('}'));
        let lines = match (is_declared, is_one_line) {
            (true, _) => 0,
            (_, true) => 1,
            _ => rest.split(&end).next().map_or(0, |body| body.lines().count() + 1),
        };
        let is_self = |argument: &&&str| !argument.contains(':');
        let arguments =
            listed.iter().filter(|argument| !is_self(argument)).map(|argument| members(argument)).sum();
        found.push(Function { name: name.to_owned(), arguments, lines });
    }
    found
}

/// How many things an argument is: of a tuple all of its members, however it is nested.
fn members(argument: &str) -> usize {
    let depth =
        |text: &str| text.matches(['(', '[']).count() as i32 - text.matches([')', ']']).count() as i32;
    let is_pattern = |at: usize| depth(&argument[..at]) == 0 && !argument[at..].starts_with("::");
    let pattern = argument.match_indices(':').map(|(at, _)| at);
    let kind = pattern.filter(|at| !argument[..*at].ends_with(':')).find(|at| is_pattern(*at));
    let kind = kind.map_or(argument, |at| &argument[at + 1..]).trim_start();
    let kind = kind.strip_prefix('&').map_or(kind, |kind| kind.trim_start_matches("mut "));
    if !kind.starts_with('(') {
        return 1;
    }
    split_list(&kind[1..bracketed(kind) - 1]).into_iter().map(members).sum()
}

/// How far the bracket reaches that a text begins with.
fn bracketed(text: &str) -> usize {
    let mut depth = 0;
    for (at, character) in text.char_indices() {
        match character {
            '(' | '[' | '{' | '<' => depth += 1,
            '>' if text[..at].ends_with(['-', '=']) => {}
            ')' | ']' | '}' | '>' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return at + 1;
        }
    }
    text.len()
}

#[test]
fn functions_are_short_and_take_five_arguments() {
    let mut count = 0;
    for (file, _, text) in sources() {
        for Function { name, arguments, lines } in functions(&text) {
            count += 1;
            assert!(arguments <= MOST_ARGUMENTS, "{file}: `{name}` has {arguments} arguments");
            assert!(lines <= MOST_LINES_OF_A_FUNCTION, "{file}: `{name}` has {lines} lines");
        }
    }
    assert!(count > 3_000, "functions are found: {count}");
}

#[test]
fn functions_are_read_in_every_form() {
    let text = "fn none() {}\nimpl A {\n    /// fn no()\n    pub(crate) const fn two<F: Fn(B) -> C>(\n        &self,\n        (a, b): (D, E),\n        call: impl Fn(F, G) -> H,\n    ) -> [I; 2] {\n        // a comment\n        call(a)\n    }\n    fn declared(self, a: [A; 2]) -> B;\n}\n";
    let function = |name: &str, arguments, lines| Function { name: name.to_owned(), arguments, lines };
    assert_eq!(functions(text), [function("none", 0, 1), function("two", 3, 7), function("declared", 1, 0)]);
}

/// What each module that is a file names of others, re-exports followed to where things are written.
fn uses(sources: &[(String, String, String)]) -> BTreeMap<Vec<String>, BTreeSet<Vec<String>>> {
    let modules: BTreeSet<Vec<String>> = sources.iter().map(|(file, ..)| module_of(file)).collect();
    let mut reexports = BTreeMap::new();
    for (file, _, text) in sources {
        let own = module_of(file);
        for (at, _) in text.match_indices("use ") {
            let mut found = Vec::new();
            expand(&own, &text[at + 4..], &mut found);
            for path in
                found.into_iter().filter(|path| modules.contains(&path[..(own.len() + 1).min(path.len())]))
            {
                let name = [own.clone(), path[path.len() - 1..].to_vec()].concat();
                reexports.insert(name, path);
            }
        }
    }
    let resolve = |path: Vec<String>| {
        let mut path = path;
        for _ in 0..8 {
            let known = (1..=path.len()).rev().find(|&end| modules.contains(&path[..end])).unwrap_or(0);
            let Some(target) = path.get(..=known).and_then(|name| reexports.get(name)) else {
                return path[..known].to_vec();
            };
            path = [target.clone(), path[known + 1..].to_vec()].concat();
        }
        path
    };
    let mut uses: BTreeMap<Vec<String>, BTreeSet<Vec<String>>> = BTreeMap::new();
    for (file, _, text) in sources {
        let own = module_of(file);
        let named = paths(file, text).into_iter().map(resolve);
        let others = named.filter(|path| !path.is_empty() && *path != own).collect();
        uses.insert(own, others);
    }
    uses
}

#[test]
fn no_files_import_one_another_in_a_circle() {
    let uses = uses(&sources());
    let reached_from = |start: &Vec<String>| {
        let (mut reached, mut next) = (BTreeSet::new(), vec![start]);
        while let Some(module) = next.pop() {
            let others = uses.get(module).into_iter().flatten();
            next.extend(others.filter(|other| reached.insert((*other).clone())));
        }
        reached
    };
    assert!(uses.len() > 200, "the source is read");
    let all = uses.values().map(BTreeSet::len).sum::<usize>();
    assert!(all > 800, "imports are found: {all}");
    let circles: Vec<String> = uses
        .keys()
        .filter(|module| reached_from(module).contains(*module))
        .map(|path| path.join("::"))
        .collect();
    assert!(circles.is_empty(), "these are in circles: {circles:?}");
}

#[test]
fn imports_are_read_in_every_form() {
    let text = "use crate::a::{b::C, d::{self, E}};\nuse super::{F, g};\nfn f() { super::super::g::H; }\n#[cfg(test)]\nmod tests { use crate::z; }\nuse super::Late;";
    let found: Vec<String> = paths("m/n/o.rs", &shipped(text)).iter().map(|path| path.join("::")).collect();
    assert_eq!(found, ["a::b::C", "a::d::self", "a::d::E", "m::n::F", "m::n::g", "m::g::H", "m::n::Late"]);
}
