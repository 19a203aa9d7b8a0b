//! Work off the thread that draws: a [`Lane`] does one job at a time, and of those that wait only the latest.
//!
//! While somebody drags a slider, jobs are asked for faster than they end. One that is quick is let to its end, so that the picture
//! follows the hand; one that has brought a first answer, or takes longer than `PATIENCE` for it, is told to stop when a newer one is
//! waiting.

use crate::progress::Progress;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// A job that has run for longer is stopped for a newer one.
const PATIENCE: Duration = Duration::from_millis(400);

/// What a running job tells of itself, and how it is stopped.
#[derive(Debug)]
pub struct Meter {
    stage: Mutex<String>,
    total: AtomicU64,
    done: AtomicU64,
    cancelled: AtomicBool,
    answered: AtomicBool,
    begin: Instant,
}

impl Default for Meter {
    fn default() -> Self {
        Self {
            stage: Mutex::default(),
            total: AtomicU64::new(0),
            done: AtomicU64::new(0),
            cancelled: AtomicBool::new(false),
            answered: AtomicBool::new(false),
            begin: Instant::now(),
        }
    }
}

impl Meter {
    /// Asks the job to stop.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// True if it may be stopped for a newer one.
    fn has_had_its_time(&self) -> bool {
        self.answered.load(Ordering::Relaxed) || self.elapsed() > PATIENCE
    }

    /// The stage's name, and the share of it that is done if that is known.
    #[must_use]
    pub fn state(&self) -> (String, Option<f32>) {
        let (total, done) = (self.total.load(Ordering::Relaxed), self.done.load(Ordering::Relaxed));
        (lock(&self.stage).clone(), (total > 0).then(|| (done as f32 / total as f32).min(1.0)))
    }

    /// Time since the job was asked for.
    #[must_use]
    pub fn elapsed(&self) -> Duration {
        self.begin.elapsed()
    }
}

impl Progress for Meter {
    fn stage(&self, name: &str, total: u64) {
        name.clone_into(&mut lock(&self.stage));
        self.total.store(total, Ordering::Relaxed);
        self.done.store(0, Ordering::Relaxed);
    }

    fn done(&self, done: u64) {
        self.done.store(done, Ordering::Relaxed);
    }

    fn cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

/// Takes what a job brings forth; may be called several times.
pub type Deliver<'a, T> = &'a dyn Fn(T);

type Job<T> = Box<dyn FnOnce(&Arc<Meter>, Deliver<'_, T>) + Send>;

struct State<T> {
    next: Option<(Arc<Meter>, Job<T>)>,
    running: Option<Arc<Meter>>,
    results: Vec<T>,
    closed: bool,
}

struct Shared<T> {
    state: Mutex<State<T>>,
    changed: Condvar,
    wake: Box<dyn Fn() + Send + Sync>,
}

/// A thread for one kind of work.
pub struct Lane<T: Send + 'static> {
    shared: Arc<Shared<T>>,
}

impl<T: Send + 'static> std::fmt::Debug for Lane<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Lane").field("busy", &self.meter().is_some()).finish_non_exhaustive()
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<T: Send + 'static> Lane<T> {
    /// A lane whose thread has that name; `wake` is called whenever a result has come. Where the system gives no thread, jobs
    /// are done at once by whoever asks for them.
    pub fn new(name: &str, wake: impl Fn() + Send + Sync + 'static) -> Self {
        let state = State { next: None, running: None, results: Vec::new(), closed: false };
        let shared = Arc::new(Shared { state: Mutex::new(state), changed: Condvar::new(), wake: Box::new(wake) });
        let inner = Arc::clone(&shared);
        let thread = std::thread::Builder::new().name(name.to_owned());
        if thread.spawn(move || while inner.turn(true) {}).is_err() {
            lock(&shared.state).closed = true;
        }
        Self { shared }
    }

    /// Asks for a job instead of the one that waits, if one does.
    pub fn submit(&self, job: impl FnOnce(&Arc<Meter>, Deliver<'_, T>) + Send + 'static) {
        let mut state = lock(&self.shared.state);
        if let Some(running) = state.running.as_ref().filter(|m| m.has_had_its_time()) {
            running.cancel();
        }
        state.next = Some((Arc::default(), Box::new(job)));
        let alone = state.closed;
        drop(state);
        self.shared.changed.notify_one();
        if alone {
            self.shared.turn(false);
        }
    }

    /// Stops what runs and forgets what waits.
    pub fn cancel(&self) {
        let mut state = lock(&self.shared.state);
        state.next = None;
        if let Some(running) = &state.running {
            running.cancel();
        }
    }

    /// What has come since the last call, in order.
    #[must_use]
    pub fn take(&self) -> Vec<T> {
        std::mem::take(&mut lock(&self.shared.state).results)
    }

    /// True if no job runs or waits, and all that has come was taken.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        let state = lock(&self.shared.state);
        state.next.is_none() && state.running.is_none() && state.results.is_empty()
    }

    /// Of the job that runs or waits, if there is one.
    #[must_use]
    pub fn meter(&self) -> Option<Arc<Meter>> {
        let state = lock(&self.shared.state);
        state.next.as_ref().map(|(meter, _)| meter).or(state.running.as_ref()).map(Arc::clone)
    }
}

impl<T> Shared<T> {
    /// Waits for a job and does it; false once the lane is closed.
    fn turn(&self, wait: bool) -> bool {
        let mut state = lock(&self.state);
        while wait && state.next.is_none() && !state.closed {
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        let Some((meter, job)) = state.next.take() else { return false };
        state.running = Some(Arc::clone(&meter));
        drop(state);
        job(&meter, &|result| {
            let mut state = lock(&self.state);
            state.results.push(result);
            meter.answered.store(true, Ordering::Relaxed);
            if state.next.is_some() {
                meter.cancel();
            }
            drop(state);
            (self.wake)();
        });
        lock(&self.state).running = None;
        (self.wake)();
        true
    }
}

impl<T: Send + 'static> Drop for Lane<T> {
    fn drop(&mut self) {
        let mut state = lock(&self.shared.state);
        state.closed = true;
        state.next = None;
        if let Some(running) = &state.running {
            running.cancel();
        }
        drop(state);
        self.shared.changed.notify_one();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::channel;

    #[test]
    fn of_the_jobs_that_wait_only_the_latest_is_done() {
        let (woken, wake) = channel();
        let lane: Lane<u32> = Lane::new("test", move || woken.send(()).unwrap());
        let (go, gate) = channel::<()>();
        lane.submit(move |_, deliver| {
            let _ = gate.recv();
            deliver(1);
        });
        // Until the first runs, another would take its place.
        while lock(&lane.shared.state).running.is_none() {
            std::thread::yield_now();
        }
        lane.submit(|_, deliver| deliver(2));
        lane.submit(|_, deliver| deliver(3));
        go.send(()).expect("the first waits");
        let mut results = Vec::new();
        while lane.meter().is_some() || results.len() < 2 {
            let _ = wake.recv_timeout(Duration::from_secs(10));
            results.extend(lane.take());
        }
        assert_eq!(results, [1, 3], "the second was never begun");
    }

    #[test]
    fn a_job_that_has_answered_makes_way_for_a_newer_one() {
        let lane: Lane<u32> = Lane::new("test", || ());
        let draft_then_wait = |meter: &Arc<Meter>, deliver: Deliver<'_, u32>| {
            deliver(1);
            while !meter.cancelled() {
                std::thread::yield_now();
            }
        };
        lane.submit(draft_then_wait);
        let mut results = Vec::new();
        while results.is_empty() {
            results.extend(lane.take());
        }
        // It would wait for ever.
        lane.submit(|_, deliver| deliver(2));
        while !lane.is_idle() {
            results.extend(lane.take());
        }
        assert_eq!(results, [1, 2]);
    }

    #[test]
    fn a_running_job_hears_that_it_is_cancelled() {
        let lane: Lane<bool> = Lane::new("test", || ());
        lane.submit(|meter, deliver| {
            while !meter.cancelled() {
                std::thread::yield_now();
            }
            deliver(true);
        });
        while lock(&lane.shared.state).running.is_none() {
            std::thread::yield_now();
        }
        lane.cancel();
        while lane.meter().is_some() {
            std::thread::yield_now();
        }
        assert_eq!(lane.take(), [true], "it ended by itself");
    }
}
