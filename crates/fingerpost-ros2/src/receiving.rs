//! The thread that takes messages from DDS as they come, whatever the method is at.

use std::convert::Infallible;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Wake, Waker};
use std::thread::{self, JoinHandle, Thread};
use std::time::Duration;

use fingerpost_io::bag::{Schema, decode};
use rustdds::RepresentationIdentifier;
use rustdds::no_key::{Decode, DefaultDecoder, DeserializerAdapter, SimpleDataReader};

use crate::health::Input;
use crate::inbox::Inbox;

/// Longest sleep of the thread: how soon it sees that it is to end, and that a wake-up was missed.
const LONGEST_SLEEP: Duration = Duration::from_millis(50);

/// Messages as they are on the wire: the encapsulation's four bytes and CDR, as bags hold them.
#[derive(Debug)]
pub(crate) struct Wire;

/// Copies a message.
#[derive(Debug, Clone)]
pub(crate) struct CopyBytes;

impl DeserializerAdapter<Vec<u8>> for Wire {
    type Error = Infallible;
    type Decoded = Vec<u8>;

    fn supported_encodings() -> &'static [RepresentationIdentifier] {
        const ENCODINGS: [RepresentationIdentifier; 2] =
            [RepresentationIdentifier::CDR_LE, RepresentationIdentifier::CDR_BE];
        &ENCODINGS
    }

    fn transform_decoded(decoded: Vec<u8>) -> Vec<u8> {
        decoded
    }
}

impl<'de> Decode<'de, Vec<u8>> for CopyBytes {
    type Error = Infallible;

    fn decode_bytes(
        self,
        input_bytes: &'de [u8],
        encoding: RepresentationIdentifier,
    ) -> Result<Vec<u8>, Infallible> {
        let [first, second] = encoding.to_bytes();
        Ok([&[first, second, 0, 0], input_bytes].concat())
    }
}

impl DefaultDecoder<Vec<u8>> for Wire {
    type Decoder = CopyBytes;
    const DECODER: CopyBytes = CopyBytes;
}

/// A topic that is listened to.
pub(crate) struct Listened {
    pub(crate) input: Input,
    pub(crate) schema: Schema,
    pub(crate) reader: SimpleDataReader<Vec<u8>, Wire>,
}

/// Wakes the thread.
struct Unpark(Thread);

impl Wake for Unpark {
    fn wake(self: Arc<Self>) {
        self.0.unpark();
    }
}

/// The thread, which ends with this.
#[derive(Debug)]
pub(crate) struct Receiving {
    ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Receiving {
    /// Begins to listen.
    pub(crate) fn begin(topics: Vec<Listened>, inbox: Arc<Inbox>) -> std::io::Result<Self> {
        let ended = Arc::new(AtomicBool::new(false));
        let theirs = Arc::clone(&ended);
        let listen = move || receive(&topics, &inbox, &theirs);
        let thread = thread::Builder::new().name("ros2".to_owned()).spawn(listen)?;
        Ok(Self { ended, thread: Some(thread) })
    }
}

impl Drop for Receiving {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // A thread that ended early has said nothing that could be told here.
            let _ = thread.join();
        }
    }
}

fn receive(topics: &[Listened], inbox: &Inbox, ended: &AtomicBool) {
    let waker = Waker::from(Arc::new(Unpark(thread::current())));
    while !ended.load(Ordering::Acquire) {
        for Listened { input, schema, reader } in topics {
            // Set before looking: what comes from here on wakes.
            reader.set_waker(Some(waker.clone()));
            reader.drain_read_notifications();
            loop {
                match reader.try_take_one() {
                    Ok(Some(taken)) => {
                        let message = decode(*schema, &taken.into_value());
                        inbox.put(*input, message.map_err(|cause| cause.to_string()));
                    }
                    Ok(None) => break,
                    Err(cause) => {
                        inbox.put(
                            *input,
                            Err(format!("a message is not CDR ({cause}); its sender is at fault")),
                        );
                    }
                }
            }
        }
        thread::park_timeout(LONGEST_SLEEP);
    }
}
