//! Sets that may be put aside on their way.

use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::Poll;

use super::past::Past;
use super::runner::{Clash, Fate, Runner};
use crate::identify::problem::Problem;
use veribound_flow::form::{Allowance, poll};
use veribound_interval::Interval;

/// A set that stands at a sample, or is on its way from there.
pub(super) struct Going {
    /// The last sample that it met before it set out.
    pub(super) at: u64,
    /// The newest one when it did.
    newest: u64,
    stage: Stage,
}

enum Stage {
    Stands(Box<Runner>),
    /// Whoever asks has it alone: the lock is never held by two.
    Moves(Mutex<Pin<Box<dyn Future<Output = Gone> + Send>>>),
}

/// A set that has arrived.
pub(super) struct Gone {
    pub(super) runner: Box<Runner>,
    /// As of [`Runner::go`].
    pub(super) found: Result<(Fate, Option<Vec<Interval>>), Option<Clash>>,
}

/// What becomes of a set when it may go on.
pub(super) enum Next {
    /// Its allowance is spent, or there is no sample that it may go to.
    Rests(Going),
    /// It arrived; the newest sample was this one when it set out.
    Arrived(Gone, u64),
}

impl Going {
    pub(super) fn new(runner: Runner) -> Going {
        Going {
            at: runner.at,
            newest: runner.at,
            stage: Stage::Stands(Box::new(runner)),
        }
    }

    /// The set where it stands.
    pub(super) fn standing(&self) -> Option<&Runner> {
        match &self.stage {
            Stage::Stands(runner) => Some(runner),
            Stage::Moves(_) => None,
        }
    }

    /// Goes on as far as the allowance reaches, at most so many samples, keeping so many rows; it knows `most_known` samples ahead, and
    /// what is known of parameters when it sets out.
    pub(super) fn go_on(
        self,
        problem: &Arc<Problem>,
        (past, known): (&Past, &[Interval]),
        (limits, most_known): ((usize, usize), usize),
        allowance: &Arc<Allowance>,
    ) -> Next {
        let Going { at, newest, stage } = self;
        let (newest, mut way) = match stage {
            Stage::Moves(way) => {
                let way = way.into_inner().unwrap_or_else(PoisonError::into_inner);
                (newest, way)
            }
            Stage::Stands(mut runner) => {
                let newest = past.newest();
                if allowance.left() <= 0 || !runner.may_go(newest) {
                    let stage = Stage::Stands(runner);
                    return Next::Rests(Going { at, newest, stage });
                }
                runner.learn(known);
                let (problem, allowance) = (Arc::clone(problem), Arc::clone(allowance));
                let past = past.from(at, most_known);
                let way: Pin<Box<dyn Future<Output = Gone> + Send>> = Box::pin(async move {
                    let past = (&past, newest);
                    let found = runner.go(&problem, past, limits, &allowance).await;
                    Gone { runner, found }
                });
                (newest, way)
            }
        };
        match poll(way.as_mut()) {
            Poll::Ready(gone) => Next::Arrived(gone, newest),
            Poll::Pending => Next::Rests(Going {
                at,
                newest,
                stage: Stage::Moves(Mutex::new(way)),
            }),
        }
    }
}
