//! Tells the program which commit it is built from. Outside a git checkout it does not know.

use std::process::Command;

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

fn main() {
    for watched in ["../../.git/HEAD", "../../.git/index", "../../crates"] {
        println!("cargo::rerun-if-changed={watched}");
    }
    if let Some(commit) = git(&["rev-parse", "HEAD"]) {
        // Only what the program is made of counts: a record or a page does not change a timing.
        let program = ["../../crates", "../../Cargo.toml", "../../Cargo.lock"];
        let status =
            [&["status", "--porcelain", "--untracked-files=no", "--"], &program[..]].concat();
        let dirty = git(&status).is_none_or(|changes| !changes.is_empty());
        println!("cargo::rustc-env=OIT_GIT_COMMIT={commit}");
        println!("cargo::rustc-env=OIT_GIT_DIRTY={dirty}");
    }
}
