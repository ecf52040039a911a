//! Which MuJoCo this build has, whether it fits, and the one thing to do next.

use std::path::{Path, PathBuf};

/// What [`doctor`] found.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Report {
    /// A line for each feature, and for each MuJoCo library that is open or in one of the usual
    /// places.
    pub lines: Vec<String>,
    /// The one thing to do next, if there is any.
    pub next: Option<String>,
}

/// What is known about one feature: whether it is compiled in, a line, and what to do if it does
/// not work.
struct Finding {
    on: bool,
    line: String,
    next: Option<String>,
}

/// Tries every engine of this build with one step of a robot, and one small picture.
pub fn doctor() -> Report {
    let mut findings = vec![linked(), installed()];
    #[cfg(feature = "render")]
    findings.push(drawn());
    let mut lines: Vec<_> = findings.iter().map(|finding| finding.line.clone()).collect();
    lines.extend(files().iter().map(|file| format!("file: {file}")));
    // An engine that is off is not a problem while there is another.
    if findings.iter().any(|finding| finding.on) {
        findings.retain(|finding| finding.on);
    }
    Report { lines, next: findings.into_iter().find_map(|finding| finding.next) }
}

#[cfg(feature = "mujoco-rs")]
fn linked() -> Finding {
    use crate::mujoco_rs;
    examine("mujoco-rs", mujoco_rs::make("a/hopper"), mujoco_rs::version())
}

#[cfg(not(feature = "mujoco-rs"))]
fn linked() -> Finding {
    let fetched = Path::new("third_party/mujoco-3.17.0/lib").exists();
    let fetch = if fetched { "" } else { "run scripts/fetch-mujoco.sh, then " };
    off("mujoco-rs", &format!("{fetch}build with --features mujoco-rs"))
}

#[cfg(feature = "system")]
fn installed() -> Finding {
    use crate::system;
    examine("system", system::make("a/hopper"), system::version())
}

#[cfg(not(feature = "system"))]
fn installed() -> Finding {
    off("system", "build with --features system")
}

/// One small picture.
#[cfg(feature = "render")]
fn drawn() -> Finding {
    let robot = copq_envs::robot::hopper(copq_envs::robot::Preset::GymV5);
    let renderer = crate::Renderer::new(&robot, [8, 8], |_| [0; 3]);
    let next = renderer.and_then(|mut renderer| renderer.draw(&robot.initial_qpos).map(drop)).err();
    let line = if next.is_none() { "draws without a window" } else { "does not work" };
    Finding {
        on: true,
        line: format!("feature render: {line}"),
        next: next.map(|error| error.to_string()),
    }
}

/// Versions, and one step of a robot.
#[cfg(any(feature = "mujoco-rs", feature = "system"))]
fn examine(
    feature: &str,
    env: copq::Result<Box<dyn copq::Env>>,
    version: copq::Result<i32>,
) -> Finding {
    let tried = env.and_then(|mut env| {
        let mut obs = vec![0.0; env.spec().obs_len];
        let mut reward = vec![0.0; env.spec().objectives.len()];
        env.reset(0, &mut obs)?;
        env.step(&[0.0; 3], &mut obs, &mut reward)
    });
    let (line, next) = match tried.and(version) {
        Ok(version) => {
            (format!("MuJoCo {}, library and headers agree", crate::dotted(version)), None)
        }
        Err(error) => ("does not work".into(), Some(error.to_string())),
    };
    Finding { on: true, line: format!("feature {feature}: {line}"), next }
}

#[cfg(not(all(feature = "mujoco-rs", feature = "system")))]
fn off(feature: &str, next: &str) -> Finding {
    Finding { on: false, line: format!("feature {feature}: off"), next: Some(next.into()) }
}

/// The MuJoCo libraries in this process (Linux), and those in the usual places.
fn files() -> Vec<String> {
    let open = opened(&std::fs::read_to_string("/proc/self/maps").unwrap_or_default());
    let usual = [
        "third_party/mujoco-3.17.0/lib",
        "/usr/lib/x86_64-linux-gnu",
        "/usr/lib/aarch64-linux-gnu",
        "/usr/lib",
        "/usr/local/lib",
    ];
    let usual = usual.map(|folder| Path::new(folder).join("libmujoco.so"));
    let closed = usual.iter().filter(|file| lies_idle(file, &open));
    let closed = closed.map(|file| format!("{} (not open)", file.display()));
    open.iter().map(|file| file.display().to_string()).chain(closed).collect()
}

/// The MuJoCo libraries of a process, from its table of mapped files: five columns without spaces,
/// then the path.
fn opened(maps: &str) -> Vec<PathBuf> {
    let paths = maps.lines().filter_map(|line| line.splitn(6, ' ').nth(5));
    let mut files: Vec<_> = paths.map(|path| PathBuf::from(path.trim_start())).collect();
    files.retain(|file| {
        file.file_name().is_some_and(|name| name.to_string_lossy().starts_with("libmujoco"))
    });
    files.dedup();
    files
}

/// Whether there is such a file that is neither open nor a link to one that is.
fn lies_idle(file: &Path, open: &[PathBuf]) -> bool {
    file.canonicalize().is_ok_and(|file| !open.contains(&file))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_of_open_libraries_may_have_spaces() {
        let maps = "\
7f00-7f10 r--p 00000000 08:01 17                 /opt/my robots/libmujoco.so.3.17.0
7f10-7f20 r-xp 00010000 08:01 17                 /opt/my robots/libmujoco.so.3.17.0
7f20-7f30 r--p 00000000 08:01 18                 /opt/libmujoco/other.so
7f30-7f40 rw-p 00000000 00:00 0
7f40-7f50 rw-p 00000000 00:00 0                  [stack]
";
        assert_eq!(opened(maps), [Path::new("/opt/my robots/libmujoco.so.3.17.0")]);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_to_an_open_library_does_not_lie_idle() {
        let folder = std::env::temp_dir().join(format!("copq-doctor-{}", std::process::id()));
        std::fs::create_dir(&folder).unwrap();
        let library = folder.join("libmujoco.so.3.17.0");
        let link = folder.join("libmujoco.so");
        std::fs::write(&library, "").unwrap();
        std::os::unix::fs::symlink("libmujoco.so.3.17.0", &link).unwrap();
        let open = [library.canonicalize().unwrap()];
        let said = [&library, &link].map(|file| (lies_idle(file, &[]), lies_idle(file, &open)));
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(said, [(true, false); 2]);
        assert!(!lies_idle(&link, &[]), "it is gone");
    }
}
