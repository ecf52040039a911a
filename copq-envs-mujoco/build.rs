//! Builds the C parts of the engines, and sees to it that the linked MuJoCo is found at run time.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    #[cfg(any(feature = "mujoco-rs", feature = "system"))]
    compile();
    #[cfg(feature = "mujoco-rs")]
    linked::provide();
}

/// The guard, and with feature `system` the shim.
#[cfg(any(feature = "mujoco-rs", feature = "system"))]
fn compile() {
    let mut build = cc::Build::new();
    build.std("c11").file("src/guard.c");
    println!("cargo::rerun-if-changed=src/guard.c");
    if cfg!(feature = "system") {
        build.file("src/system/shim.c");
        println!("cargo::rerun-if-changed=src/system/shim.c");
        system::find(&mut build);
    }
    build.compile("copq_mujoco");
}

#[cfg(any(feature = "mujoco-rs", feature = "system"))]
mod system {
    use std::env;
    use std::path::{Path, PathBuf};

    /// A folder with `include/mujoco/mujoco.h` and the library somewhere below; without it, what
    /// the compiler finds.
    const DIR: &str = "COPQ_MUJOCO_DIR";
    const HEADER: &str = "include/mujoco/mujoco.h";

    pub fn find(build: &mut cc::Build) {
        println!("cargo::rerun-if-env-changed={DIR}");
        let Some(dir) = env::var_os(DIR).map(PathBuf::from) else {
            // Missing or not: when headers come or go, build again.
            println!("cargo::rerun-if-changed=/usr/include/mujoco/mujoco.h");
            return;
        };
        println!("cargo::rerun-if-changed={}", dir.join(HEADER).display());
        let dir = match dir.canonicalize() {
            Ok(found) if found.join(HEADER).exists() => found,
            _ => {
                let wanted = format!("a folder with {HEADER} (an absolute path, or one from");
                let got = dir.display();
                println!("cargo::error={DIR}: wanted {wanted} copq-envs-mujoco), got {got}");
                return;
            }
        };
        build.include(dir.join("include"));
        if let Some(library) = library_below(&dir, 3) {
            println!("cargo::rustc-env=COPQ_MUJOCO_FOUND={}", library.display());
        }
    }

    /// The first file named `libmujoco.so*` or `libmujoco*.dylib`, not too deep.
    fn library_below(dir: &Path, depth: usize) -> Option<PathBuf> {
        let mut entries: Vec<_> =
            dir.read_dir().ok()?.flatten().map(|entry| entry.path()).collect();
        entries.sort();
        let is_library = |path: &&PathBuf| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            name.starts_with("libmujoco") && (name.contains(".so") || name.ends_with(".dylib"))
        };
        let here = entries.iter().find(is_library).cloned();
        here.or_else(|| {
            entries.iter().filter(|_| depth > 0).find_map(|entry| library_below(entry, depth - 1))
        })
    }
}

#[cfg(feature = "mujoco-rs")]
mod linked {
    use std::path::{Path, PathBuf};
    use std::{env, fs, io};

    /// What mujoco-rs's own build script reads.
    const DIR: &str = "MUJOCO_DYNAMIC_LINK_DIR";

    /// Copies the library to where cargo lets programs look that it runs: a link path inside of the
    /// target folder.
    pub fn provide() {
        println!("cargo::rerun-if-env-changed={DIR}");
        // Linked statically, found by pkg-config or downloaded by mujoco-rs: then it is not ours to
        // provide.
        let Some(lib) = env::var_os(DIR).map(PathBuf::from) else { return };
        println!("cargo::rerun-if-changed={}", lib.display());
        let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
        if copy_libraries(&lib, &out) == 0 {
            println!(
                "cargo::error={DIR} is {}, where there is no MuJoCo: run scripts/fetch-mujoco.sh in copq's repository, or set it \
                 to the lib folder of MuJoCo 3.17.0",
                lib.display()
            );
        }
        println!("cargo::rustc-link-search=native={}", out.display());
        println!("cargo::metadata=lib_dir={}", out.display());
    }

    fn copy_libraries(from: &Path, to: &Path) -> usize {
        let files = from.read_dir().into_iter().flatten().flatten();
        let libraries =
            files.filter(|file| file.file_name().to_string_lossy().starts_with("libmujoco"));
        libraries.filter(|file| replace(&file.path(), &to.join(file.file_name())).is_ok()).count()
    }

    /// Copies to another name and renames: a program that runs meanwhile has the old file in its
    /// memory, and to write into that would end it.
    fn replace(from: &Path, to: &Path) -> io::Result<()> {
        let part = to.with_extension("part");
        fs::copy(from, &part)?;
        fs::rename(part, to)
    }
}
