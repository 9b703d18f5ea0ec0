//! Threads: the only file that names rayon.
//!
//! Work is cut into tiles whose size depends on the work alone, never on the number of threads, and each
//! tile writes to its own part of the output. So the bytes of a result are the same for any thread count.

use crate::error::{Error, Result};
use std::cell::{Cell, RefCell};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// 0 stands for "as many as the machine has".
static GLOBAL_LIMIT: AtomicUsize = AtomicUsize::new(0);

/// More threads than this help nobody and are not made.
const MOST_THREADS: usize = 256;

/// Work of fewer pixels stays on the calling thread: others would hardly be awake before it is done.
pub const SERIAL: usize = 10_000;

/// Tiles handed out between two calls of the interrupt hook.
const TILES_PER_CHECK: usize = 256;

type Hook = Box<dyn FnMut(f64) -> bool>;

thread_local! {
    static CALL_LIMIT: Cell<Option<usize>> = const { Cell::new(None) };
    static HOOK: RefCell<Option<Hook>> = const { RefCell::new(None) };
}

/// Sets how many threads a call may use; 0 means all that the machine has.
pub fn set_num_threads(threads: usize) {
    GLOBAL_LIMIT.store(threads, Ordering::Relaxed);
}

/// How many threads a call from this thread may use now.
pub fn num_threads() -> usize {
    let all = || std::thread::available_parallelism().map_or(1, usize::from);
    match CALL_LIMIT.get().unwrap_or_else(|| GLOBAL_LIMIT.load(Ordering::Relaxed)) {
        0 => all().min(MOST_THREADS),
        n => n.min(MOST_THREADS),
    }
}

/// Runs `work` with at most `threads` threads (0: all, `None`: the global limit).
pub fn with_threads<R>(threads: Option<usize>, work: impl FnOnce() -> R) -> R {
    let before = CALL_LIMIT.replace(threads);
    let result = work();
    CALL_LIMIT.set(before);
    result
}

/// Runs `work` with `hook` called now and then from this thread with the share that is done;
/// when it answers `true`, the work ends with [`Error::Interrupted`].
pub fn with_interrupt<R>(hook: impl FnMut(f64) -> bool + 'static, work: impl FnOnce() -> R) -> R {
    let before = HOOK.replace(Some(Box::new(hook)));
    let result = work();
    HOOK.replace(before);
    result
}

/// Calls this thread's hook with the share that is done, for work that is cut into several calls.
///
/// # Errors
/// [`Error::Interrupted`] where the hook says so.
pub fn check_interrupt(done: f64) -> Result<()> {
    let stop = HOOK.with_borrow_mut(|hook| hook.as_mut().is_some_and(|hook| hook(done)));
    if stop { Err(Error::Interrupted) } else { Ok(()) }
}

/// Calls `work(i, tile)` for every tile of an iterator, on as many threads as allowed.
///
/// The tiles are usually disjoint `&mut` parts of an output. The first error ends the work.
pub fn for_each<T: Send>(
    tiles: impl ExactSizeIterator<Item = T> + Send,
    work: impl Fn(usize, T) -> Result<()> + Sync,
) -> Result<()> {
    let total = tiles.len();
    let queue = Mutex::new(tiles.enumerate());
    in_turn(total, &|end| {
        let next = {
            let mut queue = queue.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            if total - queue.len() >= end { None } else { queue.next() }
        };
        next.map(|(i, tile)| work(i, tile))
    })
}

/// Calls `step` until all of `total` tiles are done; `step(end)` works on the next tile, if it is before number `end`.
/// Compiled once, whatever the work.
fn in_turn(total: usize, step: &(dyn Fn(usize) -> Option<Result<()>> + Sync)) -> Result<()> {
    // Asking how many threads there are takes longer than a small tile.
    let threads = if total > 1 { num_threads().min(total) } else { 1 };
    if threads <= 1 {
        for i in 0..total {
            if i % TILES_PER_CHECK == TILES_PER_CHECK - 1 {
                check_interrupt(i as f64 / total as f64)?;
            }
            step(total).unwrap_or(Ok(()))?;
        }
        return Ok(());
    }
    let mut done = 0;
    while done < total {
        let end = total.min(done + TILES_PER_CHECK.max(threads));
        let failed = Mutex::new(None);
        run_on_pool(threads, &|| {
            while let Some(result) = step(end) {
                if let Err(error) = result {
                    *failed.lock().unwrap_or_else(std::sync::PoisonError::into_inner) = Some(error);
                    break;
                }
            }
        });
        if let Some(error) = failed.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner) {
            return Err(error);
        }
        done = end;
        if done < total {
            check_interrupt(done as f64 / total as f64)?;
        }
    }
    Ok(())
}

/// Runs `work`, on the calling thread alone where there are fewer than [`SERIAL`] pixels in all.
pub fn alone_below<R>(pixels: usize, work: impl FnOnce() -> R) -> R {
    if pixels < SERIAL { with_threads(Some(1), work) } else { work() }
}

/// As [`for_each`], on the calling thread alone where there are fewer than [`SERIAL`] pixels in all.
pub fn for_pixels<T: Send>(
    pixels: usize,
    tiles: impl ExactSizeIterator<Item = T> + Send,
    work: impl Fn(usize, T) -> Result<()> + Sync,
) -> Result<()> {
    alone_below(pixels, || for_each(tiles, work))
}

/// Calls `worker` once on each of `threads` threads and waits for them.
#[cfg(feature = "rayon")]
fn run_on_pool(threads: usize, worker: &(dyn Fn() + Sync)) {
    // The pool of a forked child has no living threads: keep one pool a process.
    static POOL: Mutex<Option<(u32, usize, std::sync::Arc<rayon::ThreadPool>)>> = Mutex::new(None);
    let pool = {
        let mut slot = POOL.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let pid = std::process::id();
        match &*slot {
            Some((owner, size, pool)) if *owner == pid && *size >= threads => Some(pool.clone()),
            _ => {
                if slot.as_ref().is_some_and(|(owner, ..)| *owner != pid) {
                    // Dropping it would wait for threads that this process does not have.
                    std::mem::forget(slot.take());
                }
                let built = rayon::ThreadPoolBuilder::new()
                    .num_threads(threads)
                    .thread_name(|i| format!("multum-{i}"))
                    .build();
                built.ok().map(|pool| {
                    let pool = std::sync::Arc::new(pool);
                    *slot = Some((pid, threads, pool.clone()));
                    pool
                })
            }
        }
    };
    match pool {
        Some(pool) => pool.scope(|scope| {
            for _ in 0..threads {
                scope.spawn(|_| worker());
            }
        }),
        // The system gives no more threads: this one does all the work.
        None => worker(),
    }
}

#[cfg(not(feature = "rayon"))]
fn run_on_pool(_threads: usize, worker: &(dyn Fn() + Sync)) {
    worker();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_tile_is_visited_once_for_any_thread_count() {
        for threads in [1, 2, 7, 0] {
            let mut out = vec![0u32; 10_007];
            let result = with_threads(Some(threads), || {
                for_each(out.chunks_mut(10), |i, tile| {
                    for (k, value) in tile.iter_mut().enumerate() {
                        *value += (i * 10 + k) as u32;
                    }
                    Ok(())
                })
            });
            assert!(result.is_ok());
            assert!(out.iter().enumerate().all(|(i, &v)| v == i as u32), "{threads} threads");
        }
    }

    #[test]
    fn the_first_error_and_the_hook_end_the_work() {
        for threads in [1, 3] {
            let fail = with_threads(Some(threads), || {
                for_each(
                    0..1000usize,
                    |i, _| if i == 500 { Err(Error::value("i", i, "less")) } else { Ok(()) },
                )
            });
            assert!(matches!(fail, Err(Error::Value { .. })));
            let stop = with_threads(Some(threads), || {
                with_interrupt(|done| done > 0.3, || for_each(0..10_000usize, |_, _| Ok(())))
            });
            assert!(matches!(stop, Err(Error::Interrupted)));
        }
    }
}
