//! What has become of a sweep's runs.

use copq_experiments::{Standing, failure, steps_done};

use super::file::{SweepFile, Task};
use crate::options::say;

pub fn print(sweep: &SweepFile) -> anyhow::Result<()> {
    let mut text = "| run | state | steps | of |\n|---|---|--:|--:|\n".to_owned();
    let mut remarks = String::new();
    for task in &sweep.tasks {
        let folder = &task.folder;
        let name = folder.file_name().unwrap_or_default().to_string_lossy();
        let [word, remark] = standing(task);
        let steps = steps_done(folder);
        text += &format!("| {name} | {word} | {steps} | {} |\n", task.plan.run.steps);
        if !remark.is_empty() {
            remarks += &format!("\n{}: {remark}\n", folder.display());
        }
    }
    Ok(say(&(text + &remarks))?)
}

/// Where a run stands, and what there is to say about it.
fn standing(task: &Task) -> [String; 2] {
    match Standing::of(&task.folder) {
        Standing::Done if !task.is_done() => {
            let remark = task.why_only_anew().unwrap_or_else(|| {
                "done with other settings than the file has now; sweep run continues it if only \
                 steps have risen, and says what else differs"
                    .to_owned()
            });
            let why = failure(&task.folder).filter(|why| *why != remark);
            let why = why.map_or(String::new(), |why| format!(" ({why})"));
            ["changed".to_owned(), format!("{remark}{why}")]
        }
        standing => {
            let remark = standing.remark().unwrap_or_default().to_owned();
            [standing.word().to_owned(), remark]
        }
    }
}
