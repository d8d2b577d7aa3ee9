//! How the inputs and the method are, as `diagnostic_msgs`, and the sentences that tell of a change.

use std::time::{Duration, Instant};

use fingerpost_format::FrameRecord;

use crate::messages::{DiagnosticArray, DiagnosticStatus, Header, KeyValue};

/// An input that gives nothing for so long is silent: cameras give ten pictures a second or more, GPS receivers a position.
const SILENT_AFTER: Duration = Duration::from_millis(1500);
/// How often diagnostics are sent: viewers take those older than five seconds for stale.
const EVERY: Duration = Duration::from_secs(1);
/// How long an input that has never come is waited for before that is said: nodes of a robot start within some seconds.
const SAY_MISSING_AFTER: Duration = Duration::from_secs(5);

// Levels of `diagnostic_msgs/DiagnosticStatus`.
const OK: u8 = 0;
const WARN: u8 = 1;
const STALE: u8 = 3;

/// What comes in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Input {
    Pictures,
    Calibration,
    Gps,
    Twist,
}

impl Input {
    pub(crate) const ALL: [Self; 4] = [Self::Pictures, Self::Calibration, Self::Gps, Self::Twist];

    /// Whether it may be silent once it has come.
    const fn comes_once(self) -> bool {
        matches!(self, Self::Calibration)
    }

    const fn name(self) -> &'static str {
        match self {
            Self::Pictures => "pictures",
            Self::Calibration => "calibration",
            Self::Gps => "gps",
            Self::Twist => "twist",
        }
    }
}

/// What has come of an input.
#[derive(Debug, Clone, Default)]
pub(crate) struct TopicCount {
    pub(crate) received: u64,
    pub(crate) last: Option<Instant>,
    /// Those that cannot be used.
    pub(crate) refused: u64,
    pub(crate) last_refusal: Option<String>,
    /// What the first of those that are used is taken for without its saying so.
    pub(crate) guess: Option<String>,
}

impl TopicCount {
    pub(crate) fn guess(&mut self, assumed: impl FnOnce() -> String) {
        self.guess.get_or_insert_with(assumed);
    }

    pub(crate) fn refuse(&mut self, cause: String) {
        self.refused += 1;
        self.last_refusal = Some(cause);
    }
}

/// An input that is listened to.
#[derive(Debug)]
struct Watched {
    input: Input,
    topic: String,
    /// What was refused when diagnostics were sent last.
    refused: u64,
    is_said: bool,
    is_guess_said: bool,
}

/// The method after a frame.
#[derive(Debug, Clone, Default)]
struct Method {
    frames: u64,
    state: String,
    why: String,
    feature: Vec<(String, String)>,
    latency_ms: f64,
}

/// Watches inputs and method.
#[derive(Debug)]
pub(crate) struct Health {
    node: String,
    began: Instant,
    sent: Option<Instant>,
    watched: Vec<Watched>,
    dropped: u64,
    method: Method,
}

impl Health {
    pub(crate) fn new(node: &str, topics: &[(Input, String)], now: Instant) -> Self {
        let watched = topics.iter().map(|(input, topic)| Watched {
            input: *input,
            topic: topic.clone(),
            refused: 0,
            is_said: false,
            is_guess_said: false,
        });
        Self {
            node: node.to_owned(),
            began: now,
            sent: None,
            watched: watched.collect(),
            dropped: 0,
            method: Method::default(),
        }
    }

    /// Takes in what the method says of a frame, and how long after its picture came.
    pub(crate) fn note(&mut self, record: &FrameRecord, latency: Duration) {
        let feature = record.feature.iter().flat_map(|feature| {
            let number =
                |value: Option<f64>| value.map_or_else(|| "unknown".to_owned(), |v| format!("{v:.3}"));
            [
                ("feature".to_owned(), feature.id.to_string()),
                ("p".to_owned(), number(feature.p)),
                ("present".to_owned(), number(feature.present)),
                ("forward_m".to_owned(), number(Some(feature.forward_m))),
                ("left_m".to_owned(), number(Some(feature.left_m))),
            ]
        });
        self.method = Method {
            frames: self.method.frames + 1,
            // As in frames.jsonl.
            state: state_name(record),
            why: record.why.clone(),
            feature: feature.collect(),
            latency_ms: 1e3 * latency.as_secs_f64(),
        };
    }

    /// What is to be said of inputs that have fallen silent, never come, come again or are used by a guess.
    pub(crate) fn changes(&mut self, now: Instant, count: impl Fn(Input) -> TopicCount) -> Vec<String> {
        let began = self.began;
        let mut said = Vec::new();
        for watched in &mut self.watched {
            let (name, topic) = (watched.input.name(), &watched.topic);
            let count = count(watched.input);
            let since = now.saturating_duration_since(count.last.unwrap_or(began));
            let longest = if count.last.is_some() { SILENT_AFTER } else { SAY_MISSING_AFTER };
            let is_silent = since > longest && !(watched.input.comes_once() && count.last.is_some());
            if is_silent && !watched.is_said {
                said.push(match count.last {
                    Some(_) => format!("{name}: {topic} has been silent for {:.1} s; check its sender", since.as_secs_f64()),
                    None => format!(
                        "{name}: nothing has come on {topic} yet; check the topic's name and type, the domain (ROS_DOMAIN_ID) and the network"
                    ),
                });
            } else if watched.is_said && !is_silent {
                said.push(format!("{name}: {topic} has come again"));
            }
            watched.is_said = is_silent;
            if let Some(assumed) = count.guess.filter(|_| !watched.is_guess_said) {
                watched.is_guess_said = true;
                said.push(format!("{name}: {topic}: {assumed}"));
            }
        }
        said
    }

    /// The diagnostics, when they are due. `dropped` pictures had to make room for later ones so far.
    pub(crate) fn due(
        &mut self,
        now: Instant,
        stamp_ns: u64,
        dropped: u64,
        count: impl Fn(Input) -> TopicCount,
    ) -> Option<DiagnosticArray> {
        if self.sent.is_some_and(|sent| now.saturating_duration_since(sent) < EVERY) {
            return None;
        }
        self.sent = Some(now);
        let newly_dropped = dropped - std::mem::replace(&mut self.dropped, dropped);
        let mut status = Vec::with_capacity(self.watched.len() + 1);
        for watched in &mut self.watched {
            let count = count(watched.input);
            let newly_refused = count.refused - std::mem::replace(&mut watched.refused, count.refused);
            let since = count.last.map(|last| now.saturating_duration_since(last));
            let (level, message) = match since {
                None => (STALE, "nothing has come yet".to_owned()),
                Some(since) if since > SILENT_AFTER && !watched.input.comes_once() => {
                    (STALE, format!("silent for {:.1} s", since.as_secs_f64()))
                }
                Some(_) if newly_refused > 0 => {
                    let cause = count.last_refusal.clone().unwrap_or_default();
                    (WARN, format!("{newly_refused} cannot be used; the last: {cause}"))
                }
                Some(_) if watched.input == Input::Pictures && newly_dropped > 0 => (
                    WARN,
                    format!(
                        "{newly_dropped} came faster than they could be used; send fewer or smaller ones"
                    ),
                ),
                Some(_) => (OK, "as it should be".to_owned()),
            };
            let mut values = vec![
                ("topic".to_owned(), watched.topic.clone()),
                ("received".to_owned(), count.received.to_string()),
                ("refused".to_owned(), count.refused.to_string()),
            ];
            if watched.input == Input::Pictures {
                values.push(("dropped".to_owned(), dropped.to_string()));
            }
            status.push(entry(&self.node, watched.input.name(), level, message, values));
        }
        let Method { frames, state, why, feature, latency_ms } = self.method.clone();
        let mut values = vec![
            ("frames".to_owned(), frames.to_string()),
            ("state".to_owned(), state.clone()),
            ("latency_ms".to_owned(), format!("{latency_ms:.1}")),
        ];
        values.extend(feature);
        let (level, message) = match frames {
            0 => (STALE, "no picture has been used yet".to_owned()),
            _ if state == "lost" => (WARN, why),
            _ => (OK, why),
        };
        status.push(entry(&self.node, "navigation", level, message, values));
        Some(DiagnosticArray { header: Header::new(stamp_ns, ""), status })
    }
}

/// The state as it stands in `frames.jsonl`.
fn state_name(record: &FrameRecord) -> String {
    use fingerpost_format::TrackState as State;
    match record.state {
        State::NoRoute => "no_route",
        State::Searching => "searching",
        State::Tracking => "tracking",
        State::Arrived => "arrived",
        State::Lost => "lost",
        State::RouteDone => "route_done",
    }
    .to_owned()
}

fn entry(
    node: &str,
    part: &str,
    level: u8,
    message: String,
    values: Vec<(String, String)>,
) -> DiagnosticStatus {
    let values = values.into_iter().map(|(key, value)| KeyValue { key, value }).collect();
    DiagnosticStatus { level, name: format!("{node}: {part}"), message, hardware_id: String::new(), values }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn health(now: Instant) -> Health {
        Health::new("fingerpost", &[(Input::Pictures, "/camera".to_owned())], now)
    }

    #[test]
    fn a_silence_is_said_once_and_so_is_its_end() {
        let began = Instant::now();
        let mut health = health(began);
        let mut at = |after_s: f64, last_s: Option<f64>| {
            let last = last_s.map(|s| began + Duration::from_secs_f64(s));
            let count = |_| TopicCount { last, ..TopicCount::default() };
            health.changes(began + Duration::from_secs_f64(after_s), count)
        };
        assert!(at(1.0, None).is_empty());
        let missing = at(6.0, None);
        assert!(missing.len() == 1 && missing[0].contains("/camera") && missing[0].contains("ROS_DOMAIN_ID"));
        assert!(at(7.0, None).is_empty());
        assert_eq!(at(7.1, Some(7.0)), ["pictures: /camera has come again"]);
        assert!(at(8.0, Some(7.0)).is_empty());
        assert!(at(9.0, Some(7.0))[0].contains("silent for 2.0 s"));
        assert!(at(9.1, Some(7.0)).is_empty());
    }

    #[test]
    fn a_guess_is_said_once() {
        let began = Instant::now();
        let mut health = health(began);
        let mut at = |guess: Option<&str>| {
            let guess = guess.map(str::to_owned);
            let count = |_| TopicCount { last: Some(began), guess: guess.clone(), ..TopicCount::default() };
            health.changes(began, count)
        };
        assert!(at(None).is_empty());
        assert_eq!(at(Some("a body's")), ["pictures: /camera: a body's"]);
        assert!(at(Some("a body's")).is_empty());
    }

    #[test]
    fn what_was_refused_since_is_a_warning_with_its_reason() {
        let began = Instant::now();
        let mut health = health(began);
        let mut count = TopicCount { received: 1, last: Some(began), ..TopicCount::default() };
        let first = health.due(began, 7, 0, |_| count.clone()).unwrap();
        assert_eq!(first.status.iter().map(|status| status.level).collect::<Vec<_>>(), [OK, STALE]);
        assert_eq!(health.due(began + EVERY / 2, 7, 0, |_| count.clone()), None);
        count.refuse("encoding \"yuv422\" is not read".to_owned());
        let second = health.due(began + EVERY, 8, 0, |_| count.clone()).unwrap();
        assert_eq!((second.status[0].level, second.status[0].name.as_str()), (WARN, "fingerpost: pictures"));
        assert!(second.status[0].message.contains("yuv422"), "{}", second.status[0].message);
        count.last = Some(began + EVERY);
        let third = health.due(began + 2 * EVERY, 9, 4, |_| count.clone()).unwrap();
        assert!(third.status[0].message.starts_with("4 came faster"), "{}", third.status[0].message);
    }
}
