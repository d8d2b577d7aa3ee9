//! What is known of the vehicle in a frame: how it moves, and where its driver wants to go.

/// Where the driver says to go.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum TurnSignal {
    /// Not known.
    #[default]
    Unknown,
    /// Straight on.
    Off,
    /// To the left.
    Left,
    /// To the right.
    Right,
}

/// What is known of the vehicle's motion and its driver's intent.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct VehicleState {
    /// Speed, metres a second, positive forward.
    pub speed_mps: Option<f64>,
    /// Yaw rate, radians a second, positive to the left.
    pub yaw_rate_rps: Option<f64>,
    /// Turn signal.
    pub turn_signal: TurnSignal,
}

impl VehicleState {
    /// Slower vehicles count as standing, m/s.
    pub const STANDING_BELOW_MPS: f64 = 0.3;

    /// Whether the vehicle is known to stand.
    pub fn stands(&self) -> bool {
        self.speed_mps.is_some_and(|speed_mps| speed_mps.abs() < Self::STANDING_BELOW_MPS)
    }
}
