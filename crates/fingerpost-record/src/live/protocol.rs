//! The protocol's messages. Source: Foxglove, `ws-protocol`, docs/spec.md.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Deserialize;
use serde_json::{Value, json};

use crate::recording::Channel;

/// Subprotocols that are spoken, the best first.
pub(crate) const SUBPROTOCOLS: [&str; 2] = ["foxglove.sdk.v1", "foxglove.websocket.v1"];

/// First byte of a binary message that holds one of a channel.
const MESSAGE_DATA: u8 = 1;

/// What a client says that is listened to.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(tag = "op", rename_all = "camelCase")]
pub(crate) enum Request {
    /// It wants channels.
    Subscribe {
        /// Which, and what it calls each.
        subscriptions: Vec<Subscription>,
    },
    /// It does not want them any more.
    #[serde(rename_all = "camelCase")]
    Unsubscribe {
        /// What it called them.
        subscription_ids: Vec<u32>,
    },
    /// Something else.
    #[serde(other)]
    Other,
}

/// A wish for a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Subscription {
    /// What the client calls it.
    pub(crate) id: u32,
    /// Number of the channel.
    pub(crate) channel_id: u32,
}

/// The channel of a number; numbers count from one.
pub(crate) fn channel(number: u32) -> Option<Channel> {
    let index = usize::try_from(number).ok()?.checked_sub(1)?;
    Channel::ALL.get(index).copied()
}

/// What a server says first.
pub(crate) fn server_info(name: &str) -> String {
    let info = json!({ "op": "serverInfo", "name": name, "capabilities": [], "supportedEncodings": [], "metadata": {} });
    info.to_string()
}

/// All channels with their schemas.
pub(crate) fn advertisement() -> String {
    let channels: Vec<Value> = Channel::ALL
        .into_iter()
        .zip(1_u32..)
        .map(|(channel, number)| {
            let schema = channel.schema();
            // Schemas that are texts stand as they are.
            let text = match schema.encoding.as_str() {
                "protobuf" => STANDARD.encode(&schema.data),
                _ => String::from_utf8_lossy(&schema.data).into_owned(),
            };
            json!({
                "id": number,
                "topic": channel.topic(),
                "encoding": channel.encoding(),
                "schemaName": schema.name,
                "schema": text,
                "schemaEncoding": schema.encoding,
            })
        })
        .collect();
    json!({ "op": "advertise", "channels": channels }).to_string()
}

/// A message of a channel for a subscription.
pub(crate) fn message_data(subscription: u32, time_ns: u64, data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(data.len() + 13);
    bytes.push(MESSAGE_DATA);
    bytes.extend(subscription.to_le_bytes());
    bytes.extend(time_ns.to_le_bytes());
    bytes.extend(data);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_those_of_the_specification() {
        let text = r#"{"op":"subscribe","subscriptions":[{"id":7,"channelId":3},{"id":8,"channelId":1}]}"#;
        let wanted = [Subscription { id: 7, channel_id: 3 }, Subscription { id: 8, channel_id: 1 }];
        assert_eq!(
            serde_json::from_str::<Request>(text).unwrap(),
            Request::Subscribe { subscriptions: wanted.to_vec() }
        );
        let text = r#"{"op":"unsubscribe","subscriptionIds":[7]}"#;
        assert_eq!(
            serde_json::from_str::<Request>(text).unwrap(),
            Request::Unsubscribe { subscription_ids: vec![7] }
        );
        let text = r#"{"op":"getParameters","parameterNames":[],"id":"a"}"#;
        assert_eq!(serde_json::from_str::<Request>(text).unwrap(), Request::Other);
    }

    #[test]
    fn every_channel_is_advertised_under_the_number_that_finds_it() {
        let told: Value = serde_json::from_str(&advertisement()).unwrap();
        let channels = told["channels"].as_array().unwrap();
        assert_eq!(channels.len(), Channel::ALL.len());
        for told in channels {
            let number = u32::try_from(told["id"].as_u64().unwrap()).unwrap();
            assert_eq!(channel(number).unwrap().topic(), told["topic"]);
        }
        assert_eq!((channel(0), channel(channels.len() as u32 + 1)), (None, None));
    }

    #[test]
    fn a_message_has_its_subscription_and_time_before_it() {
        let bytes = message_data(0x0102, 5, b"ab");
        assert_eq!(bytes, [1, 2, 1, 0, 0, 5, 0, 0, 0, 0, 0, 0, 0, b'a', b'b']);
    }
}
