//! What lies in a container, as solids.

use std::sync::Arc;

use nalgebra::Isometry3;

use crate::loads::Burden;
use crate::model::Model;

/// A solid that lies in or on the container.
#[derive(Debug, Clone, PartialEq)]
pub struct LyingSolid {
    /// Its geometry.
    pub model: Arc<Model>,
    /// Where the model's frame is.
    pub container_from_item: Isometry3<f64>,
    /// What it weighs, and may carry.
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
    /// Its shape or its place is not known.
    Unknown,
}

/// What is known to lie in a container.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Content {
    solids: Arc<[LyingSolid]>,
    has_seen: bool,
    is_partial: bool,
}

impl Content {
    /// The solids that lie there.
    pub fn solids(&self) -> &[LyingSolid] {
        &self.solids
    }

    /// Whether some of the solids are no more than the shapes that were seen.
    pub fn has_seen(&self) -> bool {
        self.has_seen
    }

    /// Whether something else lies there, of which no solid is known.
    pub fn is_partial(&self) -> bool {
        self.is_partial
    }
}

impl FromIterator<LyingBody> for Content {
    fn from_iter<I: IntoIterator<Item = LyingBody>>(bodies: I) -> Self {
        let (mut has_seen, mut is_partial) = (false, false);
        let solids = bodies.into_iter().filter_map(|body| match body {
            LyingBody::Known(solid) => Some(solid),
            LyingBody::Seen(solid) => {
                has_seen = true;
                Some(solid)
            }
            LyingBody::Unknown => {
                is_partial = true;
                None
            }
        });
        let solids = solids.collect();
        Self {
            solids,
            has_seen,
            is_partial,
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::MassProperties;
    use crate::model::mesh::Mesh;

    fn solid() -> LyingSolid {
        let model = Model {
            name: "solid".to_owned(),
            mesh: Mesh::default(),
            volume_m3: 0.0,
            pieces: Vec::new(),
            mass: MassProperties {
                mass_kg: 0.0,
                centre_of_mass_m: nalgebra::Point3::origin(),
                inertia_kg_m2: nalgebra::Matrix3::zeros(),
            },
            carries_kg: None,
            resting_poses: Vec::new(),
        };
        LyingSolid::new(Arc::new(model), Isometry3::identity())
    }

    #[test]
    fn a_content_says_how_well_it_is_known() {
        let content = |bodies: &[LyingBody]| {
            let content: Content = bodies.iter().cloned().collect();
            let solids = content.solids().len();
            (solids, content.has_seen(), content.is_partial())
        };
        let (known, seen) = (LyingBody::Known(solid()), LyingBody::Seen(solid()));
        assert_eq!(content(&[]), (0, false, false));
        assert_eq!(content(std::slice::from_ref(&known)), (1, false, false));
        assert_eq!(content(&[known.clone(), seen.clone()]), (2, true, false));
        assert_eq!(content(&[known, seen, LyingBody::Unknown]), (2, true, true));
        let all = Content::from(vec![solid()]);
        assert!(!all.has_seen() && !all.is_partial());
    }
}
