//! The servo's Operating Modes.

use dynamixel::xm430;

/// Values of Operating Mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Goal Current.
    Current,
    /// Goal Velocity.
    Velocity,
    /// Goal Position, within a revolution.
    Position,
    /// Goal Position, of several turns.
    ExtendedPosition,
    /// Goal Position with no more than Goal Current.
    CurrentBasedPosition,
    /// Goal PWM.
    Pwm,
}

impl Mode {
    /// Of a value of the register.
    pub fn of(value: u8) -> Option<Self> {
        Some(match value {
            0 => Self::Current,
            1 => Self::Velocity,
            xm430::POSITION_CONTROL => Self::Position,
            4 => Self::ExtendedPosition,
            5 => Self::CurrentBasedPosition,
            16 => Self::Pwm,
            _ => return None,
        })
    }

    /// Whether Goal Position leads it.
    pub fn is_position(self) -> bool {
        matches!(self, Self::Position | Self::ExtendedPosition | Self::CurrentBasedPosition)
    }
}
