//! The latest picture of an input that does not wait.
//!
//! A camera goes on whether its pictures are taken or not. Left in a queue they would reach the method later and later, so a
//! thread takes every picture as it comes and keeps the latest alone: whoever asks gets what the camera shows now. Those that
//! nobody asked for in time are counted.

use std::{
    io,
    panic::resume_unwind,
    sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError},
    thread::{JoinHandle, spawn},
};

use crate::decoders::{Decode, Decoded, timed};

/// A decoder in a thread of its own, of whose pictures the latest is kept.
#[derive(Debug)]
pub(crate) struct Latest<P> {
    shared: Arc<Shared<P>>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug)]
struct Shared<P> {
    state: Mutex<State<P>>,
    changed: Condvar,
}

#[derive(Debug)]
struct State<P> {
    /// The latest picture, where it has not been taken yet.
    newest: Option<Decoded<P>>,
    /// Why there are no more, if that is an error.
    failure: Option<io::Error>,
    ended: bool,
    /// Nobody takes pictures any more.
    abandoned: bool,
    dropped: u64,
    /// Memory for the next pictures.
    spare: Vec<Vec<u8>>,
}

/// A picture whose memory can be used again.
pub(crate) trait Reusable {
    /// Its memory.
    fn into_buffer(self) -> Vec<u8>;
}

impl<P: Reusable + Send + 'static> Latest<P> {
    /// Begins to decode.
    pub(crate) fn start<D: Decode<Picture = io::Result<P>>>(decoder: D) -> Self {
        let state = State {
            newest: None,
            failure: None,
            ended: false,
            abandoned: false,
            dropped: 0,
            spare: Vec::new(),
        };
        let shared = Arc::new(Shared { state: Mutex::new(state), changed: Condvar::new() });
        let work = Ending(Arc::clone(&shared));
        Self { shared, thread: Some(spawn(move || work.keep_latest(decoder))) }
    }

    /// The latest picture that has not been taken yet, or the next one; none behind the last. A failure comes behind the
    /// pictures before it.
    pub(crate) fn next(&mut self) -> Option<Decoded<io::Result<P>>> {
        let mut state = self.shared.lock();
        loop {
            if let Some(Decoded { picture, decoding }) = state.newest.take() {
                return Some(Decoded { picture: Ok(picture), decoding });
            }
            if let Some(failure) = state.failure.take() {
                return Some(Decoded { picture: Err(failure), decoding: std::time::Duration::ZERO });
            }
            if state.ended {
                break;
            }
            state = self.shared.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        drop(state);
        if let Some(Err(fault)) = self.thread.take().map(JoinHandle::join) {
            // A fault of the decoder is one of the caller's, as it would be without a thread.
            resume_unwind(fault);
        }
        None
    }
}

impl<P> Latest<P> {
    /// Takes a buffer back for a later picture.
    pub(crate) fn recycle(&mut self, buffer: Vec<u8>) {
        self.shared.lock().spare.push(buffer);
    }

    /// Pictures so far that gave way to later ones before anybody asked for them.
    pub(crate) fn dropped(&self) -> u64 {
        self.shared.lock().dropped
    }
}

impl<P> Drop for Latest<P> {
    fn drop(&mut self) {
        self.shared.lock().abandoned = true;
        // What became of the thread is of no interest any more.
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

impl<P> Shared<P> {
    fn lock(&self) -> MutexGuard<'_, State<P>> {
        // Every change is whole before anything that could fail.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Says that there are no more pictures when the thread ends, however it does.
struct Ending<P>(Arc<Shared<P>>);

impl<P> Drop for Ending<P> {
    fn drop(&mut self) {
        self.0.lock().ended = true;
        self.0.changed.notify_all();
    }
}

impl<P: Reusable> Ending<P> {
    fn keep_latest<D: Decode<Picture = io::Result<P>>>(self, mut decoder: D) {
        loop {
            let buffer = self.0.lock().spare.pop().unwrap_or_default();
            let Some(Decoded { picture, decoding }) = timed(&mut decoder, buffer) else { return };
            let mut state = self.0.lock();
            if state.abandoned {
                return;
            }
            match picture {
                Ok(picture) => {
                    if let Some(before) = state.newest.replace(Decoded { picture, decoding }) {
                        state.dropped += 1;
                        state.spare.push(before.picture.into_buffer());
                    }
                }
                Err(failure) => {
                    state.failure = Some(failure);
                    return;
                }
            }
            drop(state);
            self.0.changed.notify_all();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::{
        sync::mpsc::{Receiver, Sender, channel},
        thread::sleep,
        time::{Duration, Instant},
    };

    use super::*;

    struct Number(u32);

    impl Reusable for Number {
        fn into_buffer(self) -> Vec<u8> {
            Vec::new()
        }
    }

    /// Gives the numbers that it is sent, and breaks at zero.
    struct Relay(Receiver<u32>);

    impl Decode for Relay {
        type Picture = io::Result<Number>;

        fn decode(&mut self, _buffer: Vec<u8>) -> Option<Self::Picture> {
            let number = self.0.recv().ok()?;
            Some(if number == 0 { Err(io::Error::other("broken")) } else { Ok(Number(number)) })
        }
    }

    fn relay() -> (Sender<u32>, Latest<Number>) {
        let (sender, receiver) = channel();
        (sender, Latest::start(Relay(receiver)))
    }

    /// Waits until so many pictures have been dropped.
    fn wait_for_drops(latest: &Latest<Number>, dropped: u64) {
        let began = Instant::now();
        while latest.dropped() < dropped {
            assert!(began.elapsed() < Duration::from_secs(60), "{} dropped", latest.dropped());
            sleep(Duration::from_millis(1));
        }
    }

    fn next(latest: &mut Latest<Number>) -> Option<Result<u32, String>> {
        latest.next().map(|decoded| match decoded.picture {
            Ok(Number(number)) => Ok(number),
            Err(error) => Err(error.to_string()),
        })
    }

    #[test]
    fn who_asks_late_gets_the_latest_and_who_asks_early_gets_all() {
        let (sender, mut latest) = relay();
        for number in 1..=3 {
            sender.send(number).unwrap();
            assert_eq!(next(&mut latest), Some(Ok(number)));
        }
        assert_eq!(latest.dropped(), 0);
        (4..=9).for_each(|number| sender.send(number).unwrap());
        wait_for_drops(&latest, 5);
        assert_eq!(next(&mut latest), Some(Ok(9)));
        drop(sender);
        assert_eq!((next(&mut latest), latest.dropped()), (None, 5));
    }

    #[test]
    fn a_failure_comes_behind_the_latest_picture() {
        let (sender, mut latest) = relay();
        [1, 2, 0].into_iter().for_each(|number| sender.send(number).unwrap());
        wait_for_drops(&latest, 1);
        assert_eq!(next(&mut latest), Some(Ok(2)));
        assert_eq!(next(&mut latest), Some(Err("broken".to_owned())));
        assert_eq!(next(&mut latest), None);
    }
}
