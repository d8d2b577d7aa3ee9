//! The node: its topics, what it takes in and what it sends.

use std::net::{Ipv4Addr, UdpSocket};
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use fingerpost_format::{CameraInfo, FrameRecord};
use fingerpost_io::bag::Schema;
use fingerpost_map::LatLon;
use fingerpost_record::recording::{Odometry, feature_entities};
use fingerpost_report::Scene;
use foxglove::messages::Timestamp;
use ros2_client::qos::{History, Reliability, WhenFull};
use ros2_client::{Context, MessageTypeName, Name, Node, NodeName, NodeOptions, Publisher, QosProfile};
use rustdds::{DomainParticipantBuilder, QosPolicies};
use serde::Serialize;
use thiserror::Error;

use crate::command::Commands;
use crate::health::{Health, Input};
use crate::inbox::{Arrival, Inbox};
use crate::odometry::{DrivenPath, driving_line, odometry};
use crate::place::{FrameChain, nav_sat_fix};
use crate::receiving::{Listened, Receiving};
use crate::{markers, messages};

/// Results that may wait for a reader to confirm them: a second and a half at 20 Hz. One that confirms none holds nobody up.
const RESULTS_WAITING: usize = 32;

/// What comes in over which topic.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InputTopics {
    /// The camera's pictures.
    pub pictures: String,
    /// The message that they are in.
    pub picture_type: PictureType,
    /// The camera's calibration, where it is wanted.
    pub calibration: Option<String>,
    /// GPS positions.
    pub gps: Option<String>,
    /// The vehicle's speed and yaw rate.
    pub twist: Option<(String, TwistType)>,
    /// Pictures that may wait to be used; the oldest ones make room for later ones.
    pub depth: usize,
}

/// The message that holds a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PictureType {
    /// `sensor_msgs/Image`
    Image,
    /// `sensor_msgs/CompressedImage`
    CompressedImage,
}

/// The message that holds speed and yaw rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TwistType {
    /// `geometry_msgs/TwistStamped`
    TwistStamped,
    /// `geometry_msgs/TwistWithCovarianceStamped`
    TwistWithCovarianceStamped,
    /// `nav_msgs/Odometry`
    Odometry,
}

/// What goes out over which topic.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OutputTopics {
    /// `nav_msgs/Odometry`
    pub odometry: String,
    /// `nav_msgs/Path`: the way driven.
    pub path: String,
    /// `nav_msgs/Path`: the way ahead.
    pub driving_line: String,
    /// `ackermann_msgs/AckermannDriveStamped`
    pub command: String,
    /// `visualization_msgs/MarkerArray`
    pub feature: String,
    /// `sensor_msgs/NavSatFix`, with a map.
    pub fix: String,
    /// `diagnostic_msgs/DiagnosticArray`
    pub diagnostics: String,
    /// Whether `tf2_msgs/TFMessage` is sent on `/tf`.
    pub transforms: Transforms,
}

/// Whether transforms are sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Transforms {
    /// They are.
    Sent,
    /// They are not: another node gives `odom` to `base_link`.
    LeftToOthers,
}

/// Where and under which name the node is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NodeSetting {
    /// Name with its namespace, as `/fingerpost`.
    pub name: String,
    /// The domain, 0 to 232.
    pub domain: u16,
    /// Addresses of this machine's interfaces that are used; all where none are named.
    pub interfaces: Vec<Ipv4Addr>,
}

/// A node that cannot begin, or a command that it cannot send.
#[derive(Debug, Error)]
pub enum NodeError {
    /// A name is none of ROS.
    #[error(
        "{name:?} is no name of a ROS topic or node ({cause}); names begin with / and have letters, digits and _ between /"
    )]
    Name {
        /// The name.
        name: String,
        /// What is wrong with it.
        cause: String,
    },
    /// There is no such interface.
    #[error(
        "no network interface of this machine has the address {address} ({cause}); `ip addr` lists those that there are"
    )]
    Interface {
        /// The address.
        address: Ipv4Addr,
        /// What the system says.
        cause: std::io::Error,
    },
    /// DDS does not begin.
    #[error(
        "DDS cannot begin in domain {domain} ({cause}); check the network interfaces, or choose another domain (--domain)"
    )]
    Participant {
        /// The domain.
        domain: u16,
        /// What it says.
        cause: String,
    },
    /// A topic cannot be opened.
    #[error("topic {topic} cannot be opened ({cause}); is another type of message on it already?")]
    Topic {
        /// The topic.
        topic: String,
        /// What DDS says.
        cause: String,
    },
    /// The command to stop cannot be sent.
    #[error(
        "the command to stop cannot be sent ({cause}); a reader of commands confirms none: end it, or have it read with best effort"
    )]
    Stop {
        /// What DDS says.
        cause: String,
    },
    /// There is no thread to listen.
    #[error("there is no thread to listen with ({0}); the system has too many")]
    Thread(#[from] std::io::Error),
}

/// A node of ROS 2 with its topics.
///
/// Messages come in while the method works; what it makes of a picture is sent by [`RosNode::send`].
pub struct RosNode {
    // Ends before the node does.
    _receiving: Receiving,
    inbox: Arc<Inbox>,
    results: Results,
    health: Health,
    diagnostics: Publisher<messages::DiagnosticArray>,
    // Readers and writers are announced for as long as there is a node.
    _node: Node,
}

/// What is sent of every picture.
struct Results {
    odometry: Publisher<messages::Odometry>,
    path: Publisher<messages::Path>,
    driving_line: Publisher<messages::Path>,
    commands: Commands,
    feature: Publisher<messages::MarkerArray>,
    fix: Publisher<messages::NavSatFix>,
    transforms: Option<Publisher<messages::TfMessage>>,
    reckoning: Odometry,
    last_stamp_ns: Option<u64>,
    driven: DrivenPath,
    chain: FrameChain,
}

impl RosNode {
    /// Begins to listen and announces what is sent. `map_origin` is the origin of the map frame, where one is known beforehand.
    ///
    /// # Errors
    /// [`NodeError`] when a name is none, or DDS cannot begin.
    pub fn begin(
        setting: &NodeSetting,
        inputs: &InputTopics,
        outputs: &OutputTopics,
        map_origin: Option<LatLon>,
    ) -> Result<Self, NodeError> {
        let mut opening = Opening::begin(setting)?;
        let listened = inputs.all();
        let topics: Result<Vec<Listened>, NodeError> = listened
            .iter()
            .map(|(input, topic, schema)| opening.listen(*input, topic, *schema, inputs.depth))
            .collect();
        let results = Results {
            odometry: opening.publisher(&outputs.odometry, "nav_msgs", "Odometry")?,
            path: opening.publisher(&outputs.path, "nav_msgs", "Path")?,
            driving_line: opening.publisher(&outputs.driving_line, "nav_msgs", "Path")?,
            commands: Commands::new(opening.publisher(
                &outputs.command,
                "ackermann_msgs",
                "AckermannDriveStamped",
            )?),
            feature: opening.publisher(&outputs.feature, "visualization_msgs", "MarkerArray")?,
            fix: opening.publisher(&outputs.fix, "sensor_msgs", "NavSatFix")?,
            transforms: match outputs.transforms {
                Transforms::Sent => Some(opening.publisher("/tf", "tf2_msgs", "TFMessage")?),
                Transforms::LeftToOthers => None,
            },
            reckoning: Odometry::default(),
            last_stamp_ns: None,
            driven: DrivenPath::default(),
            chain: FrameChain::new(map_origin),
        };
        let diagnostics = opening.publisher(&outputs.diagnostics, "diagnostic_msgs", "DiagnosticArray")?;
        let watched: Vec<(Input, String)> =
            listened.into_iter().map(|(input, topic, _)| (input, topic)).collect();
        let inbox = Arc::new(Inbox::new(inputs.depth));
        Ok(Self {
            _receiving: Receiving::begin(topics?, Arc::clone(&inbox))?,
            inbox,
            results,
            health: Health::new(setting.name.trim_start_matches('/'), &watched, Instant::now()),
            diagnostics,
            _node: opening.node,
        })
    }

    /// The next picture, if it comes within `longest`.
    pub fn next(&self, longest: Duration) -> Option<Arrival> {
        self.inbox.next(longest)
    }

    /// The newest calibration that has come.
    pub fn calibration(&self) -> Option<CameraInfo> {
        self.inbox.calibration()
    }

    /// Pictures that made room for later ones so far.
    pub fn dropped(&self) -> u64 {
        self.inbox.dropped()
    }

    /// Says that a picture could not be used after all.
    pub fn refuse(&self, cause: &str) {
        self.inbox.refuse_picture(cause.to_owned());
    }

    /// Sends what the method makes of the picture with that stamp.
    pub fn send(&mut self, stamp_ns: u64, scene: &Scene<'_>) {
        self.results.send(stamp_ns, scene);
    }

    /// Commands the vehicle to stop, wheels as they are, where it was commanded to drive before.
    ///
    /// # Errors
    /// [`NodeError::Stop`] when that could not be sent, and may be tried again.
    pub fn stop(&self) -> Result<(), NodeError> {
        self.results.commands.stop().map_err(|cause| NodeError::Stop { cause })
    }

    /// Takes in what is said of a frame, for the diagnostics; its picture came at `came`.
    pub fn note(&mut self, record: &FrameRecord, came: Instant) {
        self.health.note(record, came.elapsed());
    }

    /// Sends diagnostics when they are due, and gives what is to be said of inputs that fall silent, never come or come again. To be
    /// called some times a second.
    pub fn look_after(&mut self) -> Vec<String> {
        let now = Instant::now();
        let count = |input| self.inbox.count(input);
        let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let stamp_ns = u64::try_from(since_1970.as_nanos()).unwrap_or(u64::MAX);
        if let Some(due) = self.health.due(now, stamp_ns, self.inbox.dropped(), count) {
            publish(&self.diagnostics, due);
        }
        self.health.changes(now, count)
    }
}

impl std::fmt::Debug for RosNode {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RosNode").field("health", &self.health).finish_non_exhaustive()
    }
}

impl InputTopics {
    /// All that are listened to.
    fn all(&self) -> Vec<(Input, String, Schema)> {
        let pictures = match self.picture_type {
            PictureType::Image => Schema::RosImage,
            PictureType::CompressedImage => Schema::RosCompressedImage,
        };
        let mut all = vec![(Input::Pictures, self.pictures.clone(), pictures)];
        all.extend(
            self.calibration.iter().map(|topic| (Input::Calibration, topic.clone(), Schema::RosCameraInfo)),
        );
        all.extend(self.gps.iter().map(|topic| (Input::Gps, topic.clone(), Schema::RosNavSatFix)));
        all.extend(self.twist.iter().map(|(topic, kind)| {
            let schema = match kind {
                TwistType::TwistStamped => Schema::RosTwistStamped,
                TwistType::TwistWithCovarianceStamped => Schema::RosTwistWithCovarianceStamped,
                TwistType::Odometry => Schema::RosOdometry,
            };
            (Input::Twist, topic.clone(), schema)
        }));
        all
    }
}

impl Results {
    fn send(&mut self, stamp_ns: u64, scene: &Scene<'_>) {
        let output = scene.output;
        // First, because a vehicle waits for it.
        self.commands.send(stamp_ns, &output.advice);
        let dt_s = self
            .last_stamp_ns
            .replace(stamp_ns)
            .map(|last_ns| stamp_ns.saturating_sub(last_ns) as f64 * 1e-9);
        self.reckoning.go_on(output.motion.as_ref(), dt_s);
        let estimate = self.reckoning.estimate();
        publish(&self.odometry, odometry(stamp_ns, &estimate));
        if let Some(transforms) = &self.transforms {
            let chain = self.chain.transforms(stamp_ns, &estimate.odom_from_vehicle, output.fix.as_ref());
            publish(transforms, chain);
        }
        publish(&self.driving_line, driving_line(stamp_ns, &output.driving_line));
        publish(
            &self.feature,
            markers::markers(stamp_ns, &feature_entities(Timestamp::MIN, scene.followed())),
        );
        if let Some(fix) = &output.fix {
            publish(&self.fix, nav_sat_fix(stamp_ns, fix));
        }
        if let Some(path) = self.driven.go_on(stamp_ns, &estimate.odom_from_vehicle) {
            publish(&self.path, path);
        }
    }
}

/// Sends a message. One for which a reader that confirms nothing leaves no room is left out, as the next ones will be: nobody waits
/// for it.
fn publish<M: Serialize>(to: &Publisher<M>, message: M) {
    let _ = to.publish(message);
}

/// A node whose topics are being opened.
struct Opening {
    context: Context,
    node: Node,
}

impl Opening {
    fn begin(setting: &NodeSetting) -> Result<Self, NodeError> {
        let domain = setting.domain;
        let of_dds = |cause: String| NodeError::Participant { domain, cause };
        for &address in &setting.interfaces {
            // DDS itself would begin without it, and nobody would find the node.
            UdpSocket::bind((address, 0)).map_err(|cause| NodeError::Interface { address, cause })?;
        }
        let builder = DomainParticipantBuilder::new(domain);
        let builder = match setting.interfaces.as_slice() {
            [] => builder,
            some => builder.with_only_networks(some.iter().copied()),
        };
        let participant = builder.build().map_err(|cause| of_dds(cause.to_string()))?;
        let context =
            Context::from_domain_participant(participant).map_err(|cause| of_dds(cause.to_string()))?;
        let wrong = |cause: String| NodeError::Name { name: setting.name.clone(), cause };
        let (namespace, base) = setting.name.rsplit_once('/').unwrap_or(("", &setting.name));
        let namespace = if namespace.is_empty() { "/" } else { namespace };
        let name = NodeName::new(namespace, base).map_err(|cause| wrong(cause.to_string()))?;
        let options = NodeOptions::new().enable_rosout(false).start_parameter_services(false);
        let node = context.new_node(name, options).map_err(|cause| of_dds(cause.to_string()))?;
        Ok(Self { context, node })
    }

    fn topic(
        &self,
        topic: &str,
        kind: MessageTypeName,
        qos: &QosProfile,
    ) -> Result<rustdds::Topic, NodeError> {
        let name = Name::parse(topic)
            .map_err(|cause| NodeError::Name { name: topic.to_owned(), cause: cause.to_string() })?;
        self.node.create_topic(&name, kind, qos).map_err(|cause| of_topic(topic, &cause))
    }

    /// Best effort, the newest ones, as sensors send.
    fn listen(&self, input: Input, topic: &str, schema: Schema, depth: usize) -> Result<Listened, NodeError> {
        let qos = QosProfile::subscription_default().history(History::KeepLast { depth });
        let (package, kind) = schema.name().split_once("/msg/").unwrap_or_default();
        let opened = self.topic(topic, MessageTypeName::new(package, kind), &qos)?;
        let policies = QosPolicies::from(&qos);
        let participant = self.context.domain_participant();
        let reader = participant
            .create_subscriber(&policies)
            .and_then(|subscriber| subscriber.create_simple_datareader_no_key(&opened, Some(policies)))
            .map_err(|cause| of_topic(topic, &cause))?;
        Ok(Listened { input, schema, reader })
    }

    /// Reliable: a reader gets every result.
    fn publisher<M: Serialize>(
        &mut self,
        topic: &str,
        package: &str,
        kind: &str,
    ) -> Result<Publisher<M>, NodeError> {
        let qos = QosProfile::publisher_default()
            .reliability(Reliability::Reliable { when_full: WhenFull::Fail })
            .history(History::KeepLast { depth: RESULTS_WAITING });
        let opened = self.topic(topic, MessageTypeName::new(package, kind), &qos)?;
        self.node.create_publisher(&opened, Some(qos)).map_err(|cause| of_topic(topic, &cause))
    }
}

fn of_topic(topic: &str, cause: &dyn std::fmt::Display) -> NodeError {
    NodeError::Topic { topic: topic.to_owned(), cause: cause.to_string() }
}
