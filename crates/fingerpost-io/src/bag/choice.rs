//! Which topic serves for what.

use thiserror::Error;

use super::schema::{Role, Schema};
use super::survey::Topic;

/// Topics by name, where they are asked for.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Wanted {
    /// Of the camera's pictures.
    pub image: Option<String>,
    /// Of its calibration.
    pub camera_info: Option<String>,
    /// Of GPS positions.
    pub gps: Option<String>,
    /// Of speed and yaw rate.
    pub twist: Option<String>,
    /// Of an inertial unit's yaw rate.
    pub imu: Option<String>,
}

/// A recording in which a topic cannot be chosen.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ChoiceError {
    /// There are no pictures.
    #[error("it has no topic of pictures ({kinds}); it has {found}")]
    NoPictures {
        /// What would be one.
        kinds: String,
        /// What there is.
        found: String,
    },
    /// Several would do.
    #[error("it has {count} topics of {what}: {found}; choose one with {option}")]
    Several {
        /// How many.
        count: usize,
        /// What they give.
        what: &'static str,
        /// The topics.
        found: String,
        /// The option that chooses.
        option: &'static str,
    },
    /// A topic that is asked for is not there.
    #[error("it has no topic {topic:?} of {what}; it has {found}")]
    NotThere {
        /// The topic.
        topic: String,
        /// What it should give.
        what: &'static str,
        /// What there is of that, or else all.
        found: String,
    },
    /// Its messages are encoded in another manner.
    #[error(
        "topic {topic} holds {schema} in encoding {encoding:?}, which is read in {read:?} alone; record or convert it as such"
    )]
    Encoding {
        /// The topic.
        topic: String,
        /// Name of the schema.
        schema: &'static str,
        /// The encoding found.
        encoding: String,
        /// The encoding that is read.
        read: &'static str,
    },
}

/// The topics that are used, each with its schema.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Choice {
    used: Vec<(Role, String, Schema)>,
}

impl Choice {
    /// Of what there is, what is asked for or is the only one; pictures there must be.
    ///
    /// # Errors
    /// [`ChoiceError`] when there are no pictures, several topics would do, or one that is asked for is not there or not readable.
    pub fn of(topics: &[Topic], wanted: &Wanted) -> Result<Self, ChoiceError> {
        let named = [
            (Role::Pictures, &wanted.image),
            (Role::Calibration, &wanted.camera_info),
            (Role::Gps, &wanted.gps),
            (Role::Twist, &wanted.twist),
            (Role::Imu, &wanted.imu),
        ];
        let mut used = Vec::new();
        for (role, name) in named {
            let chosen = topic_of(topics, role, name.as_deref())?;
            let Some((topic, schema)) = chosen else { continue };
            if topic.encoding != schema.encoding() {
                return Err(ChoiceError::Encoding {
                    topic: topic.name.clone(),
                    schema: schema.name(),
                    encoding: topic.encoding.clone(),
                    read: schema.encoding(),
                });
            }
            used.push((role, topic.name.clone(), schema));
        }
        // `/tf` moves; what stays as it is has a topic of its own.
        let is_static = |topic: &&Topic| topic.name == STATIC_TRANSFORMS && topic.encoding == "cdr";
        if let Some((topic, schema)) =
            topics.iter().find(is_static).and_then(|t| Some((t, t.known_schema()?)))
            && schema.role() == Role::Transforms
        {
            used.push((Role::Transforms, topic.name.clone(), schema));
        }
        Ok(Self { used })
    }

    /// Schema and role of a topic that is used.
    pub fn schema_of(&self, topic: &str) -> Option<Schema> {
        self.used.iter().find(|(_, name, _)| name == topic).map(|(_, _, schema)| *schema)
    }

    /// The topic that serves for a role.
    pub fn topic(&self, role: Role) -> Option<&str> {
        self.used.iter().find(|(of, ..)| *of == role).map(|(_, name, _)| name.as_str())
    }
}

/// Topic of transforms that hold for good (ROS `tf2_ros`).
const STATIC_TRANSFORMS: &str = "/tf_static";

/// Whether a topic of pictures says that they are rectified: `image_rect`, `image_rect_color`, `rectified` (ROS `image_proc`), `ImageRect`,
/// `image_undistorted`, in letters of either case. A name that says what goes in, as `rectifier_input` does, says nothing of it.
pub fn is_rectified(topic: &str) -> bool {
    let words = words(topic);
    let before = std::iter::once("").chain(words.iter().map(String::as_str));
    let is_said = |(word, before): (&String, &str)| {
        says_rectified(word) && !matches!(before, "un" | "non" | "not" | "no")
    };
    !words.iter().any(|word| word == "input") && words.iter().zip(before).any(is_said)
}

/// Whether a word of a name, in small letters, says that a picture is rectified.
fn says_rectified(word: &str) -> bool {
    let word = word.strip_prefix("image").unwrap_or(word);
    let word = ["color", "colour", "mono", "raw"].iter().find_map(|of| word.strip_suffix(of)).unwrap_or(word);
    matches!(word, "rect" | "rectified" | "rectify")
        || word.contains("undistort") && !word.ends_with("undistorter")
}

/// The words of a name in small letters: a sign, a digit, and a capital behind a small letter or before one, begin another.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut letters = name.chars().peekable();
    let mut last = ' ';
    while let Some(letter) = letters.next() {
        let is_capital = letter.is_uppercase()
            && (last.is_lowercase()
                || last.is_uppercase() && letters.peek().is_some_and(|next| next.is_lowercase()));
        if (!letter.is_alphabetic() || is_capital) && words.last().is_some_and(|word| !word.is_empty()) {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut().filter(|_| letter.is_alphabetic()) {
            word.extend(letter.to_lowercase());
        }
        last = letter;
    }
    words
}

fn topic_of<'a>(
    topics: &'a [Topic],
    role: Role,
    name: Option<&str>,
) -> Result<Option<(&'a Topic, Schema)>, ChoiceError> {
    let candidates: Vec<(&Topic, Schema)> = topics
        .iter()
        .filter_map(|topic| Some((topic, topic.known_schema()?)))
        .filter(|(_, schema)| schema.role() == role)
        .collect();
    let found = || listed(candidates.iter().map(|(topic, _)| *topic));
    if let Some(name) = name {
        let chosen = candidates.iter().find(|(topic, _)| topic.name == name).copied();
        return chosen.map(Some).ok_or_else(|| ChoiceError::NotThere {
            topic: name.to_owned(),
            what: what(role),
            found: if candidates.is_empty() { listed(topics) } else { found() },
        });
    }
    match candidates[..] {
        [only] => Ok(Some(only)),
        [] if role == Role::Pictures => {
            let kinds = Schema::ALL.into_iter().filter(|schema| schema.role() == role);
            let kinds: Vec<&str> = kinds.map(Schema::name).collect();
            Err(ChoiceError::NoPictures { kinds: kinds.join(", "), found: listed(topics) })
        }
        [] => Ok(None),
        _ => Err(ChoiceError::Several {
            count: candidates.len(),
            what: what(role),
            found: found(),
            option: option(role),
        }),
    }
}

const fn what(role: Role) -> &'static str {
    match role {
        Role::Pictures => "pictures",
        Role::Calibration => "calibrations",
        Role::Gps => "GPS positions",
        Role::Twist => "speed and yaw rate",
        Role::Imu => "inertial units",
        Role::Transforms => "transforms",
    }
}

const fn option(role: Role) -> &'static str {
    match role {
        Role::Pictures => "--image-topic",
        Role::Calibration => "--camera-info-topic",
        Role::Gps => "--gps-topic",
        Role::Twist => "--twist-topic",
        Role::Imu | Role::Transforms => "--imu-topic",
    }
}

/// Topics that a message names, and letters that it shows of a name: a recording has as many and as long ones as its writer likes.
const MOST_NAMED: usize = 50;
const MOST_LETTERS: usize = 120;

/// Topics with their schemas and numbers of messages; of very many the first, and how many more there are.
fn listed<'a>(topics: impl IntoIterator<Item = &'a Topic>) -> String {
    let mut topics = topics.into_iter();
    let mut named: Vec<String> = topics
        .by_ref()
        .take(MOST_NAMED)
        .map(|Topic { name, schema, messages, .. }| {
            format!("{} ({messages} of {})", shortened(name), shortened(schema))
        })
        .collect();
    let more = topics.count();
    if more > 0 {
        named.push(format!("and {more} more"));
    }
    if named.is_empty() { "no messages at all".to_owned() } else { named.join(", ") }
}

/// A name, or the beginning of a long one.
fn shortened(name: &str) -> String {
    match name.char_indices().nth(MOST_LETTERS) {
        Some((end, _)) => format!("{}…", &name[..end]),
        None => name.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn topic(name: &str, schema: &str) -> Topic {
        let encoding = if schema.starts_with("foxglove") { "protobuf" } else { "cdr" };
        Topic { name: name.to_owned(), schema: schema.to_owned(), encoding: encoding.to_owned(), messages: 3 }
    }

    #[test]
    fn a_message_is_short_however_many_and_long_the_topics_are() {
        let long = "ä".repeat(50_000);
        let topics: Vec<Topic> = (0..2000).map(|number| topic(&format!("/{number}{long}"), &long)).collect();
        let error = Choice::of(&topics, &Wanted::default()).expect_err("no pictures").to_string();
        assert!(error.len() < 30_000, "{} bytes", error.len());
        assert!(error.contains("/49ä") && error.contains("and 1950 more"));
    }

    #[test]
    fn the_only_topic_of_a_kind_is_taken_and_several_are_named() {
        let front = topic("/front/image_raw", "sensor_msgs/msg/Image");
        let rear = topic("/rear/compressed", "sensor_msgs/msg/CompressedImage");
        let gps = topic("/fix", "sensor_msgs/msg/NavSatFix");
        let choice = Choice::of(&[front.clone(), gps.clone()], &Wanted::default()).expect("one of each");
        assert_eq!(choice.topic(Role::Pictures), Some("/front/image_raw"));
        assert_eq!(choice.schema_of("/fix"), Some(Schema::RosNavSatFix));
        assert_eq!(choice.topic(Role::Imu), None);

        let both = [front, rear, gps];
        let error = Choice::of(&both, &Wanted::default()).unwrap_err().to_string();
        assert!(error.contains("/front/image_raw") && error.contains("/rear/compressed"), "{error}");
        assert!(error.contains("--image-topic") && !error.contains("/fix"), "{error}");
        let wanted = Wanted { image: Some("/rear/compressed".to_owned()), ..Wanted::default() };
        let choice = Choice::of(&both, &wanted).expect("chosen");
        assert_eq!(choice.schema_of("/rear/compressed"), Some(Schema::RosCompressedImage));
        let wanted = Wanted { image: Some("/left".to_owned()), ..Wanted::default() };
        let error = Choice::of(&both, &wanted).unwrap_err().to_string();
        assert!(error.contains("\"/left\"") && error.contains("/rear/compressed"), "{error}");
    }

    #[test]
    fn static_transforms_are_taken_beside_those_that_move() {
        let transforms = ["/tf", "/tf_static"].map(|name| topic(name, "tf2_msgs/msg/TFMessage"));
        let all = [topic("/image", "sensor_msgs/msg/Image"), transforms[0].clone(), transforms[1].clone()];
        let choice = Choice::of(&all, &Wanted::default()).expect("pictures");
        assert_eq!(choice.topic(Role::Transforms), Some("/tf_static"));
        assert_eq!(choice.schema_of("/tf"), None);
    }

    #[test]
    fn topics_of_rectified_pictures_are_told_by_their_names() {
        for name in [
            "/camera/image_rect/compressed",
            "/left/image_rect_color",
            "/front/rectified/image",
            "image_rect",
            "/cam/image_rect_raw",
            "/cam/image_rect_mono/compressed",
            "/cam/image_undistorted/compressed",
            "/cam/undistort/image",
            "/cam/undistorted_image",
            "/cam/imageUndistorted",
            "/cam/IMAGE_UNDISTORTED",
            "/cam0undistorted",
            "/cam/ImageRect/compressed",
            "/cam/imageRectColor",
            "/cam/RGBRect",
            "/cam/IMAGE_RECT",
            "/cam/Image_Rect_Color",
            "/cam/imagerectcolor",
            "/cam/image-rect",
            "/cam/image_rect2",
            "/cam/ImageRectified",
        ] {
            assert!(is_rectified(name), "{name}");
        }
        for name in [
            "/camera/image_raw",
            "/direct/image",
            "/rectangle/image",
            "/front/rectifier_input",
            "/correct/image_raw",
            "/cam/CorrectedImage",
            "/cam/imageRectangle",
            "/cam/image_unrectified",
            "/cam/not_rectified/image",
            "/cam/UnRectified",
            "/cam/distorted",
            "/undistorter/input/image",
            "/image_undistort/input/image",
            "/cam/imageRaw",
            "/",
            "",
        ] {
            assert!(!is_rectified(name), "{name}");
        }
    }

    #[test]
    fn no_pictures_and_unread_encodings_are_named() {
        let error = Choice::of(&[topic("/chatter", "std_msgs/msg/String")], &Wanted::default()).unwrap_err();
        assert!(error.to_string().contains("/chatter (3 of std_msgs/msg/String)"), "{error}");
        let error = Choice::of(&[], &Wanted::default()).unwrap_err();
        assert!(error.to_string().contains("no messages at all"), "{error}");
        let json = Topic { encoding: "json".to_owned(), ..topic("/camera", "foxglove.CompressedImage") };
        let error = Choice::of(&[json], &Wanted::default()).unwrap_err();
        assert!(
            error.to_string().contains("\"json\"") && error.to_string().contains("\"protobuf\""),
            "{error}"
        );
    }
}
