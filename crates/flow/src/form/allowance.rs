//! Work that may be done at once: what a form takes longer for is put aside, and goes on where it stood.
//!
//! Somebody who has to answer soon gives a journey an [`Allowance`] of work, counted in products of coefficients and never in seconds,
//! so that it stands at the same places on every machine. Between two pieces of its work a journey asks whether there is some left, and
//! waits where there is none: it is a future, and who drives it polls it again once more was given. No other waker is needed.

use std::future::Future;
use std::pin::{Pin, pin};
use std::sync::atomic::{AtomicI64, AtomicU64, Ordering};
use std::task::{Context, Poll, Waker};

/// Products of coefficients that may be spent before work is put aside.
///
/// Guarantee: a journey spends at most what one piece of its work takes, a step or a try to cross a surface, beyond what was given;
/// that is counted, so the next share is smaller by it.
///
/// ```
/// use std::task::Poll;
/// use veribound_flow::form::{Allowance, Flow, FormOptions, Meeting, Stretch, poll};
/// use veribound_interval::Interval;
///
/// # let text = "format = 1\nstates = [\"x\"]\ninit.x = [0.9, 1.1]\nparams.k = [0.5, 1]\nder.x = \"-k*x\"\noutputs.y = \"x +- 0.01\"";
/// # let model = veribound_model::Model::from_text("decay.toml", text)?;
/// let flow = Flow::new(&model);
/// let form = flow.start(&[model.states[0].init], &[model.params[0].bounds], FormOptions::default());
/// let stretches = vec![Stretch { inputs: vec![], dt: Interval::ONE }; 5];
/// let allowance = Allowance::default();
/// let (mut met, mut pauses) = (0, 0);
/// let mut meet = |_: Meeting<'_>| met += 1;
/// let mut journey = Box::pin(flow.travel(form, &stretches, &mut meet, &|_| true, &allowance));
/// while let Poll::Pending = poll(journey.as_mut()) {
///     pauses += 1;
///     allowance.give(1000);
/// }
/// drop(journey);
/// assert!(met == 6 && pauses > 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Default)]
pub struct Allowance {
    /// Less than zero where a piece of work took more than was left.
    left: AtomicI64,
}

impl Allowance {
    /// So many products more may be spent.
    pub fn give(&self, products: i64) {
        let left = self.left.load(Ordering::Relaxed);
        self.left
            .store(left.saturating_add(products), Ordering::Relaxed);
    }

    /// What is left; less than zero where more was spent than given.
    pub fn left(&self) -> i64 {
        self.left.load(Ordering::Relaxed)
    }

    /// Spends so many products, and waits until there are some left.
    pub async fn spend(&self, products: f64) {
        // More than there is room for ends at the end of the range.
        self.give(-(products.max(0.0) as i64));
        Left(self).await;
    }
}

/// What work took until now, told by who is asked on its way.
#[derive(Debug, Default)]
pub(crate) struct Spent(AtomicU64);

impl Spent {
    pub(crate) fn add(&self, work: f64) {
        let all = self.all() + work;
        self.0.store(all.to_bits(), Ordering::Relaxed);
    }

    pub(crate) fn all(&self) -> f64 {
        f64::from_bits(self.0.load(Ordering::Relaxed))
    }
}

/// Ready when something is left.
struct Left<'a>(&'a Allowance);

impl Future for Left<'_> {
    type Output = ();

    fn poll(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<()> {
        if self.0.left() > 0 {
            Poll::Ready(())
        } else {
            Poll::Pending
        }
    }
}

/// Goes on with work as far as its allowance reaches.
///
/// Example: [`Allowance`].
pub fn poll<F: Future + ?Sized>(work: Pin<&mut F>) -> Poll<F::Output> {
    work.poll(&mut Context::from_waker(Waker::noop()))
}

/// Work that has no allowance, and is never put aside.
pub(super) fn at_once<F: Future>(work: F) -> F::Output {
    let mut work = pin!(work);
    loop {
        if let Poll::Ready(done) = poll(work.as_mut()) {
            return done;
        }
    }
}
