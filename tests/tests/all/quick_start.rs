//! The quick start is shown in four places, and runs in one.

/// The lines of code, without indentation and comments.
fn code(text: &str) -> Vec<&str> {
    let lines = text.lines().map(|line| line.split(" //").next().unwrap_or_default().trim());
    lines.filter(|line| !line.is_empty()).collect()
}

/// The first block of code in a text that holds `word`.
fn block<'a>(text: &'a str, word: &str) -> &'a str {
    let mut blocks = text.split("```").skip(1).step_by(2);
    let block = blocks.find(|block| block.contains(word)).expect("a block of code");
    block.split_once('\n').expect("lines").1
}

fn uncommented(text: &str, mark: &str) -> String {
    let lines = text.lines().filter_map(|line| line.trim_start().strip_prefix(mark));
    lines.map(|line| format!("{line}\n")).collect()
}

#[test]
fn what_is_shown_is_what_runs() {
    let readme = include_str!("../../../README.md");
    let shown = code(block(readme, "save_policy"));

    let tested = uncommented(include_str!("../../lib.rs"), "///");
    let tested = block(&tested, "save_policy").replace("1_050", "20_000");
    let mut tested = code(&tested);
    tested.retain(|line| !line.contains("set_current_dir"));
    assert_eq!(shown, tested, "README.md and tests/lib.rs");

    let front_page = uncommented(include_str!("../../../copq/src/lib.rs"), "//!");
    let crate_readme = include_str!("../../../copq/README.md");
    for text in [front_page.as_str(), crate_readme] {
        for line in code(block(text, "trainer.evaluate")) {
            assert!(shown.contains(&line), "not in README.md: {line}");
        }
    }
}
