//! Threads of the reference: nothing but the standard library.

use crate::error::{Error, Result};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError, mpsc};
use std::time::Duration;

/// How often the caller is asked whether to stop.
const PATIENCE: Duration = Duration::from_millis(50);

/// Who does the work, and who may stop it.
pub struct Crew<'a> {
    threads: usize,
    stop: &'a mut dyn FnMut() -> bool,
}

impl std::fmt::Debug for Crew<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Crew").field("threads", &self.threads).finish_non_exhaustive()
    }
}

impl<'a> Crew<'a> {
    /// At most `threads` threads (0: as many as the machine has). `stop` is called from the caller's thread
    /// some twenty times a second; when it answers `true` the work ends with [`Error::Interrupted`].
    pub fn new(threads: usize, stop: &'a mut dyn FnMut() -> bool) -> Self {
        let all = || std::thread::available_parallelism().map_or(1, usize::from);
        Self { threads: if threads == 0 { all() } else { threads }, stop }
    }

    /// Calls `work` for every item. Items are independent, so the result does not depend on the threads.
    pub(super) fn each<T: Send>(
        &mut self,
        items: impl Iterator<Item = T> + Send,
        work: impl Fn(T) -> Result<()> + Sync,
    ) -> Result<()> {
        let (queue, ended, failed) = (Mutex::new(items), AtomicBool::new(false), Mutex::new(None));
        let worker = || {
            while !ended.load(Ordering::Relaxed) {
                let next = queue.lock().unwrap_or_else(PoisonError::into_inner).next();
                let Some(item) = next else { break };
                if let Err(error) = work(item) {
                    failed.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
                    ended.store(true, Ordering::Relaxed);
                }
            }
        };
        std::thread::scope(|scope| {
            let (done, news) = mpsc::channel::<()>();
            let mut running = 0;
            for _ in 0..self.threads {
                let done = done.clone();
                let spawned = std::thread::Builder::new().spawn_scoped(scope, move || {
                    worker();
                    // The listener outlives every thread.
                    let _ = done.send(());
                });
                running += usize::from(spawned.is_ok());
            }
            if running == 0 {
                worker();
            }
            while running > 0 {
                match news.recv_timeout(PATIENCE) {
                    Ok(()) => running -= 1,
                    Err(_) if (self.stop)() => {
                        failed
                            .lock()
                            .unwrap_or_else(PoisonError::into_inner)
                            .get_or_insert(Error::Interrupted);
                        ended.store(true, Ordering::Relaxed);
                    }
                    Err(_) => {}
                }
            }
        });
        match failed.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_item_is_worked_on_and_errors_end_it() {
        for threads in [1, 3, 0] {
            let mut out = vec![0usize; 1000];
            let mut never = || false;
            let result = Crew::new(threads, &mut never).each(out.iter_mut().enumerate(), |(i, slot)| {
                *slot = i + 1;
                Ok(())
            });
            assert!(result.is_ok() && out.iter().enumerate().all(|(i, v)| *v == i + 1));
            let mut never = || false;
            let fail = Crew::new(threads, &mut never)
                .each(0..100, |i| if i == 50 { Err(Error::value("i", i, "less")) } else { Ok(()) });
            assert!(matches!(fail, Err(Error::Value { .. })));
            let mut always = || true;
            let stopped = Crew::new(threads, &mut always).each(0..100, |_| {
                std::thread::sleep(Duration::from_millis(5));
                Ok(())
            });
            assert!(matches!(stopped, Err(Error::Interrupted)));
        }
    }
}
