//! What a finger grasps.

use model_core::object::ObjectDesign;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// What a finger grasps: the object, in that finger's world frame, and its friction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Object {
    /// Shape and place.
    pub design: ObjectDesign,
    /// Coulomb's coefficient of friction between finger and object, 0 to 3. A board without room for what friction remembers takes 0 only.
    pub friction: f64,
}

impl From<ObjectDesign> for Object {
    /// Without friction.
    fn from(design: ObjectDesign) -> Self {
        Self { design, friction: 0.0 }
    }
}
