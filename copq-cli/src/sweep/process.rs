//! Processes as the system knows them: started, told to end, ended.

use std::path::Path;
use std::process::{Child, Command, ExitStatus};

#[cfg(unix)]
use rustix::process::Signal;

/// This program, once more: the file that runs, even if another has taken its name since.
pub fn this_program() -> std::io::Result<Command> {
    let link = Path::new("/proc/self/exe");
    let file = if link.exists() { link.to_owned() } else { std::env::current_exe()? };
    let mut command = Command::new(file);
    // The link's name says nothing.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::arg0(&mut command, "copq");
    Ok(command)
}

/// Whether a process was ended by a signal that people and schedulers send, before it listened.
#[cfg(unix)]
pub fn was_told_to_end(status: ExitStatus) -> bool {
    use std::os::unix::process::ExitStatusExt;
    let signals = [Signal::INT, Signal::TERM, Signal::HUP, Signal::USR1];
    signals.iter().any(|signal| status.signal() == Some(signal.as_raw()))
}

#[cfg(not(unix))]
pub fn was_told_to_end(_: ExitStatus) -> bool {
    false
}

/// Asks a process to save and end.
#[cfg(unix)]
pub fn terminate(child: &Child) -> std::io::Result<()> {
    use rustix::process::{Pid, kill_process};
    Ok(kill_process(Pid::from_child(child), Signal::TERM)?)
}

/// Asks a process to save and end: on this system, the console's Ctrl-C has already done so.
#[cfg(not(unix))]
pub fn terminate(_: &Child) -> std::io::Result<()> {
    Ok(())
}
