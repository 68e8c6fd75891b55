//! The program can be started; what it does is tested against a whole stack.

use std::process::Command;

#[test]
fn it_says_what_it_is_for() -> std::io::Result<()> {
    let output = Command::new(env!("CARGO_BIN_EXE_ppnpack-example-controller"))
        .arg("--help")
        .output()?;
    assert!(output.status.success());
    assert!(String::from_utf8_lossy(&output.stdout).contains("--session"));
    Ok(())
}
