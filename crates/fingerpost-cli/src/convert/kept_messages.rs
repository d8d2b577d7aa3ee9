//! What a recording's measurements take: they are kept until its end, where pictures go into files as they come.

use anyhow::{Result, bail};
use fingerpost_io::bag::{Choice, Role, Topic};

use crate::arguments::InputLimit;

/// Bytes that a message takes at the most: a time with some numbers, in a table that has room for as many again.
const MESSAGE_BYTES: u64 = 128;

/// Refuses a recording whose measurements take more memory than an input may: a small file can unpack to any number of them.
pub(super) fn check(topics: &[Topic], choice: &Choice, limit: InputLimit) -> Result<()> {
    for role in [Role::Gps, Role::Twist, Role::Imu] {
        let used = topics.iter().find(|topic| choice.topic(role) == Some(&topic.name));
        let Some(Topic { name, messages, .. }) = used else { continue };
        let most = limit.bytes() as u64 / MESSAGE_BYTES;
        if *messages > most {
            bail!(
                "topic {name} has {messages} messages, and {most} fit into the memory that an input may take; allow more with \
                 --max-input-mib, or record less often"
            );
        }
    }
    Ok(())
}
