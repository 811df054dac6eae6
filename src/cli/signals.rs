//! Ctrl-C and what a farm sends. In go signals, out comes the end of the process, soon. Invariant: whatever
//! the program is at (loading, baking, building trees, rendering, writing), it ends about a tenth of a second
//! after the signal, and no file is half-written.

use super::{CliError, error, process, tell};
use signal_hook::consts::{SIGINT, SIGTERM};
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::thread;
use std::time::Duration;
use sunfleck::frame_file;

/// Time in which the work may end by itself, so that a frame that is about done is still written. Short,
/// for the system takes its time too: 40 to 60 ms to have back the 400 MB of a large frame, page by page
/// (docs/decisions/measuring.md#signals).
const GRACE: Duration = Duration::from_millis(5);

/// Signal that came, if any.
#[derive(Clone, Default)]
pub(super) struct Stop {
    /// Set by a signal.
    pub(super) flag: Arc<AtomicBool>,
    number: Arc<AtomicU8>,
    /// Set by whoever ends the process.
    ending: Arc<AtomicBool>,
}

impl Stop {
    /// Waits for signals on a thread of its own.
    pub(super) fn watch() -> Result<Self, CliError> {
        let stop = Self::default();
        let failure = |error| CliError::InputOutput(format!("error: signals cannot be caught: {error}"));
        let wait = caught().map_err(failure)?;
        heed_limits().map_err(failure)?;
        let watched = stop.clone();
        let watcher = move || {
            let Some(signal) = wait() else { return };
            watched.number.store(signal as u8, Ordering::Relaxed);
            watched.flag.store(true, Ordering::Relaxed);
            thread::sleep(GRACE);
            // No work asks everywhere whether it should stop: what is not done by now is
            // dropped where it stands.
            frame_file::abandon_writes();
            let code = watched.code(Err(CliError::Signal(signal as u8)));
            std::process::exit(i32::from(code));
        };
        thread::Builder::new().spawn(watcher).map_err(failure)?;
        Ok(stop)
    }

    pub(super) fn signal(&self) -> Option<u8> {
        Some(self.number.load(Ordering::Relaxed)).filter(|&number| number > 0)
    }

    /// The process's exit code, and why on the error stream; asked twice, once only.
    pub(super) fn code(&self, result: Result<(), CliError>) -> u8 {
        while self.ending.swap(true, Ordering::Relaxed) {
            // The other one is about to end the process.
            thread::park();
        }
        let Err(error) = result else { return 0 };
        tell(&error.to_string());
        error.code()
    }
}

/// Has limits of the system end in a message and an exit code, not in a dead process.
///
/// Memory that cannot be had: the standard library says how much, and aborts. Nothing may run in between, so
/// that it is told from other aborts by what is so before: memory has a limit, and nothing panicked.
///
/// A file that may not grow: the signal's own action ends the process, and without it the write fails.
#[cfg(unix)]
fn heed_limits() -> io::Result<()> {
    use signal_hook::consts::{SIGABRT, SIGXFSZ};
    let is_of_memory = Arc::new(AtomicBool::new(process::is_there_any()));
    let (panicked, say) = (Arc::clone(&is_of_memory), std::panic::take_hook());
    std::panic::set_hook(Box::new(move |panic| {
        panicked.store(false, Ordering::SeqCst);
        say(panic);
    }));
    let (code, always) = (i32::from(error::INPUT_OUTPUT), Arc::new(AtomicBool::new(true)));
    signal_hook::flag::register_conditional_shutdown(SIGABRT, code, is_of_memory)?;
    signal_hook::flag::register_conditional_default(SIGABRT, always)?;
    signal_hook::flag::register(SIGXFSZ, Arc::default())?;
    Ok(())
}

#[cfg(not(unix))]
fn heed_limits() -> io::Result<()> {
    Ok(())
}

const STOPPING: [i32; 2] = [SIGINT, SIGTERM];

/// Catches signals from now on; what comes back waits for the first.
#[cfg(unix)]
fn caught() -> io::Result<impl FnOnce() -> Option<i32>> {
    use signal_hook::consts::SIGHUP;
    // Under `nohup` the end of a terminal is nothing to hear of.
    let of_terminal = (!process::is_ignored(SIGHUP)).then_some(SIGHUP);
    let mut signals = signal_hook::iterator::Signals::new(STOPPING.into_iter().chain(of_terminal))?;
    Ok(move || signals.forever().next())
}

/// Catches signals where nothing can be waited for but a flag.
#[cfg(not(unix))]
fn caught() -> io::Result<impl FnOnce() -> Option<i32>> {
    use std::sync::atomic::AtomicUsize;
    const LOOK_EVERY: Duration = Duration::from_millis(10);
    let caught = Arc::new(AtomicUsize::new(0));
    for signal in STOPPING {
        signal_hook::flag::register_usize(signal, Arc::clone(&caught), signal as usize)?;
    }
    Ok(move || {
        loop {
            match caught.load(Ordering::Relaxed) {
                0 => thread::sleep(LOOK_EVERY),
                signal => return Some(signal as i32),
            }
        }
    })
}
