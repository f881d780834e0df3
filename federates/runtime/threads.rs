//! Threads whose death is a fault of the run, never a silence.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Starts `body` on a thread of its own; should it end by a panic, `died` is told why.
///
/// # Errors
/// If the system gives no thread.
pub fn spawn_watched(
    name: &str,
    died: impl FnOnce(String) + Send + 'static,
    body: impl FnOnce() + Send + 'static,
) -> std::io::Result<()> {
    let called = name.to_owned();
    let thread = std::thread::Builder::new().name(called.clone());
    thread.spawn(move || {
        // What `body` owned is dropped with it; nobody sees a half-changed value.
        if let Err(cause) = catch_unwind(AssertUnwindSafe(body)) {
            died(format!("{called} ended by a broken invariant: {}", words(&*cause)));
        }
    })?;
    Ok(())
}

fn words(cause: &(dyn Any + Send)) -> &str {
    let text = cause.downcast_ref::<&str>().copied();
    text.or_else(|| cause.downcast_ref::<String>().map(String::as_str)).unwrap_or("no words left")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_that_dies_says_so_and_one_that_ends_does_not() {
        let (tell, told) = crossbeam_channel::unbounded();
        let of = tell.clone();
        spawn_watched("listener", move |why| drop(of.send(why)), || panic!("hour {}", 7))
            .expect("a thread");
        let why = told.recv().expect("told");
        assert!(why.contains("listener") && why.contains("hour 7"), "{why}");
        let of = tell.clone();
        spawn_watched("sender", move |why| drop(of.send(why)), || {}).expect("a thread");
        drop(tell);
        assert!(told.recv().is_err(), "an end in order is no fault");
    }
}
