//! The programs: what each says of its configuration, and what it refuses before it opens any port.

use std::process::Command;

use crate::process::beside;

/// A program's exit code, output and errors.
fn run(service: &str, arguments: &[&str]) -> (Option<i32>, String, String) {
    let program = beside(&format!("ppnpack-{service}")).unwrap();
    let output = Command::new(program).args(arguments).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let (printed, errors) = (text(&output.stdout), text(&output.stderr));
    (output.status.code(), printed, errors)
}

#[test]
fn a_configuration_can_be_printed_and_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let services = "bridge console heuristic perception planner ppn router";
    for service in services.split(' ') {
        let (code, printed, errors) = run(service, &["--print-config"]);
        assert_eq!(code, Some(0), "{service}: {errors}");
        let instance = format!("instance = \"{service}-1\"");
        assert!(printed.contains(&instance), "{service}: {printed}");
        let file = folder.path().join(format!("{service}.toml"));
        std::fs::write(&file, &printed).unwrap();
        let again = ["--config", file.to_str().unwrap(), "--print-config"];
        let (code, again, errors) = run(service, &again);
        assert_eq!(code, Some(0), "{service}: {errors}");
        assert_eq!(again, printed, "{service}");
    }
}
