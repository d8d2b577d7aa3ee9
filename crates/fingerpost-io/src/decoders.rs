//! Decoding ahead: pictures are made in threads of their own while the ones before are worked on.
//!
//! Several decoders take turns, so that the order is that of the input; together they may be a few pictures ahead and then
//! wait, which bounds the memory. Buffers go round: a picture that is no longer needed is handed back for a later one.

use std::{
    num::NonZeroUsize,
    panic::resume_unwind,
    sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel},
    thread::{JoinHandle, spawn},
    time::{Duration, Instant},
};

/// Pictures that wait behind all decoders together: enough to go on with while a frame takes longer than others. Every
/// decoder has one more in its hands, and where there are many of them, one that waits.
const AHEAD: usize = 8;

/// Makes pictures one after the other.
pub(crate) trait Decode: Send + 'static {
    /// A picture, or why there is none.
    type Picture: Send + 'static;

    /// The next one, in the memory of `buffer` where that is possible; none behind the last.
    fn decode(&mut self, buffer: Vec<u8>) -> Option<Self::Picture>;
}

/// A decoded picture.
#[derive(Debug)]
pub(crate) struct Decoded<P> {
    /// What was made.
    pub(crate) picture: P,
    /// Wall time that it took, waiting for the input with it.
    pub(crate) decoding: Duration,
}

/// Decoders that take turns.
#[derive(Debug)]
pub(crate) enum Decoders<D: Decode> {
    /// One that works only when it is asked.
    OnDemand {
        /// It.
        decoder: D,
        /// Memory for the next picture.
        spare: Vec<u8>,
    },
    /// Some that work ahead, each in its thread.
    Ahead {
        /// They, in the order of their turns.
        workers: Vec<Worker<D::Picture>>,
        /// Whose picture comes next.
        turn: usize,
        /// Who gets the next buffer back.
        recycling: usize,
    },
}

/// A decoder in a thread of its own, seen from outside.
#[derive(Debug)]
pub(crate) struct Worker<P> {
    decoded: Option<Receiver<Decoded<P>>>,
    spare: Sender<Vec<u8>>,
    thread: Option<JoinHandle<()>>,
}

/// How many threads there may be where nobody says: as many as the machine runs at once.
pub(crate) fn threads_of_machine() -> NonZeroUsize {
    std::thread::available_parallelism().unwrap_or(NonZeroUsize::MIN)
}

impl<D: Decode> Decoders<D> {
    /// One decoder that works on demand.
    pub(crate) const fn on_demand(decoder: D) -> Self {
        Self::OnDemand { decoder, spare: Vec::new() }
    }

    /// Decoders that work ahead from now on; the first makes the first picture, the second the second, and so on in turns.
    pub(crate) fn ahead(decoders: impl IntoIterator<Item = D>) -> Self {
        let decoders: Vec<D> = decoders.into_iter().collect();
        let waiting = AHEAD.div_ceil(decoders.len().max(1));
        let workers = decoders.into_iter().map(|decoder| Worker::start(decoder, waiting)).collect();
        Self::Ahead { workers, turn: 0, recycling: 0 }
    }

    /// The next picture; none behind the last.
    pub(crate) fn next(&mut self) -> Option<Decoded<D::Picture>> {
        match self {
            Self::OnDemand { decoder, spare } => timed(decoder, std::mem::take(spare)),
            Self::Ahead { workers, turn, .. } => {
                let decoded = workers.get_mut(*turn)?.take();
                *turn = (*turn + 1) % workers.len();
                decoded
            }
        }
    }

    /// Takes a buffer back for a later picture.
    pub(crate) fn recycle(&mut self, buffer: Vec<u8>) {
        match self {
            Self::OnDemand { spare, .. } => *spare = buffer,
            Self::Ahead { workers, recycling, .. } => {
                if let Some(worker) = workers.get(*recycling) {
                    // A decoder that has come to its end needs it no more.
                    let _ = worker.spare.send(buffer);
                    *recycling = (*recycling + 1) % workers.len();
                }
            }
        }
    }
}

impl<P: Send + 'static> Worker<P> {
    /// Starts a decoder behind which so many pictures may wait.
    fn start<D: Decode<Picture = P>>(mut decoder: D, waiting: usize) -> Self {
        let (sender, decoded) = sync_channel(waiting);
        let (spare, buffers) = channel();
        let thread = spawn(move || work(&mut decoder, &buffers, &sender));
        Self { decoded: Some(decoded), spare, thread: Some(thread) }
    }
}

impl<P> Worker<P> {
    fn take(&mut self) -> Option<Decoded<P>> {
        let decoded = self.decoded.as_ref()?.recv();
        if decoded.is_err()
            && let Some(Err(fault)) = self.thread.take().map(JoinHandle::join)
        {
            // A fault of the decoder is one of the caller's, as it would be without a thread.
            resume_unwind(fault);
        }
        decoded.ok()
    }
}

impl<P> Drop for Worker<P> {
    fn drop(&mut self) {
        // The thread ends because nobody takes its pictures any more; what became of it is of no interest then.
        self.decoded = None;
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

fn work<D: Decode>(decoder: &mut D, buffers: &Receiver<Vec<u8>>, sender: &SyncSender<Decoded<D::Picture>>) {
    while let Some(decoded) = timed(decoder, buffers.try_recv().unwrap_or_default()) {
        if sender.send(decoded).is_err() {
            return;
        }
    }
}

/// The next picture with the time that it took.
pub(crate) fn timed<D: Decode>(decoder: &mut D, buffer: Vec<u8>) -> Option<Decoded<D::Picture>> {
    let began = Instant::now();
    let picture = decoder.decode(buffer)?;
    Some(Decoded { picture, decoding: began.elapsed() })
}

#[cfg(test)]
mod tests {
    use std::sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
    };

    use super::*;

    /// Counts from a number in steps; says how many it has made.
    struct Counter {
        next: usize,
        step: usize,
        end: usize,
        made: Arc<AtomicUsize>,
    }

    impl Decode for Counter {
        type Picture = usize;

        fn decode(&mut self, _buffer: Vec<u8>) -> Option<usize> {
            let number = (self.next < self.end).then_some(self.next)?;
            self.next += self.step;
            self.made.fetch_add(1, Ordering::SeqCst);
            Some(number)
        }
    }

    fn counters(count: usize, end: usize) -> (Vec<Counter>, Arc<AtomicUsize>) {
        let made = Arc::new(AtomicUsize::new(0));
        let counter = |next| Counter { next, step: count, end, made: Arc::clone(&made) };
        ((0..count).map(counter).collect(), made)
    }

    fn all(mut decoders: Decoders<Counter>) -> Vec<usize> {
        std::iter::from_fn(|| decoders.next()).map(|decoded| decoded.picture).collect()
    }

    #[test]
    fn the_order_is_that_of_the_input_whoever_decodes() {
        let expected: Vec<usize> = (0..101).collect();
        for decoder in counters(1, 101).0 {
            assert_eq!(all(Decoders::on_demand(decoder)), expected);
        }
        for count in [1, 2, 7] {
            assert_eq!(all(Decoders::ahead(counters(count, 101).0)), expected, "{count}");
        }
    }

    #[test]
    fn decoders_wait_when_they_are_far_ahead_and_end_when_nobody_takes_any_more() {
        let (two, made) = counters(2, usize::MAX);
        let mut decoders = Decoders::ahead(two);
        assert_eq!(decoders.next().map(|decoded| decoded.picture), Some(0));
        std::thread::sleep(Duration::from_millis(50));
        drop(decoders);
        // One taken; those that wait, and the one in each decoder's hands.
        assert!(made.load(Ordering::SeqCst) <= 1 + AHEAD + 2, "{made:?}");
    }

    #[test]
    fn buffers_come_back_to_the_decoders() {
        struct Sizes(usize);
        impl Decode for Sizes {
            type Picture = Vec<u8>;
            fn decode(&mut self, mut buffer: Vec<u8>) -> Option<Vec<u8>> {
                self.0 = self.0.checked_sub(1)?;
                if buffer.capacity() == 0 {
                    buffer = Vec::with_capacity(1000);
                }
                Some(buffer)
            }
        }
        let mut decoders = Decoders::ahead([Sizes(300)]);
        let mut places = std::collections::BTreeSet::new();
        while let Some(Decoded { picture, .. }) = decoders.next() {
            places.insert(picture.as_ptr());
            decoders.recycle(picture);
        }
        assert!(places.len() <= AHEAD + 3, "{} buffers", places.len());
    }
}
