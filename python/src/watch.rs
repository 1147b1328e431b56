//! Long work: other Python threads go on, progress is told, and Ctrl-C ends it.

use pyo3::exceptions::{PyKeyboardInterrupt, PyRuntimeError};
use pyo3::prelude::*;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

/// So long the work goes on before signals are looked at and progress is told.
const PAUSE: Duration = Duration::from_millis(50);

/// Expressions may be nested deeply; this is what a main thread usually has.
const STACK: usize = 8 << 20;

/// How far the work is.
#[derive(Debug, Clone, Default)]
pub struct Standing {
    /// What is done.
    pub done: u64,
    /// Of so many; 0 where that is not known.
    pub whole: u64,
    /// The same in words.
    pub text: String,
}

/// What the work tells, and is told.
#[derive(Debug, Default)]
pub struct Watch {
    is_stopped: AtomicBool,
    is_done: AtomicBool,
    standing: Mutex<Standing>,
}

impl Watch {
    /// False once the work is to end.
    pub fn goes_on(&self) -> bool {
        !self.is_stopped.load(Ordering::Relaxed)
    }

    /// Tells how far it is.
    pub fn tell(&self, standing: Standing) {
        if let Ok(mut known) = self.standing.lock() {
            *known = standing;
        }
    }

    fn standing(&self) -> Standing {
        self.standing
            .lock()
            .map_or_else(|_| Standing::default(), |known| known.clone())
    }
}

/// Does `work` on a thread of its own without holding the interpreter; calls `progress(done, whole, text)` about
/// twenty times a second. The second part of the result: the user pressed Ctrl-C, and the work was asked to end.
///
/// *Errors*: what a signal handler or `progress` raises, after the work has ended; `RuntimeError` where the work
/// panicked, which would be a defect.
pub fn watched<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Watch) -> T + Send,
) -> PyResult<(T, bool)> {
    let watch = Watch::default();
    let here = thread::current();
    let (done, raised) = thread::scope(|scope| {
        let work = || {
            let _end = End(&watch, here);
            work(&watch)
        };
        let started = thread::Builder::new()
            .stack_size(STACK)
            .spawn_scoped(scope, work)
            .map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
        let mut raised = None;
        while !watch.is_done.load(Ordering::Acquire) {
            py.detach(|| thread::park_timeout(PAUSE));
            if let (None, Err(error)) = (&raised, look(py, progress, &watch)) {
                watch.is_stopped.store(true, Ordering::Relaxed);
                raised = Some(error);
            }
        }
        let done = py.detach(|| started.join());
        let done = done.map_err(|_| PyRuntimeError::new_err("the calculation broke off"))?;
        Ok::<_, PyErr>((done, raised))
    })?;
    match raised {
        Some(error) if !error.is_instance_of::<PyKeyboardInterrupt>(py) => Err(error),
        raised => Ok((done, raised.is_some())),
    }
}

/// Lets signal handlers run, and tells the progress.
fn look(py: Python<'_>, progress: Option<&Bound<'_, PyAny>>, watch: &Watch) -> PyResult<()> {
    py.check_signals()?;
    if let Some(progress) = progress {
        let Standing { done, whole, text } = watch.standing();
        progress.call1((done, whole, text))?;
    }
    Ok(())
}

/// Says that the work is done, whichever way it ended.
struct End<'w>(&'w Watch, thread::Thread);

impl Drop for End<'_> {
    fn drop(&mut self) {
        self.0.is_done.store(true, Ordering::Release);
        self.1.unpark();
    }
}
