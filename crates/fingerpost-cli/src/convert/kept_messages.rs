//! What a recording's measurements take: they are kept until its end, where pictures go into files as they come.

use anyhow::{Result, bail};
use fingerpost_io::bag::{Choice, GpsPosition, Inertial, Role, Topic, Twist, VehicleMotion};

use crate::arguments::InputLimit;

/// A list that grows is copied into one of twice its size: for a moment both are there.
const GROWTH: u64 = 3;

/// Bytes that a message of a role takes at the most. The names of its frame are kept once, in bounds of their own.
const fn message_bytes(role: Role) -> u64 {
    let kept = match role {
        Role::Gps => size_of::<(u64, GpsPosition)>(),
        // A row of motion comes of each.
        Role::Twist => size_of::<(u64, Twist)>() + size_of::<(u64, VehicleMotion)>(),
        Role::Imu => size_of::<(u64, Inertial)>(),
        Role::Pictures | Role::Calibration | Role::Transforms => 0,
    };
    GROWTH * kept as u64
}

/// Refuses a recording whose measurements take more memory than an input may: a small file can unpack to any number of them.
pub(super) fn check(topics: &[Topic], choice: &Choice, limit: InputLimit) -> Result<()> {
    let mut left_bytes = limit.bytes() as u64;
    for role in [Role::Gps, Role::Twist, Role::Imu] {
        let used = topics.iter().find(|topic| choice.topic(role) == Some(&topic.name));
        let Some(Topic { name, messages, .. }) = used else { continue };
        let taken = messages.checked_mul(message_bytes(role));
        let Some(left) = taken.and_then(|taken| left_bytes.checked_sub(taken)) else {
            bail!(
                "topic {name} has {messages} messages, and {} fit into what is left of the memory that an input may take; allow more with \
                 --max-input-mib, or record less often",
                left_bytes / message_bytes(role)
            );
        };
        left_bytes = left;
    }
    Ok(())
}
