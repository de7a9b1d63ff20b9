//! The programs under test. A test crate does not get the other crates' binaries from cargo, so they are built here, once, into
//! the same folder and profile as the tests; a program that does not build fails the test.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// The repository's root.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the tests lie in the repository")
}

/// A command that runs the tool `haptor` in the repository's root.
pub fn haptor() -> assert_cmd::Command {
    static TOOL: OnceLock<PathBuf> = OnceLock::new();
    let mut command = assert_cmd::Command::new(TOOL.get_or_init(|| built("haptor")));
    command.current_dir(root());
    command
}

/// Builds a program and yields its path.
pub fn built(package: &str) -> PathBuf {
    let program = build(package).join(package);
    assert!(program.is_file(), "{} is missing after its build", program.display());
    program
}

/// Builds a package; yields the folder in which its programs and libraries then lie.
pub fn build(package: &str) -> PathBuf {
    // target/PROFILE/deps/it-HASH
    let test = std::env::current_exe().expect("a test knows its path");
    let profile = test.parent().and_then(Path::parent).expect("tests lie in target/PROFILE/deps");
    let target = profile.parent().expect("a profile lies in a target folder");
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
    cargo.current_dir(root()).args(["build", "--quiet", "--package", package, "--target-dir"]).arg(target);
    if profile.ends_with("release") {
        cargo.arg("--release");
    }
    let status = cargo.status().expect("cargo can be started");
    assert!(status.success(), "{package} does not build");
    profile.to_owned()
}

/// Builds one program of a package in release, whatever the tests are: what is counted is what is shipped; yields its path.
pub fn released(package: &str, program: &str) -> PathBuf {
    let test = std::env::current_exe().expect("a test knows its path");
    let target = test.ancestors().nth(3).expect("tests lie in target/PROFILE/deps");
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
    cargo.current_dir(root()).args(["build", "--quiet", "--release", "--package", package, "--bin", program]);
    cargo.arg("--target-dir").arg(target);
    assert!(cargo.status().expect("cargo can be started").success(), "{program} does not build");
    target.join("release").join(program)
}

/// Compiles a program in C with every warning an error; `more` are further sources, folders and libraries.
pub fn compiled(source: &str, name: &str, more: &[String]) -> PathBuf {
    let program = std::env::current_exe().expect("a test knows its path").with_file_name(name);
    let mut cc = Command::new("cc");
    cc.args(["-std=c11", "-O2", "-Wall", "-Wextra", "-Werror", "-pedantic"]).arg(root().join(source)).args(more);
    assert!(
        cc.arg("-o").arg(&program).status().expect("a C compiler is installed as `cc`").success(),
        "{source} does not compile"
    );
    program
}
