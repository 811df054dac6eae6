//! Signals, such as of Ctrl-C or a farm. In go signals, out comes the end of the process. Invariant: whatever
//! the program is doing, it ends about a tenth of a second after the signal, and no file is half-written.

use super::{CliError, error, process, tell};
use signal_hook::consts::{SIGINT, SIGTERM};
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::thread;
use std::time::Duration;
use sunfleck::frame_file;

/// Time for the work to end by itself, so that an almost finished frame is still written. It is short, as the
/// system needs 40 to 60 ms to free the 400 MB of a large frame, page by page
/// (docs/decisions/measuring.md#signals).
const GRACE: Duration = Duration::from_millis(5);

/// Signal that was received, if any.
#[derive(Clone, Default)]
pub(super) struct Stop {
    /// Set by a signal.
    pub(super) flag: Arc<AtomicBool>,
    number: Arc<AtomicU8>,
    /// Set by the thread that ends the process.
    ending: Arc<AtomicBool>,
}

impl Stop {
    /// Starts a thread that waits for signals.
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
            // Not all work checks for cancellation, so unfinished work is dropped.
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

    /// Exit code of the process; prints the error. Only the first of two callers returns.
    pub(super) fn code(&self, result: Result<(), CliError>) -> u8 {
        while self.ending.swap(true, Ordering::Relaxed) {
            // The other thread is about to end the process.
            thread::park();
        }
        let Err(error) = result else { return 0 };
        tell(&error.to_string());
        error.code()
    }
}

/// Handles limits of the system, which then end in a message and an exit code.
///
/// Failed allocations: the standard library prints the size, and aborts. No code can run in between. Such an
/// abort is recognized by earlier conditions: memory is limited, and nothing panicked.
///
/// Files at the size limit: the signal's default action would end the process; with a handler the write
/// fails.
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

/// Starts to catch signals; the returned function waits for the first.
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
