//! Content of a container, as solids.

use std::sync::Arc;

use nalgebra::Isometry3;

use crate::scene::model::Model;

/// Mass of an item that lies somewhere, and the mass it may carry.
#[derive(Debug, Clone, PartialEq)]
pub struct Burden {
    /// Names the item, for people.
    pub name: Arc<str>,
    /// Mass, in kilograms.
    pub mass_kg: f64,
    /// The greatest mass that may rest on it, in kilograms, where there is a limit.
    pub carries_kg: Option<f64>,
}

impl Burden {
    /// Reads both off a model.
    pub fn of(model: &Model) -> Self {
        Self {
            name: model.name.as_str().into(),
            mass_kg: model.mass.mass_kg,
            carries_kg: model.carries_kg,
        }
    }
}

/// A solid that lies in or on the container.
#[derive(Debug, Clone, PartialEq)]
pub struct LyingSolid {
    /// Its geometry.
    pub model: Arc<Model>,
    /// Pose of the model's frame.
    pub container_from_item: Isometry3<f64>,
    /// Mass, and the mass it may carry.
    pub burden: Burden,
}

impl LyingSolid {
    /// A solid that weighs and carries what its model says.
    pub fn new(model: Arc<Model>, container_from_item: Isometry3<f64>) -> Self {
        Self {
            burden: Burden::of(&model),
            model,
            container_from_item,
        }
    }
}

/// Something that lies in or on the container, by how well it is known.
#[derive(Debug, Clone, PartialEq)]
pub enum LyingBody {
    /// Its solid is known.
    Known(LyingSolid),
    /// No more is known of it than the shape that was seen, of which this is the solid.
    Seen(LyingSolid),
    /// It was to lie there, and nobody has looked.
    Assumed(LyingSolid),
    /// Its shape or its place is not known.
    Unknown,
}

impl LyingBody {
    /// The same, of which nobody knows that it lies there.
    #[must_use]
    pub fn assumed(self) -> Self {
        match self {
            Self::Known(solid) | Self::Seen(solid) | Self::Assumed(solid) => Self::Assumed(solid),
            Self::Unknown => Self::Unknown,
        }
    }
}

/// Known content of a container.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Content {
    /// Solids that lie there, then those that are assumed to.
    solids: Arc<[LyingSolid]>,
    lying: usize,
    has_seen: bool,
    has_unknown: bool,
}

impl Content {
    /// The solids that lie there.
    pub fn solids(&self) -> &[LyingSolid] {
        self.solids.get(..self.lying).unwrap_or_default()
    }

    /// The solids that are only assumed to lie there.
    pub fn assumed(&self) -> &[LyingSolid] {
        self.solids.get(self.lying..).unwrap_or_default()
    }

    /// All of these: what weighs on the container and on what lies there, wherever it is exactly.
    pub fn all_solids(&self) -> &[LyingSolid] {
        &self.solids
    }

    /// Whether some of the solids are no more than the shapes that were seen.
    pub fn has_seen(&self) -> bool {
        self.has_seen
    }

    /// Whether something else lies there, of which no solid is known.
    pub fn has_unknown(&self) -> bool {
        self.has_unknown
    }

    /// The same content, beside which something else lies there.
    #[must_use]
    pub fn with_unknown(self) -> Self {
        Self {
            has_unknown: true,
            ..self
        }
    }

    /// Whether more lies there than [`Self::solids`]: where it is, a picture has to say.
    pub fn is_partial(&self) -> bool {
        self.has_unknown || !self.assumed().is_empty()
    }
}

impl FromIterator<LyingBody> for Content {
    fn from_iter<I: IntoIterator<Item = LyingBody>>(bodies: I) -> Self {
        let (mut solids, mut assumed) = (Vec::new(), Vec::new());
        let (mut has_seen, mut has_unknown) = (false, false);
        for body in bodies {
            match body {
                LyingBody::Known(solid) => solids.push(solid),
                LyingBody::Seen(solid) => {
                    has_seen = true;
                    solids.push(solid);
                }
                LyingBody::Assumed(solid) => assumed.push(solid),
                LyingBody::Unknown => has_unknown = true,
            }
        }
        let lying = solids.len();
        solids.append(&mut assumed);
        Self {
            solids: solids.into(),
            lying,
            has_seen,
            has_unknown,
        }
    }
}

/// Solids that are known, and are all that lies there.
impl FromIterator<LyingSolid> for Content {
    fn from_iter<I: IntoIterator<Item = LyingSolid>>(solids: I) -> Self {
        solids.into_iter().map(LyingBody::Known).collect()
    }
}

/// Solids that are known, and are all that lies there.
impl From<Vec<LyingSolid>> for Content {
    fn from(solids: Vec<LyingSolid>) -> Self {
        solids.into_iter().collect()
    }
}
